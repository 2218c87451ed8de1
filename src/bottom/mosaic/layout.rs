//! Places the echoes of every ping in the plane of the map, and finds the tiles that they touch.

mod thinned;

use super::{MosaicSettings, altitudes_m};
use crate::bathymetry::Grid;
use crate::calibration::Calibration;
use crate::first_return::FirstReturns;
use bathyscope_log::support::outline::{NOWHERE, bounds, box_around, boxes_meet};
use bathyscope_log::support::statistics::ends;
use bathyscope_log::survey::{
    AcrossTrack, Exclusions, Navigation, Relief, Side, Survey, turn_rates_deg_s,
};
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::sync::Arc;

/// Number of cells along the side of a tile.
pub const TILE_CELLS: usize = 256;

/// Longest distance and pause between two pings with shown ground between them: beyond these the
/// log was interrupted.
const LONGEST_STEP_M: f64 = 3.0;
const LONGEST_PAUSE_S: f64 = 2.0;
/// Slant range over which an echo rises from the first return on, metres: about a pulse and the
/// scatter of first returns.
const RISE_M: f64 = 0.05;
/// Length over which the plane's scale and direction are measured, metres.
const PROBE_M: f64 = 20.0;

/// One side of one ping in the plane of the map.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MosaicRay {
    /// Place of the boat.
    pub at: [f64; 2],
    /// Vector in the plane of one metre outward on the ground.
    pub out: [f64; 2],
    /// Slant range of the first return, metres; on level ground, the height over it.
    pub altitude_m: f64,
    /// Height over the ground under the boat, metres.
    pub under_m: f64,
    /// Shape of the ground across the track, outward.
    pub across: AcrossTrack,
    /// Calibrated slant range of the near edge of the first sample, and length of each sample,
    /// metres.
    pub start_m: f64,
    /// See `start_m`.
    pub step_m: f64,
    /// Number of samples.
    pub count: usize,
    /// [`MosaicRay::reach_m`] with or without the water column, as the layout shows it.
    pub shown_m: f64,
}

impl MosaicRay {
    /// Returns the slant range at a distance of `sample` samples, metres.
    #[inline(always)]
    pub fn range_m(&self, sample: f64) -> f64 {
        self.start_m + self.step_m * sample
    }

    /// Returns the distance in samples of a slant range: the inverse of [`MosaicRay::range_m`].
    #[inline(always)]
    pub fn sample_at(&self, range_m: f64) -> f64 {
        (range_m - self.start_m) / self.step_m
    }

    /// Returns the farthest distance on the ground, metres; with the water column, the farthest
    /// slant range itself.
    pub fn reach_m(&self, water_column: bool) -> f64 {
        let far_m = self.range_m(self.count as f64);
        if water_column { far_m.max(0.0) } else { self.across.ground_m(self.under_m, far_m) }
    }

    /// Returns the place on the ray, in samples, of the ground at a distance; with the water
    /// column, the distance is the slant range itself.
    pub fn sample_of(&self, ground_m: f64, water_column: bool) -> f64 {
        if water_column {
            return self.sample_at(ground_m);
        }
        let range_m = self.across.range_m(self.under_m, ground_m);
        self.sample_at(range_m.max(self.least_m()))
    }

    /// Replaces distances in rising order with their [`MosaicRay::sample_of`].
    #[inline(always)]
    pub(super) fn replace_by_samples(&self, grounds_m: &mut [f64], water_column: bool) {
        let mut least_m = f64::NEG_INFINITY;
        if !water_column {
            least_m = self.least_m();
            self.across.replace_by_ranges_m(self.under_m, grounds_m);
        }
        for range_m in grounds_m {
            *range_m = self.sample_at(range_m.max(least_m));
        }
    }

    /// Returns the least slant range that is shown, metres. Where the bottom rises from under the
    /// boat, the rising echo of the first return is broad and the water before it dark.
    #[inline(always)]
    fn least_m(&self) -> f64 {
        if self.under_m > self.altitude_m { self.altitude_m + RISE_M } else { 0.0 }
    }

    /// Returns the place at a distance on the ground.
    pub fn place(&self, ground_m: f64) -> [f64; 2] {
        [0, 1].map(|axis| self.at[axis] + self.out[axis] * ground_m)
    }
}

/// Place and direction of a ping in the plane of the map.
#[derive(Clone, Copy, Debug)]
struct Placed {
    at: [f64; 2],
    starboard: [f64; 2],
}

/// Slant ranges of one side of a ping.
#[derive(Clone, Copy, Debug)]
struct Ranges {
    start_m: f32,
    step_m: f32,
    count: u32,
}

/// Number of pings whose strips share a box, which shows whether the strips need to be examined.
const BOXED: usize = 64;

/// West, south, east and north, metres in the plane of the map.
pub type Bounds = [f64; 4];

/// Pings in the plane of the map: all pings of a survey, or as many as a coarse picture needs.
#[derive(Clone, Debug)]
pub struct MosaicLayout {
    /// Index in the survey of each ping.
    pings: Vec<u32>,
    /// Pings of the survey that each ping represents: the first, and one after the last.
    stands_for: Vec<[u32; 2]>,
    placed: Vec<Option<Placed>>,
    /// Slant ranges of each ping, by side, port first.
    ranges: [Vec<Option<Ranges>>; 2],
    altitudes_m: [Vec<f32>; 2],
    /// Reach of each ray, metres, stored since it is used often and slow to compute on ground that
    /// is not level. Empty until all other fields are known.
    shown_m: [Vec<f64>; 2],
    /// Shape of the ground across the track, and heights over it under the boat; `None` where the
    /// ground is level.
    relief: Option<(Arc<Relief>, [Vec<f32>; 2])>,
    /// True where the ground between a ping and the next is shown.
    joined: Vec<bool>,
    /// True if the water column is shown.
    pub(super) water_column: bool,
    /// Longest slant range, metres.
    pub(super) far_m: f64,
    /// Boxes around the strips that begin at each run of [`BOXED`] pings.
    boxes: Vec<Bounds>,
}

impl MosaicLayout {
    /// Creates the layout of a survey. `plane` converts metres east and north of the survey's
    /// origin to the plane of the map (metres too: the survey's own plane, or a projection such as
    /// UTM).
    pub fn new(
        survey: &Survey,
        navigation: &Navigation,
        returns: &FirstReturns,
        calibration: &Calibration,
        settings: &MosaicSettings,
        plane: impl Fn([f64; 2]) -> [f64; 2],
    ) -> Self {
        let times_s: Vec<f64> = survey.side_scan.iter().map(|ping| ping.time_s).collect();
        let turns = turn_rates_deg_s(&times_s, &navigation.pings);
        let placed: Vec<Option<Placed>> = navigation
            .pings
            .iter()
            .zip(&turns)
            .map(|(place, &turn_deg_s)| {
                let [x, y] = place.starboard()?;
                let straight = f64::from(turn_deg_s) <= settings.most_turn_deg_s;
                let at = plane(place.place());
                let probe = plane([place.east_m + PROBE_M * x, place.north_m + PROBE_M * y]);
                let starboard = [0, 1].map(|axis| (probe[axis] - at[axis]) / PROBE_M);
                let known = at.iter().chain(&starboard).all(|value| value.is_finite());
                (known && straight).then_some(Placed { at, starboard })
            })
            .collect();
        // A ping and the next must be near enough to each other to show the ground between them.
        let is_joined = |ping: usize| {
            placed[ping].is_some()
                && placed.get(ping + 1).is_some_and(Option::is_some)
                && joined_way_m(survey, navigation, ping).is_some()
        };
        let joined: Vec<bool> = (0..placed.len()).map(is_joined).collect();
        Self { joined, ..Self::of_placed(survey, placed, returns, calibration, settings) }.boxed()
    }

    /// Creates a layout of pings at their places, with no ground shown between them.
    fn of_placed(
        survey: &Survey,
        placed: Vec<Option<Placed>>,
        returns: &FirstReturns,
        calibration: &Calibration,
        settings: &MosaicSettings,
    ) -> Self {
        let ranges = Side::BOTH.map(|side| side_ranges(survey, calibration, side));
        let far = |ranges: &Ranges| {
            f64::from(ranges.start_m) + f64::from(ranges.step_m) * f64::from(ranges.count)
        };
        Self {
            pings: (0..placed.len() as u32).collect(),
            stands_for: (0..placed.len() as u32).map(|ping| [ping, ping + 1]).collect(),
            joined: vec![false; placed.len()],
            altitudes_m: Side::BOTH.map(|side| altitudes_m(survey, returns, calibration, side)),
            shown_m: Default::default(),
            water_column: settings.water_column,
            far_m: ranges.iter().flatten().flatten().map(far).fold(0.1, f64::max),
            placed,
            ranges,
            relief: None,
            boxes: Vec::new(),
        }
    }

    /// Creates a layout with all pings at one place, for results that depend on ranges and
    /// altitudes alone, where the place of the boat is not known.
    pub fn placeless(survey: &Survey, returns: &FirstReturns, calibration: &Calibration) -> Self {
        let here = Placed { at: [0.0; 2], starboard: [1.0, 0.0] };
        let placed = vec![Some(here); survey.side_scan.len()];
        Self::of_placed(survey, placed, returns, calibration, &MosaicSettings::default())
    }

    /// Returns true if any side of any ping has a ray.
    pub fn has_rays(&self) -> bool {
        let rays = |side| (0..self.placed.len()).any(|ping| self.ray(ping, side).is_some());
        Side::BOTH.into_iter().any(rays)
    }

    /// Returns the layout with all ranges multiplied by a factor: for a speed of sound other than
    /// the one that the recorder assumed.
    pub fn with_range_factor(mut self, factor: f64) -> Self {
        for ranges in self.ranges.iter_mut().flatten().flatten() {
            ranges.start_m = (f64::from(ranges.start_m) * factor) as f32;
            ranges.step_m = (f64::from(ranges.step_m) * factor) as f32;
        }
        for altitude_m in self.altitudes_m.iter_mut().flatten() {
            *altitude_m = (f64::from(*altitude_m) * factor) as f32;
        }
        self.far_m *= factor;
        self.boxed()
    }

    /// Returns the layout on ground that is not level; the depths of `relief` must include the
    /// range factor.
    #[must_use]
    pub fn with_relief(mut self, relief: &Arc<Relief>) -> Self {
        if relief.is_level() {
            return self;
        }
        let under = |side: Side| {
            let altitudes = self.pings.par_iter().zip(&self.altitudes_m[side as usize]);
            let under = altitudes.map(|(ping, altitude_m)| {
                let across = relief.across(side, *ping as usize);
                across.altitude_m(f64::from(*altitude_m)) as f32
            });
            under.collect()
        };
        self.relief = Some((relief.clone(), Side::BOTH.map(under)));
        self.boxed()
    }

    /// Returns the layout without the excluded pings, and without the ground between them and their
    /// neighbours.
    #[must_use]
    pub fn without(mut self, exclusions: &Exclusions) -> Self {
        if exclusions.is_empty() {
            return self;
        }
        for (index, ping) in self.pings.iter().enumerate() {
            if exclusions.ping(*ping as usize).is_some() {
                self.placed[index] = None;
                self.joined[index] = false;
                if let Some(before) = index.checked_sub(1) {
                    self.joined[before] = false;
                }
            }
        }
        self.boxed()
    }

    fn boxed(mut self) -> Self {
        self.shown_m = Default::default();
        self.shown_m = Side::BOTH.map(|side| {
            let rays = (0..self.placed.len()).into_par_iter();
            let shown = rays.map(|ping| self.ray(ping, side).map_or(0.0, |ray| ray.shown_m));
            shown.collect()
        });
        let around = |index: usize| {
            let pings = index * BOXED..(index + 1) * BOXED;
            let strips = pings.flat_map(|ping| Side::BOTH.map(|side| self.strip(ping, side)));
            let bounds = strips.flatten().map(|strip| bounds(self.corners(&strip)));
            bounds.fold(NOWHERE, box_around)
        };
        let boxes = (0..self.placed.len().div_ceil(BOXED)).into_par_iter();
        self.boxes = boxes.map(around).collect();
        self
    }

    /// Returns the number of pings in the layout.
    pub fn len(&self) -> usize {
        self.pings.len()
    }

    /// Returns true if the layout has no ping.
    pub fn is_empty(&self) -> bool {
        self.pings.is_empty()
    }

    /// Returns the index in the survey of a ping of this layout.
    pub fn ping(&self, index: usize) -> Option<usize> {
        self.pings.get(index).map(|ping| *ping as usize)
    }

    /// Returns the range of pings of the survey that a ping of this layout represents, including
    /// itself.
    pub(crate) fn stands_for(&self, index: usize) -> std::ops::Range<usize> {
        let [from, to] = self.stands_for.get(index).copied().unwrap_or_default();
        from as usize..to as usize
    }

    /// Returns the bounds of all strips, with the ground between them; `None` when nothing is
    /// shown.
    pub fn bounds(&self) -> Option<Bounds> {
        let all = self.boxes.iter().copied().fold(NOWHERE, box_around);
        (all[0] <= all[2]).then_some(all)
    }

    /// Returns the strips that touch some ground, in the order that they were recorded: the ping of
    /// this layout at which a strip begins, and the side.
    pub fn strips_in(&self, ground: Bounds) -> impl Iterator<Item = (usize, Side)> {
        let boxes = self.boxes.iter().enumerate();
        let boxes = boxes.filter(move |(_, bounds)| boxes_meet(**bounds, ground));
        boxes.flat_map(move |(index, _)| {
            let pings = index * BOXED..(index + 1) * BOXED;
            pings.flat_map(move |ping| {
                Side::BOTH.into_iter().filter_map(move |side| {
                    let strip = self.strip(ping, side)?;
                    let corners = self.corners(&strip);
                    let is_near = boxes_meet(bounds(corners), ground);
                    (is_near && lies_on(&strip, &corners, &ground)).then_some((ping, side))
                })
            })
        })
    }

    /// Returns the ray of one side of a ping; `None` where the side was not recorded, the ping has
    /// no place, heading or altitude, or the boat turns.
    pub fn ray(&self, ping: usize, side: Side) -> Option<MosaicRay> {
        let placed = (*self.placed.get(ping)?)?;
        let ranges = (*self.ranges[side as usize].get(ping)?)?;
        let altitude_m = f64::from(*self.altitudes_m[side as usize].get(ping)?);
        let sign = side.to_starboard(1.0);
        let (across, under_m) = match &self.relief {
            Some((relief, under_m)) => (
                relief.across(side, *self.pings.get(ping)? as usize),
                f64::from(*under_m[side as usize].get(ping)?),
            ),
            None => (AcrossTrack::LEVEL, altitude_m),
        };
        let ray = (altitude_m > 0.0).then(|| MosaicRay {
            under_m,
            across,
            at: placed.at,
            out: placed.starboard.map(|component| sign * component),
            altitude_m,
            start_m: f64::from(ranges.start_m),
            step_m: f64::from(ranges.step_m),
            count: ranges.count as usize,
            shown_m: f64::NAN,
        })?;
        let known_m = self.shown_m[side as usize].get(ping).copied();
        Some(MosaicRay {
            shown_m: known_m.unwrap_or_else(|| ray.reach_m(self.water_column)),
            ..ray
        })
    }

    /// Returns the rays of the strip between a ping and the next on one side; `None` where it is
    /// not shown.
    pub fn strip(&self, ping: usize, side: Side) -> Option<[MosaicRay; 2]> {
        if !*self.joined.get(ping)? {
            return None;
        }
        Some([self.ray(ping, side)?, self.ray(ping + 1, side)?])
    }

    /// Returns the corners of a strip, in the order around it.
    pub fn corners(&self, strip: &[MosaicRay; 2]) -> [[f64; 2]; 4] {
        let reach_m = strip.iter().map(|ray| ray.shown_m).fold(0.0, f64::max);
        let [here, next] = strip;
        [here.at, here.place(reach_m), next.place(reach_m), next.at]
    }

    /// Returns all strips in the order that they were recorded: the ping at which a strip begins,
    /// the side and the rays.
    pub(super) fn strips(&self) -> impl Iterator<Item = (usize, Side, [MosaicRay; 2])> {
        let pings = 0..self.placed.len().saturating_sub(1);
        pings.flat_map(move |ping| {
            Side::BOTH
                .into_iter()
                .filter_map(move |side| Some((ping, side, self.strip(ping, side)?)))
        })
    }

    /// Returns the grid that holds every strip, its edges at whole cells; `None` when nothing is
    /// shown.
    pub fn grid(&self, cell_m: f64) -> Option<Grid> {
        self.bounds().map(|bounds| grid_over(bounds, cell_m))
    }

    /// Lists the strips that touch each tile of a grid.
    pub fn index(&self, grid: &Grid) -> TileIndex {
        let mut tiles: BTreeMap<(u32, u32), Vec<u32>> = BTreeMap::new();
        let tile_m = grid.cell_m * TILE_CELLS as f64;
        let last = |cells: usize| (cells.div_ceil(TILE_CELLS) as u32).saturating_sub(1);
        for (ping, side) in self.strips_in(grid.bounds_m()) {
            let Some(strip) = self.strip(ping, side) else {
                continue;
            };
            let corners = self.corners(&strip);
            let span = |axis: usize, from_m: f64, sign: f64, last: u32| {
                let places =
                    corners.map(|corner| (sign * (corner[axis] - from_m) / tile_m).max(0.0));
                let low = places.iter().copied().fold(f64::MAX, f64::min);
                let high = places.iter().copied().fold(0.0, f64::max);
                low as u32..=(high as u32).min(last)
            };
            for row in span(1, grid.north_m, -1.0, last(grid.rows)) {
                for column in span(0, grid.west_m, 1.0, last(grid.columns)) {
                    let north_m = grid.north_m - f64::from(row) * tile_m;
                    let west_m = grid.west_m + f64::from(column) * tile_m;
                    let ground = [west_m, north_m - tile_m, west_m + tile_m, north_m];
                    if !lies_on(&strip, &corners, &ground) {
                        continue;
                    }
                    let strips = tiles.entry((row, column)).or_default();
                    strips.push(2 * ping as u32 + side as u32);
                }
            }
        }
        TileIndex { tiles }
    }

    /// Returns a box around each strip.
    pub fn strip_bounds(&self) -> impl Iterator<Item = Bounds> {
        (self.strips()).map(|(_, _, strip)| bounds(self.corners(&strip)))
    }
}

/// Returns true if a strip may be on some ground that its bounds touch. Long, thin strips that run
/// diagonally are not on most of the ground in their bounds: all of that ground is on one side of
/// the strip, seen along its rays.
fn lies_on(
    strip: &[MosaicRay; 2],
    corners: &[[f64; 2]; 4],
    [west, south, east, north]: &Bounds,
) -> bool {
    let ground = [[*west, *south], [*west, *north], [*east, *south], [*east, *north]];
    strip.iter().all(|ray| {
        let reach = |places: &[[f64; 2]; 4]| {
            let off = |place: &[f64; 2]| {
                (place[0] - ray.at[0]) * ray.out[1] - (place[1] - ray.at[1]) * ray.out[0]
            };
            ends(places.iter().map(off))
        };
        let [strip, ground] = [reach(corners), reach(&ground)];
        strip[0] <= ground[1] && ground[0] <= strip[1]
    })
}

/// Returns the slant range of the first sample and the length of each sample, for every ping of a
/// side; `None` where these are not valid.
fn side_ranges(survey: &Survey, calibration: &Calibration, side: Side) -> Vec<Option<Ranges>> {
    let ranges = |ping: usize| {
        let span = survey.span(ping, side)?;
        let start_m = calibration.range_m(span, 0.0);
        let step_m = calibration.range_m(span, 1.0) - start_m;
        let count = survey.samples(ping, side)?.len() as u32;
        (step_m > 0.0 && count > 1).then_some(Ranges {
            start_m: start_m as f32,
            step_m: step_m as f32,
            count,
        })
    };
    (0..survey.side_scan.len()).map(ranges).collect()
}

/// Returns the distance from a ping to the next, metres; `None` where they are too far apart, in
/// distance or time, to show the ground between them.
pub fn joined_way_m(survey: &Survey, navigation: &Navigation, ping: usize) -> Option<f64> {
    let (here, next) = (navigation.pings.get(ping)?, navigation.pings.get(ping + 1)?);
    let way_m = f64::hypot(next.east_m - here.east_m, next.north_m - here.north_m);
    let pause_s = survey.side_scan.get(ping + 1)?.time_s - survey.side_scan.get(ping)?.time_s;
    (way_m <= LONGEST_STEP_M && pause_s <= LONGEST_PAUSE_S).then_some(way_m)
}

/// Returns the bounds of several layouts together; `None` when nothing is shown.
pub(super) fn bounds_of<'a>(layouts: impl Iterator<Item = &'a MosaicLayout>) -> Option<Bounds> {
    layouts.filter_map(MosaicLayout::bounds).reduce(box_around)
}

/// Returns the grid over some ground, its edges at whole cells.
pub(super) fn grid_over([west, south, east, north]: Bounds, cell_m: f64) -> Grid {
    let west_m = (west / cell_m).floor() * cell_m;
    let north_m = (north / cell_m).ceil() * cell_m;
    let cells = |length_m: f64| (length_m / cell_m).ceil().max(1.0) as usize;
    Grid { west_m, north_m, cell_m, columns: cells(east - west_m), rows: cells(north_m - south) }
}

/// Index of the strips that touch each tile, without the tiles that no strip touches.
#[derive(Clone, Debug, Default)]
pub struct TileIndex {
    tiles: BTreeMap<(u32, u32), Vec<u32>>,
}

impl TileIndex {
    /// Returns the tiles that show something, as row and column, from the north-west by rows.
    pub fn tiles(&self) -> impl Iterator<Item = (usize, usize)> {
        self.tiles.keys().map(|&(row, column)| (row as usize, column as usize))
    }

    /// Returns the strips of a tile, in the order that they were recorded: the ping at which a
    /// strip begins, and the side.
    pub fn strips(&self, row: usize, column: usize) -> impl Iterator<Item = (usize, Side)> {
        let key = u32::try_from(row).ok().zip(u32::try_from(column).ok());
        let strips = key.and_then(|key| self.tiles.get(&key));
        let strips = strips.into_iter().flatten().map(|strip| *strip as usize);
        strips.map(|strip| (strip / 2, Side::BOTH[strip % 2]))
    }
}

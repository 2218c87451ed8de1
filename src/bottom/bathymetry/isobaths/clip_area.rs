//! Cuts lines and areas at the edges of an area, such as a shoreline with its islands, and computes
//! the area and volume below a level in it.

use super::lines::LEAST_LENGTH_M;
use super::{DepthArea, Isobath, Polygon};
use crate::bathymetry::Surface;
use bathyscope_log::support::outline::{between, edges, is_crossed};
use bathyscope_log::support::statistics::{ends, sorted};
use i_overlay::core::fill_rule::FillRule;
use i_overlay::core::overlay_rule::OverlayRule;
use i_overlay::float::single::SingleFloatOverlay as _;
use serde::Serialize;

/// Distance beyond its ends at which a step still touches an edge, as a share of its length: where
/// a line passes through a corner, rounding must not let it slip between the two edges.
const SLACK: f64 = 1e-9;
/// Distance beyond its ends at which a step still reaches a band, metres.
const SLACK_M: f64 = 1e-6;
/// Distance below which two corners of an area count as one, metres: in the digits of files they
/// would fold into a spike.
const SAME_M: f64 = 0.002;
/// Largest number of bands, and largest number of bands that an edge lies in on average.
const MOST_BANDS: usize = 4096;
const MOST_TIMES: usize = 8;

/// Area in the plane of a map: a place is inside where an odd number of the rings go around it.
#[derive(Clone, Debug)]
pub struct ClipArea {
    /// Rings, each corner once.
    rings: Vec<Vec<[f64; 2]>>,
    edges: Vec<[[f64; 2]; 2]>,
    /// Edges in each band from west to east, so that few are examined; bands are in order from the
    /// south.
    bands: Vec<Vec<u32>>,
    south_m: f64,
    band_m: f64,
}

impl ClipArea {
    /// Creates an area from rings that contain each corner once; rings without three corners, and
    /// corners that are not finite, are ignored.
    pub fn new(rings: Vec<Vec<[f64; 2]>>) -> Self {
        let mut rings = rings;
        for ring in &mut rings {
            ring.retain(|corner| corner.iter().all(|value| value.is_finite()));
        }
        rings.retain(|ring| ring.len() > 2);
        let edges: Vec<[[f64; 2]; 2]> = rings.iter().flat_map(|ring| edges(ring)).collect();
        let [south_m, north_m] = ends(edges.iter().map(|edge| edge[0][1]));
        let mut count = edges.len().clamp(1, MOST_BANDS);
        let height_m = (north_m - south_m).max(f64::MIN_POSITIVE);
        let times = |count: usize| {
            let band_m = height_m / count as f64;
            let of_edge = |[from, to]: &[[f64; 2]; 2]| (from[1] - to[1]).abs() / band_m;
            edges.iter().map(of_edge).sum::<f64>()
        };
        while count > 1 && times(count) > (MOST_TIMES * edges.len()) as f64 {
            count /= 2;
        }
        let mut area = Self {
            rings,
            bands: vec![Vec::new(); count],
            south_m,
            band_m: height_m / count as f64,
            edges: Vec::new(),
        };
        for (index, [from, to]) in edges.iter().enumerate() {
            for band in area.bands_over(from[1], to[1]) {
                area.bands[band].push(index as u32);
            }
        }
        area.edges = edges;
        area
    }

    /// Returns true if no place lies in the area.
    pub fn is_empty(&self) -> bool {
        self.rings.is_empty()
    }

    /// Returns true if a place lies in the area.
    pub fn holds(&self, place: [f64; 2]) -> bool {
        let crosses = |index: &&u32| is_crossed(self.edges[**index as usize], place);
        let band = self.bands_over(place[1], place[1]).next();
        let near = band.and_then(|band| self.bands.get(band));
        near.is_some_and(|near| near.iter().filter(crosses).count() % 2 == 1)
    }

    /// Returns the parts of a line in the area, in the direction of the line. They end at the edges
    /// of the area.
    pub fn parts_of(&self, line: &Isobath) -> Vec<Isobath> {
        let mut parts: Vec<Vec<[f64; 2]>> = Vec::new();
        let mut is_inside = None;
        for step in line.points.windows(2) {
            let [from, to] = [step[0], step[1]];
            let shares = self.shares(from, to);
            let inner = shares.iter().filter(|share| (SLACK..=1.0 - SLACK).contains(*share));
            let mut stops: Vec<f64> = inner.copied().collect();
            stops.dedup_by(|stop, before| *stop - *before < SLACK);
            stops.insert(0, 0.0);
            stops.push(1.0);
            let at = |share: f64| {
                if share == 0.0 {
                    from
                } else if share == 1.0 {
                    to
                } else {
                    between(from, to, share)
                }
            };
            for ends in stops.windows(2) {
                // A step that meets no edge is inside where the step before it was.
                let known = is_inside.filter(|_| shares.is_empty());
                let now = known.unwrap_or_else(|| self.holds(at(0.5 * (ends[0] + ends[1]))));
                is_inside = Some(now);
                if !now {
                    continue;
                }
                let [begin, end] = [at(ends[0]), at(ends[1])];
                match parts.last_mut() {
                    Some(part) if part.last() == Some(&begin) => part.push(end),
                    _ => parts.push(vec![begin, end]),
                }
            }
        }
        if line.is_ring() {
            join_ends(&mut parts, line.points[0]);
        }
        let lines = parts.into_iter().map(|points| Isobath { points, ..*line });
        lines.filter(|line| line.length_m() > LEAST_LENGTH_M).collect()
    }

    /// Returns the part of a depth area that lies in this area.
    pub fn part_of(&self, area: &DepthArea) -> DepthArea {
        let open = |ring: &Vec<[f64; 2]>| ring[..ring.len().saturating_sub(1)].to_vec();
        let rings: Vec<Vec<[f64; 2]>> = (area.polygons.iter())
            .flat_map(|polygon| std::iter::once(&polygon.outline).chain(&polygon.holes))
            .map(open)
            .collect();
        let polygons = if rings.is_empty() || self.is_empty() {
            Vec::new()
        } else {
            // With integers of 64 bits, whose steps are far below those of the coordinates.
            rings.overlay_as::<i64>(&self.rings, OverlayRule::Intersect, FillRule::EvenOdd)
        };
        let polygon = |shape: Vec<Vec<[f64; 2]>>| {
            let mut rings = shape.into_iter().map(without_spikes);
            Some(Polygon { outline: rings.next()??, holes: rings.flatten().collect() })
        };
        DepthArea { polygons: polygons.into_iter().filter_map(polygon).collect(), ..*area }
    }

    /// Returns the bands that lie between two northings.
    fn bands_over(&self, one_m: f64, other_m: f64) -> std::ops::RangeInclusive<usize> {
        let last = self.bands.len() - 1;
        // Places north or south of all edges are in no ring, whatever band is searched.
        let band = |north_m: f64| ((north_m - self.south_m) / self.band_m) as usize;
        band(one_m.min(other_m) - SLACK_M).min(last)..=band(one_m.max(other_m) + SLACK_M).min(last)
    }

    /// Returns the places where a step touches edges, as rising shares of the step; a step that
    /// ends at an edge touches it.
    fn shares(&self, from: [f64; 2], to: [f64; 2]) -> Vec<f64> {
        let way = [to[0] - from[0], to[1] - from[1]];
        let cross = |a: [f64; 2], b: [f64; 2]| a[0] * b[1] - a[1] * b[0];
        let share = |index: &u32| {
            let [begin, end] = self.edges[*index as usize];
            let edge = [end[0] - begin[0], end[1] - begin[1]];
            let off = [begin[0] - from[0], begin[1] - from[1]];
            let turn = cross(way, edge);
            let along = [cross(off, edge) / turn, cross(off, way) / turn];
            let meets = |share: &f64| (-SLACK..=1.0 + SLACK).contains(share);
            // A step that is parallel to an edge meets the edges next to this one instead.
            (turn != 0.0 && along.iter().all(meets)).then_some(along[0])
        };
        let bands = self.bands_over(from[1], to[1]);
        let near = self.bands[bands].iter().flatten();
        sorted(near.filter_map(share))
    }
}

/// Closes a ring that contains each corner once, and removes corners that are nearly the same as
/// the one before or the one before that; `None` where nothing is left.
fn without_spikes(ring: Vec<[f64; 2]>) -> Option<Vec<[f64; 2]>> {
    let is_same = |a: [f64; 2], b: [f64; 2]| (a[0] - b[0]).hypot(a[1] - b[1]) < SAME_M;
    let mut kept: Vec<[f64; 2]> = Vec::with_capacity(ring.len() + 1);
    for corner in ring {
        match kept.as_slice() {
            [.., last] if is_same(*last, corner) => {}
            [.., before, _] if is_same(*before, corner) => _ = kept.pop(),
            _ => kept.push(corner),
        }
    }
    // The same where the ring ends and begins.
    loop {
        match kept.as_slice() {
            [first, .., last] if is_same(*first, *last) => _ = kept.pop(),
            [first, .., before, _] if is_same(*first, *before) => _ = kept.pop(),
            [_, second, .., last] if is_same(*second, *last) => _ = kept.remove(0),
            _ => break,
        }
    }
    kept.extend(kept.first().copied());
    (kept.len() > 3).then_some(kept)
}

/// Joins the ends of a ring that was cut: the part that ends where the line began continues with
/// the part that begins there.
fn join_ends(parts: &mut Vec<Vec<[f64; 2]>>, start: [f64; 2]) {
    let begins = parts.first().and_then(|part| part.first()) == Some(&start);
    let ends = parts.last().and_then(|part| part.last()) == Some(&start);
    if parts.len() > 1 && begins && ends {
        let first = parts.remove(0);
        if let Some(last) = parts.last_mut() {
            last.extend(first.into_iter().skip(1));
        }
    }
}

/// Part of a surface below a level.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Storage {
    /// Depth of the level, metres.
    pub depth_m: f64,
    /// Area of the bottom that is deeper than the level, seen from above, square metres.
    pub area_m2: f64,
    /// Volume of water between the level and the bottom below it, cubic metres.
    pub volume_m3: f64,
}

/// Returns the area and volume below each level. Every cell counts as a column of its own depth;
/// cells without a depth do not count, nor do cells whose centre lies outside `clip_area`, if
/// given.
///
/// The levels with their areas and volumes are a reservoir's table.
pub fn storage(surface: &Surface, levels_m: &[f64], clip_area: Option<&ClipArea>) -> Vec<Storage> {
    let is_within = |cell: usize| {
        let middle = surface.grid.centre_of(cell);
        clip_area.is_none_or(|area| area.holds(middle))
    };
    let known = surface.depth_m.iter().enumerate();
    let known = known.filter(|(cell, depth)| !depth.is_nan() && is_within(*cell));
    let depths = sorted(known.map(|(_, depth)| f64::from(*depth)));
    // Sums of the depths from the deepest up to each place in the order.
    let mut deepest_first = Vec::with_capacity(depths.len() + 1);
    let mut sum_m = 0.0;
    deepest_first.push(sum_m);
    for depth in depths.iter().rev() {
        sum_m += depth;
        deepest_first.push(sum_m);
    }
    let cell_m2 = surface.grid.cell_m.powi(2);
    let below = |&level_m: &f64| {
        let deeper = depths.len() - depths.partition_point(|depth| *depth < level_m);
        Storage {
            depth_m: level_m,
            area_m2: cell_m2 * deeper as f64,
            volume_m3: cell_m2 * (deepest_first[deeper] - level_m * deeper as f64),
        }
    };
    levels_m.iter().map(below).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A bay with a notch in the north and an island.
    fn bay() -> ClipArea {
        ClipArea::new(vec![
            vec![[0.0, 0.0], [10.0, 0.0], [10.0, 10.0], [5.0, 4.0], [0.0, 10.0]],
            vec![[2.0, 1.0], [3.0, 1.0], [3.0, 2.0], [2.0, 2.0]],
        ])
    }

    fn line(points: &[[f64; 2]]) -> Isobath {
        Isobath { depth_m: 2.0, points: points.to_vec() }
    }

    fn cut(points: &[[f64; 2]]) -> Vec<Vec<[f64; 2]>> {
        let parts = bay().parts_of(&line(points)).into_iter();
        parts.map(|part| part.points).collect()
    }

    #[test]
    fn a_place_is_in_it_but_not_on_an_island() {
        let places = [[1.0, 1.0], [2.5, 1.5], [5.0, 5.0], [9.5, 9.0], [-1.0, 3.0], [4.0, 99.0]];
        let held = places.map(|place| bay().holds(place));
        assert_eq!(held, [true, false, false, true, false, false]);
        assert!(
            !ClipArea::new(vec![vec![[0.0, 0.0], [f64::NAN, 1.0], [2.0, 2.0]]]).holds([1.0; 2])
        );
    }

    #[test]
    fn a_line_ends_at_edges_and_goes_on_behind_islands_and_notches() {
        let across = cut(&[[-5.0, 1.5], [15.0, 1.5]]);
        assert_eq!(across, [[[0.0, 1.5], [2.0, 1.5]], [[3.0, 1.5], [10.0, 1.5]]]);
        // Through the notch, in several steps.
        let steps = cut(&[[-1.0, 7.0], [1.0, 7.0], [5.0, 7.0], [9.0, 7.0], [11.0, 7.0]]);
        assert_eq!(steps.len(), 2);
        assert_eq!(steps[0], [[0.0, 7.0], [1.0, 7.0], [2.5, 7.0]]);
        assert_eq!(steps[1], [[7.5, 7.0], [9.0, 7.0], [10.0, 7.0]]);
        assert_eq!(cut(&[[20.0, 0.0], [30.0, 5.0]]), Vec::<Vec<[f64; 2]>>::new());
    }

    #[test]
    fn a_line_through_corners_and_along_edges_is_neither_lost_nor_let_out() {
        // From the west through the corner of the notch and out in the east.
        let through = cut(&[[-2.0, 4.0], [5.0, 4.0], [12.0, 4.0]]);
        let length: f64 = through.iter().map(|part| line(part).length_m()).sum();
        assert!((length - 10.0).abs() < 1e-9, "{through:?}");
        // Along the southern edge, then out, and back in through a corner.
        let along =
            cut(&[[-1.0, 0.0], [6.0, 0.0], [6.0, -2.0], [10.0, -2.0], [10.0, 0.0], [8.0, 3.0]]);
        let last = along.last().expect("the part after the corner");
        assert_eq!(last.last(), Some(&[8.0, 3.0]));
        assert!(along.iter().flatten().all(|at| at[1] > -1e-9), "{along:?}");
    }

    #[test]
    fn a_ring_inside_stays_one_and_one_that_is_cut_has_no_seam() {
        let inside = [[6.0, 1.0], [8.0, 1.0], [8.0, 3.0], [6.0, 1.0]];
        assert_eq!(cut(&inside), [inside.to_vec()]);
        // The ring is whole around the island, and open where it leaves in the south; it begins
        // inside.
        let ring = [[7.0, 1.0], [7.0, -1.0], [4.0, -1.0], [4.0, 1.0], [7.0, 1.0]];
        let parts = cut(&ring);
        assert_eq!(parts, [[[4.0, 0.0], [4.0, 1.0], [7.0, 1.0], [7.0, 0.0]]]);
    }

    #[test]
    fn an_area_is_what_it_shares_with_the_polygon() {
        let square = |west: f64, south: f64, side: f64| {
            let east = west + side;
            let north = south + side;
            vec![[west, south], [east, south], [east, north], [west, north], [west, south]]
        };
        let hole: Vec<[f64; 2]> = square(6.0, 1.0, 1.0).into_iter().rev().collect();
        let area = DepthArea {
            from_m: 1.0,
            to_m: 2.0,
            polygons: vec![Polygon { outline: square(-5.0, -5.0, 20.0), holes: vec![hole] }],
        };
        let part = bay().part_of(&area);
        // The bay without its notch, its island and the hole.
        assert!((part.area_m2() - (100.0 - 30.0 - 1.0 - 1.0)).abs() < 1e-9);
        assert_eq!(part.polygons.len(), 1);
        let polygon = &part.polygons[0];
        assert_eq!(polygon.holes.len(), 2);
        assert_eq!(polygon.outline.first(), polygon.outline.last());
        assert!(part.polygons.iter().all(|polygon| polygon.area_m2() > 0.0));
        let spiked =
            [[0.0, 0.0], [4.0, 0.0], [4.0, 1e-4], [9.0, 0.0], [4.0, 5e-4], [4.0, 4.0], [0.0, 1e-3]];
        let triangle = [[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [0.0, 0.0]];
        assert_eq!(without_spikes(spiked.to_vec()), Some(triangle.to_vec()));
        assert_eq!(without_spikes(spiked[1..5].to_vec()), None);
        let nothing = ClipArea::new(Vec::new());
        assert!(nothing.is_empty() && nothing.part_of(&area).polygons.is_empty());
    }

    #[test]
    fn what_is_cut_is_inside_however_many_corners_there_are() {
        // A star of many corners, and lines across it: their parts are as long as the places in it
        // are many.
        let corners = (0..3000).map(|index| {
            let turn = f64::from(index) / 3000.0 * std::f64::consts::TAU;
            let out_m = 50.0 + 20.0 * (37.0 * turn).sin();
            [out_m * turn.cos(), out_m * turn.sin()]
        });
        let star = ClipArea::new(vec![corners.collect()]);
        for row in -60..60 {
            let north_m = f64::from(row) + 0.31;
            let points: Vec<[f64; 2]> =
                (-800..=800).map(|step| [f64::from(step) / 10.0, north_m]).collect();
            let parts = star.parts_of(&line(&points));
            let cut_m: f64 = parts.iter().map(Isobath::length_m).sum();
            let held = (0..160_000)
                .filter(|step| star.holds([f64::from(*step) / 1000.0 - 80.0 + 0.0005, north_m]));
            let held_m = held.count() as f64 / 1000.0;
            assert!((cut_m - held_m).abs() < 0.05, "{north_m}: {cut_m} {held_m}");
        }
    }
}

//! Finds where tracks cross and how far the depths of the two passes differ there: a survey's own
//! measure of its repeatability.

use bathyscope_log::support::progress::{Cancelled, Progress};
use bathyscope_log::support::statistics::median;
use std::collections::HashMap;

/// A depth along a track.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TrackDepth {
    /// Time, seconds, by the same clock for all depths of a track.
    pub time_s: f64,
    /// East coordinate, metres.
    pub east_m: f64,
    /// North coordinate, metres.
    pub north_m: f64,
    /// Depth, metres.
    pub depth_m: f64,
}

impl TrackDepth {
    /// Creates a depth at a time and a place.
    pub fn new(time_s: f64, [east_m, north_m]: [f64; 2], depth_m: f64) -> Self {
        Self { time_s, east_m, north_m, depth_m }
    }
}

/// One of the two passes over a crossing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CrosslinePass {
    /// Index of the track.
    pub track: usize,
    /// Time of the pass, seconds.
    pub time_s: f64,
    /// Median of the depths of this pass within [`REACH_M`] of the crossing, or the depth
    /// interpolated between its neighbours where none is so near, metres.
    pub depth_m: f64,
    /// Velocity of the boat, metres a second to the east and north.
    pub velocity_mps: [f64; 2],
}

/// A place where two passes cross.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Crossing {
    /// East and north, metres.
    pub place: [f64; 2],
    /// The two passes: the earlier one, or that of the earlier track, first.
    pub passes: [CrosslinePass; 2],
    /// Angle between the two courses, degrees, at most 90.
    pub angle_deg: f64,
    /// Increase of the depth per metre to the east and to the north, metres, from the depths along
    /// both passes; NaN where they are too few.
    pub gradient: [f64; 2],
}

impl Crossing {
    /// Returns the elevation by the second pass minus that by the first, metres: up is positive.
    pub fn difference_m(&self) -> f64 {
        self.passes[0].depth_m - self.passes[1].depth_m
    }

    /// Returns the slope of the bottom, metres a metre; NaN where it is not known.
    pub(crate) fn slope(&self) -> f64 {
        self.gradient[0].hypot(self.gradient[1])
    }
}

/// Greatest distance from a crossing, along their own track, of the depths that count there,
/// metres.
pub const REACH_M: f64 = 0.5;
/// Greatest distance from a crossing, along their own track, of the depths that give the slope
/// there: in metres, and for coarser tracks as a number of usual pieces; and the fewest such
/// depths.
const SLOPE_REACH_M: f64 = 3.0;
const SLOPE_REACH: f64 = 3.0;
const LEAST_FOR_SLOPE: usize = 5;
/// Least angle between the courses of a crossing, degrees: at a smaller angle tracks run along each
/// other, and where they cross is chance.
pub const LEAST_ANGLE_DEG: f64 = 20.0;
/// Least way along a track between the two passes of a crossing, metres: a boat that has gone less
/// far has not come back, it has stayed.
const LEAST_WAY_M: f64 = 10.0;
/// Least length of the straight pieces that a track is divided into, metres: shorter pieces have
/// chance directions.
const PIECE_M: f64 = 0.5;
/// Longest piece of a track that spans no gap, in metres, in seconds, and as a number of usual
/// pieces for tracks whose depths are farther apart.
const LONGEST_PIECE_M: f64 = 5.0;
const LONGEST_PIECE_S: f64 = 5.0;
const LONGEST_PIECE: f64 = 3.0;
/// Upper limit of this length for all tracks, metres: a longer piece would lie in too many squares.
const MOST_PIECE_M: f64 = 100.0;
/// Least and greatest time between a depth and the two places that give its velocity, seconds.
const VELOCITY_S: [f64; 2] = [1.0, 10.0];
/// Side of the squares that pieces are sorted into, metres.
const SQUARE_M: f64 = 5.0;
/// Largest number of crossings that are returned: those of a boat that circles for a day would fill
/// the memory.
const MOST: usize = 1_000_000;

/// Returns the crossings of tracks with themselves and each other, in the order of their first
/// pass. Each track is in time order.
///
/// # Errors
/// When the work was cancelled.
pub fn crossings(
    tracks: &[Vec<TrackDepth>],
    progress: &Progress,
) -> Result<Vec<Crossing>, Cancelled> {
    let pieces: Vec<Piece> =
        tracks.iter().enumerate().flat_map(|(track, depths)| pieces(track, depths)).collect();
    let mut squares: HashMap<[i64; 2], Vec<usize>> = HashMap::new();
    for (index, piece) in pieces.iter().enumerate() {
        for square in piece.squares() {
            squares.entry(square).or_default().push(index);
        }
    }
    progress.start(squares.len() as u64);
    let mut found = Vec::new();
    for (square, inside) in &squares {
        for (rank, &first) in inside.iter().enumerate() {
            // A boat at anchor for a day has all its pieces in one square, so this loop may take
            // long.
            progress.check()?;
            for &second in &inside[rank + 1..] {
                let track_crossing = pieces[first].crosses(&pieces[second], *square);
                let crossing = track_crossing.map(|at| at.crossing(tracks));
                found.extend(crossing.filter(|_| found.len() < MOST));
            }
        }
        progress.advance(1);
    }
    let order = |crossing: &Crossing| crossing.passes.map(|pass| (pass.track, pass.time_s));
    found.sort_by(|a, b| order(a).partial_cmp(&order(b)).unwrap_or(std::cmp::Ordering::Equal));
    Ok(found)
}

/// Returns the velocity of the boat at a depth of a track, metres a second to the east and north:
/// from the nearest places at least a second before and after the depth. Where there is none within
/// ten seconds, the depth's own place replaces it.
pub fn velocity_mps(track: &[TrackDepth], index: usize) -> [f64; 2] {
    let here = &track[index];
    let is_far = |depth: &&TrackDepth| (depth.time_s - here.time_s).abs() >= VELOCITY_S[0];
    let is_near = |depth: &&TrackDepth| (depth.time_s - here.time_s).abs() <= VELOCITY_S[1];
    let behind = track[..index].iter().rev().find(is_far).filter(is_near);
    let ahead = track[index..].iter().find(is_far).filter(is_near);
    let (from, to) = (behind.unwrap_or(here), ahead.unwrap_or(here));
    let span_s = to.time_s - from.time_s;
    let way = [to.east_m - from.east_m, to.north_m - from.north_m];
    if span_s > 0.0 { way.map(|metres| metres / span_s) } else { [0.0; 2] }
}

/// Longest way and longest time from one depth of a track to the next that is no gap in the track.
#[derive(Clone, Copy, Debug)]
pub(super) struct Gaps {
    /// Longest way, metres.
    pub(super) longest_m: f64,
    /// Longest time, seconds.
    longest_s: f64,
    /// Distance within which depths give the slope, metres.
    slope_reach_m: f64,
}

impl Gaps {
    /// Returns the limits of a track, computed from its usual piece.
    pub(super) fn of(depths: &[TrackDepth]) -> Self {
        let (mut ways_m, mut times_s) = (Vec::new(), Vec::new());
        let mut from = depths.first();
        for here in depths {
            let Some(before) = from.filter(|before| way_m(before, here) >= PIECE_M) else {
                continue;
            };
            ways_m.push(way_m(before, here));
            times_s.push(here.time_s - before.time_s);
            from = Some(here);
        }
        let usual = |values: &mut [f64]| if values.is_empty() { 0.0 } else { median(values) };
        let (usual_m, usual_s) = (usual(&mut ways_m), usual(&mut times_s));
        Self {
            longest_m: LONGEST_PIECE_M.max((LONGEST_PIECE * usual_m).min(MOST_PIECE_M)),
            longest_s: LONGEST_PIECE_S.max(LONGEST_PIECE * usual_s),
            slope_reach_m: SLOPE_REACH_M.max((SLOPE_REACH * usual_m).min(MOST_PIECE_M)),
        }
    }

    /// Returns true if there is a gap in the track between two depths.
    pub(super) fn is_gap(&self, from: &TrackDepth, to: &TrackDepth) -> bool {
        way_m(from, to) > self.longest_m || to.time_s - from.time_s > self.longest_s
    }
}

/// Returns the straight distance from one depth to another, metres.
pub(super) fn way_m(from: &TrackDepth, to: &TrackDepth) -> f64 {
    (to.east_m - from.east_m).hypot(to.north_m - from.north_m)
}

/// Straight piece of a track, between two of its depths.
struct Piece {
    track: usize,
    /// Distance within which depths give the slope, metres.
    slope_reach_m: f64,
    /// Indices of the depths at the ends of the piece.
    ends: [usize; 2],
    from: [f64; 2],
    to: [f64; 2],
    /// Way along the track up to the start of the piece, metres.
    along_m: f64,
}

/// Returns the pieces of a track, without those that span a gap.
fn pieces(track: usize, depths: &[TrackDepth]) -> Vec<Piece> {
    let gaps = Gaps::of(depths);
    let mut found = Vec::new();
    let mut along_m = 0.0;
    let mut start: Option<usize> = None;
    for (index, here) in depths.iter().enumerate() {
        let Some(before) = start.map(|start| &depths[start]) else {
            start = Some(index);
            continue;
        };
        let length_m = way_m(before, here);
        if length_m < PIECE_M {
            continue;
        }
        if !gaps.is_gap(before, here) {
            found.push(Piece {
                track,
                slope_reach_m: gaps.slope_reach_m,
                ends: [start.unwrap_or(index), index],
                from: [before.east_m, before.north_m],
                to: [here.east_m, here.north_m],
                along_m,
            });
        }
        along_m += length_m;
        start = Some(index);
    }
    found
}

/// Crossing of two pieces of tracks.
struct TrackCrossing<'a> {
    pieces: [&'a Piece; 2],
    place: [f64; 2],
    /// Place of the crossing along each piece, 0 to 1.
    shares: [f64; 2],
    angle_deg: f64,
}

/// Returns the slope of the straight line of depth against the way in a direction, by least
/// squares; NaN where the depths are too few or lie in one place.
fn slope_along<'a>(
    depths: impl Iterator<Item = &'a TrackDepth>,
    place: [f64; 2],
    direction: [f64; 2],
) -> f64 {
    let (mut count, mut sums) = (0, [0.0; 4]);
    for depth in depths {
        let way_m =
            (depth.east_m - place[0]) * direction[0] + (depth.north_m - place[1]) * direction[1];
        let added = [way_m, depth.depth_m, way_m * way_m, way_m * depth.depth_m];
        sums = [0, 1, 2, 3].map(|index| sums[index] + added[index]);
        count += 1;
    }
    if count < LEAST_FOR_SLOPE {
        return f64::NAN;
    }
    let [way, depth, square, product] = sums.map(|sum| sum / count as f64);
    (product - way * depth) / (square - way * way)
}

impl Piece {
    /// Returns the unit vector from the start of the piece to its end.
    fn direction(&self) -> [f64; 2] {
        let way = [self.to[0] - self.from[0], self.to[1] - self.from[1]];
        let length_m = way[0].hypot(way[1]);
        way.map(|component| component / length_m)
    }

    fn squares(&self) -> impl Iterator<Item = [i64; 2]> + use<> {
        let square = |metres: f64| (metres / SQUARE_M).floor() as i64;
        let span = |axis: usize| {
            let (a, b) = (square(self.from[axis]), square(self.to[axis]));
            a.min(b)..=a.max(b)
        };
        let norths = span(1);
        span(0).flat_map(move |east| norths.clone().map(move |north| [east, north]))
    }

    /// Returns the crossing with another piece, if it lies in `square` (the two pieces may share
    /// several squares).
    fn crosses<'a>(&'a self, other: &'a Piece, square: [i64; 2]) -> Option<TrackCrossing<'a>> {
        let way_m = (other.along_m - self.along_m).abs();
        if self.track == other.track && way_m < LEAST_WAY_M {
            return None;
        }
        let [a, b] =
            [self, other].map(|piece| [piece.to[0] - piece.from[0], piece.to[1] - piece.from[1]]);
        let cross = a[0] * b[1] - a[1] * b[0];
        let dot = a[0] * b[0] + a[1] * b[1];
        let angle_deg = cross.abs().atan2(dot.abs()).to_degrees();
        if angle_deg < LEAST_ANGLE_DEG {
            return None;
        }
        let between = [other.from[0] - self.from[0], other.from[1] - self.from[1]];
        let shares = [
            (between[0] * b[1] - between[1] * b[0]) / cross,
            (between[0] * a[1] - between[1] * a[0]) / cross,
        ];
        // An end belongs to the piece that begins there.
        let inside = shares.iter().all(|share| (0.0..1.0).contains(share));
        let place = [self.from[0] + shares[0] * a[0], self.from[1] + shares[0] * a[1]];
        let here = place.map(|metres| (metres / SQUARE_M).floor() as i64);
        (inside && here == square).then_some(TrackCrossing {
            pieces: [self, other],
            place,
            shares,
            angle_deg,
        })
    }
}

impl TrackCrossing<'_> {
    fn crossing(&self, tracks: &[Vec<TrackDepth>]) -> Crossing {
        let passes = [0, 1].map(|index| {
            let (piece, share) = (self.pieces[index], self.shares[index]);
            self.pass(piece, share, &tracks[piece.track])
        });
        Crossing {
            place: self.place,
            passes,
            angle_deg: self.angle_deg,
            gradient: self.gradient(tracks),
        }
    }

    /// Returns the gradient of the depth, to the east and north: that of the plane that falls along
    /// each pass as the depths of this pass do.
    fn gradient(&self, tracks: &[Vec<TrackDepth>]) -> [f64; 2] {
        let [a, b] = self.pieces.map(Piece::direction);
        let [along_a, along_b] = [0, 1].map(|index| {
            let (piece, share) = (self.pieces[index], self.shares[index]);
            let middle = piece.ends[usize::from(share >= 0.5)];
            let near = self.depths_near(piece.slope_reach_m, &tracks[piece.track], middle);
            slope_along(near, self.place, piece.direction())
        });
        let cross = a[0] * b[1] - a[1] * b[0];
        let east = (along_a * b[1] - along_b * a[1]) / cross;
        let north = (along_b * a[0] - along_a * b[0]) / cross;
        [east, north]
    }

    /// Returns the depths of a pass within a distance of the crossing, outwards from `middle`,
    /// since the other pass may lie in the same track.
    fn depths_near<'a>(
        &self,
        reach_m: f64,
        depths: &'a [TrackDepth],
        middle: usize,
    ) -> impl Iterator<Item = &'a TrackDepth> + use<'a> {
        let place = self.place;
        let near = move |depth: &&TrackDepth| {
            (depth.east_m - place[0]).hypot(depth.north_m - place[1]) <= reach_m
        };
        let before = depths[..middle].iter().rev().take_while(near);
        before.chain(depths[middle..].iter().take_while(near))
    }

    fn pass(&self, piece: &Piece, share: f64, depths: &[TrackDepth]) -> CrosslinePass {
        let ends = piece.ends.map(|end| &depths[end]);
        let between = |value: fn(&TrackDepth) -> f64| {
            let [from, to] = ends.map(value);
            from + share * (to - from)
        };
        let middle = piece.ends[usize::from(share >= 0.5)];
        let near = self.depths_near(REACH_M, depths, middle);
        let mut values: Vec<f64> = near.map(|depth| depth.depth_m).collect();
        if values.is_empty() {
            values.push(between(|depth| depth.depth_m));
        }
        CrosslinePass {
            track: piece.track,
            time_s: between(|depth| depth.time_s),
            depth_m: median(&mut values),
            velocity_mps: velocity_mps(depths, middle),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn bed_m(east_m: f64, north_m: f64) -> f64 {
        3.0 + 0.05 * east_m - 0.02 * north_m
    }

    /// A figure of loops, 0.1 m between depths, each pass measured a millimetre deeper a second.
    fn loops() -> Vec<TrackDepth> {
        // Once around: a second lap would lie on the first.
        (0..3900)
            .map(|index| {
                let turn = f64::from(index) * 0.0016;
                let (east_m, north_m) = (40.0 * (3.0 * turn).sin(), 30.0 * (2.0 * turn).sin());
                let time_s = 0.05 * f64::from(index);
                let depth_m = bed_m(east_m, north_m) + 0.001 * time_s;
                TrackDepth::new(time_s, [east_m, north_m], depth_m)
            })
            .collect()
    }

    #[test]
    fn every_crossing_of_a_search_through_all_pairs_is_found() {
        let track = loops();
        let found = crossings(std::slice::from_ref(&track), &Progress::new()).unwrap();
        let pieces = pieces(0, &track);
        let mut brute = 0;
        for (rank, a) in pieces.iter().enumerate() {
            for b in &pieces[rank + 1..] {
                let side = |p: &Piece, q: [f64; 2]| {
                    (p.to[0] - p.from[0]) * (q[1] - p.from[1])
                        - (p.to[1] - p.from[1]) * (q[0] - p.from[0])
                };
                let apart =
                    side(a, b.from) * side(a, b.to) < 0.0 && side(b, a.from) * side(b, a.to) < 0.0;
                brute += usize::from(apart && (b.along_m - a.along_m) >= LEAST_WAY_M);
            }
        }
        assert!(brute >= 6, "{brute}");
        assert_eq!(found.len(), brute);
        for crossing in &found {
            let [first, second] = crossing.passes;
            // The second pass is deeper by the time between, so its elevation is lower.
            let expected_m = -0.001 * (second.time_s - first.time_s);
            assert!(second.time_s > first.time_s);
            // The depths around a crossing are not quite even about it.
            assert!((crossing.difference_m() - expected_m).abs() < 0.006, "{crossing:?}");
            // The bed falls 5 in the hundred to the east and rises 2 to the north.
            assert!((crossing.slope() - 0.0539).abs() < 0.004, "{crossing:?}");
        }
    }

    #[test]
    fn tracks_of_slow_recorders_cross_and_tell_the_slope() {
        // A depth each 5 s and 10 m; and one of a fast recorder.
        let line = |step_m: f64, along: fn(f64) -> [f64; 2]| -> Vec<TrackDepth> {
            let ways_m = (0..).map(|index| step_m * f64::from(index) - 61.0);
            let depth = |way_m: f64| {
                let place = along(way_m);
                TrackDepth::new(0.5 * way_m, place, bed_m(place[0], place[1]))
            };
            ways_m.take_while(|way_m| *way_m < 60.0).map(depth).collect()
        };
        for steps_m in [[10.0, 10.0], [0.1, 10.0], [10.0, 2.0]] {
            let tracks =
                [line(steps_m[0], |way_m| [way_m, 1.0]), line(steps_m[1], |way_m| [2.0, way_m])];
            let found = crossings(&tracks, &Progress::new()).unwrap();
            assert_eq!(found.len(), 1, "{steps_m:?}");
            assert!(found[0].difference_m().abs() < 0.03, "{steps_m:?} {:?}", found[0]);
            assert!(
                (found[0].slope() - 0.05f64.hypot(0.02)).abs() < 1e-6,
                "{steps_m:?} {:?}",
                found[0]
            );
            // Over a gap the track is not known.
            let mut cut = tracks;
            for track in &mut cut {
                track.retain(|depth| depth.east_m.abs().max(depth.north_m.abs()) > 25.0);
            }
            assert!(crossings(&cut, &Progress::new()).unwrap().is_empty(), "{steps_m:?}");
        }
    }

    #[test]
    fn tracks_cross_each_other_and_neighbours_do_not_count() {
        let line = |east: bool, offset_m: f64| -> Vec<TrackDepth> {
            (0..200)
                .map(|index| {
                    let along_m = 0.1 * f64::from(index) - 10.0;
                    let place = if east { [along_m, 0.03] } else { [0.02, along_m] };
                    let depth_m = bed_m(place[0], place[1]) + offset_m;
                    TrackDepth::new(f64::from(index), place, depth_m)
                })
                .collect()
        };
        let found = crossings(&[line(true, 0.0), line(false, 0.25)], &Progress::new()).unwrap();
        assert_eq!(found.len(), 1);
        assert!((found[0].difference_m() + 0.25).abs() < 2e-3);
        assert!((found[0].angle_deg - 90.0).abs() < 1e-9);
        let along = [line(true, 0.0), line(true, 0.1)];
        assert!(crossings(&along, &Progress::new()).unwrap().is_empty());
        let resting = vec![line(true, 0.0)[0]; 500];
        assert!(crossings(&[resting], &Progress::new()).unwrap().is_empty());
    }
}

//! Finds the part of a polygon that a side of a ping insonified.

use super::footprint::{CoveredSamples, Footprint, SideRange};
use bathyscope_log::support::geo::{LonLat, UtmZone};
use bathyscope_log::support::outline::{bounds, goes_around};

/// Closed rings in the metres of a zone. A place is in the area if an odd number of rings go around
/// it; an island is therefore a further ring.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Area {
    rings: Vec<Vec<[f64; 2]>>,
    /// West, south, east and north.
    pub bounds_m: [f64; 4],
}

impl Area {
    /// Creates an area from rings of corners, each corner named once; `None` without a corner.
    pub(super) fn new(zone: UtmZone, rings: &[Vec<LonLat>]) -> Option<Self> {
        let closed = |ring: &Vec<LonLat>| {
            let corners = ring.iter().chain(ring.first());
            corners.map(|at| zone.to_metres(*at)).collect()
        };
        Self::of(rings.iter().map(closed).collect())
    }

    fn of(rings: Vec<Vec<[f64; 2]>>) -> Option<Self> {
        let corners = || rings.iter().flatten().copied();
        corners().next()?;
        Some(Self { bounds_m: bounds(corners()), rings })
    }

    /// Returns the samples of each side of a ping, port first, that lie in the area, from the
    /// nearest to the farthest. The footprint of a side is a rectangle next to the boat; its
    /// overlap with the area ends at corners of the area, at corners of the rectangle, and where
    /// their edges cross.
    pub(super) fn seen_by(&self, ping: &Footprint) -> [Option<CoveredSamples>; 2] {
        let local = |ring: &Vec<[f64; 2]>| ring.iter().map(|at| ping.on_ground(*at)).collect();
        let rings: Vec<Vec<[f64; 2]>> = self.rings.iter().map(local).collect();
        let seen = |side: &SideRange, sign: f64| {
            let [near_m, far_m] = side.ground_m(ping.altitude_m)?;
            let across = [sign * near_m, sign * far_m];
            let along = [-ping.behind_m, ping.ahead_m];
            let ground = [across[0].min(across[1]), along[0], across[0].max(across[1]), along[1]];
            let is_within = |place: &[f64; 2]| {
                rings.iter().filter(|ring| goes_around(ring, *place)).count() % 2 == 1
            };
            let corners = across.iter().flat_map(|x| along.map(|y| [*x, y]));
            let edges = rings.iter().flat_map(|ring| ring.windows(2));
            let crossed = edges.filter_map(|edge| inside(edge[0], edge[1], ground)).flatten();
            let reached = corners.filter(is_within).chain(crossed);
            let reached_m = reached.map(|[x, _]| [(sign * x).max(near_m); 2]);
            let ends_m = reached_m.reduce(|[a, b], [from, to]| [a.min(from), b.max(to)]);
            Some(side.seen(ping.altitude_m, ends_m?, 0.0))
        };
        [0, 1].map(|side| seen(ping.sides[side].as_ref()?, [-1.0, 1.0][side]))
    }
}

/// Returns the ends of the part of a line that lies in a rectangle (west, south, east and north),
/// after Liang and Barsky 1984; `None` if no part does.
fn inside(from: [f64; 2], to: [f64; 2], ground: [f64; 4]) -> Option<[[f64; 2]; 2]> {
    let mut shares = [0.0_f64, 1.0];
    for axis in 0..2 {
        let way = to[axis] - from[axis];
        let ends = [ground[axis], ground[axis + 2]].map(|end| end - from[axis]);
        if way == 0.0 {
            if ends[0] > 0.0 || ends[1] < 0.0 {
                return None;
            }
            continue;
        }
        let [a, b] = ends.map(|end| end / way);
        shares = [shares[0].max(a.min(b)), shares[1].min(a.max(b))];
    }
    let at = |share: f64| [0, 1].map(|axis| from[axis] + share * (to[axis] - from[axis]));
    (shares[0] <= shares[1]).then(|| shares.map(at))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Heads north-east over 3 m of water.
    fn ping() -> Footprint {
        let half = 0.5_f64.sqrt();
        Footprint {
            place: [100.0, 50.0],
            starboard: [half, -half],
            altitude_m: 3.0,
            behind_m: 0.4,
            ahead_m: 0.6,
            sides: [Some(SideRange { near_m: 0.0, sample_m: 0.05, count: 300 }); 2],
        }
    }

    fn closed(mut ring: Vec<[f64; 2]>) -> Vec<[f64; 2]> {
        ring.push(ring[0]);
        ring
    }

    #[test]
    fn the_samples_of_an_area_are_those_of_all_places_in_it() {
        let ping = ping();
        // Areas around the boat, beside it with an island, at a corner of its footprint, around the
        // whole footprint, and away from the footprint.
        let square = |x: f64, y: f64, half: f64| {
            closed(vec![
                [x - half, y - half],
                [x + half, y - half],
                [x + half, y + half],
                [x - half, y + half],
            ])
        };
        let areas = [
            vec![square(100.0, 50.0, 2.0)],
            vec![square(104.0, 46.0, 2.5), square(104.0, 46.0, 1.7)],
            vec![closed(vec![[93.0, 50.0], [99.0, 52.5], [95.0, 58.0]])],
            vec![square(100.0, 50.0, 60.0)],
            vec![square(140.0, 50.0, 3.0)],
        ];
        for rings in areas {
            let area = Area::of(rings.clone()).expect("corners");
            let [west, south, east, north] = area.bounds_m.map(|end| end.clamp(20.0, 180.0));
            let mut samples: [Option<[i32; 2]>; 2] = [None; 2];
            let steps = |from: f64, to: f64| {
                (0..=400).map(move |k| from + (to - from) * f64::from(k) / 400.0)
            };
            for x in steps(west, east) {
                for y in steps(south, north) {
                    if rings.iter().filter(|ring| goes_around(ring, [x, y])).count() % 2 == 0 {
                        continue;
                    }
                    for (side, seen) in ping.seen([x, y], 0.0).into_iter().enumerate() {
                        if let Some(seen) = seen {
                            let [least, most] = samples[side].unwrap_or([seen.samples[0]; 2]);
                            let [from, to] = seen.samples;
                            samples[side] = Some([least.min(from), most.max(to)]);
                        }
                    }
                }
            }
            for (found, expected) in area.seen_by(&ping).into_iter().zip(samples) {
                assert_eq!(found.is_some(), expected.is_some(), "{rings:?}");
                if let (Some(found), Some(expected)) = (found, expected) {
                    // Steps of up to 0.3 m are six samples.
                    for (a, b) in found.samples.iter().zip(expected) {
                        assert!(a.abs_diff(b) < 7, "{:?} {expected:?} {rings:?}", found.samples);
                    }
                    assert!(found.samples[0] <= expected[0] && found.samples[1] >= expected[1]);
                }
            }
        }
    }
}

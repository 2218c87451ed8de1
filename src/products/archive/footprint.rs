//! Describes the ground that a side-scan ping insonified.

use bathyscope_log::support::outline::box_around;

/// Slant ranges that one side of a ping recorded, calibrated, with the true speed of sound.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct SideRange {
    /// Slant range at the near edge of the first sample, metres.
    pub near_m: f64,
    /// Slant range that each sample adds, metres.
    pub sample_m: f64,
    /// Number of samples.
    pub count: i32,
}

/// Footprint of a ping over level ground, in the metres of a zone. Across the track a sample of
/// slant range `r` lies `sqrt(r^2 - a^2)` from the boat, where `a` is the altitude; along the track
/// the footprint reaches half way to the pings before and behind, as in the mosaic. The width of
/// the beam is ignored: it is wider than the distance between two pings, and the ground that it
/// adds is the footprint of the neighbours.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Footprint {
    /// Place of the transducer, metres of the zone.
    pub place: [f64; 2],
    /// Vector in the zone that is one metre on the bottom to starboard.
    pub starboard: [f64; 2],
    /// Height of the transducer over the ground, metres.
    pub altitude_m: f64,
    /// Length of the footprint backward along the track, metres.
    pub behind_m: f64,
    /// Length of the footprint forward along the track, metres.
    pub ahead_m: f64,
    /// Slant ranges of port and starboard; `None` for a side that was not recorded.
    pub sides: [Option<SideRange>; 2],
}

/// Samples of one side of a ping that cover a place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CoveredSamples {
    /// First and last of the samples in the place or nearest to it, counted outward from 0; for a
    /// single point both are the same sample.
    pub samples: [i32; 2],
    /// Slant range of the first of these samples, metres.
    pub range_m: f64,
    /// Distance from the place to the insonified ground, metres; 0 within it.
    pub distance_m: f64,
}

impl SideRange {
    /// Returns the across-track distances on the bottom of the first and the last sample; `None`
    /// where all samples are of water.
    pub(super) fn ground_m(&self, altitude_m: f64) -> Option<[f64; 2]> {
        let far_m = self.near_m + self.sample_m * f64::from(self.count);
        let ground = |range_m: f64| (range_m * range_m - altitude_m * altitude_m).max(0.0).sqrt();
        let is_known = self.sample_m > 0.0 && self.count > 0 && far_m > altitude_m;
        is_known.then(|| [ground(self.near_m.max(0.0)), ground(far_m)])
    }

    /// Returns the samples between two across-track distances on the bottom.
    pub(super) fn seen(
        &self,
        altitude_m: f64,
        across_m: [f64; 2],
        distance_m: f64,
    ) -> CoveredSamples {
        let ranges_m = across_m.map(|across_m| across_m.hypot(altitude_m));
        let sample = |range_m: f64| {
            let sample = ((range_m - self.near_m) / self.sample_m).floor() as i32;
            sample.clamp(0, self.count - 1)
        };
        CoveredSamples { samples: ranges_m.map(sample), range_m: ranges_m[0], distance_m }
    }
}

impl Footprint {
    /// Returns the samples of each side, port first, that cover a place of the zone; `None` for a
    /// side whose footprint is farther from the place than `radius_m`.
    pub(super) fn seen(&self, place: [f64; 2], radius_m: f64) -> [Option<CoveredSamples>; 2] {
        let [to_starboard_m, forward_m] = self.on_ground(place);
        let along_m = forward_m.clamp(-self.behind_m, self.ahead_m);
        let seen = |side: &SideRange, out_m: f64| {
            let [near_m, far_m] = side.ground_m(self.altitude_m)?;
            let across_m = out_m.clamp(near_m, far_m);
            let distance_m = (out_m - across_m).hypot(forward_m - along_m);
            (distance_m <= radius_m).then(|| side.seen(self.altitude_m, [across_m; 2], distance_m))
        };
        let outward_m = [-to_starboard_m, to_starboard_m];
        [0, 1].map(|side| seen(self.sides[side].as_ref()?, outward_m[side]))
    }

    /// Returns the distance of a place to starboard of and forward of the transducer, metres on the
    /// ground.
    pub(super) fn on_ground(&self, place: [f64; 2]) -> [f64; 2] {
        let [x, y] = [0, 1].map(|axis| place[axis] - self.place[axis]);
        let [east, north] = self.starboard;
        let scale = east * east + north * north;
        [(x * east + y * north) / scale, (y * east - x * north) / scale]
    }

    /// Returns the west, south, east and north edge of all insonified ground, metres of the zone;
    /// `None` where the ping insonified none.
    pub(super) fn bounds_m(&self) -> Option<[f64; 4]> {
        let [east, north] = self.starboard;
        let corner = |out_m: f64, along_m: f64| {
            [
                self.place[0] + out_m * east - along_m * north,
                self.place[1] + out_m * north + along_m * east,
            ]
        };
        let reaches = self.sides.iter().zip([-1.0, 1.0]).filter_map(|(side, sign)| {
            let [near_m, far_m] = side.as_ref()?.ground_m(self.altitude_m)?;
            Some([sign * near_m, sign * far_m])
        });
        let corners = reaches
            .flatten()
            .flat_map(|out_m| [-self.behind_m, self.ahead_m].map(|along_m| corner(out_m, along_m)));
        corners.map(|[x, y]| [x, y, x, y]).reduce(box_around)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn heading_east() -> Footprint {
        Footprint {
            place: [100.0, 50.0],
            starboard: [0.0, -1.0],
            altitude_m: 3.0,
            behind_m: 0.2,
            ahead_m: 0.3,
            sides: [Some(SideRange { near_m: 0.0, sample_m: 0.05, count: 400 }); 2],
        }
    }

    #[test]
    fn a_place_to_port_is_seen_at_its_slant_range_and_between_the_neighbours_only() {
        let ping = heading_east();
        // Port is north: 4 m out and 3 m up give 5 m of slant range, the hundredth sample.
        let [port, starboard] = ping.seen([100.1, 54.0], 0.0);
        let port = port.unwrap();
        assert_eq!((port.samples, port.distance_m), ([100; 2], 0.0));
        assert!((port.range_m - 5.0).abs() < 1e-12 && starboard.is_none());
        assert_eq!(ping.seen([100.4, 54.0], 0.0), [None; 2]);
        assert_eq!(ping.seen([99.7, 54.0], 0.0), [None; 2]);
        assert_eq!(ping.seen([100.0, 70.0], 0.0), [None; 2], "beyond 19.77 m");
        let [near, _] = ping.seen([101.0, 54.0], 0.71);
        assert!((near.unwrap().distance_m - 0.7).abs() < 1e-9);
        let bounds = ping.bounds_m().unwrap();
        let out_m = (400.0_f64 - 9.0).sqrt();
        for (found, expected) in bounds.iter().zip([99.8, 50.0 - out_m, 100.3, 50.0 + out_m]) {
            assert!((found - expected).abs() < 1e-9, "{bounds:?}");
        }
    }

    #[test]
    fn a_side_that_ends_in_the_water_saw_no_ground() {
        let short = Some(SideRange { near_m: 0.0, sample_m: 0.05, count: 50 });
        let ping = Footprint { sides: [short, None], ..heading_east() };
        assert_eq!(ping.seen([100.0, 50.0], 9.0), [None; 2]);
        assert_eq!(ping.bounds_m(), None);
    }
}

//! Converts recorded ranges at every ping into calibrated slant ranges and distances on the ground.

use crate::calibration::Calibration;
use crate::first_return::FirstReturns;
use crate::mosaic::altitudes_m;
use bathyscope_log::survey::{Side, Survey};

/// Quantity that the picture shows across the track.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum PictureGeometry {
    /// Slant range as recorded, with the water column.
    #[default]
    Slant,
    /// Slant range less the altitude: both sides meet at the first return.
    SlantBeyondWater,
    /// Distance on level ground.
    Ground,
}

/// Scale between recorded and calibrated ranges of one side of a ping.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PingScale {
    /// Height over the ground, metres; 0 where it is not known.
    pub altitude_m: f32,
    /// Calibrated metres for each recorded metre.
    pub scale: f32,
    /// Calibrated range where the recorded range is 0, metres.
    pub offset_m: f32,
}

impl Default for PingScale {
    /// Returns the scale for ranges as recorded and an unknown altitude.
    fn default() -> Self {
        Self { altitude_m: 0.0, scale: 1.0, offset_m: 0.0 }
    }
}

impl PingScale {
    /// Converts a recorded range to a calibrated slant range, metres.
    pub fn slant_m(&self, recorded_m: f64) -> f64 {
        f64::from(self.scale) * recorded_m + f64::from(self.offset_m)
    }

    /// Converts a calibrated slant range to a recorded range, metres: the inverse of
    /// [`PingScale::slant_m`].
    pub fn recorded_m(&self, slant_m: f64) -> f64 {
        (slant_m - f64::from(self.offset_m)) / f64::from(self.scale)
    }

    /// Returns the distance of a recorded range from the middle, metres across the track; without
    /// the water column, 0 for ranges before the ground.
    pub fn across_m(&self, geometry: PictureGeometry, recorded_m: f64) -> f64 {
        let altitude_m = f64::from(self.altitude_m);
        match geometry {
            PictureGeometry::Slant => recorded_m,
            PictureGeometry::SlantBeyondWater => (self.slant_m(recorded_m) - altitude_m).max(0.0),
            PictureGeometry::Ground => {
                let slant_m = self.slant_m(recorded_m).max(0.0);
                (slant_m * slant_m - altitude_m * altitude_m).max(0.0).sqrt()
            }
        }
    }

    /// Returns the recorded range that is shown at a distance from the middle, metres: the inverse
    /// of [`PingScale::across_m`] on the ground.
    pub fn recorded_at_m(&self, geometry: PictureGeometry, across_m: f64) -> f64 {
        let altitude_m = f64::from(self.altitude_m);
        match geometry {
            PictureGeometry::Slant => across_m,
            PictureGeometry::SlantBeyondWater => self.recorded_m(across_m + altitude_m),
            PictureGeometry::Ground => self.recorded_m(across_m.hypot(altitude_m)),
        }
    }
}

/// Smallest and largest values of the scales of a log.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Extremes {
    least: PingScale,
    most: PingScale,
}

impl Extremes {
    /// Returns every combination of smallest and largest values: a result that is monotonic in each
    /// value has its minimum and maximum at one of these.
    fn corners(&self) -> impl Iterator<Item = PingScale> {
        let Self { least, most } = *self;
        (0..8).map(move |corner| {
            let of = |bit: u32| if corner & bit == 0 { least } else { most };
            PingScale { altitude_m: of(1).altitude_m, scale: of(2).scale, offset_m: of(4).offset_m }
        })
    }

    /// Returns the smallest and the largest distance across the track, at any ping, of recorded
    /// ranges from `near_m` to `far_m`.
    pub fn across_m(&self, geometry: PictureGeometry, [near_m, far_m]: [f64; 2]) -> [f64; 2] {
        let nearest = self.corners().map(|corner| corner.across_m(geometry, near_m));
        let farthest = self.corners().map(|corner| corner.across_m(geometry, far_m));
        [nearest.fold(f64::MAX, f64::min), farthest.fold(0.0, f64::max)]
    }

    /// Returns the smallest and the largest recorded range, at any ping, that is shown between two
    /// distances from the middle.
    pub fn recorded_m(&self, geometry: PictureGeometry, [near_m, far_m]: [f64; 2]) -> [f64; 2] {
        let nearest = self.corners().map(|corner| corner.recorded_at_m(geometry, near_m));
        let farthest = self.corners().map(|corner| corner.recorded_at_m(geometry, far_m));
        [nearest.fold(f64::MAX, f64::min), farthest.fold(f64::MIN, f64::max)]
    }
}

/// Scales of all pings of a log, by side, port first.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PingScales {
    sides: [Vec<PingScale>; 2],
}

impl PingScales {
    /// Creates the scales of a log from its first returns and its calibration, with all ranges
    /// multiplied by `range_factor`: for a speed of sound other than the one that the recorder
    /// assumed.
    pub fn new(
        survey: &Survey,
        returns: &FirstReturns,
        calibration: &Calibration,
        range_factor: f64,
    ) -> Self {
        let side = |side: Side| {
            let altitudes_m = altitudes_m(survey, returns, calibration, side);
            let pings = altitudes_m.iter().enumerate();
            let scale = |(ping, &altitude_m): (usize, &f32)| {
                let altitude_m = (f64::from(altitude_m) * range_factor) as f32;
                let known = PingScale {
                    altitude_m: if altitude_m > 0.0 { altitude_m } else { 0.0 },
                    ..PingScale::default()
                };
                let Some(span) = survey.span(ping, side) else {
                    return known;
                };
                let count = f64::from(span.count.max(1));
                let [near_m, far_m] =
                    [0.0, count].map(|sample| range_factor * calibration.range_m(span, sample));
                let recorded_m = f64::from(span.far_m) - f64::from(span.near_m);
                let scale = (far_m - near_m) / recorded_m;
                if !(scale.is_finite() && scale > 0.0) {
                    return known;
                }
                PingScale {
                    scale: scale as f32,
                    offset_m: (near_m - scale * f64::from(span.near_m)) as f32,
                    ..known
                }
            };
            pings.map(scale).collect()
        };
        Self { sides: Side::BOTH.map(side) }
    }

    /// Creates scales of `pings` pings over level ground, with ranges as recorded.
    pub fn level(pings: usize, altitude_m: f32) -> Self {
        let scale = PingScale { altitude_m, ..PingScale::default() };
        Self { sides: [vec![scale; pings], vec![scale; pings]] }
    }

    /// Returns the scales of a side, ping by ping.
    pub fn side(&self, side: Side) -> &[PingScale] {
        &self.sides[side as usize]
    }

    /// Returns the scale of a side at a ping; beyond the end, the scale of the last ping, or the
    /// default if there is none.
    pub fn at(&self, side: Side, ping: usize) -> PingScale {
        let scales = self.side(side);
        let known = scales.get(ping).or(scales.last());
        known.copied().unwrap_or_default()
    }

    /// Returns the smallest and largest altitude, scale and offset over both sides.
    pub fn extremes(&self) -> Extremes {
        let mut pings = self.sides.iter().flatten();
        let first = pings.next().copied().unwrap_or_default();
        let (mut least, mut most) = (first, first);
        for ping in pings {
            least.altitude_m = least.altitude_m.min(ping.altitude_m);
            least.scale = least.scale.min(ping.scale);
            least.offset_m = least.offset_m.min(ping.offset_m);
            most.altitude_m = most.altitude_m.max(ping.altitude_m);
            most.scale = most.scale.max(ping.scale);
            most.offset_m = most.offset_m.max(ping.offset_m);
        }
        Extremes { least, most }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn any_scale() -> impl Strategy<Value = PingScale> {
        (0.0_f32..80.0, 0.8_f32..1.2, -1.0_f32..1.0)
            .prop_map(|(altitude_m, scale, offset_m)| PingScale { altitude_m, scale, offset_m })
    }

    #[test]
    fn a_triangle_of_three_four_and_five() {
        let scale = PingScale { altitude_m: 3.0, ..PingScale::default() };
        assert!((scale.across_m(PictureGeometry::Ground, 5.0) - 4.0).abs() < 1e-9);
        assert_eq!(scale.across_m(PictureGeometry::Ground, 2.0), 0.0);
        assert_eq!(scale.across_m(PictureGeometry::SlantBeyondWater, 5.0), 2.0);
        assert_eq!(scale.across_m(PictureGeometry::Slant, 5.0), 5.0);
    }

    proptest! {
        #[test]
        fn what_is_shown_comes_back(scale in any_scale(), across_m in 0.01..100.0_f64) {
            for geometry in [PictureGeometry::Slant, PictureGeometry::SlantBeyondWater, PictureGeometry::Ground] {
                let recorded_m = scale.recorded_at_m(geometry, across_m);
                let back_m = scale.across_m(geometry, recorded_m);
                prop_assert!((back_m - across_m).abs() < 1e-3, "{geometry:?} {back_m}");
            }
        }

        #[test]
        fn extremes_hold_every_ping(
            scales in prop::collection::vec(any_scale(), 1..9),
            near_m in 0.0..50.0_f64,
            wide_m in 0.0..50.0_f64,
        ) {
            let far_m = near_m + wide_m;
            let all = PingScales { sides: [scales.clone(), Vec::new()] };
            let extremes = all.extremes();
            for geometry in [PictureGeometry::Slant, PictureGeometry::SlantBeyondWater, PictureGeometry::Ground] {
                let [nearest, farthest] = extremes.across_m(geometry, [near_m, far_m]);
                let [least, most] = extremes.recorded_m(geometry, [near_m, far_m]);
                for ping in &scales {
                    prop_assert!(ping.across_m(geometry, near_m) >= nearest - 1e-4);
                    prop_assert!(ping.across_m(geometry, far_m) <= farthest + 1e-4);
                    prop_assert!(ping.recorded_at_m(geometry, near_m) >= least - 1e-4);
                    prop_assert!(ping.recorded_at_m(geometry, far_m) <= most + 1e-4);
                }
            }
        }
    }
}

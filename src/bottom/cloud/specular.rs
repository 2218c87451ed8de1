//! Places a first return on a slope at its specular point: the first return comes from the upper
//! side, where the bottom is square to the beam.
//!
//! Over a plane that falls off to starboard by the angle `beta`, the nearest bottom to port lies up
//! the slope: `r = d cos(beta)`, at depth `r cos(beta)` and `r sin(beta)` out. To starboard it lies
//! at the edge of the beam, which reaches past the nadir by the overlap `p`
//! (`BeamWidths::overlap_rad`): `r = d cos(beta) / cos(beta - p)`, at depth `r cos(p)` and `r
//! sin(p)` over to port. So the two sides of the same pings give the slope, `cos(beta - p) = r_port
//! / r_starboard`, without the recorded depth and its noise. Near level ground beta depends on
//! millimetres (1 % of range is 8 degrees), so the difference of the sides is a median along the
//! track, less its own spread: a difference that speckle and stones may have made counts as level.
//! Among dead bands, windows, smoothers and the recorded depth as reference, this measured best on
//! simulated gentle, steep and rough beds alike.
//!
//! On a slope of less than `p` both sides see the same place up the slope, `r = d cos(beta)`, and
//! their ranges do not tell which side that is. The point is then that straight below, at the
//! depth by the recorder.
//!
//! The farther side also shows whether the slope goes on under the boat. On a bank or a step that
//! ends beside the boat its range is the depth, and not `d cos(beta) / cos(beta - p)`. Where it is
//! more than the depth, the ground straight below is so steep that this side does not see it.
//!
//! With first returns of one side alone, the recorded depth is used for `d`; where it is not known
//! either, the slope is interpolated between those before and behind.

use super::{Geometry, SlopeEnd};
use bathyscope_log::support::statistics::{SIGMA_PER_MAD, upper_median, usual_step};
use bathyscope_log::survey::{PingNav, Side};
use rayon::prelude::*;

/// Number of pings on each side of a ping that its slope is measured over.
const REACH: usize = 10;
/// Fewest pings with a measured value that a slope needs, of the pings of a fast recorder and of
/// those of a slow one.
const MIN_PAIRS: [usize; 2] = [7, 3];
/// Longest time to a ping that counts as the same place, seconds.
const MAX_AWAY_S: f64 = 2.0;
/// Steepest slope that is used, degrees: a pick on an obstacle must not throw its bottom point far
/// out.
const MAX_SLOPE_DEG: f64 = 35.0;
/// Longest time over which a slope is interpolated, seconds.
const BRIDGED_S: f64 = 15.0;
/// Share by which a range and a recorded depth differ on level ground, by their calibration.
const CALIBRATED: f64 = 0.01;
/// Shares of the depth by which a slope past the nadir is nearer than the bottom straight below:
/// up to the first the farther side does not show whether the slope goes on, from the second on it
/// does. Calibration and picks err by a part of these.
const TELLING: [f64; 2] = [0.02, 0.04];
/// A slope goes on under the boat up to the first share of what the farther side would see nearer
/// by it, and has ended from the second share on.
const ENDS: [f64; 2] = [0.75, 0.95];
/// Shares of the depth by which the farther side is late where the ground falls away from it so
/// steeply that it sees the foot of the slope first: up to the first share it is not, from the
/// second on it is, and the slope goes on.
const LATE: [f64; 2] = [0.01, 0.02];

/// Place on the bottom, relative to the boat.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BottomPoint {
    /// Depth below the transducer, metres.
    pub depth_m: f64,
    /// Distance out to the beam's own side, metres.
    pub across_m: f64,
}

/// Returns the bottom point of a first return at slant range `range_m` in the geometries that need
/// nothing but the range.
///
/// - published: `z = r cos(alpha_2)`, `y = r sin(alpha_2)`, equations (5) and (6) of the paper;
/// - self-consistent: with `PPD' = p_0 cos(alpha_2) / d_0` in place of `p_0 / d_0` the published
///   equations give back the depth they were calibrated on: `z = r`, `y = r tan(alpha_2)` in terms
///   of the unchanged range;
/// - nadir, and [`Geometry::Slope`] before the slope is known: `z = r`, `y = 0`.
pub fn fixed_bottom_point(geometry: Geometry, range_m: f64, alpha2_deg: f64) -> BottomPoint {
    let (sin, cos) = alpha2_deg.to_radians().sin_cos();
    let (depth_m, across_m) = match geometry {
        Geometry::Published => (range_m * cos, range_m * sin),
        Geometry::SelfConsistent => (range_m, range_m * sin / cos),
        Geometry::Nadir | Geometry::Slope => (range_m, 0.0),
    };
    BottomPoint { depth_m, across_m }
}

/// Returns the place `across_m` out to one side of the boat; `None` without heading or position.
pub fn across_track(place: &PingNav, side: Side, across_m: f64) -> Option<[f64; 2]> {
    place.abeam(side, across_m).filter(|[east_m, _]| east_m.is_finite())
}

/// Slant ranges of both sides of a ping, and the depth below the transducer by the recorder,
/// metres; NaN where one is not known.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Pair {
    pub(super) time_s: f64,
    pub(super) port_m: f64,
    pub(super) starboard_m: f64,
    pub(super) altitude_m: f64,
}

impl Pair {
    /// Returns the range of the farther side, metres; NaN where that of one side is unknown.
    fn farther_m(&self) -> f64 {
        let [port_m, starboard_m] = [self.port_m, self.starboard_m];
        if (starboard_m - port_m).is_nan() { f64::NAN } else { starboard_m.max(port_m) }
    }
}

/// Pings around one, with the buffer that medians are taken in.
struct Around<'a> {
    pairs: &'a [Pair],
    time_s: f64,
    /// Fewest pings with a measured value.
    least: usize,
    values: [f64; 2 * REACH + 1],
}

impl<'a> Around<'a> {
    fn new(pairs: &'a [Pair], ping: usize, least: usize) -> Self {
        Self {
            least,
            pairs: &pairs[ping.saturating_sub(REACH)..pairs.len().min(ping + REACH + 1)],
            time_s: pairs[ping].time_s,
            values: [0.0; 2 * REACH + 1],
        }
    }

    /// Returns the median of what is measured at the pings, and by how much it exceeds its own
    /// spread: 0 where the spread may have made it. `None` where too few pings have a value.
    fn middle(&mut self, measured: impl Fn(&Pair) -> f64) -> Option<(f64, f64)> {
        let mut count = 0;
        for pair in self.pairs {
            let value = measured(pair);
            if value.is_finite() && (pair.time_s - self.time_s).abs() <= MAX_AWAY_S {
                self.values[count] = value;
                count += 1;
            }
        }
        if count < self.least {
            return None;
        }
        let values = &mut self.values[..count];
        let middle = upper_median(values, f64::total_cmp)?;
        for value in values.iter_mut() {
            *value = (*value - middle).abs();
        }
        let spread = SIGMA_PER_MAD * upper_median(values, f64::total_cmp)?;
        Some((middle, (middle.abs() - spread).max(0.0)))
    }
}

/// Angles of the first returns of a ping.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct BeamAngles {
    /// Angles to port and to starboard from straight below, outwards, radians.
    pub(super) out_rad: [f64; 2],
    /// Share, 0 to 1, by which the slope of the nearer first return ends before the nadir: 0 where
    /// it goes on under the boat, 1 where the bottom is level there.
    pub(super) slope_end: f64,
    /// Share by which both first returns are nearer than the bottom straight below: on a slope of
    /// less than the overlap both show the same place up the slope.
    nearer_by: f64,
}

impl BeamAngles {
    /// Returns the bottom point of the first return of a side at slant range `range_m`.
    pub(super) fn bottom_point(&self, side: Side, range_m: f64) -> BottomPoint {
        let below_m = range_m / (1.0 - self.nearer_by);
        specular_point(below_m, self.out_rad[side as usize])
    }

    /// Returns the share by which the slope ends that the first return of a side lies on.
    pub(super) fn slope_end(&self, side: Side) -> SlopeEnd {
        let is_up_slope = self.out_rad[side as usize] > 0.0;
        if is_up_slope { SlopeEnd::of(self.slope_end) } else { SlopeEnd::NO_SLOPE }
    }
}

/// Returns the angles of the first returns to port and to starboard from straight below, outwards,
/// radians, at every ping: the slope on the side to which the bottom rises, and less than 0 on the
/// other side, whose beam reaches past the nadir by `overlap_rad`. Both are 0 on level ground.
/// An angle that neither the other side nor a depth determines, as over a bank whose depth the
/// recorder has lost, is interpolated between the angles before and behind; it is 0 where these are
/// too far away.
pub(super) fn beam_angles(pairs: &[Pair], overlap_rad: f64) -> Vec<BeamAngles> {
    let interval_s = usual_step(pairs.iter().map(|pair| pair.time_s));
    let [most, least] = MIN_PAIRS;
    let least = ((MAX_AWAY_S / interval_s) as usize).clamp(least, most);
    // The range of the farther side as a share of the recorded depth, around each ping.
    let farther = |ping: usize| {
        let mut around = Around::new(pairs, ping, least);
        around
            .middle(|pair| pair.farther_m() / pair.altitude_m)
            .map_or(f64::NAN, |(share, _)| share)
    };
    let mut shares: Vec<f64> = (0..pairs.len()).into_par_iter().map(farther).collect();
    bridge(pairs, &mut shares, |share| share);
    hold(pairs, &mut shares);
    let shares = shares.into_par_iter().enumerate();
    let known = shares.map(|(ping, of_depth)| known(pairs, ping, least, of_depth, overlap_rad));
    let mut angles: Vec<BeamAngles> = known.collect();
    for side in [0, 1] {
        bridge(pairs, &mut angles, |angles| &mut angles.out_rad[side]);
        let unknown = angles.iter_mut().filter(|angles| angles.out_rad[side].is_nan());
        unknown.for_each(|angles| angles.out_rad[side] = 0.0);
    }
    angles
}

/// Interpolates the unknown values of pings between known ones that are near in time; `value`
/// returns the value of an item, NaN where it is unknown.
fn bridge<T>(pairs: &[Pair], items: &mut [T], value: impl Fn(&mut T) -> &mut f64) {
    let mut known: Option<(usize, f64)> = None;
    for ping in 0..items.len() {
        let to = *value(&mut items[ping]);
        if to.is_nan() {
            continue;
        }
        if let Some((before, from)) = known.filter(|(before, _)| before + 1 < ping) {
            let span_s = pairs[ping].time_s - pairs[before].time_s;
            for between in before + 1..ping {
                let share = (pairs[between].time_s - pairs[before].time_s) / span_s;
                if span_s <= BRIDGED_S {
                    *value(&mut items[between]) = from + share * (to - from);
                }
            }
        }
        known = Some((ping, to));
    }
}

/// Sets each value that `bridge` leaves unknown to the nearest known value, if that is at most half
/// of [`BRIDGED_S`] away in time.
fn hold(pairs: &[Pair], values: &mut [f64]) {
    let known: Vec<usize> = (0..values.len()).filter(|ping| values[*ping].is_finite()).collect();
    for ping in (0..values.len()).filter(|ping| known.binary_search(ping).is_err()) {
        let after = known.partition_point(|known| *known < ping);
        let away_s = |known: &usize| (pairs[*known].time_s - pairs[ping].time_s).abs();
        let beside = &known[after.saturating_sub(1)..known.len().min(after + 1)];
        let nearest = beside.iter().min_by(|one, other| away_s(one).total_cmp(&away_s(other)));
        if let Some(nearest) = nearest.filter(|nearest| away_s(nearest) <= 0.5 * BRIDGED_S) {
            values[ping] = values[*nearest];
        }
    }
}

/// Returns the angles at a ping from the pings around it, radians; NaN where too few of these
/// determine them, `least` at least. `of_depth` is the range of the farther side as a share of the
/// recorded depth, NaN where it is unknown.
fn known(pairs: &[Pair], ping: usize, least: usize, of_depth: f64, overlap_rad: f64) -> BeamAngles {
    let mut around = Around::new(pairs, ping, least);
    let steepest = MAX_SLOPE_DEG.to_radians();
    if let Some((difference_m, certain_m)) = around.middle(|pair| pair.starboard_m - pair.port_m) {
        if certain_m <= 0.0 {
            // The minimum is the second where the share is unknown.
            let nearer_by = (1.0 - of_depth).max(0.0).min(1.0 - overlap_rad.cos());
            return BeamAngles { nearer_by, ..BeamAngles::default() };
        }
        let deeper_m = around.middle(Pair::farther_m).map_or(f64::NAN, |(deeper_m, _)| deeper_m);
        let over_rad = (1.0 - certain_m / deeper_m).max(steepest.cos()).acos();
        let slope_rad = (over_rad + overlap_rad).min(steepest);
        let past_rad = past_nadir_rad(of_depth, slope_rad, overlap_rad);
        let out_rad =
            if difference_m > 0.0 { [slope_rad, -past_rad] } else { [-past_rad, slope_rad] };
        return BeamAngles {
            out_rad,
            slope_end: slope_end(of_depth, slope_rad, overlap_rad),
            nearer_by: 0.0,
        };
    }
    let ranges_m = [|pair: &Pair| pair.port_m, |pair: &Pair| pair.starboard_m];
    let out_rad = ranges_m.map(|range_m| {
        let nearer = around.middle(|pair| 1.0 - range_m(pair) / pair.altitude_m);
        nearer.map_or(f64::NAN, |(nearer, certain)| {
            if nearer > 0.0 {
                (1.0 - (certain - CALIBRATED).max(0.0)).max(steepest.cos()).acos()
            } else {
                0.0
            }
        })
    });
    BeamAngles { out_rad, ..BeamAngles::default() }
}

/// Returns the share, 0 to 1, by which a slope ends before the nadir: a slope that went on there
/// would bring the bottom nearer to the farther side than straight below. `of_depth` is the range
/// of this side as a share of the recorded depth, NaN where this is unknown.
fn slope_end(of_depth: f64, slope_rad: f64, overlap_rad: f64) -> f64 {
    let nearer = 1.0 - slope_rad.cos() / (slope_rad - overlap_rad).cos();
    if of_depth.is_nan() || nearer <= 0.0 {
        return 0.0;
    }
    let rise = |value: f64, [from, to]: [f64; 2]| ((value - from) / (to - from)).clamp(0.0, 1.0);
    let late = rise(of_depth - 1.0, LATE);
    rise(nearer, TELLING) * rise(1.0 - (1.0 - of_depth) / nearer, ENDS) * (1.0 - late)
}

/// Returns the angle past the nadir from which the first return of the farther side comes, radians:
/// the overlap at most. `of_depth` is the range of this return as a share of the recorded depth,
/// NaN where this is unknown. Where the return is farther away than the bottom at the overlap, it
/// comes from nearer to the nadir.
fn past_nadir_rad(of_depth: f64, slope_rad: f64, overlap_rad: f64) -> f64 {
    if of_depth.is_nan() {
        return overlap_rad;
    }
    let cos = (slope_rad.cos() / (of_depth - CALIBRATED)).min(1.0);
    (slope_rad - cos.acos()).clamp(0.0, overlap_rad)
}

/// Returns the bottom point of a first return at slant range `range_m` and an angle from straight
/// below, outwards.
fn specular_point(range_m: f64, angle_rad: f64) -> BottomPoint {
    BottomPoint { depth_m: range_m * angle_rad.cos(), across_m: range_m * angle_rad.sin() }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Both sides over a plane 3 m deep that falls off to starboard, with picks that are off by up
    /// to 4 mm; `overlap_deg` is how far the beams look past the nadir.
    fn plane(slope_deg: f64, overlap_deg: f64) -> Vec<Pair> {
        let noise = |ping: usize| 0.004 * [0.0, 1.0, -1.0, 0.5, -0.5][ping % 5];
        let [slope_rad, overlap_rad] = [slope_deg, overlap_deg].map(f64::to_radians);
        let past_rad = overlap_rad.min(slope_rad);
        (0..60)
            .map(|ping| Pair {
                time_s: ping as f64 * 0.05,
                port_m: 3.0 * slope_rad.cos() + noise(ping),
                starboard_m: 3.0 * slope_rad.cos() / (slope_rad - past_rad).cos(),
                altitude_m: 3.0,
            })
            .collect()
    }

    /// Depth of a bottom point to port below the plane of [`plane`], metres.
    fn below_plane_m(point: BottomPoint, slope_deg: f64) -> f64 {
        point.depth_m - (3.0 - point.across_m * slope_deg.to_radians().tan())
    }

    #[test]
    fn planes_come_back_and_level_ground_stays_level() {
        for (slope_deg, overlap_deg) in
            [(8.0, 0.0), (12.0, 0.0), (20.0, 0.0), (15.0, 3.0), (33.0, 3.0)]
        {
            let pairs = plane(slope_deg, overlap_deg);
            let overlap_rad = f64::to_radians(overlap_deg);
            let [port_rad, starboard_rad] = beam_angles(&pairs, overlap_rad)[30].out_rad;
            assert!((port_rad.to_degrees() - slope_deg).abs() < 0.8, "{slope_deg}: {port_rad}");
            assert_eq!(starboard_rad, -overlap_rad);
            // Both points lie on the plane; starboard's own side is the other one.
            let port = specular_point(pairs[30].port_m, port_rad);
            let starboard = specular_point(pairs[30].starboard_m, starboard_rad);
            let starboard = BottomPoint { across_m: -starboard.across_m, ..starboard };
            for point in [port, starboard] {
                let off_m = below_plane_m(point, slope_deg);
                assert!(off_m.abs() < 0.01, "{slope_deg}, {overlap_deg}: {point:?} {off_m}");
            }
        }
        assert_eq!(beam_angles(&plane(0.0, 3.0), 0.05)[30], BeamAngles::default());
        assert_eq!(beam_angles(&plane(12.0, 0.0)[..5], 0.0)[2], BeamAngles::default());
    }

    #[test]
    fn a_slow_recorder_has_slopes_from_fewer_pings() {
        for interval_s in [0.5, 1.0] {
            let slow =
                |(ping, pair): (usize, Pair)| Pair { time_s: interval_s * ping as f64, ..pair };
            let pairs: Vec<Pair> = plane(20.0, 3.0).into_iter().enumerate().map(slow).collect();
            let [port_rad, starboard_rad] = beam_angles(&pairs, 3f64.to_radians())[30].out_rad;
            assert!((port_rad.to_degrees() - 20.0).abs() < 0.8, "{interval_s}: {port_rad}");
            assert_eq!(starboard_rad, -3f64.to_radians());
        }
    }

    #[test]
    fn a_slope_of_less_than_the_overlap_is_as_deep_as_the_recorded_depth() {
        let pairs = plane(4.0, 8.0);
        let angles = &beam_angles(&pairs, 8f64.to_radians())[30];
        assert_eq!(angles.out_rad, [0.0; 2]);
        let below = angles.bottom_point(Side::Starboard, pairs[30].starboard_m);
        assert!((below.depth_m - 3.0).abs() < 0.001 && below.across_m == 0.0, "{below:?}");
        // Beams that end at the nadir do not see the same place.
        assert_eq!(beam_angles(&pairs, 0.0)[30].nearer_by, 0.0);
    }

    #[test]
    fn the_farther_side_shows_whether_a_bank_ends_beside_the_boat() {
        // The depth is lost for 1.5 s, and from the start.
        for lost in [25..40, 0..35] {
            let end = |starboard_m: f64| {
                let mut pairs = plane(33.0, 3.0);
                pairs.iter_mut().for_each(|pair| pair.starboard_m = starboard_m);
                pairs[lost.clone()].iter_mut().for_each(|pair| pair.altitude_m = f64::NAN);
                beam_angles(&pairs, 0.08)[30]
            };
            let level = end(3.0);
            assert_eq!(level.slope_end(Side::Port).share(), 1.0, "{lost:?}");
            assert_eq!(level.slope_end(Side::Starboard), SlopeEnd::NO_SLOPE);
            // On the bank itself, and where the foot of the bank is seen first.
            assert_eq!(end(2.9).slope_end(Side::Port).share(), 0.0);
            assert_eq!(end(3.12).slope_end(Side::Port).share(), 0.0);
        }
        let no_overlap = beam_angles(&plane(33.0, 0.0), 0.0)[30];
        assert_eq!(no_overlap.slope_end(Side::Port).share(), 0.0);
    }

    #[test]
    fn a_side_alone_has_its_slope_from_the_recorded_depth() {
        let mut pairs = plane(33.0, 3.0);
        for pair in &mut pairs {
            pair.starboard_m = f64::NAN;
        }
        let [port_rad, starboard_rad] = beam_angles(&pairs, 0.05)[30].out_rad;
        assert!((port_rad.to_degrees() - 32.0).abs() < 1.5, "{port_rad}");
        assert_eq!(starboard_rad, 0.0);
        // The depth is lost for a while, and for longer than a slope is bridged.
        let mut lost = pairs.clone();
        for pair in &mut lost[15..45] {
            pair.altitude_m = f64::NAN;
        }
        let bridged_rad = beam_angles(&lost, 0.05)[30].out_rad[0];
        assert!((bridged_rad - port_rad).abs() < 0.03, "{bridged_rad}");
        for (ping, pair) in lost.iter_mut().enumerate() {
            pair.time_s = ping as f64;
        }
        assert_eq!(beam_angles(&lost, 0.05)[30], BeamAngles::default());
        for pair in &mut pairs {
            pair.altitude_m = f64::NAN;
        }
        assert_eq!(beam_angles(&pairs, 0.05)[30], BeamAngles::default());
    }
}

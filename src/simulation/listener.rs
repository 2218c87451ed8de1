//! Computes, for simulated recordings, what one side of the sonar hears at one position of the
//! boat: the gain of its beam, and the ground, objects and weed that echo.

use super::arithmetic::{exp, ln};
use super::bed::SceneBed;
use super::objects::PlacedObject;
use super::path::{BoatPose, Path};
use super::random::{NoiseField, Random, RandomPurpose, smooth};
use super::scene::RecorderSettings;
use bathyscope_log::survey::Side;
use std::f64::consts::{FRAC_PI_2, LN_2};

/// One receiving side of the sonar at one place.
pub(super) struct Listener<'a> {
    pub world: &'a World,
    pub beam: &'a Beam,
    pub pose: BoatPose,
    /// Unit vector (east, north) forward in `pose`.
    pub forward: [f64; 2],
    pub side: Side,
    /// Roll towards this side, radians, by which the beam is turned downward.
    pub roll_rad: f64,
    pub metres_per_sample: f64,
    /// Added to every slant range in the recording, metres.
    pub range_offset_m: f64,
    pub samples: usize,
}

/// Spacing of the points at which the ground is sampled: under the track, metres, and its increase
/// for each metre of distance from the track.
const STEP_M: (f64, f64) = (0.012, 0.002);
/// Half-power width of a normal curve, standard deviations.
const HALF_POWER: f64 = 2.354_82;
/// Share of the power of the ground's echo that remains under weed: 6 dB are lost in total, down
/// and back.
const WEED_LOSS: f64 = 0.25;

impl Listener<'_> {
    /// Returns the place `across_m` to this side and `along_m` ahead of the boat, metres east and
    /// north.
    pub(super) fn place(&self, across_m: f64, along_m: f64) -> [f64; 2] {
        let [east, north] = self.forward;
        let across_m = self.side.to_starboard(across_m);
        [
            self.pose.east_m + along_m * east + across_m * north,
            self.pose.north_m + along_m * north - across_m * east,
        ]
    }
}

/// Shape of the beam of one side. Along the track it is represented by three rays: one in the
/// middle and an outer one on each side.
///
/// Its one-way gain is `G = 2^-((phi - axis) / half width)^2`, with `phi` the angle from the
/// vertical.
pub(super) struct Beam {
    /// Angle of the axis from the vertical, radians.
    axis_rad: f64,
    half_width_rad: f64,
    /// Half-power width along the track, radians.
    pub azimuth_rad: f64,
    /// Distance along the track from the middle ray to an outer one, per metre of distance to the
    /// ground.
    spread: f64,
    /// Distances from the track of the points at which the ground is sampled, metres, from 0
    /// outward.
    pub steps_m: Vec<f64>,
}

impl Beam {
    /// Weights of the three rays that represent the beam along the track: the middle one, and one
    /// at sqrt(3) standard deviations of the beam on each side (Gauss-Hermite quadrature).
    pub(super) const RAY_WEIGHTS: [f64; 3] = [1.0 / 6.0, 2.0 / 3.0, 1.0 / 6.0];

    /// Creates the beam of a recorder, with steps up to `range_m`.
    pub(super) fn new(recorder: &RecorderSettings, range_m: f64) -> Self {
        let azimuth_rad = recorder.beam_azimuth_deg.to_radians();
        let mut steps_m = vec![0.0];
        let mut at = 0.0;
        while at < range_m {
            at += STEP_M.0 + STEP_M.1 * at;
            steps_m.push(at);
        }
        Self {
            axis_rad: FRAC_PI_2 - recorder.beam_axis_deg.to_radians(),
            half_width_rad: 0.5 * recorder.beam_width_deg.to_radians(),
            azimuth_rad,
            spread: 3f64.sqrt() * azimuth_rad / HALF_POWER,
            steps_m,
        }
    }

    /// Returns the two-way gain at an angle from the vertical, radians.
    pub(super) fn two_way_gain(&self, phi_rad: f64) -> f64 {
        let off = (phi_rad - self.axis_rad) / self.half_width_rad;
        exp(-2.0 * LN_2 * off * off)
    }

    /// Returns the standard deviation of the two-way beam along the track at a slant range, metres.
    pub(super) fn spread_at_m(&self, range_m: f64) -> f64 {
        self.azimuth_rad / HALF_POWER * range_m
    }

    /// Returns the distance along the track between the middle and an outer ray where they meet the
    /// ground, metres.
    pub(super) fn outer_ray_m(&self, across_m: f64, depth_m: f64) -> f64 {
        self.spread * (across_m * across_m + depth_m * depth_m).sqrt()
    }
}

/// Everything that returns echoes. Places are metres from the scene's centre.
pub(super) struct World {
    pub bed: SceneBed,
    pub objects: Vec<PlacedObject>,
    pub weed: Vec<WeedBed>,
}

impl World {
    /// Returns the depth of the visible ground (objects included, weed not) below the water
    /// surface, metres.
    pub(super) fn depth_m(&self, east_m: f64, north_m: f64) -> f64 {
        let heights = self.objects.iter().map(|object| object.height_m(east_m, north_m));
        self.bed.depth_m(east_m, north_m) - heights.fold(0.0, f64::max)
    }

    /// Returns the share of the ground's echo that is left under the weed at a place; 1 without
    /// weed.
    pub(super) fn weed_loss(&self, east_m: f64, north_m: f64) -> f64 {
        let grown = |weed: &WeedBed| weed.height_m(east_m, north_m) > 0.0;
        if self.weed.iter().any(grown) { WEED_LOSS } else { 1.0 }
    }

    /// Returns the indices of objects in a band across the boat's heading, `half_width_m` ahead and
    /// astern and `reach_m` to both sides.
    pub(super) fn objects_across(
        &self,
        pose: BoatPose,
        half_width_m: f64,
        reach_m: f64,
    ) -> Vec<usize> {
        let [east, north] = pose.forward();
        let objects = self.objects.iter().enumerate();
        let met = objects.filter(|(_, object)| {
            let de = object.settings.east_m - pose.east_m;
            let dn = object.settings.north_m - pose.north_m;
            let (along, across) = (de * east + dn * north, de * north - dn * east);
            along.abs() <= object.reach_m + half_width_m && across.abs() <= object.reach_m + reach_m
        });
        met.map(|(index, _)| index).collect()
    }
}

/// Returns the scattering per unit of area at an angle of incidence `th`, given by the square of
/// its cosine: Lambert's law with Mackenzie's -27 dB where `power` is 2, and near-normal facets
/// that slope by 7 degrees, `10^-2.7 cos^power th + 10^-1.2 exp(-tan^2 th / (2 tan^2 7 deg))`.
pub(super) fn backscatter(cos_squared: f64, power: f64) -> f64 {
    const LAMBERT: f64 = 1.995_262_3e-3;
    const NORMAL: f64 = 6.309_573_4e-2;
    /// 2 tan^2(7 degrees).
    const FACETS: f64 = 2.0 * 0.122_784_56 * 0.122_784_56;
    if cos_squared <= 0.0 {
        return 0.0;
    }
    let tan_squared = (1.0 - cos_squared) / cos_squared;
    // Beyond 35 degrees the echo of the facets is 70 dB weaker.
    let normal = if tan_squared < 0.5 { NORMAL * exp(-tan_squared / FACETS) } else { 0.0 };
    let facing = if power == 2.0 { cos_squared } else { exp(0.5 * power * ln(cos_squared)) };
    LAMBERT * facing + normal
}

/// A round bed of water weed: a canopy whose echo comes before that of the ground.
pub(super) struct WeedBed {
    east_m: f64,
    north_m: f64,
    radius_m: f64,
    outline: NoiseField,
    height: NoiseField,
    stems: NoiseField,
}

/// Lowest and highest height of the canopy above the ground, metres.
const CANOPY_M: (f64, f64) = (0.25, 0.45);
/// Irregularity of the outline, as a share of the radius (standard deviation).
const RAGGED: f64 = 0.25;
/// Width of the rim over which the canopy slopes down to the ground, metres.
const RIM_M: f64 = 1.0;

impl WeedBed {
    /// Creates a bed of a diameter at a random place of the way, away from the ends of the way;
    /// `None` for a diameter of 0 or less.
    pub(super) fn new(diameter_m: f64, path: &Path, seed: u64) -> Option<Self> {
        if diameter_m <= 0.0 {
            return None;
        }
        let mut random = Random::new(seed, RandomPurpose::Weed, 0);
        let pose = path.at(random.between(0.1, 0.9) * path.length_m());
        Some(Self::at([pose.east_m, pose.north_m], diameter_m, seed))
    }

    /// Creates a bed of a diameter around a place (east and north, metres).
    pub(super) fn at([east_m, north_m]: [f64; 2], diameter_m: f64, seed: u64) -> Self {
        Self {
            east_m,
            north_m,
            radius_m: 0.5 * diameter_m,
            outline: NoiseField::new(seed, RandomPurpose::Outline, 0.2 * diameter_m),
            height: NoiseField::new(seed, RandomPurpose::Canopy, 0.8),
            stems: NoiseField::new(seed, RandomPurpose::Stems, 0.25),
        }
    }

    /// Returns true if the bed is within a distance of a place.
    pub(super) fn is_near(&self, east_m: f64, north_m: f64, distance_m: f64) -> bool {
        self.inside(east_m, north_m) > -distance_m
    }

    /// Returns the approximate distance of a place to the rim of the bed, metres; negative outside.
    fn inside(&self, east_m: f64, north_m: f64) -> f64 {
        let (east, north) = (east_m - self.east_m, north_m - self.north_m);
        // The irregular outline is never outside of the radius, so that it is not computed there.
        let beyond = self.radius_m - (east * east + north * north).sqrt();
        if beyond < 0.0 {
            return beyond;
        }
        let ragged = RAGGED * self.radius_m * self.outline.at(east, north);
        beyond - ragged.abs()
    }

    /// Returns the height of the canopy above the ground at a place, metres; 0 outside of the bed.
    pub(super) fn height_m(&self, east_m: f64, north_m: f64) -> f64 {
        let inside = self.inside(east_m, north_m);
        if inside <= 0.0 {
            return 0.0;
        }
        let (low, high) = CANOPY_M;
        let middle =
            0.5 * (low + high) + 0.5 * (high - low) * self.height.at(east_m, north_m) / 2.4;
        middle * smooth(inside / RIM_M)
    }

    /// Returns the density of the weed at a place: 0 (a gap) to about 3.
    pub(super) fn density(&self, east_m: f64, north_m: f64) -> f64 {
        let rim = smooth(self.inside(east_m, north_m) / RIM_M);
        rim * (1.0 + 0.9 * self.stems.at(east_m, north_m)).max(0.0)
    }
}

//! The ground with all that lies and grows on it.

use super::arithmetic::{exp, ln};
use super::bed::SceneBed;
use super::objects::PlacedObject;
use super::path::BoatPose;
use super::weed::WeedBed;

/// Everything that echoes. Places are metres from the scene's centre.
pub(super) struct World {
    pub bed: SceneBed,
    pub objects: Vec<PlacedObject>,
    pub weed: Vec<WeedBed>,
}

/// Share of the echo of the ground that remains under weed (6 dB lost, both ways).
const WEED_LOSS: f64 = 0.25;

impl World {
    /// Depth of the visible ground (objects included, weed not) below the water surface, metres.
    pub(super) fn depth_m(&self, east_m: f64, north_m: f64) -> f64 {
        let heights = self.objects.iter().map(|object| object.height_m(east_m, north_m));
        self.bed.depth_m(east_m, north_m) - heights.fold(0.0, f64::max)
    }

    /// Returns the share of the ground's echo that weed over a place leaves.
    pub(super) fn weed_loss(&self, east_m: f64, north_m: f64) -> f64 {
        let grown = |weed: &WeedBed| weed.height_m(east_m, north_m) > 0.0;
        if self.weed.iter().any(grown) { WEED_LOSS } else { 1.0 }
    }

    /// Objects in a band across the boat's heading, `half_width_m` to both ends and `reach_m` to
    /// both sides.
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

/// Scattering per unit of area at an angle of incidence `th` given by the square of its cosine:
/// Lambert's law with Mackenzie's -27 dB where `power` is 2, and near-normal facets that slope by 7
/// degrees, `10^-2.7 cos^power th + 10^-1.2 exp(-tan^2 th / (2 tan^2 7 deg))`.
pub(super) fn backscatter(cos_squared: f64, power: f64) -> f64 {
    const LAMBERT: f64 = 1.995_262_3e-3;
    const NORMAL: f64 = 6.309_573_4e-2;
    /// 2 tan^2(7 degrees).
    const FACETS: f64 = 2.0 * 0.122_784_56 * 0.122_784_56;
    if cos_squared <= 0.0 {
        return 0.0;
    }
    let tan_squared = (1.0 - cos_squared) / cos_squared;
    // Beyond 35 degrees the facets are 70 dB down.
    let normal = if tan_squared < 0.5 { NORMAL * exp(-tan_squared / FACETS) } else { 0.0 };
    let facing = if power == 2.0 { cos_squared } else { exp(0.5 * power * ln(cos_squared)) };
    LAMBERT * facing + normal
}

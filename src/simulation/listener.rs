//! One side of the sonar at one place.

use super::beam::Beam;
use super::path::BoatPose;
use super::world::World;
use bathyscope_log::survey::Side;

/// One receiving side at one place.
pub(super) struct Listener<'a> {
    pub world: &'a World,
    pub beam: &'a Beam,
    pub pose: BoatPose,
    /// The pose's unit vector (east, north) forward.
    pub forward: [f64; 2],
    pub side: Side,
    /// Roll towards this side, radians: the beam looks that much deeper.
    pub roll_rad: f64,
    pub metres_per_sample: f64,
    /// Added to every slant range where it is recorded, metres.
    pub range_offset_m: f64,
    pub samples: usize,
}

impl Listener<'_> {
    /// The place `across_m` to this side and `along_m` ahead of the boat.
    pub(super) fn place(&self, across_m: f64, along_m: f64) -> [f64; 2] {
        let [east, north] = self.forward;
        let across_m = self.side.to_starboard(across_m);
        [
            self.pose.east_m + along_m * east + across_m * north,
            self.pose.north_m + along_m * north - across_m * east,
        ]
    }
}

//! A shoal of fish: each an echo of its own wherever it swims, in the water column or over the
//! ground.

use super::arithmetic::{exp, to_db};
use super::beam::Beam;
use super::path::BoatPose;
use super::random::{Random, RandomPurpose};
use super::scene::Shoal;
use bathyscope_log::survey::Side;

/// Fish farther off the beam's middle than this many standard deviations return no echo.
const BEAM_REACH: f64 = 3.0;

/// The places of a shoal's fish: metres east, north and below the surface, and the strength of
/// each, dB.
pub(super) struct Fishes(Vec<([f64; 3], f64)>);

impl Fishes {
    /// Places the fish of a shoal: dense in the middle, twice as wide as high.
    pub(super) fn new(shoal: &Shoal, seed: u64) -> Self {
        let mut random = Random::new(seed, RandomPurpose::Shoal, 0);
        let fish = (0..shoal.count).map(|_| {
            let [east, north] = random.normal_pair();
            let [down, spread] = random.normal_pair();
            let at = [
                shoal.east_m + 0.5 * shoal.radius_m * east,
                shoal.north_m + 0.5 * shoal.radius_m * north,
                shoal.depth_m + 0.25 * shoal.radius_m * down,
            ];
            (at, shoal.strength_db + 3.0 * spread)
        });
        Self(fish.collect())
    }

    /// Slant ranges (metres) and strengths (dB) of the fish that one side insonifies.
    pub(super) fn echoes(
        &self,
        pose: BoatPose,
        side: Side,
        beam: &Beam,
        depth_m: f64,
    ) -> Vec<[f64; 2]> {
        let [east, north] = pose.forward();
        let echoes = self.0.iter().filter_map(|&(at, strength_db)| {
            let (de, dn) = (at[0] - pose.east_m, at[1] - pose.north_m);
            let (along, right) = (de * east + dn * north, de * north - dn * east);
            let outward = side.to_starboard(right);
            let down = at[2];
            if outward < 0.0 || down < 0.1 || down > depth_m {
                return None;
            }
            let range_m = (outward * outward + along * along + down * down).sqrt();
            let off = along / beam.spread_at_m(range_m);
            let loss = exp(-0.5 * off * off);
            (off.abs() < BEAM_REACH).then(|| [range_m, strength_db + to_db(loss)])
        });
        echoes.collect()
    }
}

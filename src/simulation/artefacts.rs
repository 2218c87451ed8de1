//! Plans the faults of a simulated survey: which pings they affect, and how much.

use super::arithmetic::{exp, from_db, sin, to_db};
use super::listener::Beam;
use super::path::{BoatPose, Path};
use super::random::{NoiseField, Random, RandomPurpose};
use super::scene::{Scene, Shoal};
use bathyscope_log::survey::Side;
use std::f64::consts::{LN_10, PI};

/// Faults of one ping.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Trouble {
    /// Factor on the power of every echo.
    pub gain: f64,
    /// Roll to starboard, radians.
    pub roll_rad: f64,
    /// True if the ping is not in the log.
    pub missing: bool,
    /// True if another sounder interferes.
    pub interference: bool,
    /// A fish in the water column; `None` without one.
    pub fish: Option<Fish>,
    /// Recorded range, metres.
    pub range_m: f64,
}

/// A fish that one side shows in a row of pings.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Fish {
    pub side: Side,
    /// First ping of the row.
    pub first_ping: u64,
    /// Slant range of the fish when it is abeam, as a share of the depth at `first_ping`.
    pub depth_share: f64,
    /// Distance that the fish has swum outward since it was abeam, metres; negative before.
    pub outward_m: f64,
    /// Distance ahead of the boat, metres; negative astern.
    pub ahead_m: f64,
    /// Strength of the echo over that of a level bottom's edge, dB.
    pub strength_db: f64,
}

/// Length of the stretch with a gain drop, metres.
const GAIN_DROP_M: f64 = 10.0;
/// Time over which the fixes wander, seconds.
const DRIFT_S: f64 = 30.0;
/// Largest number of consecutive pings that are missing.
const LONGEST_DROPOUT: u64 = 5;
/// Largest number of consecutive pings that show a fish. In the real river recording, echoes in the
/// water column are up to a dozen pings long, a metre of the boat's way: a fish of some length, or
/// one that keeps up with the boat for a while.
const LONGEST_FISH: u64 = 8;
/// Fastest speed of a fish towards or away from the boat, metres a second: cruising speed, two
/// lengths a second of a fish of 15 cm.
const FISH_SPEED_MPS: f64 = 0.3;
/// Distance from the beam's middle beyond which fish return no echo, standard deviations.
const BEAM_REACH: f64 = 3.0;

impl Fish {
    /// Returns the slant range of the fish in water of a depth, metres: over the pings a fish draws
    /// the arch that a passing boat records of a point.
    pub(super) fn range_m(&self, depth_m: f64) -> f64 {
        let abeam_m = self.depth_share * depth_m + self.outward_m;
        (abeam_m * abeam_m + self.ahead_m * self.ahead_m).sqrt()
    }
}

/// Plan of the faults of a survey.
pub(super) struct ArtefactPlan<'a> {
    scene: &'a Scene,
    seed: u64,
    wander: NoiseField,
    swing: NoiseField,
    drift: NoiseField,
    /// Metres along the way at which the gain drop starts.
    gain_drop_m: f64,
    /// Begin and end of the stretch with a changed range, as shares of the way.
    range_change: [f64; 2],
    length_m: f64,
}

impl<'a> ArtefactPlan<'a> {
    /// Draws the places of the faults along the way at random.
    pub(super) fn new(scene: &'a Scene, path: &Path, seed: u64) -> Self {
        let mut random = Random::new(seed, RandomPurpose::Plan, 0);
        let length_m = path.length_m();
        let change = random.between(0.5, 0.75);
        Self {
            scene,
            seed,
            wander: NoiseField::new(seed, RandomPurpose::Wander, 12.0),
            swing: NoiseField::new(seed, RandomPurpose::Roll, 6.0),
            drift: NoiseField::new(seed, RandomPurpose::Position, DRIFT_S),
            gain_drop_m: random.between(0.1, 0.9) * length_m,
            range_change: [change, change + 0.2],
            length_m,
        }
    }

    /// Returns the error of a fix at a time, metres east and north.
    pub(super) fn position_error_m(&self, time_s: f64) -> [f64; 2] {
        // Two rows of the noise field that are far enough apart to be independent.
        [0.0, 100.0 * DRIFT_S].map(|row| {
            let since_first = self.drift.at(time_s, row) - self.drift.at(0.0, row);
            self.scene.artefacts.position_m * since_first
        })
    }

    /// Returns the faults of a ping at a time and a place along the way.
    pub(super) fn at(&self, ping: u64, time_s: f64, travelled_m: f64) -> Trouble {
        let artefacts = &self.scene.artefacts;
        let share = travelled_m / self.length_m;
        let [from, to] = self.range_change;
        let changed = (from..to).contains(&share);
        let range_m = self.scene.recorder.range_m;
        Trouble {
            gain: self.gain(travelled_m),
            roll_rad: self.roll_rad(time_s),
            missing: self
                .row(ping, artefacts.dropouts, LONGEST_DROPOUT, RandomPurpose::Dropouts)
                .is_some(),
            interference: Random::new(self.seed, RandomPurpose::Interference, ping)
                .chance(artefacts.interference),
            fish: self.fish(ping),
            range_m: if changed { range_m * artefacts.range_change } else { range_m },
        }
    }

    fn gain(&self, travelled_m: f64) -> f64 {
        let artefacts = &self.scene.artefacts;
        let wander = from_db(artefacts.gain_wander_db * self.wander.at(travelled_m, 0.0));
        let dropped = (0.0..GAIN_DROP_M).contains(&(travelled_m - self.gain_drop_m));
        if dropped { wander * artefacts.gain_drop } else { wander }
    }

    /// Returns the roll of a rocking boat, radians: an oscillation with a period of 2.6 s and a
    /// varying amplitude.
    fn roll_rad(&self, time_s: f64) -> f64 {
        let amplitude = self.scene.artefacts.roll_deg.to_radians();
        let strength = 0.5 + 0.5 * (self.swing.at(time_s, 0.0) / 2.4);
        amplitude * strength * sin(2.0 * PI * time_s / 2.6)
    }

    fn fish(&self, ping: u64) -> Option<Fish> {
        let share = self.scene.artefacts.fish;
        let first_ping = self.row(ping, share, LONGEST_FISH, RandomPurpose::Fish)?;
        let mut random =
            Random::new(self.seed, RandomPurpose::Fish, first_ping.wrapping_add(1 << 40));
        let side = if random.chance(0.5) { Side::Port } else { Side::Starboard };
        let track = &self.scene.track;
        let abeam = random.between(0.0, LONGEST_FISH as f64 - 1.0);
        let pings = (ping - first_ping) as f64 - abeam;
        let outward_mps = random.between(-FISH_SPEED_MPS, FISH_SPEED_MPS);
        Some(Fish {
            side,
            first_ping,
            // Uniform over the water, down to the bottom: the area of water at a range is
            // proportional to the length of the half circle there.
            depth_share: random.unit().sqrt(),
            outward_m: outward_mps * pings / track.ping_rate_hz,
            ahead_m: -pings * track.speed_mps / track.ping_rate_hz,
            strength_db: random.between(-14.0, -2.0),
        })
    }

    /// Returns the first ping of the row of pings with a fault that contains this ping; `None`
    /// where the ping is in no row. Rows are 1 to `longest` pings long and together make up `share`
    /// of all pings.
    fn row(&self, ping: u64, share: f64, longest: u64, purpose: RandomPurpose) -> Option<u64> {
        let mean_length = 0.5 * (1.0 + longest as f64);
        (0..longest).find_map(|back| {
            let start = ping.checked_sub(back)?;
            let mut random = Random::new(self.seed, purpose, start);
            let starts = random.chance(share / mean_length);
            (starts && back < 1 + random.bits() % longest).then_some(start)
        })
    }
}

/// The fish of a shoal: place of each, metres east, north and below the surface, and strength of
/// its echo, dB.
///
/// Each fish returns a separate echo, in the water column or over the ground.
pub(super) struct Fishes(Vec<([f64; 3], f64)>);

impl Fishes {
    /// Draws the places of the fish of a shoal: dense in the middle, twice as wide as high.
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

    /// Returns the slant ranges (metres) and strengths (dB) of the fish that one side insonifies.
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

/// Returns the ring-down power at a slant range: the sum of a fast and a slow decay.
pub(super) fn ring_down(range_m: f64) -> f64 {
    2e-2 * exp(-range_m / 0.035) + 4e-6 * exp(-range_m / 0.12)
}

/// Returns the share of the power that is left after absorption over a slant range, there and back.
pub(super) fn absorption(db_per_km: f64, range_m: f64) -> f64 {
    exp(-2.0 * db_per_km * 1e-3 * range_m * LN_10 / 10.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn troubles_take_their_shares_of_the_pings() {
        let mut scene = Scene::gentle();
        scene.artefacts.dropouts = 0.02;
        let path = Path::new(&scene.track);
        let plan = ArtefactPlan::new(&scene, &path, 11);
        let count = 60_000_u64;
        let troubles: Vec<Trouble> =
            (0..count).map(|ping| plan.at(ping, 0.05 * ping as f64, 0.0)).collect();
        let share = |meets: &dyn Fn(&Trouble) -> bool| {
            troubles.iter().filter(|trouble| meets(trouble)).count() as f64 / count as f64
        };
        let with_fish = share(&|trouble| trouble.fish.is_some());
        let missing = share(&|trouble| trouble.missing);
        let interference = share(&|trouble| trouble.interference);
        assert!((with_fish - 0.03).abs() < 0.004, "{with_fish}");
        assert!((missing - 0.02).abs() < 0.003, "{missing}");
        assert!((interference - 0.015).abs() < 0.002, "{interference}");
        let fish: Vec<Fish> = troubles.iter().filter_map(|trouble| trouble.fish).collect();
        let deep = fish.iter().filter(|fish| fish.depth_share > 0.9).count();
        // A share of 1 - 0.9^2 of the area of a half disc is in the outer tenth of its radius.
        let deep = deep as f64 / fish.len() as f64;
        assert!((deep - 0.19).abs() < 0.05, "{deep}");
        let steepest = troubles.iter().map(|trouble| trouble.roll_rad.abs()).fold(0.0, f64::max);
        assert!((1.0..2.0).contains(&steepest.to_degrees()), "{steepest}");
    }
}

//! The echoes in pieces of a few pings by three quarters of a metre of ground: the median level of each, and where on the ground it lies.

use super::echoes::{LogEchoes, PingPlace};
use super::ground::Ground;
use super::layout::{Chunk, ChunkId};
use crate::survey::Side;

/// Ground range of a piece, metres.
pub const PIECE_M: f64 = 0.75;
/// Ground range that pieces lie between, metres: nearer the beam looks straight down.
const NEAREST_M: f64 = 1.0;
pub(super) const FARTHEST_M: f64 = 40.0;
/// Steps in which a ray is followed along the ground, metres.
const RAY_STEP_M: f64 = 0.2;
/// Fewer samples make no piece.
const LEAST_SAMPLES: u32 = 24;
/// Angles from straight down that the mean of a piece may have, degrees, and how much farther its samples may reach.
const ANGLES_DEG: [f64; 2] = [20.0, 70.0];
const BEYOND_DEG: f64 = 6.0;
/// A ray is not followed where it would be flatter than this, degrees from straight down.
const FLATTEST_DEG: f64 = 80.0;
/// Length of the mean of the unit vectors outward: below it the boat turns.
const LEAST_STRAIGHT: f64 = 0.99;
/// Samples beyond this share of a ping are taken for noise.
const NOISE_FROM: f64 = 0.93;
/// Fewer samples on the ground are not worth a ping.
const LEAST_OF_PING: usize = 5;
/// Pieces across the track.
const BINS: usize = (FARTHEST_M / PIECE_M) as usize;
/// Least altitude over the ground that a slant range is turned into an angle by, metres.
const LEAST_ALTITUDE_M: f64 = 0.1;

/// The median level of a few pings over three quarters of a metre of ground on one side.
#[derive(Clone, Copy, Debug)]
pub struct Piece {
    /// Which chunk of pings it is of.
    pub chunk: ChunkId,
    /// Which range setting of the recorder.
    pub range_setting: i32,
    /// Which side.
    pub side: Side,
    /// Number of samples.
    pub samples: u32,
    /// Median level, fractions by rank within a step.
    pub level: f32,
    /// Mean level of the noise at the end of its pings.
    pub noise_level: f32,
    /// Mean ground range, metres.
    pub ground_m: f64,
    /// Angle from straight down, radians: that of the mean ground and slant ranges.
    pub phi_rad: f64,
    /// Mean slant range, metres.
    pub range_m: f64,
    /// East and north, metres.
    pub place_m: [f64; 2],
    /// Unit vector outward, east and north.
    pub outward: [f64; 2],
    /// How fast the ground's depth grows outward, metres a metre.
    pub slope: f64,
}

/// The pieces of a chunk over a ground, port first; `log` is the place of its log among all.
pub fn pieces(echoes: &LogEchoes<'_>, log: u32, chunk: &Chunk, ground: &Ground) -> Vec<Piece> {
    let mut found = Vec::new();
    for side in Side::BOTH {
        let mut sums = Sums::none();
        for ping in chunk.pings.clone() {
            sums.add_ping(echoes, ping, side, ground);
        }
        sums.pieces(log, chunk, side, ground, &mut found);
    }
    found
}

/// What the pings of a chunk say on one side.
struct Sums {
    bins: Vec<Bin>,
    pings: f64,
    place_m: [f64; 2],
    outward: [f64; 2],
    noise: f64,
    levels: Vec<u8>,
}

#[derive(Clone)]
struct Bin {
    count: u32,
    ground_m: f64,
    range_m: f64,
    /// How often each level occurs.
    of_level: [u16; 256],
}

impl Sums {
    fn none() -> Self {
        Self {
            bins: Vec::new(),
            pings: 0.0,
            place_m: [0.0; 2],
            outward: [0.0; 2],
            noise: 0.0,
            levels: Vec::new(),
        }
    }

    fn add_ping(&mut self, log: &LogEchoes<'_>, ping: usize, side: Side, ground: &Ground) {
        let Some(place) = log.pings.get(ping) else {
            return;
        };
        let echoes = place.side(side);
        let mut levels = std::mem::take(&mut self.levels);
        if place.is_placed() && echoes.has_ranges() && log.read(ping, side, &mut levels) {
            let outward = place.outward(side);
            self.pings += 1.0;
            self.place_m = plus(self.place_m, place.place_m);
            self.outward = plus(self.outward, outward);
            let far = &levels[(levels.len() as f64 * NOISE_FROM) as usize..];
            let sum: f64 = far.iter().map(|level| f64::from(*level)).sum();
            self.noise += sum / far.len().max(1) as f64;
            let on_ground = Ray::new(place, outward, ground).samples(
                echoes.near_m,
                echoes.step_m,
                levels.len(),
            );
            if on_ground.len() >= LEAST_OF_PING {
                for sample in on_ground {
                    self.add(&sample, levels[sample.index]);
                }
            }
        }
        self.levels = levels;
    }

    fn add(&mut self, sample: &OnGround, level: u8) {
        let place = (sample.ground_m / PIECE_M) as usize;
        if place >= self.bins.len() {
            self.bins.resize(BINS.min(place + 1), Bin::NONE);
        }
        if let Some(bin) = self.bins.get_mut(place) {
            bin.count += 1;
            bin.ground_m += sample.ground_m;
            bin.range_m += sample.range_m;
            let count = &mut bin.of_level[usize::from(level)];
            *count = count.saturating_add(1);
        }
    }

    fn pieces(&self, log: u32, chunk: &Chunk, side: Side, ground: &Ground, found: &mut Vec<Piece>) {
        let [middle, outward] =
            [self.place_m, self.outward].map(|sum| sum.map(|part| part / self.pings));
        let straight = outward[0].hypot(outward[1]);
        if !(self.pings > 0.0 && straight > LEAST_STRAIGHT) {
            return;
        }
        let outward = outward.map(|part| part / straight);
        let angles_rad = ANGLES_DEG.map(f64::to_radians);
        for bin in self.bins.iter().filter(|bin| bin.count >= LEAST_SAMPLES) {
            let count = f64::from(bin.count);
            let [ground_m, range_m] = [bin.ground_m, bin.range_m].map(|sum| sum / count);
            let phi_rad = (ground_m / range_m).asin();
            if phi_rad > angles_rad[0] && phi_rad < angles_rad[1] {
                let place_m = [0, 1].map(|axis| middle[axis] + ground_m * outward[axis]);
                found.push(Piece {
                    chunk: ChunkId {
                        log,
                        number: chunk.number,
                    },
                    range_setting: chunk.range_setting,
                    side,
                    samples: bin.count,
                    level: bin.median() as f32,
                    noise_level: (self.noise / self.pings) as f32,
                    ground_m,
                    phi_rad,
                    range_m,
                    place_m,
                    outward,
                    slope: ground.slope_at(place_m, outward),
                });
            }
        }
    }
}

fn plus(one: [f64; 2], other: [f64; 2]) -> [f64; 2] {
    [one[0] + other[0], one[1] + other[1]]
}

impl Bin {
    const NONE: Self = Self {
        count: 0,
        ground_m: 0.0,
        range_m: 0.0,
        of_level: [0; 256],
    };

    /// The median level as if all that share a step lay evenly in it.
    fn median(&self) -> f64 {
        let middle = self.count / 2;
        let mut below = 0;
        for (level, count) in self.of_level.iter().enumerate() {
            let count = u32::from(*count);
            if below + count > middle {
                let share = (f64::from(middle - below) + 0.5) / f64::from(count);
                return level as f64 - 0.5 + share;
            }
            below += count;
        }
        f64::NAN
    }
}

/// A sample that lies on the ground.
struct OnGround {
    index: usize,
    ground_m: f64,
    range_m: f64,
}

/// Slant range of the ground across the track, metres, at even steps of ground range: never falling, for of two places at one range the
/// nearer one comes first.
struct Ray(Vec<f64>);

impl Ray {
    fn new(place: &PingPlace, outward: [f64; 2], ground: &Ground) -> Self {
        // Of squares, for a survey has millions of steps and `f64::hypot` minds numbers that none has.
        let mut most_m2: f64 = 0.0;
        let steps = (FARTHEST_M / RAY_STEP_M).round() as usize;
        let flattest = FLATTEST_DEG.to_radians().tan();
        let along = (0..=steps).map_while(|step| {
            let ground_m = step as f64 * RAY_STEP_M;
            let at = [0, 1].map(|axis| place.place_m[axis] + ground_m * outward[axis]);
            let altitude_m = ground.depth_at(at) - place.transducer_m;
            most_m2 = most_m2.max(ground_m * ground_m + altitude_m * altitude_m);
            let goes_on = altitude_m > LEAST_ALTITUDE_M && ground_m < flattest * altitude_m;
            // Strictly growing, so that each range has one place.
            goes_on.then(|| most_m2.sqrt() + 1e-9 * step as f64)
        });
        Self(along.collect())
    }

    /// The samples between the ends of the reach, nearest first.
    fn samples(&self, near_m: f64, step_m: f64, count: usize) -> Vec<OnGround> {
        let beyond = (ANGLES_DEG[1] + BEYOND_DEG).to_radians().sin();
        let mut found = Vec::new();
        let mut step = 0;
        for index in 0..count {
            let range_m = near_m + (index as f64 + 0.5) * step_m;
            while step + 1 < self.0.len() && self.0[step + 1] < range_m {
                step += 1;
            }
            let Some(&[from, to]) = self.0.get(step..step + 2) else {
                break;
            };
            let share = (range_m - from) / (to - from);
            let ground_m = (step as f64 + share) * RAY_STEP_M;
            if share < 0.0 || ground_m <= NEAREST_M {
                continue;
            }
            if ground_m < beyond * range_m {
                found.push(OnGround {
                    index,
                    ground_m,
                    range_m,
                });
            }
        }
        found
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_median_lies_within_its_step() {
        let mut bin = Bin::NONE;
        bin.of_level[10] = 4;
        bin.of_level[12] = 3;
        bin.count = 7;
        assert_eq!(bin.median(), 9.5 + 3.5 / 4.0);
    }
}

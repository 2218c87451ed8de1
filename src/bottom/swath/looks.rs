//! Averages the levels of a chunk of pings on one side in ranges so short that the bed under each
//! is even. These means (a look) are read from a log once, and placed on the bed again as its
//! depths become known.

use super::layout::{LaidOutLog, PingChunk};
use bathyscope_log::survey::Side;

/// Share of clipped samples above which a range is not used.
const MOST_CLIPPED: f64 = 0.1;
/// Least length of the mean of the unit vectors outward: below it the boat turns.
const LEAST_STRAIGHT: f64 = 0.997;

/// Averaged levels of a chunk of pings on one side: a look.
#[derive(Clone, Debug)]
pub(super) struct SideChunk {
    /// Index of the log, and number of the stretch in the log.
    pub stretch: (u32, u32),
    /// Index of the set of curves.
    pub curves: usize,
    /// Side of the boat: -1 is port, 1 is starboard.
    pub side: f64,
    /// Mean place of the pings, east and north, metres.
    pub place_m: [f64; 2],
    /// Unit vector outward, east and north.
    pub outward: [f64; 2],
    /// Mean depth of the transducer, metres.
    pub transducer_m: f64,
    /// Slant range of the middle of the first range, and length of each range, metres.
    pub first_m: f64,
    /// See `first_m`.
    pub step_m: f64,
    /// Number of independent samples in a range.
    pub independent: f64,
    /// Mean logarithm of power of each range less the gain; NaN where the range is not used.
    pub ln_power: Vec<f32>,
}

/// Eighths of the circle from which a place is seen, with one bit for each.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct SeenOctants(u8);

impl SeenOctants {
    /// Adds the direction of a look, a unit vector east and north.
    pub(super) fn add(&mut self, [east, north]: [f64; 2]) {
        let eighth = (east.atan2(north) / std::f64::consts::FRAC_PI_4).round() as i32;
        self.0 |= 1 << eighth.rem_euclid(8);
    }

    /// Returns true if the place is seen from any eighth.
    pub(super) fn is_any(&self) -> bool {
        self.0 != 0
    }

    /// Returns true if the place is seen from two eighths that are about opposite to each other.
    pub(super) fn are_two(&self) -> bool {
        [3, 4, 5].iter().any(|by| self.0 & self.0.rotate_left(*by) != 0)
    }
}

impl SideChunk {
    /// Creates the look of a side of a chunk, in ranges of `length_m` metres, or of one sample
    /// where samples are longer; `None` where nothing was recorded, or the boat turns.
    pub(super) fn new(
        log: &LaidOutLog<'_>,
        number: usize,
        chunk: &PingChunk,
        curves: usize,
        side: Side,
        ln_power: &[f32; 256],
        length_m: f64,
    ) -> Option<Self> {
        let law = log.law?;
        let pings = log.echoes.pings.get(chunk.pings.clone())?;
        let count = pings.len() as f64;
        let (mut place_m, mut outward, mut transducer_m) = ([0.0; 2], [0.0; 2], 0.0);
        for ping in pings {
            let out = ping.outward(side);
            for axis in 0..2 {
                place_m[axis] += ping.place_m[axis] / count;
                outward[axis] += out[axis] / count;
            }
            transducer_m += ping.transducer_m / count;
        }
        let straight = outward[0].hypot(outward[1]);
        let echoes = *pings.first()?.side(side);
        if !echoes.has_ranges() || straight.is_nan() || straight < LEAST_STRAIGHT {
            return None;
        }
        let each = ((length_m / echoes.step_m).round() as usize).max(1);
        let mut sums: Vec<(f32, u32, u32)> = Vec::new();
        let mut levels = Vec::new();
        for ping in chunk.pings.clone() {
            log.echoes.read(ping, side, &mut levels);
            sums.resize(sums.len().max(levels.len() / each), (0.0, 0, 0));
            for (part, sum) in levels.chunks_exact(each).zip(&mut sums) {
                for level in part {
                    sum.0 += ln_power[usize::from(*level)];
                    sum.1 += 1;
                    sum.2 += u32::from(*level == 0 || *level >= law.most_level);
                }
            }
        }
        let mean = |(sum, count, clipped): (f32, u32, u32)| {
            if f64::from(clipped) > MOST_CLIPPED * f64::from(count) {
                f32::NAN
            } else {
                sum / count as f32 - chunk.gain as f32
            }
        };
        Some(Self {
            stretch: (number as u32, chunk.stretch),
            curves,
            side: side.to_starboard(1.0),
            place_m,
            outward: outward.map(|part| part / straight),
            transducer_m,
            first_m: echoes.near_m + 0.5 * each as f64 * echoes.step_m,
            step_m: each as f64 * echoes.step_m,
            independent: (each * pings.len()) as f64 / law.grain_samples,
            // Collected anew, since the sums take three times the memory.
            ln_power: sums.iter().copied().map(mean).collect(),
        })
    }
}

//! Converts echo power into recorded bytes by pulse, losses, noise, gain, speckle and the
//! recorder's curve.

use super::arithmetic::{exp, from_db, ln, to_db};
use super::artefacts::{Trouble, absorption, ring_down};
use super::bed::SceneBed;
use super::echo::Echo;
use super::listener::{Beam, Listener, World};
use super::path::BoatPose;
use super::random::Random;
use super::scene::{Curve, RecorderSettings, Scene};
use super::visibility::Trace;
use bathyscope_log::survey::Side;
use std::ops::Range;

/// The receiver, with its tables for one recorded range.
pub(super) struct Receiver<'a> {
    scene: &'a Scene,
    pub beam: Beam,
    pub range_m: f64,
    pub metres_per_sample: f64,
    pub samples: usize,
    pulse: Vec<f64>,
    /// Factor of spreading, absorption and gain together on an echo, by sample.
    echo_gain: Vec<f64>,
    /// Ring-down power after gain, by sample.
    ringing: Vec<f64>,
    /// Electronic and volume noise power after gain, by sample.
    noise: Vec<f64>,
    /// Power after gain that is written as `bottom_byte`.
    reference: f64,
}

/// Slant range from which the gain follows a power of the range, metres; nearer, the gain is
/// constant, because a recorder's gain does not start at 0.
const TVG_START_M: f64 = 0.3;
/// Share of the samples that an interfering sounder hits.
const INTERFERENCE_SHARE: f64 = 0.08;
/// Distance in slant range behind the first return over which the second echo decays by a factor of
/// e, metres.
const SECOND_ECHO_M: f64 = 0.15;
/// Largest distance from the beginning of the pulse to the first return, metres.
const PULSE_LEAD_M: f64 = 0.1;
/// Length of the echo of a fish in slant range, metres (standard deviation).
const FISH_M: f64 = 0.04;
/// Strength of a glint over the ground (mean of an exponential factor), and its length, samples.
const GLINT: f64 = 8.0;
const GLINT_SAMPLES: usize = 3;
/// Amplitude of neighbouring samples in the receiver's filter: a Gaussian with a standard deviation
/// of one sample, which gives speckle correlated as in the real river recording (0.55 and 0.2 at
/// one and two samples).
const FILTER: [f64; 5] = [0.135_335_283, 0.606_530_660, 1.0, 0.606_530_660, 0.135_335_283];
/// Root of the sum of the squares of `FILTER`.
const FILTER_NORM: f64 = 1.331_311_443_697_662;
/// Number of samples that share one grain of speckle: the sum over all lags of the correlation of
/// the power, which is the square of the correlation of `FILTER`.
pub(super) const GRAIN: f32 = 2.485;

impl<'a> Receiver<'a> {
    /// Creates the receiver of a scene at one recorded range; its reference power is that of a
    /// level bottom at the scene's mean depth.
    pub(super) fn new(scene: &'a Scene, range_m: f64) -> Self {
        let recorder = &scene.recorder;
        let samples = recorder.samples_per_side as usize;
        let metres_per_sample = range_m / samples as f64;
        let middle = |index: usize| (index as f64 + 0.5) * metres_per_sample;
        let table = |value: &dyn Fn(f64) -> f64| (0..samples).map(|i| value(middle(i))).collect();
        let gain = |range: f64| tvg(recorder, range);
        let mut receiver = Self {
            scene,
            beam: Beam::new(recorder, range_m),
            range_m,
            metres_per_sample,
            samples,
            pulse: pulse(recorder.pulse_m / metres_per_sample),
            echo_gain: table(&|r| {
                let near = r.max(0.05);
                gain(r) * absorption(recorder.absorption_db_per_km, r) / (near * near * near)
            }),
            ringing: table(&|r| scene.artefacts.ring_down * ring_down(r) * gain(r)),
            noise: table(&|r| {
                let near = r.max(0.05);
                let volume = recorder.volume_noise / (near * near);
                (recorder.electronic_noise + volume) * gain(r)
            }),
            reference: 1.0,
        };
        receiver.reference = receiver.level_bottom().max(1e-300);
        receiver
    }

    /// Returns the strongest power after gain from a level bottom at the mean depth.
    fn level_bottom(&self) -> f64 {
        let bed = SceneBed::level(&self.scene.bed);
        let world = World { bed, objects: Vec::new(), weed: Vec::new() };
        let pose = BoatPose { east_m: 0.0, north_m: 0.0, heading_rad: 0.0 };
        let echo = self.listen(&world, pose, Side::Starboard, 0.0);
        self.after_gain(&echo.power, 0..self.samples).into_iter().fold(0.0, f64::max)
    }

    /// Returns the echo that one side receives at a place.
    pub(super) fn listen(&self, world: &World, pose: BoatPose, side: Side, roll_rad: f64) -> Echo {
        let listener = Listener {
            world,
            beam: &self.beam,
            pose,
            forward: pose.forward(),
            side,
            roll_rad,
            metres_per_sample: self.metres_per_sample,
            range_offset_m: self.scene.recorder.range_offset_m,
            samples: self.samples,
        };
        listener.receive()
    }

    /// Applies pulse, losses and time-varied gain to some samples of an echo's power.
    fn after_gain(&self, power: &[f64], samples: Range<usize>) -> Vec<f64> {
        let half = self.pulse.len() / 2;
        let smeared = samples.clone().map(|i| {
            let taps = self.pulse.iter().enumerate();
            taps.map(|(k, tap)| {
                let source = (i + k).checked_sub(half);
                tap * source.and_then(|at| power.get(at)).copied().unwrap_or(0.0)
            })
            .sum::<f64>()
        });
        smeared.zip(&self.echo_gain[samples]).map(|(power, gain)| power * gain).collect()
    }

    /// Returns the change of a ping's mean levels by an object, from the power with and without the
    /// object; `None` where the two do not differ. The second echo, fish and glints are left out,
    /// because they are in both.
    pub(super) fn trace(
        &self,
        [with, without]: [&[f64]; 2],
        trouble: &Trouble,
        side: Side,
        object: usize,
    ) -> Option<Trace> {
        let differs = |index: &usize| with[*index] != without[*index];
        let half = self.pulse.len() / 2;
        let first = (0..self.samples).find(differs)?.saturating_sub(half);
        let last = (0..self.samples).rfind(differs)? + half;
        let samples = first..(last + 1).min(self.samples);
        let [with, without] = [with, without].map(|power| self.after_gain(power, samples.clone()));
        let level = |power: f64, noise: f64| {
            let byte = self.byte((power + noise) * trouble.gain);
            byte.clamp(0.0, f64::from(self.scene.recorder.echo_ceiling))
        };
        let pairs = with.iter().zip(&without).zip(&self.noise[samples]);
        let stands_out = pairs.map(|((&with, &without), &noise)| {
            let (with, without) = (level(with, noise), level(without, noise));
            ((with - without) / self.speckle_bytes(with.max(without))) as f32
        });
        Some(Trace {
            object,
            side,
            metres_per_sample: self.metres_per_sample,
            first_sample: first,
            stands_out: stands_out.collect(),
        })
    }

    /// Returns the standard deviation of the speckle around a mean level, bytes: that of the
    /// logarithm of an exponential (5.57 dB), or of a Rayleigh amplitude (0.463 of its root mean
    /// square); at least 1.
    fn speckle_bytes(&self, level: f64) -> f64 {
        let deviation = match self.scene.recorder.curve {
            Curve::Decibel => 5.57 * self.scene.recorder.bytes_per_db,
            Curve::Amplitude => 0.463 * level,
            // Standard deviation of the root of a Rayleigh amplitude.
            Curve::Root => 0.254 * level,
        };
        deviation.max(1.0)
    }

    /// Returns the bytes of one side, nearest first; `fish` are the slant ranges (metres) and
    /// strengths (dB) of fish.
    pub(super) fn record(
        &self,
        echo: &Echo,
        trouble: &Trouble,
        fish: &[[f64; 2]],
        random: &mut Random,
    ) -> Vec<u8> {
        let mut power = self.after_gain(&echo.power, 0..self.samples);
        self.add_second_echo(&mut power, echo.first_return_m);
        for &[fish_m, strength_db] in fish {
            self.add_fish(&mut power, fish_m, strength_db);
        }
        if self.scene.artefacts.glints > 0.0 {
            self.add_glints(&mut power, random);
        }
        let speckle = self.speckle(random);
        let levels: Vec<f64> = (0..self.samples)
            .map(|i| {
                let echo = (power[i] + self.noise[i]) * speckle[i];
                // The transducer rings much alike from ping to ping: only a quarter of the
                // ring-down fades.
                let ringing = self.ringing[i] * (0.75 + 0.25 * speckle[i]) * trouble.gain;
                let total = echo * trouble.gain + ringing;
                let limited = self.byte(total).min(f64::from(self.scene.recorder.echo_ceiling));
                limited.max(self.byte(ringing)).clamp(0.0, 255.0)
            })
            .collect();
        let mut bytes: Vec<u8> =
            (self.smoothed(levels).into_iter()).map(|level| level as u8).collect();
        if trouble.interference {
            self.interfere(&mut bytes, random);
        }
        bytes
    }

    /// Returns levels smoothed along the ping, if the recorder smooths them.
    fn smoothed(&self, levels: Vec<f64>) -> Vec<f64> {
        let deviation = self.scene.recorder.smoothing_samples;
        if deviation == 0.0 {
            return levels;
        }
        let window = pulse(deviation);
        let half = window.len() / 2;
        let at = |i: usize| {
            let taps = window.iter().enumerate();
            taps.map(|(k, tap)| tap * levels[(i + k).saturating_sub(half).min(levels.len() - 1)])
                .sum()
        };
        (0..levels.len()).map(at).collect()
    }

    /// Adds the second echo of the bottom, which went to the surface and back once more: later and
    /// weaker. Only the ground under the boat is flat enough to return it.
    fn add_second_echo(&self, power: &mut [f64], first_return_m: f64) {
        let loss = self.scene.artefacts.second_echo_db;
        if loss <= 0.0 || first_return_m.is_nan() {
            return;
        }
        let share = from_db(-loss);
        let first = (2.0 * (first_return_m - PULSE_LEAD_M) / self.metres_per_sample) as usize;
        for index in (first..power.len()).rev() {
            let behind_m = 0.5 * index as f64 * self.metres_per_sample - first_return_m;
            power[index] += share * exp(-behind_m.max(0.0) / SECOND_ECHO_M) * power[index / 2];
        }
    }

    fn add_fish(&self, power: &mut [f64], fish_m: f64, strength_db: f64) {
        let at = fish_m / self.metres_per_sample;
        let width = FISH_M / self.metres_per_sample;
        let strength = self.reference * from_db(strength_db);
        let last = ((at + 3.0 * width) as usize + 1).min(power.len());
        let first = ((at - 3.0 * width).max(0.0) as usize).min(last);
        for (index, power) in power[first..last].iter_mut().enumerate() {
            let off = ((first + index) as f64 - at) / width;
            *power += strength * exp(-0.5 * off * off);
        }
    }

    /// Adds glints, bright points on the ground, of which there are many in the real effigy tiles.
    fn add_glints(&self, power: &mut [f64], random: &mut Random) {
        for first in 0..power.len() {
            if random.chance(self.scene.artefacts.glints) {
                let factor = 2.0 + GLINT * random.exponential();
                let end = (first + GLINT_SAMPLES).min(power.len());
                power[first..end].iter_mut().for_each(|power| *power *= factor);
            }
        }
    }

    /// Returns the speckle of each sample: the power of a filtered complex normal process, mean 1.
    fn speckle(&self, random: &mut Random) -> Vec<f64> {
        if !self.scene.artefacts.speckle {
            return vec![1.0; self.samples];
        }
        let field: Vec<[f64; 2]> =
            (0..self.samples + FILTER.len() - 1).map(|_| random.normal_pair()).collect();
        let windows = field.windows(FILTER.len());
        windows
            .map(|window| {
                let part = |which: usize| {
                    let taps = window.iter().zip(FILTER);
                    taps.map(|(z, tap)| z[which] * tap).sum::<f64>() / FILTER_NORM
                };
                let (real, imaginary) = (part(0), part(1));
                0.5 * (real * real + imaginary * imaginary)
            })
            .collect()
    }

    fn interfere(&self, bytes: &mut [u8], random: &mut Random) {
        let ceiling = f64::from(self.scene.recorder.echo_ceiling);
        for byte in bytes {
            if random.chance(INTERFERENCE_SHARE) {
                *byte = (*byte).max((ceiling * random.between(0.4, 1.0)) as u8);
            }
        }
    }

    /// Converts power to a level by the recorder's curve, which is set on the level bottom. The
    /// level is not yet limited to a byte.
    fn byte(&self, power: f64) -> f64 {
        if power <= 0.0 {
            return 0.0;
        }
        let recorder = &self.scene.recorder;
        match recorder.curve {
            Curve::Decibel => {
                recorder.bottom_byte + recorder.bytes_per_db * to_db(power / self.reference)
            }
            Curve::Amplitude => recorder.bottom_byte * (power / self.reference).sqrt(),
            Curve::Root => recorder.bottom_byte * (power / self.reference).sqrt().sqrt(),
        }
    }
}

/// Returns the time-varied gain at a range: a power of the range (usually 3) with the absorption
/// compensated, constant below a start and beyond a limit.
fn tvg(recorder: &RecorderSettings, range_m: f64) -> f64 {
    let range = range_m.clamp(TVG_START_M, recorder.tvg_limit_m);
    let beyond_cube = exp((recorder.tvg_power - 3.0) * ln(range));
    range * range * range * beyond_cube / absorption(recorder.absorption_db_per_km, range)
}

/// Returns the power of the pulse in samples, of sum 1: a Gaussian up to three standard deviations.
fn pulse(deviation_samples: f64) -> Vec<f64> {
    let half = (3.0 * deviation_samples).ceil() as i32;
    let taps: Vec<f64> = (-half..=half)
        .map(|k| {
            let off = f64::from(k) / deviation_samples.max(1e-9);
            exp(-0.5 * off * off)
        })
        .collect();
    let sum: f64 = taps.iter().sum();
    taps.into_iter().map(|tap| tap / sum).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_grain_is_what_the_filter_makes_alike() {
        let lag = |lag: usize| {
            let pairs = FILTER.iter().zip(&FILTER[lag..]);
            let product: f64 = pairs.map(|(a, b)| a * b).sum();
            (product / (FILTER_NORM * FILTER_NORM)).powi(2)
        };
        let grain = lag(0) + 2.0 * (1..FILTER.len()).map(lag).sum::<f64>();
        assert!((grain - f64::from(GRAIN)).abs() < 1e-3, "{grain}");
    }
}

//! The ground, the boat, the recorder and the troubles of a random survey.

use super::{log_between, up_to};
use crate::arithmetic::atan;
use crate::artefacts::absorption;
use crate::beam::Beam;
use crate::random::Random;
use crate::scene::{
    Artefacts, Bank, BedKind, BedSettings, Curve, RecorderSettings, RippleSettings, TrackSettings,
};
use crate::world::backscatter;

/// A random ground of a mean depth.
pub(super) fn bed(random: &mut Random, depth_m: f64, range_m: f64) -> BedSettings {
    let kind = match random.bits() % 10 {
        0..=5 => BedKind::Gentle,
        6..=7 if depth_m > 2.5 => BedKind::Steep,
        _ => BedKind::Rough,
    };
    let ripples = random.chance(0.25).then(|| {
        let wavelength_m = log_between(random, 0.25, 1.2);
        RippleSettings {
            wavelength_m,
            height_m: wavelength_m * random.between(0.04, 0.12),
            heading_deg: random.between(0.0, 180.0),
        }
    });
    let bank = random.chance(0.12).then(|| Bank {
        length_m: 1000.0,
        width_m: 2.0 * range_m * random.between(0.6, 1.0),
        slope_deg: random.between(12.0, 35.0),
    });
    BedSettings {
        seed: None,
        kind,
        mean_depth_m: depth_m,
        terrace: None,
        bank,
        ripples,
        pits: Vec::new(),
        mounds: Vec::new(),
        ..BedSettings::default()
    }
}

/// A line of a length, straight or gently turning.
pub(super) fn track(random: &mut Random, length_m: f64) -> TrackSettings {
    let speed_mps = random.between(0.8, 3.2);
    let spacing_m = log_between(random, 0.05, 0.2);
    let bend_deg_per_m = if random.chance(0.3) { random.between(-1.5, 1.5) } else { 0.0 };
    TrackSettings {
        lines: 1,
        cross_lines: 0,
        length_m,
        speed_mps,
        ping_rate_hz: (speed_mps / spacing_m).min(60.0),
        bend_deg_per_m,
        ..TrackSettings::default()
    }
}

/// A recorder of a range, over ground at a mean depth.
pub(super) fn recorder(random: &mut Random, range_m: f64, depth_m: f64) -> RecorderSettings {
    let amplitude = random.chance(0.35);
    // Some are set so loud that the ground is clipped.
    let loud = random.chance(0.12);
    let recorder = RecorderSettings {
        range_m,
        samples_per_side: 600 + 100 * up_to(random, 9) as u32,
        beam_axis_deg: random.between(25.0, 45.0),
        beam_width_deg: random.between(45.0, 70.0),
        beam_azimuth_deg: random.between(0.5, 1.2),
        pulse_m: log_between(random, 0.008, 0.03),
        tvg_limit_m: range_m * random.between(0.5, 1.1),
        tvg_power: random.between(3.4, 5.0),
        bottom_byte: if loud { random.between(150.0, 250.0) } else { random.between(80.0, 170.0) },
        bytes_per_db: random.between(1.8, 3.6),
        curve: if amplitude { Curve::Amplitude } else { Curve::Decibel },
        echo_ceiling: if loud || random.chance(0.3) { 127 } else { 255 },
        sonar_samples: 16,
        sonar_every: 20,
        ..RecorderSettings::default()
    };
    // Noise is as strong as the ground at some range, most often beyond what is recorded. It fills
    // the shadows: those of the real effigy tiles are half as bright as the ground beside them
    // (0.22 to 0.75).
    let faint_m = range_m * random.between(0.75, 1.6);
    let electronic_noise = faint_echo(&recorder, faint_m, depth_m);
    RecorderSettings {
        electronic_noise,
        volume_noise: electronic_noise * faint_m * faint_m * random.between(0.05, 1.0),
        ..recorder
    }
}

/// Power of one sample of level ground at a long range.
fn faint_echo(recorder: &RecorderSettings, range_m: f64, depth_m: f64) -> f64 {
    let beam = Beam::new(recorder, 1.0);
    let sine = depth_m / range_m;
    let across_m = (range_m * range_m - depth_m * depth_m).max(0.01).sqrt();
    let gain = beam.two_way_gain(atan(across_m / depth_m));
    let sample_m = recorder.range_m / f64::from(recorder.samples_per_side);
    let spread = beam.azimuth_rad * sample_m / (range_m * range_m * range_m);
    backscatter(sine * sine, 2.0)
        * gain
        * spread
        * absorption(recorder.absorption_db_per_km, range_m)
}

/// Draws the faults and disturbances, each in some of the surveys.
pub(super) fn artefacts(random: &mut Random) -> Artefacts {
    let sometimes = |random: &mut Random, share: f64, low: f64, high: f64| {
        let value = random.between(low, high);
        if random.chance(share) { value } else { 0.0 }
    };
    Artefacts {
        gain_wander_db: random.between(0.0, 1.5),
        fish: sometimes(random, 0.5, 0.005, 0.06),
        interference: sometimes(random, 0.3, 0.005, 0.06),
        weed_m: sometimes(random, 0.15, 3.0, 9.0),
        gain_drop: 1.0 - sometimes(random, 0.1, 0.3, 0.85),
        second_echo_db: sometimes(random, 0.6, 12.0, 26.0),
        roll_deg: random.between(0.0, 4.0),
        dropouts: sometimes(random, 0.4, 0.002, 0.03),
        range_change: 1.0,
        surface_m: sometimes(random, 0.15, 0.4, 1.5),
        glints: sometimes(random, 0.3, 0.001, 0.02),
        ..Artefacts::default()
    }
}

//! Measures the gain by echo levels between the lines where something is not as the method assumes,
//! and on recordings.
//!
//! Simulated ponds are those of the bench `surface`, with one thing changed at a time; errors are
//! those of cells more than a metre from a sounding. A recording has no known bed: points are left
//! out of the map and then predicted, with levels and without.

use super::surface::{BETWEEN_M, KINDS, errors_of, from_levels, scene};
use super::truth::{Mission, map, map_with};
use bathyscope_bottom::bathymetry::{FromLevels, Surface, SurfaceSettings, SwathDepth};
use bathyscope_bottom::cloud::{CloudPoint, PointSource, Residuals};
use bathyscope_bottom::swath::PingPlace;
use bathyscope_log::formats;
use bathyscope_log::support::progress::Progress;
use bathyscope_log::survey::Survey;
use bathyscope_products::pipeline::{self, Products, Settings, log_echoes};
use bathyscope_simulation::{Curve, Scene};
use std::path::{Path, PathBuf};

/// Ponds of each kind and change; `BATHYSCOPE_SEEDS` takes another number.
const SEEDS: u64 = 3;
/// Length of the stretches that are left out in turn with those that are not, metres.
const STRETCH_M: f64 = 15.0;
/// A levels that changes a pond by less than this share has not harmed it.
const HARM: f64 = 1.05;

/// Change of a pond: its name and the function that makes it.
type Change = (&'static str, fn(&mut Scene));
/// Ponds as they are, of which the echoes that look north count alone.
const ONE_LOOK: &str = "one look";

/// Changes by one thing each that the method does not know or assumes otherwise.
const CHANGES: &[Change] = &[
    ("as they are", |_| {}),
    (ONE_LOOK, |scene| scene.track.cross_lines = 0),
    ("lines 12 m apart", |scene| scene.track.spacing_m = 12.0),
    ("no weed", |scene| scene.artefacts.weed_m = 0.0),
    ("weed of 16 m", |scene| scene.artefacts.weed_m = 16.0),
    ("bed of one brightness", |scene| scene.bed.patch_factor = 0.0),
    ("patches of 5 dB", |scene| scene.bed.patch_factor = 2.5),
    ("no roll", |scene| scene.artefacts.roll_deg = 0.0),
    ("roll of 5 degrees", |scene| scene.artefacts.roll_deg = 5.0),
    ("positions off by 0.5 m", |scene| scene.artefacts.position_m = 0.5),
    ("positions off by 1 m", |scene| scene.artefacts.position_m = 1.0),
    ("bed scatters cos^1", |scene| scene.bed.scatter_power = 1.0),
    ("bed scatters cos^4", |scene| scene.bed.scatter_power = 4.0),
    ("gain wanders by 3 dB", |scene| scene.artefacts.gain_wander_db = 3.0),
    ("levels smoothed", |scene| scene.recorder.smoothing_samples = 2.0),
    ("levels: roots of amplitudes", |scene| scene.recorder.curve = Curve::Root),
    ("levels: amplitudes", |scene| {
        scene.recorder.curve = Curve::Amplitude;
        scene.recorder.bottom_byte = 60.0;
        scene.recorder.echo_ceiling = 255;
    }),
];

/// Prints the tables.
pub(super) fn run() {
    let data = std::env::var_os("BATHYSCOPE_DATA").map(PathBuf::from);
    let data = data.unwrap_or_else(|| Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/data"));
    for name in ["humminbird-glen-canyon/Rec00001.DAT", "xtf/000_1236.xtf"] {
        let path = data.join(name);
        if path.exists() { left_out(&path) } else { println!("{name}: not here, left out") }
    }
    let seeds = std::env::var("BATHYSCOPE_SEEDS").ok();
    let seeds = seeds.and_then(|text| text.parse().ok()).unwrap_or(SEEDS);
    println!(
        "RMS more than a metre from a sounding, cm, by auto and from_levels; shares within 1 and 2 sigma; ponds more than 5 % worse"
    );
    for (name, change) in CHANGES {
        for kind in KINDS {
            println!("{name:28} {kind:7} {}", changed(kind, (name, *change), seeds));
        }
    }
}

fn auto() -> SurfaceSettings {
    SurfaceSettings { swath: SwathDepth::Off, ..from_levels() }
}

/// The row of a kind of pond with a change.
fn changed(kind: &str, (name, change): Change, seeds: u64) -> String {
    let mut all = [Vec::new(), Vec::new()];
    let mut harmed = 0;
    let mut inside = [0, 0];
    for seed in 1..=seeds {
        let mut scene = scene(kind, seed);
        change(&mut scene);
        let pond = Mission::new(&scene, seed);
        let maps = [auto(), from_levels()].map(|settings| {
            let mut echoes = log_echoes(&pond.known.survey, &pond.products, |place| place);
            if name == ONE_LOOK {
                echoes.pings.iter_mut().for_each(keep_north);
            }
            let map = map_with(echoes, &pond.products, &settings, |_| true).expect("a map");
            let mut errors = errors_of(&pond, &map);
            errors.retain(|error| error.away_m >= BETWEEN_M);
            errors
        });
        for error in &maps[1] {
            for (sigmas, inside) in [1.0, 2.0].into_iter().zip(&mut inside) {
                *inside += usize::from(error.error_m.abs() < sigmas * error.spread_m);
            }
        }
        let errors =
            maps.map(|errors| errors.iter().map(|error| error.error_m).collect::<Vec<f64>>());
        let [before, after] = errors.each_ref().map(|errors| rms_m(errors.clone()));
        harmed += u64::from(after > HARM * before);
        for (all, errors) in all.iter_mut().zip(errors) {
            all.extend(errors);
        }
    }
    let count = all[1].len().max(1) as f64;
    let shares = inside.map(|inside| 100.0 * inside as f64 / count);
    let [before, after] = all.map(|errors| 100.0 * rms_m(errors));
    format!(
        "{before:6.2} {after:6.2} ({:+3.0} %)   {:.0} % {:.0} %   {harmed} of {seeds}",
        100.0 * (after / before - 1.0),
        shares[0],
        shares[1]
    )
}

/// Takes the side away that looks south.
fn keep_north(ping: &mut PingPlace) {
    let south = if ping.starboard[1] < 0.0 { 1 } else { 0 };
    ping.sides[south].step_m = 0.0;
}

fn rms_m(mut errors_m: Vec<f64>) -> f64 {
    Residuals::of(&mut errors_m).map_or(f64::NAN, |residuals| residuals.rms_m)
}

/// Leaves out the first returns of each side, then stretches of the way, and predicts them.
fn left_out(path: &Path) {
    let progress = Progress::new();
    let survey = formats::open(path, &progress).expect("a recording that opens");
    let run = pipeline::run(&survey, &Settings::default(), None, &progress, |_| ());
    let products = run.expect("not cancelled");
    let mut travelled_m = vec![0.0; survey.side_scan.len()];
    let pings = &products.navigation.pings;
    for ping in 1..travelled_m.len().min(pings.len()) {
        let [before, after] = [&pings[ping - 1], &pings[ping]];
        let step_m = (after.east_m - before.east_m).hypot(after.north_m - before.north_m);
        travelled_m[ping] = travelled_m[ping - 1] + if step_m.is_finite() { step_m } else { 0.0 };
    }
    let is_left_out = |point: &CloudPoint, half: usize| {
        let along_m = travelled_m.get(point.ping as usize).copied();
        (along_m.unwrap_or(0.0) / STRETCH_M) as usize % 2 == half
    };
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let predicted = |what: &str, out: &dyn Fn(&CloudPoint) -> bool| {
        println!("{name}: {what}: {}", prediction(&survey, &products, out));
    };
    predicted("first returns to port", &|point| point.source == PointSource::Port);
    predicted("first returns to starboard", &|point| point.source == PointSource::Starboard);
    predicted("both sides' first returns", &|point| point.source != PointSource::DownScan);
    predicted("even stretches of 15 m", &|point| is_left_out(point, 0));
    predicted("odd stretches of 15 m", &|point| is_left_out(point, 1));
}

/// RMS of what is left out minus the map of the rest, by auto and from_levels, where both have a
/// depth.
fn prediction(survey: &Survey, products: &Products, out: &dyn Fn(&CloudPoint) -> bool) -> String {
    let maps = [auto(), from_levels()]
        .map(|settings| map(survey, products, &settings, |point| !out(point)));
    let [Some(without), Some(with)] = &maps else {
        return "no map".to_owned();
    };
    if !matches!(with.levels, FromLevels::Used { .. }) {
        return "not from_levels".to_owned();
    }
    let at = |map: &Surface, point: &CloudPoint| {
        let (depth_m, _) = map.at(point.east_m, point.north_m)?;
        Some(-point.z_m - f64::from(depth_m))
    };
    let pairs: Vec<[f64; 2]> = products
        .kept_points()
        .filter(|point| out(point))
        .filter_map(|point| Some([at(without, point)?, at(with, point)?]))
        .collect();
    let [before, after] =
        [0, 1].map(|which| 100.0 * rms_m(pairs.iter().map(|pair| pair[which]).collect()));
    let mut moved: Vec<f64> = pairs.iter().map(|pair| (pair[1] - pair[0]).abs()).collect();
    let p95_m = Residuals::of(&mut moved).map_or(f64::NAN, |residuals| residuals.p95_m);
    format!(
        "{before:.2} cm by auto, {after:.2} from_levels ({:+.1} %); moved by up to {:.2} cm (p95); n {}",
        100.0 * (after / before - 1.0),
        100.0 * p95_m,
        pairs.len()
    )
}

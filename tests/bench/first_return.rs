//! First returns over 100 000 pings: a step of the threshold slider, and the tracker.

use bathyscope_bottom::first_return::{
    FirstReturnSettings, FirstReturns, ImageSettings, Normalisation, ThresholdIndex, track_range,
};
use bathyscope_log::formats;
use bathyscope_log::support::progress::Progress;
use bathyscope_log::survey::{Side, Survey};
use bathyscope_products::pipeline::settings::{ControlValue, rows};
use bathyscope_products::pipeline::{LogSettings, Settings};
use bathyscope_simulation::{Scene, simulate};
use std::hint::black_box;
use std::time::Instant;

const PINGS: usize = 100_000;

/// Goal: a slider step in under 16 ms of wall clock on two cores.
pub(super) fn run() {
    let survey = long_survey();
    let (image, progress) = (ImageSettings::default(), Progress::new());
    let settings = FirstReturnSettings::default();
    let bytes = survey.side_scan.iter().map(|ping| {
        let sides = Side::BOTH.into_iter().filter_map(|side| ping.side(side));
        sides.map(|span| span.count as usize).sum::<usize>()
    });
    let bytes: usize = bytes.sum();
    println!("{PINGS} pings, {} MB of samples", bytes / 1_000_000);

    let (_, read_s) = timed(|| plain_read(&survey));
    println!("plain read of the samples, one thread {:8.1} ms", 1e3 * read_s);

    let (normalisation, scale_s) =
        timed(|| Normalisation::measure(&survey, &image, settings.dead_zone_m, &progress));
    let normalisation = normalisation.expect("not cancelled");
    println!("scale of the picture                  {:8.1} ms", 1e3 * scale_s);

    let (index, index_s) =
        timed(|| ThresholdIndex::build(&survey, &image, settings.dead_zone_m, &progress));
    let index = index.expect("not cancelled");
    println!("threshold index                       {:8.1} ms", 1e3 * index_s);

    let mut steps: Vec<f64> = (0..40)
        .map(|step| {
            let threshold = 0.2 + 0.01 * step as f32;
            timed(|| found(&index.detect(&survey, threshold, 0.15))).1
        })
        .collect();
    steps.sort_by(f64::total_cmp);
    println!(
        "slider step                           {:8.1} ms (median of 40; {:.1} at worst)",
        1e3 * steps[20],
        1e3 * steps[39]
    );

    settings_of_a_step();

    let track = |pings| {
        let returns = track_range(&survey, &normalisation, &settings, pings, &progress);
        found(&returns.expect("not cancelled"))
    };
    let (_, seen_s) = timed(|| track(50_000..51_500));
    println!("tracker over 1500 pings in view       {:8.1} ms", 1e3 * seen_s);
    let (_, all_s) = timed(|| track(0..PINGS));
    println!(
        "tracker over all                      {:8.1} ms ({:.0} times the plain read)",
        1e3 * all_s,
        all_s / read_s
    );
}

/// Prints the time in which the settings of a log follow a step of the slider, beside a comparison
/// of all settings.
fn settings_of_a_step() {
    const STEPS: u16 = 500;
    let (shared, own) = (Settings::default(), LogSettings::default());
    let mut after = shared.clone();
    let value = |step: u16| ControlValue::Number(Some(0.2 + 0.001 * f64::from(step)));
    let (_, by_control_s) = timed(|| {
        for step in 0..STEPS {
            rows::THRESHOLD.set(&mut after, value(step));
            let row = (&rows::THRESHOLD, value(step));
            let (shared, own) = own.set_by_control(&shared, &after, row);
            black_box(own.compose(&shared).expect("settings"));
        }
    });
    let (_, by_comparison_s) = timed(|| {
        for step in 0..STEPS {
            rows::THRESHOLD.set(&mut after, value(step));
            let (shared, own) = own.change(&shared, &after).expect("settings");
            black_box(own.compose(&shared).expect("settings"));
        }
    });
    println!(
        "settings of a slider step             {:8.3} ms ({:.0} times as fast as comparing all)",
        1e3 * by_control_s / f64::from(STEPS),
        by_comparison_s / by_control_s
    );
}

/// A simulated line, run over and over.
fn long_survey() -> Survey {
    let progress = Progress::new();
    let simulated = simulate(&Scene::with_pings(6_000), 1, &progress).expect("not cancelled");
    let survey = formats::open_bytes("long.sl2", simulated.sl2_bytes(), &progress);
    let mut survey = survey.expect("a readable log");
    let once = std::mem::take(&mut survey.side_scan);
    let lap_s = once.last().map_or(0.0, |ping| ping.time_s) + 0.05;
    let pings = (0..PINGS)
        .map(|index| {
            let mut ping = once[index % once.len()];
            ping.time_s += (index / once.len()) as f64 * lap_s;
            ping
        })
        .collect();
    survey.side_scan = std::sync::Arc::new(pings);
    survey
}

fn plain_read(survey: &Survey) -> u64 {
    let sum = |ping: usize, side: Side| {
        let stored = survey.samples(ping, side).and_then(|samples| samples.stored_u8());
        stored.map_or(0, |(bytes, _)| bytes.iter().map(|&byte| u64::from(byte)).sum())
    };
    (0..PINGS).map(|ping| sum(ping, Side::Port) + sum(ping, Side::Starboard)).sum()
}

fn found(returns: &FirstReturns) -> usize {
    let sides = Side::BOTH.into_iter().flat_map(|side| returns.side(side));
    sides.filter(|pick| pick.is_some()).count()
}

fn timed<T>(work: impl FnOnce() -> T) -> (T, f64) {
    let start = Instant::now();
    let result = black_box(work());
    (result, start.elapsed().as_secs_f64())
}

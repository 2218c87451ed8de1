//! The detector: a tile, and a survey of 10 000 pings.

use crate::resources::{peak_from_here_mb, peak_mb, processor_s};
use bathyscope_log::formats;
use bathyscope_log::support::progress::Progress;
use bathyscope_log::survey::{HeadingSettings, Projection, Survey, navigate};
use bathyscope_objects::{DetectorSettings, Model, Picture, TILE_PX, find, model::shipped};
use bathyscope_simulation::{Scene, simulate};
use std::hint::black_box;
use std::path::Path;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Instant;

const PINGS: u32 = 10_000;
const TILES: usize = 20;

/// Goal: 10 000 pings in under 10 s on two cores. `BATHYSCOPE_MODEL` names another model than the
/// one that is shipped.
pub(super) fn run() {
    let progress = Progress::new();
    let simulated = simulate(&Scene::with_pings(PINGS), 1, &progress).expect("not cancelled");
    let survey = formats::open_bytes("long.sl2", simulated.sl2_bytes(), &progress);
    let survey: Survey = survey.expect("a readable log");
    let model = model();
    println!("{}", model.description);
    measure(&model, &survey);
}

fn measure(model: &Model, survey: &Survey) {
    let before = processor_s();
    let tile_s = one_tile(model);
    println!(
        "a tile, one thread        {:8.1} ms ({:.1} ms of processor; median of {TILES})",
        1e3 * tile_s,
        1e3 * (processor_s() - before) / TILES as f64
    );

    let progress = Progress::new();
    let navigation = navigate(survey, &HeadingSettings::default(), Projection::Enu, &progress)
        .expect("not cancelled");
    let tiles = AtomicUsize::new(0);
    let before_mb = peak_from_here_mb();
    let before = processor_s();
    let start = Instant::now();
    let found =
        find(survey, &navigation, model, &DetectorSettings::default(), &progress, |so_far| {
            tiles.fetch_max(so_far.tiles, Ordering::Relaxed);
        });
    let survey_s = start.elapsed().as_secs_f64();
    let tiles = tiles.into_inner();
    println!(
        "{} pings, {tiles} tiles     {survey_s:8.2} s ({:.2} s of processor; {} boxes; {:.2} of as many tiles one after the \
         other)",
        survey.side_scan.len(),
        processor_s() - before,
        found.expect("a search").len(),
        survey_s / (tiles as f64 * tile_s)
    );
    if let (Some(peak_mb), Some(before_mb)) = (peak_mb(), before_mb) {
        println!(
            "memory                    {peak_mb:.0} MB at the peak, {before_mb:.0} MB before the search"
        );
    }
}

fn model() -> Model {
    match std::env::var_os("BATHYSCOPE_MODEL") {
        Some(path) => Model::load(Path::new(&path)),
        None => shipped(),
    }
    .expect("a usable model")
}

fn one_tile(model: &Model) -> f64 {
    let levels = (0..TILE_PX * TILE_PX).map(|index| (index * 7 % 251) as u8);
    let picture = Picture::grey(TILE_PX, TILE_PX, levels.collect());
    let mut times_s: Vec<f64> = (0..TILES)
        .map(|_| {
            let start = Instant::now();
            black_box(model.detect(&picture, model.score, model.iou)).expect("boxes");
            start.elapsed().as_secs_f64()
        })
        .collect();
    times_s.sort_by(f64::total_cmp);
    times_s[TILES / 2]
}

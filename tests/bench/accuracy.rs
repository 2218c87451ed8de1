//! Every detector, geometry and calibration on simulated ponds of known truth: why the recommended
//! preset is what it is.
//!
//! Errors are claimed depth minus true depth of the bed at the claimed place, all artefacts on,
//! weed left out. They are errors on simulated beds, never field accuracy. The ponds change range
//! along a fifth of the track, as users do, which is what breaks a constant scale from a flat spot.

use super::truth::KnownSurvey;
use bathyscope_bottom::calibration::{OffsetMode, PpdReach, ScaleMode};
use bathyscope_bottom::cloud::{Geometry, Residuals};
use bathyscope_bottom::first_return::{Method, SampleMode};
use bathyscope_log::support::progress::Progress;
use bathyscope_products::pipeline::{self, Preset, Products, Settings};
use bathyscope_simulation::Scene;

/// Ponds of each kind; `BATHYSCOPE_SEEDS` takes fewer.
const SEEDS: u64 = 20;

/// Prints one line for each combination: bias, standard deviation and 95th percentile of the
/// magnitude, centimetres.
pub(super) fn run() {
    let seeds = std::env::var("BATHYSCOPE_SEEDS").ok().and_then(|text| text.parse().ok());
    let combinations = combinations();
    let kinds = [Scene::gentle(), Scene::steep(), Scene::rough()];
    let columns: Vec<Vec<String>> = kinds
        .iter()
        .map(|scene| {
            let ponds: Vec<KnownSurvey> =
                (1..=seeds.unwrap_or(SEEDS)).map(|seed| KnownSurvey::new(scene, seed)).collect();
            column(&ponds, &combinations)
        })
        .collect();
    println!(
        "{:57} {:^24} {:^24} {:^24}",
        "cm: bias, sd, p95 (share of pings with points)", "gentle", "steep", "rough"
    );
    for (row, (name, _)) in combinations.iter().enumerate() {
        let cells: Vec<&str> = columns.iter().map(|column| column[row].as_str()).collect();
        println!("{name:57} {}", cells.join(" "));
    }
}

fn combinations() -> Vec<(String, Settings)> {
    let mut rows = vec![
        ("recommended preset".to_owned(), Settings::default()),
        ("published preset".to_owned(), Settings::preset(Preset::Published)),
    ];
    let detectors = [
        ("words threshold", SampleMode::Words, Method::Threshold),
        ("bytes threshold", SampleMode::Bytes, Method::Threshold),
        ("tracker", SampleMode::Bytes, Method::Tracker),
    ];
    let scales = [
        ("flat_spot, constant", ScaleMode::FlatSpot, PpdReach::Constant, OffsetMode::None),
        ("flat_spot", ScaleMode::FlatSpot, PpdReach::Factor, OffsetMode::None),
        ("header", ScaleMode::Header, PpdReach::Factor, OffsetMode::None),
        ("header, offset fit", ScaleMode::Header, PpdReach::Factor, OffsetMode::Fit),
    ];
    let geometries = [
        ("published", Geometry::Published),
        ("self_consistent", Geometry::SelfConsistent),
        ("nadir", Geometry::Nadir),
        ("slope", Geometry::Slope),
    ];
    for (detector, samples, method) in detectors {
        for (scale, mode, reach, offset) in scales {
            for (name, geometry) in geometries {
                let mut settings = Settings::default();
                settings.image.samples = samples;
                settings.first_return.method = method;
                if method == Method::Threshold {
                    // Its own best: with the tracker's half metre the ring-down passes the
                    // threshold.
                    settings.first_return.dead_zone_m =
                        Settings::preset(Preset::Published).first_return.dead_zone_m;
                }
                settings.calibration.mode = mode;
                settings.calibration.ppd = reach;
                settings.calibration.offset = offset;
                settings.cloud.geometry = geometry;
                rows.push((format!("{detector} | {scale} | {name}"), settings));
            }
        }
    }
    rows
}

/// One cell a combination, over all ponds of a kind.
fn column(ponds: &[KnownSurvey], combinations: &[(String, Settings)]) -> Vec<String> {
    let mut errors: Vec<Vec<f64>> = vec![Vec::new(); combinations.len()];
    let mut pings = 0;
    for pond in ponds {
        pings += pond.survey.side_scan.len();
        let mut previous: Option<Products> = None;
        for ((_, settings), errors) in combinations.iter().zip(&mut errors) {
            let products =
                pipeline::run(&pond.survey, settings, previous.as_ref(), &Progress::new(), |_| ())
                    .expect("not cancelled");
            errors.extend(pond.depth_errors_m(&products));
            previous = Some(products);
        }
    }
    errors.iter_mut().map(|errors| cell(errors, 2 * pings)).collect()
}

fn cell(errors: &mut [f64], picks: usize) -> String {
    let share = 100.0 * errors.len() as f64 / picks.max(1) as f64;
    Residuals::of(errors).map_or_else(
        || format!("{:^24}", "no points"),
        |r| {
            format!(
                "{:+6.1} {:5.1} {:5.1} ({share:3.0}%)",
                100.0 * r.mean_m,
                100.0 * r.sd_m,
                100.0 * r.p95_m
            )
        },
    )
}

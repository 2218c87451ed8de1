//! Tests the mounting of a recorder: lever arm and metres against pyproj, everything else against
//! surveys that were simulated askew.

mod golden;
mod sailed;
mod source;
mod window;

use crate::truth::KnownSurvey;
use bathyscope_log::formats::TrackFile;
use bathyscope_log::support::progress::Progress;
use bathyscope_log::survey::Survey;
use bathyscope_products::pipeline::{self, Products, Settings};
use bathyscope_simulation::{Artefacts, ObjectKind, ObjectSettings, Scene, TrackSettings};

/// Two lines to and fro over a gentle bed with three objects that both see, and nothing that
/// disturbs but speckle.
fn scene() -> Scene {
    let object = |east_m, north_m| ObjectSettings {
        kind: ObjectKind::Block,
        east_m,
        north_m,
        length_m: 1.2,
        width_m: 0.8,
        height_m: 0.6,
        heading_deg: 20.0,
        buried_m: 0.0,
        strength_db: None,
    };
    Scene {
        track: TrackSettings {
            lines: 2,
            cross_lines: 0,
            length_m: 60.0,
            spacing_m: 10.0,
            ..TrackSettings::default()
        },
        artefacts: Artefacts::none(),
        objects: vec![object(-15.0, 0.4), object(2.0, -0.5), object(18.0, 0.0)],
        scattered_objects: 0,
        ..Scene::default()
    }
}

fn settings(assignments: &[&str]) -> Settings {
    let with = |settings: Settings, text: &&str| settings.with_assignment(text).expect("a setting");
    assignments.iter().fold(Settings::default(), with)
}

/// A log as some settings have it, and what the pipeline makes of it.
fn processed(
    known: &KnownSurvey,
    settings: &Settings,
    track: Option<&TrackFile>,
) -> (Survey, Products) {
    let survey = pipeline::as_set(known.survey.clone(), settings, track).expect("it fits");
    let products = pipeline::run(&survey, settings, None, &Progress::new(), |_| ());
    (survey, products.expect("nobody cancels"))
}

/// Distances between where the pings are placed and where they truly were, metres: their root mean
/// square.
fn off_m(known: &KnownSurvey, products: &Products) -> f64 {
    let pairs = products.navigation.pings.iter().zip(&known.truth.pings);
    let off =
        pairs.map(|(ping, truth)| (ping.east_m - truth.east_m).hypot(ping.north_m - truth.north_m));
    // At both ends the line of the fit is one-sided.
    let off: Vec<f64> = off.skip(60).collect();
    let inner = &off[..off.len() - 60];
    crate::many_logs::rms(inner)
}

//! Depth maps of simulated ponds against their known beds: what side-scan points add to soundings, and how well two missions
//! over one pond agree.
//!
//! Errors are the map's depth minus the bed's at the middle of each cell of 0.2 m. Maps with and without side-scan points are held
//! against the bed on the same cells: those that the soundings alone can fill. All artefacts are on, weed included. The bed is
//! sailed in four lines 8 m apart and two across.

use super::missions::{Mission, repeatability};
use bathyscope::bathymetry::{SurfaceMethod, SurfaceSettings};
use bathyscope::cloud::Residuals;
use bathyscope::simulation::Scene;

/// Ponds of each kind; `BATHYSCOPE_SEEDS` takes fewer.
const SEEDS: u64 = 10;
/// The weights were compared on ponds from this seed on; the figures reported are those of seeds from 1.
const TUNING_SEED: u64 = 101;
/// Farther than this from any sounding a cell lies between the lines, metres.
const BETWEEN_M: f64 = 1.0;

/// Prints the tables.
pub fn run() {
    let seeds = std::env::var("BATHYSCOPE_SEEDS")
        .ok()
        .and_then(|text| text.parse().ok())
        .unwrap_or(SEEDS);
    for (first, what, ways) in [
        (TUNING_SEED, "to choose the weight on", tuning()),
        (1, "for the report", reported()),
    ] {
        println!(
            "map minus bed, cm: RMS and p95 over the hull, and between the lines; ponds {what}"
        );
        for (name, scene) in kinds() {
            let ponds = (first..first + seeds).map(|seed| Mission::new(&scene, seed));
            let ponds: Vec<Mission> = ponds.collect();
            for (way, settings) in &ways {
                println!("{name:7} {way:32} {}", row(&ponds, settings));
            }
        }
    }
    println!("second mission minus surface of the first, cm: mean and sd, and as the beds say");
    for (name, scene) in kinds() {
        for seed in 1..=seeds {
            println!("{name:7} {seed:3} {}", repeated(&scene, seed));
        }
    }
}

fn settings(side_scan_weight: f64, above_bottom: bool) -> SurfaceSettings {
    SurfaceSettings {
        method: SurfaceMethod::Linear,
        cell_m: Some(0.2),
        side_scan_weight,
        above_bottom,
        ..SurfaceSettings::default()
    }
}

fn tuning() -> Vec<(String, SurfaceSettings)> {
    let weights = [0.0, 0.1, 0.3, 0.5, 1.0, 2.0];
    let ways = weights.map(|weight| (format!("side-scan at {weight}"), settings(weight, false)));
    let above_bottom = (
        "side-scan at 1 with above-bottom returns".to_owned(),
        settings(1.0, true),
    );
    ways.into_iter().chain([above_bottom]).collect()
}

fn reported() -> Vec<(String, SurfaceSettings)> {
    let chosen = SurfaceSettings::default().side_scan_weight;
    vec![
        ("down-scan only".to_owned(), settings(0.0, false)),
        (
            "down-scan and side-scan".to_owned(),
            settings(chosen, false),
        ),
        (
            "the same with above-bottom returns".to_owned(),
            settings(chosen, true),
        ),
        (
            "both, least bending".to_owned(),
            SurfaceSettings {
                method: SurfaceMethod::Smooth,
                ..settings(chosen, false)
            },
        ),
        (
            "both, what predicts best".to_owned(),
            SurfaceSettings {
                method: SurfaceMethod::Auto,
                ..settings(chosen, false)
            },
        ),
    ]
}

fn kinds() -> [(&'static str, Scene); 3] {
    let kinds = [
        ("gentle", Scene::gentle()),
        ("steep", Scene::steep()),
        ("rough", Scene::rough()),
    ];
    kinds.map(|(name, mut scene)| {
        scene.track.lines = 4;
        scene.track.spacing_m = 8.0;
        (name, scene)
    })
}

fn row(ponds: &[Mission], settings: &SurfaceSettings) -> String {
    let soundings_only = SurfaceSettings {
        side_scan_weight: 0.0,
        ..settings.clone()
    };
    let mut errors = Vec::new();
    for pond in ponds {
        let map = pond.known.map(&pond.products, settings);
        let soundings = pond.known.map(&pond.products, &soundings_only);
        errors.extend(pond.known.map_errors_m(&map, &soundings));
    }
    let cell = |least_m: f64| {
        let some = errors.iter().filter(|(_, away_m)| *away_m >= least_m);
        let mut some: Vec<f64> = some.map(|(error_m, _)| *error_m).collect();
        Residuals::of(&mut some).map_or_else(
            || "none".to_owned(),
            |r| {
                let [rms, p95, mean] = [r.rms_m, r.p95_m, r.mean_m].map(|metres| 100.0 * metres);
                format!("{rms:5.2} {p95:5.2} (mean {mean:+.2}, n {})", r.n)
            },
        )
    };
    format!("{}   {}", cell(0.0), cell(BETWEEN_M))
}

/// Two missions over the bed of a seed: the second in five lines 7 m apart, with noise, weed and troubles of its own.
fn repeated(scene: &Scene, seed: u64) -> String {
    let mut scene = scene.clone();
    scene.bed.seed = Some(seed);
    scene.scattered_objects = 0;
    let first = Mission::new(&scene, seed);
    scene.track.lines = 5;
    scene.track.spacing_m = 7.0;
    let second = Mission::new(&scene, seed + 1000);
    let (found, expected) = repeatability(&first, &second);
    let [found, expected] = [found, expected]
        .map(|[mean_m, sd_m]| format!("{:+6.2} {:5.2}", 100.0 * mean_m, 100.0 * sd_m));
    format!("{found}   {expected}")
}

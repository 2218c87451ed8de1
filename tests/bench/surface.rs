//! Depth maps of simulated ponds against their known beds: what side-scan points add to soundings,
//! and how well two missions over one pond agree.
//!
//! Errors are the map's depth minus the bed's at the middle of each cell of 0.2 m. Maps with and
//! without side-scan points are held against the bed on the same cells: those that the soundings
//! alone can fill. All artefacts are on, weed included. The bed is sailed in four lines 8 m apart
//! and two across. The ponds with mounds are gentle ones with mounds and hollows midway between the
//! lines.

use super::truth::{MapError, Mission, repeatability};
use bathyscope_bottom::bathymetry::{Surface, SurfaceMethod, SurfaceSettings, SwathDepth};
use bathyscope_bottom::cloud::Residuals;
use bathyscope_simulation::{Mound, Scene};

/// Ponds of each kind; `BATHYSCOPE_SEEDS` takes fewer.
const SEEDS: u64 = 10;
/// The weights were compared on ponds from this seed on; the figures reported are those of seeds
/// from 1.
const TUNING_SEED: u64 = 101;
/// Distance from the nearest sounding beyond which a cell lies between the lines, metres.
pub(super) const BETWEEN_M: f64 = 1.0;
/// Edges of bands of distance to the nearest sounding, metres.
const BANDS_M: [f64; 5] = [0.0, 1.0, 2.0, 3.0, 10.0];

/// Prints the tables.
pub(super) fn run() {
    let seeds =
        std::env::var("BATHYSCOPE_SEEDS").ok().and_then(|text| text.parse().ok()).unwrap_or(SEEDS);
    for (first, what, ways) in
        [(TUNING_SEED, "to choose the weight on", tuning()), (1, "for the report", reported())]
    {
        println!(
            "map minus bed, cm: RMS and p95 over the hull, and between the lines; ponds {what}"
        );
        for kind in KINDS {
            let ponds = (first..first + seeds).map(|seed| Mission::new(&scene(kind, seed), seed));
            let ponds: Vec<Mission> = ponds.collect();
            for (way, settings) in &ways {
                println!("{kind:7} {way:32} {}", row(&ponds, settings));
            }
            if first == 1 {
                print_by_distance(kind, &ponds);
            }
        }
    }
    println!("second mission minus surface of the first, cm: mean and sd, and as the beds say");
    for kind in KINDS {
        for seed in 1..=seeds {
            println!("{kind:7} {seed:3} {}", repeated(&scene(kind, seed), seed));
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
    let above_bottom = ("side-scan at 1 with above-bottom returns".to_owned(), settings(1.0, true));
    ways.into_iter().chain([above_bottom]).collect()
}

fn reported() -> Vec<(String, SurfaceSettings)> {
    let chosen = SurfaceSettings::default().side_scan_weight;
    vec![
        ("down-scan only".to_owned(), settings(0.0, false)),
        ("down-scan and side-scan".to_owned(), settings(chosen, false)),
        ("the same with above-bottom returns".to_owned(), settings(chosen, true)),
        ("both, from_levels".to_owned(), from_levels()),
    ]
}

/// Returns settings with depths from echo levels.
pub(super) fn from_levels() -> SurfaceSettings {
    SurfaceSettings {
        swath: SwathDepth::Always,
        ..settings(SurfaceSettings::default().side_scan_weight, false)
    }
}

/// The kinds of ponds.
pub(super) const KINDS: [&str; 4] = ["gentle", "steep", "rough", "mounds"];

/// A pond of a kind. Only where its mounds lie depends on the seed.
pub(super) fn scene(kind: &str, seed: u64) -> Scene {
    let mut scene = match kind {
        "steep" => Scene::steep(),
        "rough" => Scene::rough(),
        _ => Scene::gentle(),
    };
    scene.track.lines = 4;
    scene.track.spacing_m = 8.0;
    if kind == "mounds" {
        scene.bed.mounds = mounds(&scene, seed);
    }
    scene
}

/// Mounds and hollows in turn, three between each two neighbouring lines, within a metre of midway.
fn mounds(scene: &Scene, seed: u64) -> Vec<Mound> {
    let track = &scene.track;
    // Multiples of the golden ratio's fraction lie evenly, and differ from seed to seed.
    let mut number = seed * 1000;
    let mut between = |low: f64, high: f64| {
        number += 1;
        low + (high - low) * (number as f64 * 0.618_033_988_75).fract()
    };
    let gaps = track.lines - 1;
    let places = (0..gaps).flat_map(|gap| (0..3).map(move |along| (gap, along)));
    places
        .map(|(gap, along)| {
            let third_m = track.length_m / 3.0;
            let sign = if (gap + along) % 2 == 0 { 1.0 } else { -1.0 };
            let midway_m = (f64::from(gap) - 0.5 * f64::from(gaps - 1)) * track.spacing_m;
            Mound {
                east_m: (f64::from(along) - 1.0) * third_m + between(-0.3, 0.3) * third_m,
                north_m: midway_m + between(-1.0, 1.0),
                radius_m: between(1.0, 1.8),
                height_m: sign * between(0.2, 0.6),
            }
        })
        .collect()
}

/// The errors of a map of all points on the cells that the soundings alone can fill, of all ponds.
fn errors(ponds: &[Mission], settings: &SurfaceSettings) -> Vec<MapError> {
    let of_pond = |pond: &Mission| errors_of(pond, &pond.known.map(&pond.products, settings));
    ponds.iter().flat_map(of_pond).collect()
}

/// The errors of a map of a pond on the cells that the soundings alone can fill.
pub(super) fn errors_of(pond: &Mission, map: &Surface) -> Vec<MapError> {
    let soundings = pond.known.map(&pond.products, &settings(0.0, false));
    pond.known.map_errors(map, &soundings)
}

/// Prints the gain by first returns, the gain by echo levels over that, and the share of errors
/// within the stated ones, by the distance to the nearest sounding.
fn print_by_distance(kind: &str, ponds: &[Mission]) {
    let triangles = settings(SurfaceSettings::default().side_scan_weight, false);
    let maps =
        [settings(0.0, false), triangles, from_levels()].map(|settings| errors(ponds, &settings));
    for (names, maps) in
        [("soundings", "triangles"), ("triangles", "from_levels")].into_iter().zip(maps.windows(2))
    {
        print_bands(kind, names, [&maps[0], &maps[1]]);
    }
}

fn print_bands(kind: &str, (first, second): (&str, &str), maps: [&[MapError]; 2]) {
    for edges in BANDS_M.windows(2) {
        let [before, after] = maps.map(|errors| {
            let band = edges[0]..edges[1];
            let here = errors.iter().filter(|error| band.contains(&error.away_m));
            here.copied().collect::<Vec<MapError>>()
        });
        let rms_cm = |errors: &[MapError]| {
            let mut errors: Vec<f64> = errors.iter().map(|error| error.error_m).collect();
            Residuals::of(&mut errors).map_or(f64::NAN, |r| 100.0 * r.rms_m)
        };
        let share_within = |sigmas: f64| {
            let inside = |error: &&MapError| error.error_m.abs() < sigmas * error.spread_m;
            100.0 * after.iter().filter(inside).count() as f64 / after.len() as f64
        };
        let [before_cm, after_cm] = [&before, &after].map(|errors| rms_cm(errors));
        println!(
            "{kind:7} {:.1} to {:.1} m from a sounding: {before_cm:5.2} by {first}, {after_cm:5.2} by {second} ({:+.0} %), {:.0} % within 1 sigma, {:.0} % within 2, n {}",
            edges[0],
            edges[1],
            100.0 * (after_cm / before_cm - 1.0),
            share_within(1.0),
            share_within(2.0),
            after.len()
        );
    }
}

fn row(ponds: &[Mission], settings: &SurfaceSettings) -> String {
    let errors = errors(ponds, settings);
    let cell = |least_m: f64| {
        let some = errors.iter().filter(|error| error.away_m >= least_m);
        let mut some: Vec<f64> = some.map(|error| error.error_m).collect();
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

/// Two missions over the bed of a seed: the second in five lines 7 m apart, with noise, weed and
/// troubles of its own.
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

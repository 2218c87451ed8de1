//! Tests the gain from sailing the planned lines in simulated ponds whose survey has a hole.

use bathyscope_bottom::bathymetry::Surface;
use bathyscope_bottom::planning::{Plan, PlanSettings, plan};
use bathyscope_log::formats;
use bathyscope_log::support::geo::{CrsChoice, LocalFrame, LonLat, MapPlane};
use bathyscope_log::support::progress::Progress;
use bathyscope_objects::objects::ObjectList;
use bathyscope_products::pipeline::{
    self, ProcessedLog, Settings, joint_depth_surface, survey_coverage,
};
use bathyscope_simulation::{
    Artefacts, BedKind, BedSettings, RecorderSettings, Scene, Simulated, TrackSettings, simulate,
};
use bathyscope_test_support::Moments;
use std::fs;
use std::sync::Arc;

/// Time of a plan, minutes, and the boat's speed, metres a second.
const MINUTES: f64 = 4.0;
const SPEED_MPS: f64 = 2.0;
const RADIUS_M: f64 = 4.0;

/// A pond of 80 by 70 m with a hole in its survey: a strip, a bay at one end, or ground in the
/// middle.
struct Pond {
    kind: BedKind,
    seed: u64,
    /// The way of the first survey, metres from the pond's middle.
    corners: Vec<[f64; 2]>,
}

impl Pond {
    fn new(index: u64) -> Self {
        let mut draw = Moments(900 + index);
        let kinds = [BedKind::Gentle, BedKind::Steep, BedKind::Rough];
        let (west, east) = (-40.0, 40.0);
        // Between which norths and easts nothing is sailed.
        let south = -25.0 + 20.0 * draw.share();
        let north = south + 20.0 + 15.0 * draw.share();
        let hole = match index % 3 {
            0 => [west - 1.0, east + 1.0],
            1 => [west - 1.0, -10.0 + 20.0 * draw.share()],
            _ => [-22.0 + 6.0 * draw.share(), 14.0 + 8.0 * draw.share()],
        };
        let lines: Vec<f64> = (0..8).map(|line| -35.0 + 10.0 * f64::from(line)).collect();
        let is_cut = |line: &f64| (south..north).contains(line);
        let mut corners: Vec<[f64; 2]> = Vec::new();
        let mut sail = |from: f64, to: f64, lines: &mut dyn Iterator<Item = f64>| {
            for (rank, line) in lines.enumerate() {
                let ends = if rank % 2 == 0 { [from, to] } else { [to, from] };
                corners.extend(ends.map(|end| [end, line]));
            }
        };
        sail(west, east, &mut lines.iter().copied().filter(|line| !is_cut(line)));
        if hole[0] > west {
            sail(west, hole[0], &mut lines.iter().rev().copied().filter(is_cut));
        }
        if hole[1] < east {
            sail(east, hole[1], &mut lines.iter().copied().filter(is_cut));
        }
        Self { kind: kinds[index as usize % 3], seed: 400 + index, corners }
    }

    /// A log of a way over this pond; `day` draws what goes wrong on it.
    fn scene(&self, corners: Vec<[f64; 2]>, minutes: Option<f64>) -> Scene {
        Scene {
            duration_s: minutes.map(|minutes| 60.0 * minutes),
            bed: BedSettings {
                kind: self.kind,
                seed: Some(self.seed),
                mean_depth_m: 3.5,
                terrace: None,
                ..BedSettings::default()
            },
            track: TrackSettings {
                turn_radius_m: RADIUS_M,
                speed_mps: SPEED_MPS,
                ping_rate_hz: 6.0,
                fix_rate_hz: 6.0,
                corners_m: corners,
                ..TrackSettings::default()
            },
            recorder: RecorderSettings {
                range_m: 14.0,
                samples_per_side: 500,
                sonar_samples: 100,
                sonar_every: 1,
                ..RecorderSettings::default()
            },
            artefacts: Artefacts { weed_m: 0.0, range_change: 1.0, ..Artefacts::default() },
            scattered_objects: 0,
            ..Scene::default()
        }
    }
}

fn settings() -> Settings {
    let mut settings = Settings::default();
    settings.surface.cell_m = Some(0.5);
    settings
}

/// Simulates a log and processes it, in the frame of an earlier one.
fn processed(scene: &Scene, seed: u64, frame: Option<&LocalFrame>) -> (ProcessedLog, Simulated) {
    scene.check().expect("a scene");
    let progress = Progress::new();
    let truth = simulate(scene, seed, &progress).expect("nobody cancels");
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("log.sl2");
    fs::write(&path, truth.sl2_bytes()).expect("a log");
    let survey = formats::open(&path, &progress).expect("a log");
    let survey = match frame {
        Some(frame) => survey.in_frame(frame),
        None => survey,
    };
    let products = pipeline::run(&survey, &settings(), None, &progress, |_| ()).expect("products");
    let survey = Arc::new(survey);
    (ProcessedLog { survey, products }, truth)
}

/// Mean stated standard deviation and mean true error of a map over the water of a plan, metres.
/// Where the map knows nothing, its depth is the mean depth and its sigma that of ignorance.
fn judged(logs: &[ProcessedLog], made: &Plan, truth: &Simulated) -> [f64; 2] {
    let frame = &logs[0].survey.track.frame;
    let origin = frame.origin();
    let plane = MapPlane::new(CrsChoice::Utm.at(origin).expect("a zone"), origin);
    let surface: Surface = joint_depth_surface(logs, &plane, &Progress::new())
        .expect("nobody cancels")
        .expect("a surface");
    let known: Vec<f64> = (surface.depth_m.iter())
        .filter(|depth| depth.is_finite())
        .map(|depth| f64::from(*depth))
        .collect();
    let mean_m = known.iter().sum::<f64>() / known.len() as f64;
    let limit_m = made.before.sigma_m.iter().copied().fold(0.0, f32::max);
    let grid = made.grid();
    let (mut sums, mut count) = ([0.0; 2], 0.0);
    for cell in 0..grid.len() {
        let [east, north] = grid.centre(cell / grid.columns, cell % grid.columns);
        if !made.is_water([east, north]) {
            continue;
        }
        let [x, y] = plane.place(frame.to_lon_lat(east, north));
        let found = surface.grid.index_at(x, y).filter(|cell| surface.depth_m[*cell].is_finite());
        let (depth_m, sigma_m) = found.map_or((mean_m, limit_m), |cell| {
            (f64::from(surface.depth_m[cell]), surface.spread_m[cell])
        });
        sums[0] += f64::from(sigma_m);
        sums[1] += (depth_m - truth.bed_depth_m(east, north)).abs();
        count += 1.0;
    }
    sums.map(|sum| sum / count)
}

/// Evenly spaced lines over the water of a plan, along its length or across, as many as the minutes
/// reach for.
fn parallel(
    made: &Plan,
    frame: &LocalFrame,
    scene_frame: &LocalFrame,
    is_along: bool,
) -> Vec<[f64; 2]> {
    let grid = made.grid();
    let (mut least, mut most) = ([f64::MAX; 2], [f64::MIN; 2]);
    for cell in 0..grid.len() {
        let place = grid.centre(cell / grid.columns, cell % grid.columns);
        if made.is_water(place) {
            for axis in 0..2 {
                least[axis] = least[axis].min(place[axis]);
                most[axis] = most[axis].max(place[axis]);
            }
        }
    }
    let (along, across) = if is_along { (0, 1) } else { (1, 0) };
    let length_m = most[along] - least[along];
    let width_m = most[across] - least[across];
    let budget_m = 60.0 * MINUTES * SPEED_MPS;
    // A line and the way to the next one: so many fit, the last perhaps not whole.
    let mut count = 1.0;
    while count * length_m + width_m * (count - 1.0) / count < budget_m {
        count += 1.0;
    }
    let mut corners = Vec::new();
    for line in 0..count as u32 {
        let offset = least[across] + width_m * (f64::from(line) + 0.5) / count;
        let ends = match line % 2 {
            0 => [least[along], most[along]],
            _ => [most[along], least[along]],
        };
        for end in ends {
            let mut place = [0.0; 2];
            (place[along], place[across]) = (end, offset);
            corners.push(scene_frame.to_enu(frame.to_lon_lat(place[0], place[1])));
        }
    }
    corners
}

/// Stated sigma and true error: as surveyed, with the planned lines, with parallel ones along and
/// across.
struct Outcome {
    before: [f64; 2],
    planned: [f64; 2],
    parallel: [[f64; 2]; 2],
    predicted: f64,
}

fn sail(index: u64) -> Outcome {
    let pond = Pond::new(index);
    let progress = Progress::new();
    let (first, truth) = processed(&pond.scene(pond.corners.clone(), None), 10 * index, None);
    let frame = first.survey.track.frame.clone();
    let known = survey_coverage(std::slice::from_ref(&first), &ObjectList::default(), &progress)
        .expect("nobody cancels")
        .expect("a log");
    let asked =
        PlanSettings { minutes: MINUTES, turn_radius_m: RADIUS_M, ..PlanSettings::default() };
    let made = plan(&known, None, &asked, &progress).expect("a plan");
    assert!((made.speed_mps - SPEED_MPS).abs() < 0.1, "{}", made.speed_mps);
    assert!(made.minutes() <= MINUTES && made.turns_outside == 0, "{}", made.minutes());
    let scene_frame = {
        let scene = Scene::default();
        LocalFrame::new(LonLat { lon_deg: scene.longitude_deg, lat_deg: scene.latitude_deg })
    };
    let way = made.way.iter();
    let way = way
        .map(|waypoint| scene_frame.to_enu(frame.to_lon_lat(waypoint.place[0], waypoint.place[1])));
    let sailed = |corners: Vec<[f64; 2]>| {
        let scene = pond.scene(corners, Some(MINUTES));
        let (second, _) = processed(&scene, 10 * index + 1, Some(&frame));
        judged(&[first.clone(), second], &made, &truth)
    };
    let outcome = Outcome {
        before: judged(std::slice::from_ref(&first), &made, &truth),
        planned: sailed(way.collect()),
        parallel: [true, false]
            .map(|is_along| sailed(parallel(&made, &frame, &scene_frame, is_along))),
        predicted: made.after.mean_sigma_m,
    };
    let [along, across] = outcome.parallel;
    println!(
        "pond {index} ({:?}): {} lines, {:.2} min; sigma before {:.3} (predicted {:.3}), planned {:.3} (predicted {:.3}), parallel {:.3} and {:.3}; \
         error before {:.3}, planned {:.3}, parallel {:.3} and {:.3} m",
        pond.kind,
        made.lines.len(),
        made.minutes(),
        outcome.before[0],
        made.before.mean_sigma_m,
        outcome.planned[0],
        outcome.predicted,
        along[0],
        across[0],
        outcome.before[1],
        outcome.planned[1],
        along[1],
        across[1],
    );
    outcome
}

/// Means over some ponds: stated sigma and true error before, planned, with parallel lines along
/// and across. Planned lines leave less sigma than either, and far less error than before.
fn mends_more(ponds: std::ops::Range<u64>) -> [[f64; 4]; 2] {
    let outcomes: Vec<Outcome> = ponds.map(sail).collect();
    let means = [0, 1].map(|which| {
        let of = |outcome: &Outcome| {
            let [along, across] = outcome.parallel;
            [outcome.before, outcome.planned, along, across].map(|values| values[which])
        };
        let all: Vec<[f64; 4]> = outcomes.iter().map(of).collect();
        let count = all.len() as f64;
        [0, 1, 2, 3].map(|column| all.iter().map(|row| row[column]).sum::<f64>() / count)
    });
    let [sigmas, errors] = means;
    println!(
        "mean sigma {sigmas:.4?} m, mean true error {errors:.4?} m: before, planned, parallel along and across"
    );
    assert!(sigmas[1] < sigmas[2].min(sigmas[3]), "{sigmas:?}");
    assert!(errors[1] < 0.7 * errors[0], "{errors:?}");
    means
}

#[test]
fn planned_lines_mend_more_than_parallel_ones() {
    mends_more(0..3);
}

#[test]
#[ignore = "minutes: ten ponds"]
fn planned_lines_mend_more_than_parallel_ones_on_ten_ponds() {
    let [_, errors] = mends_more(0..10);
    assert!(errors[1] < errors[2].min(errors[3]), "{errors:?}");
}

//! Compares the log of simulated surveys with the simulated scene, and the truth with geometry that
//! is computed independently.

#![allow(
    clippy::expect_used,
    clippy::unwrap_used,
    reason = "their failure is the failure of the test"
)]

use bathyscope_log::formats;
use bathyscope_log::support::progress::{Cancelled, Progress};
use bathyscope_log::survey::{Side, SideScanState, Survey};
use bathyscope_simulation::{
    Artefacts, ObjectKind, ObjectSettings, Scene, Simulated, Terrace, TrackSettings, simulate,
};
use std::f64::consts::PI;

fn run(scene: &Scene, seed: u64) -> Simulated {
    simulate(scene, seed, &Progress::new()).expect("nobody cancels")
}

fn open(simulated: &Simulated) -> Survey {
    formats::open_bytes("simulated.sl2", simulated.sl2_bytes(), &Progress::new())
        .expect("our reader opens our log")
}

/// Simulates the first ten seconds of a scene.
fn run_short(mut scene: Scene) -> Simulated {
    scene.duration_s = Some(10.0);
    run(&scene, 1)
}

/// Creates a short straight line over level ground at 2.5 m, without faults.
fn level_scene() -> Scene {
    let mut scene = Scene::gentle();
    scene.bed.terrace = Some(Terrace {
        east_m: 0.0,
        north_m: 0.0,
        length_m: 200.0,
        width_m: 200.0,
        depth_m: 2.5,
        edge_m: 1.0,
    });
    scene.track =
        TrackSettings { lines: 1, cross_lines: 0, length_m: 12.0, ..TrackSettings::default() };
    scene.artefacts = Artefacts::none();
    scene.scattered_objects = 0;
    scene
}

/// Returns the mean byte of one side between two slant ranges, over some pings.
fn mean_byte(
    survey: &Survey,
    pings: impl Iterator<Item = usize>,
    side: Side,
    span_m: [f64; 2],
) -> f64 {
    let (mut sum, mut count) = (0.0, 0.0);
    for ping in pings {
        let scale = survey.side_scan[ping].side(side).expect("both sides are recorded");
        let samples = survey.samples(ping, side).expect("both sides are recorded");
        let [first, last] = span_m.map(|range_m| scale.sample_at(range_m) as usize);
        for index in first..last {
            sum += f64::from(samples.get(index));
            count += 1.0;
        }
    }
    sum / count
}

#[test]
fn demo_log_is_what_its_scene_gives() {
    // The bytes are equal on every machine, because the simulation uses IEEE 754 operations only.
    // The one exception, the rounding of positions to whole metres after the system's `tan` and
    // `ln`, could differ only within 1e-9 m of half a metre.
    let bundled =
        std::fs::read(bathyscope_test_support::demo_log()).expect("the bundled demo survey");
    assert!(bundled.len() < 4_000_000, "{} bytes", bundled.len());
    let again = run(&Scene::demo(), 1).sl2_bytes();
    assert!(bundled == again, "assets/demo.sl2 is not what assets/demo.toml gives with seed 1");
}

#[test]
fn demo_scene_is_the_bundled_one() {
    assert_ne!(Scene::demo(), Scene::default());
    assert_eq!(run_short(Scene::demo()).objects.len(), 5);
}

#[test]
fn same_seed_gives_same_log_on_any_number_of_threads() {
    let mut scene = Scene::rough();
    scene.duration_s = Some(8.0);
    let threads = |count| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(count).build();
        pool.expect("a thread pool").install(|| run(&scene, 5).sl2_bytes())
    };
    let bytes = threads(1);
    assert!(bytes == threads(3));
    assert!(bytes != run(&scene, 6).sl2_bytes());
}

#[test]
fn log_reads_back_as_simulated() {
    let scene = Scene::gentle();
    let simulated = run(&scene, 2);
    let survey = open(&simulated);
    assert_eq!(survey.side_scan_state, SideScanState::Usable);
    assert_eq!(survey.warnings, Vec::new());
    assert_eq!(survey.start_unix_s, Some(f64::from(scene.start_unix_s)));
    assert_eq!(survey.side_scan.len(), simulated.pings.len());
    for (read, truth) in survey.side_scan.iter().zip(&simulated.pings) {
        assert!((read.time_s - truth.time_s).abs() < 1e-6);
        for side in Side::BOTH {
            let span = read.side(side).expect("both sides are recorded");
            assert_eq!(span.count, scene.recorder.samples_per_side);
            assert!((span.metres_per_sample() - truth.metres_per_sample).abs() < 1e-8);
        }
    }
    let ranges = |expected: f64| {
        let scale = simulated.pings.iter().map(|ping| ping.metres_per_sample * 1400.0);
        scale.filter(|range| (range - expected).abs() < 1e-9).count()
    };
    assert!(ranges(12.0) > 700 && ranges(15.0) > 150, "the range changes on the way");
}

#[test]
fn survey_and_truth_share_their_origin() {
    let simulated = run_short(Scene::steep());
    let survey = open(&simulated);
    let (read, truth) = (survey.track.frame.origin(), simulated.frame.origin());
    assert!((read.lon_deg - truth.lon_deg).abs() < 1e-12);
    assert!((read.lat_deg - truth.lat_deg).abs() < 1e-12);
    // The position is a whole Mercator metre of a fix up to a tenth of a second old.
    for ping in &simulated.pings {
        let place = survey.track.frame.to_enu(ping.position);
        assert!((place[0] - ping.east_m).abs() < 1e-6 && (place[1] - ping.north_m).abs() < 1e-6);
        let fix = survey.track.fixes.iter().rev().find(|fix| fix.time_s <= ping.time_s + 1e-6);
        let fix = survey.track.frame.to_enu(fix.expect("a fix before every ping").position);
        let off = (fix[0] - place[0]).hypot(fix[1] - place[1]);
        assert!(off < 0.5 * 0.88 * 2f64.sqrt() + 0.27 + 0.01, "{off}");
    }
}

#[test]
fn recorded_depth_scatters_by_three_centimetres() {
    let simulated = run(&Scene::gentle(), 3);
    let survey = open(&simulated);
    let errors: Vec<f64> = survey
        .soundings
        .iter()
        .filter_map(|sounding| {
            let truth =
                simulated.pings.iter().find(|ping| (ping.time_s - sounding.time_s).abs() < 1e-6)?;
            Some(f64::from(sounding.depth_m) - truth.depth_m)
        })
        .collect();
    assert!(errors.len() > 500, "{} soundings", errors.len());
    let count = errors.len() as f64;
    let mean = errors.iter().sum::<f64>() / count;
    let sd = (errors.iter().map(|error| (error - mean).powi(2)).sum::<f64>() / count).sqrt();
    assert!(mean.abs() < 0.005, "{mean}");
    assert!((0.027..0.033).contains(&sd), "{sd}");
}

#[test]
fn first_return_is_the_nearest_ground_by_brute_force() {
    for (scene, seed) in [(Scene::steep(), 1), (Scene::rough(), 2)] {
        let simulated = run(&scene, seed);
        for ping in simulated.pings.iter().step_by(97) {
            let (sin, cos) = ping.heading_rad.sin_cos();
            for (side, sign) in [(Side::Port, -1.0), (Side::Starboard, 1.0)] {
                let nearest = (0..3000)
                    .map(|step| {
                        let across = f64::from(step) * 0.001;
                        let [east, north] =
                            [ping.east_m + sign * across * cos, ping.north_m - sign * across * sin];
                        across.hypot(simulated.bed_depth_m(east, north))
                    })
                    .fold(f64::INFINITY, f64::min);
                let ours = ping.side(side).first_return_m;
                // Steps of 12 mm miss the edge of an object by half a step at most.
                assert!(
                    (ours - nearest).abs() < 0.003,
                    "{side:?} {}: {ours} {nearest}",
                    ping.time_s
                );
            }
        }
    }
}

#[test]
fn level_ground_returns_first_at_its_depth_on_both_sides() {
    let simulated = run(&level_scene(), 1);
    let survey = open(&simulated);
    for ping in &simulated.pings {
        for side in Side::BOTH {
            let first = ping.side(side).first_return_m;
            assert!((first - ping.depth_m).abs() < 0.01 && (first - 2.5).abs() < 0.02, "{first}");
        }
    }
    for side in Side::BOTH {
        let all = || 0..simulated.pings.len();
        let water = mean_byte(&survey, all(), side, [2.0, 2.4]);
        let edge = mean_byte(&survey, all(), side, [2.5, 2.6]);
        let beyond = mean_byte(&survey, all(), side, [8.0, 9.0]);
        let ringing = mean_byte(&survey, all(), side, [0.0, 0.05]);
        assert!(water < 15.0 && edge > 75.0, "{water} {edge}");
        assert!(beyond < edge - 25.0, "fading with range: {beyond} {edge}");
        assert!(ringing > 128.0, "{ringing}");
    }
}

#[test]
fn shadow_tells_the_height_of_a_block() {
    let mut scene = level_scene();
    scene.recorder.electronic_noise = 1e-13;
    scene.recorder.volume_noise = 1e-13;
    scene.objects = vec![ObjectSettings {
        kind: ObjectKind::Block,
        east_m: 0.0,
        north_m: -4.0,
        length_m: 2.0,
        width_m: 0.8,
        height_m: 0.5,
        heading_deg: 90.0,
        buried_m: 0.0,
        strength_db: None,
    }];
    let simulated = run(&scene, 1);
    let survey = open(&simulated);
    let [seen] = &simulated.objects[0].sightings[..] else {
        panic!("{:?}", simulated.objects);
    };
    // The boat goes east, so south is starboard; 2 m at 0.135 m a ping are 15 pings.
    assert_eq!(seen.side, Side::Starboard);
    assert!((14..17).contains(&(seen.last_ping - seen.first_ping + 1)), "{seen:?}");
    // h = H (r_end - r_top) / r_end, from the far edge of the top (equations of the shadow).
    let [from, to] = seen.shadow_m;
    let height = 2.5 * (to - from) / to;
    assert!((height - 0.5).abs() < 0.02, "{height}");
    // The picture shows the shadow: it is dark behind the block, but not a few metres along the
    // track.
    let shadow = [from + 0.15, to - 0.15];
    let behind =
        mean_byte(&survey, seen.first_ping + 2..seen.last_ping - 1, Side::Starboard, shadow);
    let beside = mean_byte(&survey, 0..20, Side::Starboard, shadow);
    let top = mean_byte(
        &survey,
        seen.first_ping + 2..seen.last_ping - 1,
        Side::Starboard,
        [seen.near_m, seen.near_m + 0.1],
    );
    assert!(behind < beside - 30.0, "{behind} {beside}");
    assert!(top > beside + 5.0, "{top} {beside}");
}

#[test]
fn weed_returns_before_the_ground_and_is_flagged() {
    let mut scene = level_scene();
    scene.artefacts.weed_m = 5.0;
    let simulated = run(&scene, 4);
    let survey = open(&simulated);
    let (weed, bare): (Vec<usize>, Vec<usize>) =
        (0..simulated.pings.len()).partition(|&ping| simulated.pings[ping].port.weed);
    assert!(weed.len() > 10 && bare.len() > 10, "{} {}", weed.len(), bare.len());
    let above = [2.2, 2.35];
    let over_weed = mean_byte(&survey, weed.into_iter(), Side::Port, above);
    let over_bare = mean_byte(&survey, bare.into_iter(), Side::Port, above);
    assert!(over_weed > over_bare + 25.0, "{over_weed} {over_bare}");
}

#[test]
fn fixes_are_fresh_ten_times_a_second_and_mostly_repeat() {
    let simulated = run_short(Scene::gentle());
    let bytes = simulated.sl2_bytes();
    let word = |at: usize| u16::from_le_bytes([bytes[at], bytes[at + 1]]);
    let (mut at, mut fresh, mut frames) = (8, 0, 0);
    while at < bytes.len() {
        fresh += usize::from(word(at + 132) & 0x0010 != 0);
        frames += 1;
        at += usize::from(word(at + 28));
    }
    assert_eq!(at, bytes.len());
    let seconds = simulated.pings.last().expect("pings").time_s;
    assert!((fresh as f64 / seconds - 10.0).abs() < 0.3, "{fresh} in {seconds} s");
    assert!(frames > 3 * fresh, "{frames} {fresh}");
}

#[test]
fn truth_tables_have_a_line_for_every_ping_and_sighting() {
    let simulated = run_short(Scene::gentle());
    let mut truth = Vec::new();
    simulated.write_truth_csv(&mut truth).expect("writing to memory");
    let mut reader = csv::Reader::from_reader(truth.as_slice());
    let headings: Vec<f64> = reader
        .records()
        .map(|record| record.expect("a whole line")[6].parse().expect("a heading"))
        .collect();
    assert_eq!(headings.len(), simulated.pings.len());
    assert!((headings[0] - 90.0).abs() < 1e-3, "the first line runs east");
    let rad = simulated.pings[0].heading_rad;
    assert!((rad - PI / 2.0).abs() < 1e-6, "{rad}");

    let mut objects = Vec::new();
    simulated.write_objects_csv(&mut objects).expect("writing to memory");
    let lines = csv::Reader::from_reader(objects.as_slice()).into_records().count();
    let sightings: usize =
        simulated.objects.iter().map(|object| object.sightings.len().max(1)).sum();
    assert_eq!(lines, sightings);
}

#[test]
fn scenes_out_of_bounds_are_refused_in_one_sentence() {
    for (text, part) in [
        ("[bed]\nmean_depth_m = -1.0", "bed.mean_depth_m is -1"),
        ("[bed]\nmean_depth_m = nan", "bed.mean_depth_m is NaN"),
        ("[track]\nlines = 0\ncross_lines = 0", "the track has no line"),
        ("[track]\nlength_m = 100000.0\nlines = 1000", "more than 500000"),
        ("[recorder]\nsamples_per_side = 40000", "recorder.samples_per_side is 40000"),
        ("[bed]\ncolour = 3", "unknown field `colour`"),
        ("[bed", "unclosed table"),
    ] {
        let error = Scene::from_toml(text).expect_err(text).to_string();
        assert!(error.contains(part), "{text}: {error}");
        assert_eq!(error.lines().count(), 1, "{error}");
    }
    for scene in [Scene::gentle(), Scene::steep(), Scene::rough(), Scene::demo()] {
        scene.check().expect("a preset");
        let text = toml::to_string(&scene).expect("TOML");
        assert_eq!(Scene::from_toml(&text).expect(&text), scene);
    }
}

#[test]
fn cancelled_simulation_stops() {
    let progress = Progress::new();
    progress.cancel();
    assert!(matches!(simulate(&Scene::gentle(), 1, &progress), Err(Cancelled)));
}

/// Returns the mean and the standard deviation of the starboard bytes of the even ground between
/// two slant ranges.
fn spread_of_bytes(scene: &Scene, span_m: [f64; 2]) -> [f64; 2] {
    let survey = open(&run(scene, 1));
    let mut bytes = Vec::new();
    for ping in 0..survey.side_scan.len() {
        let scale = survey.side_scan[ping].side(Side::Starboard).expect("a side");
        let samples = survey.samples(ping, Side::Starboard).expect("samples");
        let [first, last] = span_m.map(|range_m| scale.sample_at(range_m) as usize);
        bytes.extend((first..last).map(|index| f64::from(samples.get(index))));
    }
    let mean = bytes.iter().sum::<f64>() / bytes.len() as f64;
    let squares: f64 = bytes.iter().map(|byte| (byte - mean).powi(2)).sum();
    [mean, (squares / bytes.len() as f64).sqrt()]
}

#[test]
fn a_recorder_that_smooths_shows_less_speckle_and_the_same_mean() {
    let mut scene = level_scene();
    scene.recorder.echo_ceiling = 255;
    let [mean, sd] = spread_of_bytes(&scene, [3.5, 5.0]);
    scene.recorder.smoothing_samples = 3.0;
    let [smooth_mean, smooth_sd] = spread_of_bytes(&scene, [3.5, 5.0]);
    assert!((mean - smooth_mean).abs() < 0.5, "{mean} {smooth_mean}");
    // A window of some ten samples averages grains of 2.5 samples.
    assert!((0.3..0.7).contains(&(smooth_sd / sd)), "{sd} {smooth_sd}");
}

#[test]
fn a_bed_that_scatters_by_a_higher_power_is_darker_where_it_is_seen_flatly() {
    let level_db = |power: f64, span_m: [f64; 2]| {
        let mut scene = level_scene();
        scene.recorder.echo_ceiling = 255;
        scene.artefacts.ring_down = 0.0;
        scene.recorder.electronic_noise = 0.0;
        scene.recorder.volume_noise = 0.0;
        scene.bed.scatter_power = power;
        spread_of_bytes(&scene, span_m)[0] / scene.recorder.bytes_per_db
    };
    // At 3.54 and 5 m the cosines are 0.71 and 0.5: an exponent greater by 2 lowers the first level
    // by 3 dB and the second by 6 dB.
    let [near_db, far_db] =
        [[3.49, 3.59], [4.9, 5.1]].map(|span_m| level_db(2.0, span_m) - level_db(4.0, span_m));
    assert!((far_db - near_db - 3.0).abs() < 0.5, "{near_db} {far_db}");
}

#[test]
fn fixes_wander_from_the_first_on() {
    let mut scene = Scene::gentle();
    scene.artefacts = Artefacts { position_m: 2.0, ..Artefacts::none() };
    let simulated = run(&scene, 1);
    let survey = open(&simulated);
    let boat_at = |time_s: f64| {
        let ping = simulated.pings.partition_point(|ping| ping.time_s < time_s);
        simulated.pings.get(ping)
    };
    let off_m: Vec<f64> = survey
        .track
        .fixes
        .iter()
        .filter_map(|fix| {
            let [east_m, north_m] = survey.track.frame.to_enu(fix.position);
            let truth = boat_at(fix.time_s)?;
            Some((east_m - truth.east_m).hypot(north_m - truth.north_m))
        })
        .collect();
    let usual_m = off_m.iter().sum::<f64>() / off_m.len() as f64;
    assert!(off_m[0] < 1.0, "{}", off_m[0]);
    assert!((1.0..6.0).contains(&usual_m), "{usual_m}");
}

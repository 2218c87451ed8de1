//! Several logs over one lake, with their own drafts, clocks and water levels, as one survey.

use bathyscope_bottom::bathymetry::Surface;
use bathyscope_bottom::bathymetry::height_offsets::{Datum, HeightOffsets};
use bathyscope_bottom::cloud::DepthSource;
use bathyscope_bottom::mosaic::{
    MosaicLog, MosaicSettings, TileIndex, joint_grid, joint_tile, match_levels, window,
};
use bathyscope_log::formats;
use bathyscope_log::support::geo::{Crs, MapPlane};
use bathyscope_log::support::progress::Progress;
use bathyscope_log::survey::{ExclusionReason, Side, Stretch, Survey};
use bathyscope_objects::Mark;
use bathyscope_objects::objects::{LogBox, LogId, ObjectBox, ObjectList, ObjectNumbers};
use bathyscope_objects::review::{BoxId, Reviewed};
use bathyscope_objects::targets::{PassLog, Target};
use bathyscope_products::pipeline::joint::{compare_heights, crossline_analysis};
use bathyscope_products::pipeline::{
    self, Derived, Mosaic, MosaicPlane, ObjectLocator, ProcessedLog, Settings, joint_depth_surface,
    mosaic_layout,
};
use bathyscope_simulation::{
    Artefacts, BedKind, BedSettings, ObjectKind, ObjectSettings, Scene, Simulated, TrackSettings,
    simulate,
};
use std::path::Path;
use std::sync::{Arc, OnceLock};

/// Height of the transducer of each log above that of the mean log, metres: its water level less
/// its draft.
pub(super) const HIGHER_M: [f64; 10] =
    [0.0, 0.35, -0.22, 0.61, -0.4, 0.12, -0.05, 0.5, -0.31, 0.24];

/// A lake with ten logs, all in the frame of the first.
struct Lake {
    logs: Vec<ProcessedLog>,
    truths: Vec<Arc<Simulated>>,
}

/// Places of objects on the bottom, metres from the lake's middle.
pub(super) const OBJECTS: [[f64; 2]; 4] = [[4.0, 9.0], [-9.0, -3.5], [12.0, -8.0], [-3.0, 14.0]];

fn object([east_m, north_m]: [f64; 2]) -> ObjectSettings {
    ObjectSettings {
        kind: ObjectKind::Block,
        east_m,
        north_m,
        length_m: 1.2,
        width_m: 0.8,
        height_m: 0.5,
        heading_deg: 20.0,
        buried_m: 0.0,
        strength_db: None,
    }
}

/// Log `index` over the lake: other lines, another day, another clock, another height over the
/// ground.
fn scene(index: usize, kind: BedKind) -> Scene {
    let bed = BedSettings {
        kind,
        seed: Some(77),
        mean_depth_m: 4.0 + HIGHER_M[index],
        terrace: None,
        ..BedSettings::default()
    };
    let own = index as f64;
    Scene {
        start_unix_s: 1_634_000_000 + 86_400 * index as u32 + 977 * (index as u32 % 4),
        bed,
        track: TrackSettings {
            lines: 2,
            cross_lines: 2,
            length_m: 44.0 + 3.0 * own,
            cross_length_m: 62.0 - 2.0 * own,
            spacing_m: 8.0 + 2.3 * own,
            ping_rate_hz: 10.0,
            ..TrackSettings::default()
        },
        artefacts: Artefacts { weed_m: 0.0, ..Artefacts::default() },
        objects: OBJECTS.map(object).to_vec(),
        scattered_objects: 0,
        ..Scene::default()
    }
}

fn simulated(index: usize, kind: BedKind) -> Simulated {
    let scene = scene(index, kind);
    simulate(&scene, 100 + index as u64, &Progress::new()).expect("nobody cancels")
}

/// Log `index` over gentle ground, sailed once for all tests.
pub(super) fn sailed(index: usize) -> &'static Arc<Simulated> {
    static TRUTHS: [OnceLock<Arc<Simulated>>; HIGHER_M.len()] = [const { OnceLock::new() }; _];
    TRUTHS[index].get_or_init(|| Arc::new(simulated(index, BedKind::Gentle)))
}

/// Writes some of the logs into a folder: `lake-0.sl2` and so on.
pub(super) fn write_logs(folder: &Path, count: usize) {
    for index in 0..count {
        let bytes = sailed(index).sl2_bytes();
        std::fs::write(folder.join(format!("lake-{index}.sl2")), bytes).expect("a log");
    }
}

impl Lake {
    /// Ten logs over gentle ground, sailed once for all tests.
    fn gentle() -> &'static Self {
        static LAKE: OnceLock<Lake> = OnceLock::new();
        LAKE.get_or_init(|| Self::new(BedKind::Gentle, HIGHER_M.len()))
    }

    fn new(kind: BedKind, count: usize) -> Self {
        let progress = Progress::new();
        let mut frame = None;
        let (mut logs, mut truths) = (Vec::new(), Vec::new());
        for index in 0..count {
            let truth = match kind {
                BedKind::Gentle => sailed(index).clone(),
                _ => Arc::new(simulated(index, kind)),
            };
            let survey = formats::open_bytes("simulated.sl2", truth.sl2_bytes(), &progress)
                .expect("a log that opens");
            let frame = frame.get_or_insert_with(|| survey.track.frame.clone());
            let survey = Arc::new(survey.in_frame(frame));
            let products = pipeline::run(&survey, &Settings::default(), None, &progress, |_| ())
                .expect("nobody cancels");
            logs.push(ProcessedLog { survey, products });
            truths.push(truth);
        }
        Self { logs, truths }
    }

    /// The same logs with the offsets in force.
    fn adjusted(&self, offsets: &HeightOffsets) -> Vec<ProcessedLog> {
        let progress = Progress::new();
        let with = |(log, offset): (&ProcessedLog, f64)| {
            let mut settings = Settings::clone(&log.products.settings);
            settings.height_offset_m = offset;
            let products =
                pipeline::run(&log.survey, &settings, Some(&log.products), &progress, |_| ())
                    .expect("nobody cancels");
            ProcessedLog { survey: log.survey.clone(), products }
        };
        let offsets = offsets.logs.iter().map(|log| log.offset_m);
        self.logs.iter().zip(offsets).map(with).collect()
    }

    /// Depth of the ground at a place of the shared frame, metres below the transducer of the first
    /// log.
    fn bed_depth_m(&self, place: [f64; 2]) -> f64 {
        self.truths[0].bed_depth_m(place[0], place[1])
    }
}

/// Returns the true height offsets, metres: the logs whose transducers hang higher measure deeper.
pub(super) fn true_offsets_m(count: usize) -> Vec<f64> {
    let higher_m = &HIGHER_M[..count];
    let mean_m = higher_m.iter().sum::<f64>() / count as f64;
    higher_m.iter().map(|higher_m| higher_m - mean_m).collect()
}

#[test]
fn crossings_of_ten_logs_give_their_heights_to_a_centimetre() {
    let progress = Progress::new();
    let steep = Lake::new(BedKind::Steep, 4);
    for (kind, lake) in [("gentle", Lake::gentle()), ("steep", &steep)] {
        let found =
            compare_heights(&lake.logs, Datum::Mean, &progress).expect("nobody cancels").offsets;
        assert_eq!(found.groups(), 1);
        for (log, (offset, true_m)) in
            found.logs.iter().zip(true_offsets_m(lake.logs.len())).enumerate()
        {
            let off_m = offset.offset_m - true_m;
            eprintln!(
                "{kind} log {log}: off by {:+.4} m, standard error {:.4} m, {} meetings",
                off_m, offset.standard_error_m, offset.log_overlaps
            );
            // On slopes up to 20 degrees a decimetre of position is as much as a centimetre of the
            // mean of some sixty overlaps.
            let allowed_m = if kind == "gentle" { 0.01 } else { 0.03 };
            assert!(off_m.abs() < allowed_m, "{kind} log {log}: {off_m}");
            assert!(off_m.abs() < 4.0 * offset.standard_error_m, "{kind} log {log}: {offset:?}");
        }
        let adjusted = lake.adjusted(&found);
        // What is in force is part of what is found.
        let again =
            compare_heights(&adjusted, Datum::Mean, &progress).expect("nobody cancels").offsets;
        for (one, other) in found.logs.iter().zip(&again.logs) {
            assert!((one.offset_m - other.offset_m).abs() < 1e-6);
        }
        let between = |logs: &[ProcessedLog]| {
            let all = crossline_analysis(logs, &progress).expect("nobody cancels");
            all.and_then(|all| all.between_logs).expect("crossings")
        };
        let (before, after) = (between(&lake.logs), between(&adjusted));
        eprintln!("{kind}: between logs sd {:.3} m before, {:.3} m after", before.sd_m, after.sd_m);
        assert!(before.sd_m > 0.3 && after.mean_m.abs() < 0.01, "{before:?} {after:?}");
        assert!(adjusted[1].products.correction.statement().contains("height offset"));
        let at = &adjusted[1].products.cloud.points[40];
        assert!((lake.bed_depth_m([at.east_m, at.north_m]) + at.z_m).abs() < 2.0);
    }
}

/// The depth map of each log and that of all together, in the plane of the map.
struct Maps {
    map: MapPlane,
    single: Vec<Surface>,
    joint: Surface,
}

impl Maps {
    fn of(logs: &[ProcessedLog]) -> Self {
        let origin = logs[0].survey.track.frame.origin();
        let map = MapPlane::new(Crs::utm(origin), origin);
        let surface = |logs: &[ProcessedLog]| {
            joint_depth_surface(logs, &map, &Progress::new())
                .expect("nobody cancels")
                .expect("a surface")
        };
        Self {
            single: logs.iter().map(|log| surface(std::slice::from_ref(log))).collect(),
            joint: surface(logs),
            map,
        }
    }

    /// The log with the nearest sounding, and which logs have one within 2 m.
    fn near(&self, place: [f64; 2]) -> (Option<usize>, Vec<usize>) {
        let away = |(log, map): (usize, &Surface)| Some((log, map.at(place[0], place[1])?.1));
        let away: Vec<(usize, f32)> = self.single.iter().enumerate().filter_map(away).collect();
        let nearest = away.iter().min_by(|a, b| a.1.total_cmp(&b.1));
        let near = away.iter().filter(|(_, away_m)| *away_m < 2.0);
        (nearest.map(|(log, _)| *log), near.map(|(log, _)| *log).collect())
    }

    /// Errors of the known cells of the joint map.
    fn errors_m(&self, bed_m: impl Fn([f64; 2]) -> f64) -> Vec<f64> {
        let grid = &self.joint.grid;
        let cells = self.joint.depth_m.iter().enumerate();
        let known = cells.filter(|(_, depth_m)| !depth_m.is_nan());
        known
            .map(|(cell, depth_m)| {
                let place = grid.centre(cell / grid.columns, cell % grid.columns);
                f64::from(*depth_m) - bed_m(place)
            })
            .collect()
    }

    /// RMS of the error of the jump from a cell of the joint map to its eastern neighbour: where
    /// the two have another log nearest, and elsewhere.
    fn jumps_m(&self, bed_m: impl Fn([f64; 2]) -> f64) -> [f64; 2] {
        let grid = &self.joint.grid;
        let mut jumps = [Vec::new(), Vec::new()];
        for cell in 0..grid.len() {
            let (row, column) = (cell / grid.columns, cell % grid.columns);
            if column + 1 == grid.columns {
                continue;
            }
            let places = [grid.centre(row, column), grid.centre(row, column + 1)];
            let [Some(here), Some(next)] = places.map(|[x, y]| self.joint.at(x, y)) else {
                continue;
            };
            let [from, to] = places.map(|place| self.near(place).0);
            if here.1 < 2.0 && next.1 < 2.0 {
                let jump_m = f64::from(next.0 - here.0) - (bed_m(places[1]) - bed_m(places[0]));
                jumps[usize::from(from == to)].push(jump_m);
            }
        }
        jumps.map(|values| rms(&values))
    }
}

/// Depth of the ground of the lake at a place of the shared frame, metres below the transducer of
/// the first log.
pub(super) fn bed_depth_m(place: [f64; 2]) -> f64 {
    Lake::gentle().bed_depth_m(place)
}

/// Root of the mean of squares.
pub(super) fn rms(values: &[f64]) -> f64 {
    (values.iter().map(|value| value * value).sum::<f64>() / values.len() as f64).sqrt()
}

#[test]
fn one_depth_map_of_ten_logs_is_as_good_as_the_best_and_has_no_seams() {
    let lake = Lake::gentle();
    let progress = Progress::new();
    let offsets =
        compare_heights(&lake.logs, Datum::Mean, &progress).expect("nobody cancels").offsets;
    let frame = &lake.logs[0].survey.track.frame;
    let mean_m = HIGHER_M.iter().sum::<f64>() / HIGHER_M.len() as f64;
    let adjusted = Maps::of(&lake.adjusted(&offsets));
    let bed_m = |place: [f64; 2]| {
        let at = frame.to_enu(adjusted.map.to_lon_lat(place));
        lake.bed_depth_m(at) + mean_m
    };
    let grid = &adjusted.joint.grid;
    let mut errors: Vec<[Vec<f64>; 2]> = vec![Default::default(); lake.logs.len()];
    for cell in 0..grid.len() {
        let place = grid.centre(cell / grid.columns, cell % grid.columns);
        let (_, near) = adjusted.near(place);
        let Some((joint_m, _)) = adjusted.joint.at(place[0], place[1]).filter(|_| near.len() > 1)
        else {
            continue;
        };
        for log in near {
            let Some((own_m, _)) = adjusted.single[log].at(place[0], place[1]) else {
                continue;
            };
            errors[log][0].push(f64::from(own_m) - bed_m(place));
            errors[log][1].push(f64::from(joint_m) - bed_m(place));
        }
    }
    for (log, [own, joint]) in errors.iter().enumerate() {
        let (own_m, joint_m) = (rms(own), rms(joint));
        eprintln!(
            "log {log}: own map {own_m:.4} m, joint map {joint_m:.4} m over {} cells",
            own.len()
        );
        assert!(own.len() > 200, "log {log}: {}", own.len());
        assert!(joint_m < 1.02 * own_m, "log {log}: {joint_m} {own_m}");
    }
    let [seam_m, inside_m] = adjusted.jumps_m(bed_m);
    let before = Maps::of(&lake.logs);
    let [error_m, raw_error_m] = [&adjusted, &before].map(|maps| rms(&maps.errors_m(bed_m)));
    eprintln!(
        "jumps: {seam_m:.4} m at seams, {inside_m:.4} m inside; error {error_m:.4} m, without offsets {raw_error_m:.4}"
    );
    assert!(seam_m < 1.25 * inside_m.max(0.01), "{seam_m} {inside_m}");
    // A plate hides the seams of logs that disagree, but is wrong there.
    assert!(raw_error_m > 1.5 * error_m, "{raw_error_m} {error_m}");
}

/// The box that a labeller draws around echo and shadow.
pub(super) fn true_box(survey: &Survey, seen: &bathyscope_simulation::ObjectPass) -> Option<Mark> {
    let pings = seen.first_ping..seen.last_ping + 1;
    let span = survey.span(seen.first_ping, seen.side)?;
    let far_m = if seen.shadow_m[1].is_nan() {
        f64::from(span.far_m)
    } else {
        seen.shadow_m[1].max(seen.far_m)
    };
    (pings.len() >= 4).then_some(Mark { side: seen.side, pings, near_m: seen.near_m, far_m })
}

/// The boxes that a labeller draws around all objects of a log over gentle ground.
pub(super) fn true_boxes(index: usize, survey: &Survey) -> Vec<Mark> {
    let objects = sailed(index).objects.iter();
    let sightings = objects.flat_map(|object| &object.sightings);
    sightings.filter_map(|seen| true_box(survey, seen)).collect()
}

#[test]
fn an_object_that_several_logs_saw_is_one() {
    let lake = Lake::gentle();
    // Every log, its object, and where it was placed; the receivers of other days are some
    // decimetres off.
    let mut placed: Vec<(usize, usize, Target)> = Vec::new();
    for (log, (processed, truth)) in lake.logs.iter().zip(&lake.truths).enumerate() {
        let locator = ObjectLocator::new(&processed.survey, &processed.products);
        let day_m = [0.5 * (log as f64 * 2.1).sin(), 0.5 * (log as f64 * 1.3).cos()];
        for (object, known) in truth.objects.iter().enumerate() {
            let marks = known.sightings.iter().filter_map(|seen| true_box(&processed.survey, seen));
            placed.extend(marks.filter_map(|mark| {
                let target = locator.place(&mark)?;
                let moved = Target {
                    east_m: target.east_m + day_m[0],
                    north_m: target.north_m + day_m[1],
                    ..target
                };
                Some((log, object, moved))
            }));
        }
    }
    let boxed = |(index, (log, _, target)): (usize, &(usize, usize, Target))| ObjectBox {
        log: *log,
        key: LogBox { log: LogId(*log as u64), id: BoxId(index as u32) },
        one: Arc::new(Reviewed::drawn(BoxId(index as u32), target.mark.clone(), 0)),
        // One detector in ten takes it for something else.
        class: if target.mark.pings.start % 10 == 0 { "rock" } else { "block" }.to_owned(),
        target: Some(target.clone()),
        object: None,
        is_hidden: false,
    };
    let boxes = placed.iter().enumerate().map(boxed).collect();
    let pass_logs: Vec<PassLog<'_>> = lake.logs.iter().map(ProcessedLog::pass_log).collect();
    let list = ObjectList::join(boxes, &pass_logs, &ObjectNumbers::default());
    let groups = &list.objects;
    for object in 0..OBJECTS.len() {
        let seen = || placed.iter().filter(move |(_, of, _)| *of == object);
        let mut logs: Vec<usize> = seen().map(|(log, ..)| *log).collect();
        logs.dedup();
        assert!(logs.len() >= 4, "object {object}: {logs:?}");
        let of_object = |member: &usize| placed[*member].1 == object;
        let split = groups.iter().filter(|group| group.members.iter().any(of_object));
        let split: Vec<usize> = split.map(|group| group.members.len()).collect();
        eprintln!(
            "object {object}: {} sightings of {} logs in groups of {split:?}",
            seen().count(),
            logs.len()
        );
        // A glimpse in a sharp turn may stand alone; nine in ten sightings are one object.
        let largest = split.iter().max().copied().unwrap_or(0);
        assert!(10 * largest >= 9 * seen().count(), "object {object}: {split:?}");
        let joined = groups.iter().find(|group| group.members.len() == largest);
        let joined = joined.expect("an object");
        assert_eq!(joined.class, "block", "object {object}");
        // No sighting without a pass of the boat.
        let passes = joined.passes(&pass_logs);
        eprintln!("object {object}: {largest} boxes, {passes:?}");
        // Each log saw it on another day; a pass that saw it on both sides counts once.
        assert!((4..=largest).contains(&passes.seen));
        assert!((passes.seen..=40).contains(&passes.covered));
    }
    // No two objects are taken for one.
    for group in groups {
        let first = placed[group.members[0]].1;
        assert!(group.members.iter().all(|member| placed[*member].1 == first));
    }
}

#[test]
fn logs_of_one_mosaic_show_the_same_ground_alike() {
    let lake = Lake::gentle();
    let progress = Progress::new();
    let settings = MosaicSettings { cell_m: 0.5, ..MosaicSettings::default() };
    let logs = &lake.logs[..3];
    let origin = logs[0].survey.track.frame.origin();
    let map = MapPlane::new(Crs::utm(origin), origin);
    let results = Derived::default();
    let mosaic = Mosaic::new(logs, &MosaicPlane::Map(map), &results, &progress);
    let mosaic = mosaic.expect("nobody cancels");
    let mut made = mosaic.expect("ground").logs;
    let grid = joint_grid(&made, settings.cell_m).expect("ground");
    let ratio = |made: &[MosaicLog], a: usize, b: usize| {
        let drawn = [a, b].map(|log| {
            let log = &made[log];
            window(&log.survey, &log.layout, &grid, &log.gain, &settings, &progress)
                .expect("nobody cancels")
        });
        let both = drawn[0].iter().zip(&drawn[1]).filter(|(a, b)| **a > 0 && **b > 0);
        let mut ratios: Vec<f64> = both.map(|(a, b)| f64::from(*b) / f64::from(*a)).collect();
        assert!(ratios.len() > 1000, "{}", ratios.len());
        ratios.sort_by(f64::total_cmp);
        ratios[ratios.len() / 2]
    };
    // A log whose own levels make it a third darker than the others.
    made[1].gain = made[1].gain.clone().brightened(0.67);
    let before = ratio(&made, 0, 1);
    let matched = match_levels(made, &settings, &progress).expect("nobody cancels");
    for (a, b) in [(0, 1), (0, 2), (1, 2)] {
        let after = ratio(&matched, a, b);
        eprintln!("levels of {b} over those of {a}: {after:.3} (0 and 1 before: {before:.3})");
        assert!((after - 1.0).abs() < 0.04, "{a} {b}: {after}");
    }
    assert!(before < 0.75, "{before}");
    // The joint mosaic shows what any of them shows.
    let indices: Vec<TileIndex> = matched.iter().map(|log| log.layout.index(&grid)).collect();
    let parts: Vec<(&MosaicLog, &TileIndex)> = matched.iter().zip(&indices).collect();
    let joint = joint_tile(&parts, &grid, &settings, [0, 0]);
    let shown = |levels: &[u8]| levels.iter().filter(|level| **level > 0).count();
    let single = parts.iter().map(|part| shown(&joint_tile(&[*part], &grid, &settings, [0, 0])));
    assert!(shown(&joint) > single.max().unwrap_or(0));
}

#[test]
fn what_is_excluded_is_in_no_result() {
    let lake = Lake::gentle();
    let progress = Progress::new();
    let log = &lake.logs[3];
    let mut settings = Settings::clone(&log.products.settings);
    settings.excluded.max_turn_deg_s = Some(6.0);
    settings.excluded.stretches = vec![Stretch {
        pings: Some([100, 159]),
        time_s: None,
        reason: Some(ExclusionReason::Bad),
        trusted: false,
    }];
    let made = pipeline::run(&log.survey, &settings, Some(&log.products), &progress, |_| ())
        .expect("nobody cancels");
    let out = &made.exclusions;
    let turns = out.stretches.iter().filter(|stretch| stretch.reason == ExclusionReason::Turn);
    // Two lines and two cross lines have three turns, of which one is two.
    assert!((2..=5).contains(&turns.count()), "{:?}", out.stretches);
    assert_eq!(out.ping(100), Some(ExclusionReason::Bad));
    assert!(out.sounding_count() > 30 && out.ping_count() > 100);
    for point in made.cloud.points.iter() {
        assert_eq!(point.record().exclusion(out), None, "{point:?}");
    }
    let origin = log.survey.track.frame.origin();
    let map = MapPlane::new(Crs::utm(origin), origin);
    let layout = mosaic_layout(&log.survey, &made, &map);
    for ping in 0..log.survey.side_scan.len() {
        if out.ping(ping).is_some() {
            assert_eq!(made.depths[ping].source, DepthSource::None);
            assert!(Side::BOTH.iter().all(|side| layout.ray(ping, *side).is_none()));
        } else {
            assert_eq!(made.depths[ping].source, log.products.depths[ping].source);
        }
    }
    // What was found there stays to be seen.
    assert!(Arc::ptr_eq(&made.returns, &log.products.returns));
    let gone = log.products.cloud.points.len() - made.cloud.points.len();
    assert!(gone > 150, "{gone}");
    // Taken back, everything is as it was.
    let again = pipeline::run(&log.survey, &log.products.settings, Some(&made), &progress, |_| ())
        .expect("nobody cancels");
    assert_eq!(again.cloud.points.len(), log.products.cloud.points.len());
    assert_eq!(again.classes, log.products.classes);
    assert_eq!(again.calibration.offset_m, log.products.calibration.offset_m);
}

//! Several logs over one lake, with their own drafts, clocks and water levels, as one survey.

use bathyscope::bathymetry::height_offsets::{Datum, HeightOffsets};
use bathyscope::formats;
use bathyscope::pipeline::joint::{crossline_analysis, height_offsets};
use bathyscope::pipeline::{self, ProcessedLog, Settings};
use bathyscope::progress::Progress;
use bathyscope::simulation::{
    Artefacts, BedKind, BedSettings, Scene, Simulated, TrackSettings, simulate,
};
use std::sync::Arc;

/// What the transducer of a log hangs lower or higher over the ground than that of the mean log, metres: its water level less its
/// draft.
const HIGHER_M: [f64; 10] = [0.0, 0.35, -0.22, 0.61, -0.4, 0.12, -0.05, 0.5, -0.31, 0.24];

/// A lake with ten logs, all in the frame of the first.
struct Lake {
    logs: Vec<ProcessedLog>,
    truths: Vec<Simulated>,
}

/// Log `index` over the lake: other lines, another day, another clock, another height over the ground.
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
        artefacts: Artefacts {
            weed_m: 0.0,
            ..Artefacts::default()
        },
        scattered_objects: 0,
        ..Scene::default()
    }
}

impl Lake {
    fn new(kind: BedKind) -> Self {
        let progress = Progress::new();
        let mut frame = None;
        let (mut logs, mut truths) = (Vec::new(), Vec::new());
        for index in 0..HIGHER_M.len() {
            let truth = simulate(&scene(index, kind), 100 + index as u64, &progress)
                .expect("nobody cancels");
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
            let mut settings = log.products.settings.clone();
            settings.height_offset_m = offset;
            let products = pipeline::run(
                &log.survey,
                &settings,
                Some(&log.products),
                &progress,
                |_| (),
            )
            .expect("nobody cancels");
            ProcessedLog {
                survey: log.survey.clone(),
                products,
            }
        };
        let offsets = offsets.logs.iter().map(|log| log.offset_m);
        self.logs.iter().zip(offsets).map(with).collect()
    }

    /// Depth of the ground at a place of the shared frame, metres below the transducer of the first log.
    fn bed_depth_m(&self, place: [f64; 2]) -> f64 {
        self.truths[0].bed_depth_m(place[0], place[1])
    }
}

/// What the offsets should be: the logs that hang higher over the ground measure deeper.
fn true_offsets_m() -> Vec<f64> {
    let mean_m = HIGHER_M.iter().sum::<f64>() / HIGHER_M.len() as f64;
    HIGHER_M.iter().map(|higher_m| higher_m - mean_m).collect()
}

#[test]
fn crossings_of_ten_logs_give_their_heights_to_a_centimetre() {
    let progress = Progress::new();
    for kind in [BedKind::Gentle, BedKind::Steep] {
        let lake = Lake::new(kind);
        let found = height_offsets(&lake.logs, Datum::Mean, &progress).expect("nobody cancels");
        assert_eq!(found.groups(), 1);
        for (log, (offset, true_m)) in found.logs.iter().zip(true_offsets_m()).enumerate() {
            let off_m = offset.offset_m - true_m;
            eprintln!(
                "{kind:?} log {log}: off by {:+.4} m, standard error {:.4} m, {} meetings",
                off_m, offset.standard_error_m, offset.meetings
            );
            assert!(off_m.abs() < 0.01, "{kind:?} log {log}: {off_m}");
            assert!(
                off_m.abs() < 4.0 * offset.standard_error_m,
                "{kind:?} log {log}: {offset:?}"
            );
        }
        let adjusted = lake.adjusted(&found);
        // What is in force is part of what is found.
        let again = height_offsets(&adjusted, Datum::Mean, &progress).expect("nobody cancels");
        for (one, other) in found.logs.iter().zip(&again.logs) {
            assert!((one.offset_m - other.offset_m).abs() < 1e-6);
        }
        let between = |logs: &[ProcessedLog]| {
            let all = crossline_analysis(logs, &progress).expect("nobody cancels");
            all.and_then(|all| all.between_logs).expect("crossings")
        };
        let (before, after) = (between(&lake.logs), between(&adjusted));
        eprintln!(
            "{kind:?}: between logs sd {:.3} m before, {:.3} m after",
            before.sd_m, after.sd_m
        );
        assert!(
            before.sd_m > 0.3 && after.mean_m.abs() < 0.01,
            "{before:?} {after:?}"
        );
        assert!(
            adjusted[1]
                .products
                .correction
                .statement()
                .contains("height offset")
        );
        let at = &adjusted[1].products.cloud.points[40];
        assert!((lake.bed_depth_m([at.east_m, at.north_m]) + at.z_m).abs() < 2.0);
    }
}

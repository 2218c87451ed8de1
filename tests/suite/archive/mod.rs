//! Many logs over one water, in the tiles of an archive.

mod coverage;
mod killed;
mod levels;
mod map_tiles;
mod maps;
mod mosaic;
mod offsets;
pub(super) mod positions;
mod rows;

use crate::cli::run;
use bathyscope_log::support::geo::{UtmZone, metres_per_degree};
use bathyscope_log::support::progress::Progress;
use bathyscope_simulation::{Artefacts, BedSettings, Scene, Simulated, TrackSettings, simulate};
use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

/// The zone of the simulated water, and a corner of four tiles in it.
pub(super) const ZONE: UtmZone = UtmZone { number: 17, north: true };
pub(super) const CORNER_M: [f64; 2] = [392_192.0, 3_253_760.0];

/// A small survey about a place some metres from the corner, whose transducer hangs higher over the
/// ground than that of others.
pub(super) fn scene(log: u32, [east_m, north_m]: [f64; 2], higher_m: f64) -> Scene {
    let centre = ZONE.to_lon_lat(CORNER_M);
    let [lon_m, lat_m] = metres_per_degree(centre);
    Scene {
        longitude_deg: centre.lon_deg + east_m / lon_m,
        latitude_deg: centre.lat_deg + north_m / lat_m,
        start_unix_s: 1_634_000_000 + 86_400 * log,
        bed: BedSettings {
            seed: Some(77),
            mean_depth_m: 4.0 + higher_m,
            terrace: None,
            ..BedSettings::default()
        },
        track: TrackSettings {
            lines: 2,
            cross_lines: 2,
            length_m: 40.0 + 3.0 * f64::from(log),
            cross_length_m: 50.0 - 2.0 * f64::from(log),
            spacing_m: 9.0 + 1.5 * f64::from(log),
            ping_rate_hz: 10.0,
            ..TrackSettings::default()
        },
        artefacts: Artefacts { weed_m: 0.0, ..Artefacts::default() },
        scattered_objects: 0,
        ..Scene::default()
    }
}

/// The same ground, sailed to and fro about a place and across: a track that crosses those of logs
/// beside it a hundred times, so that the noise of a crossing, some 5 cm, leaves half a centimetre.
pub(super) fn zigzag(log: u32, [east_m, north_m]: [f64; 2], higher_m: f64) -> Scene {
    let ways = [
        [-26.0, -16.0],
        [26.0, -14.0],
        [25.0, 0.0],
        [-25.0, -2.0],
        [-26.0, 14.0],
        [22.0, 16.0],
        [18.0, -18.0],
        [2.0, -17.0],
        [0.0, 19.0],
        [-16.0, 18.0],
        [-14.0, -19.0],
    ];
    let scene = scene(log, [3.0, -4.0], higher_m);
    Scene {
        track: TrackSettings {
            corners_m: ways.map(|[x, y]| [east_m + x, north_m + y]).to_vec(),
            ..scene.track
        },
        ..scene
    }
}

/// Sails a survey and writes its log: `log-3.sl2`.
pub(super) fn sail(folder: &Path, log: u32, scene: &Scene) -> Simulated {
    let truth = simulate(scene, 100 + u64::from(log), &Progress::new()).expect("nobody cancels");
    fs::write(folder.join(format!("log-{log}.sl2")), truth.sl2_bytes()).expect("a log");
    truth
}

/// Three logs around the corner, in the archive `archive`.
pub(super) fn three_logs(folder: &Path) {
    for log in 0..3 {
        sail(folder, log, &scene(log, [3.0, -4.0], 0.0));
    }
    add(folder, &["log-0.sl2", "log-1.sl2", "log-2.sl2"]);
}

/// Adds logs to the archive `archive`; what the program says.
pub(super) fn add(folder: &Path, logs: &[&str]) -> String {
    let to_archive = ["-o", "archive", "--products", "tiles"];
    run(folder, &[&["process"], logs, &to_archive].concat())
}

/// All files below a folder by name.
pub(super) fn files(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let mut found = BTreeMap::new();
    for entry in fs::read_dir(folder).expect("a folder").flatten() {
        let name = entry.file_name().to_string_lossy().into_owned();
        if entry.path().is_dir() {
            let inner = files(&entry.path()).into_iter();
            found.extend(inner.map(|(inner, bytes)| (format!("{name}/{inner}"), bytes)));
        } else {
            _ = found.insert(name, fs::read(entry.path()).expect("a file"));
        }
    }
    found
}

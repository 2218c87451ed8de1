//! A survey of ten lines side by side.

use bathyscope_log::formats;
use bathyscope_log::support::progress::Progress;
use bathyscope_log::survey::Survey;
use bathyscope_simulation::{Scene, simulate};

const LINES: u32 = 10;

/// Ten lines, 15 m apart, of so many pings each.
pub(super) fn ten_lines(pings_a_line: f64) -> Survey {
    let progress = Progress::new();
    let mut scene = Scene::with_pings(1);
    scene.track.lines = LINES;
    scene.track.spacing_m = 15.0;
    scene.track.length_m = pings_a_line * scene.track.speed_mps / scene.track.ping_rate_hz;
    let simulated = simulate(&scene, 1, &progress).expect("not cancelled");
    let survey = formats::open_bytes("lines.sl2", simulated.sl2_bytes(), &progress);
    survey.expect("a readable log")
}

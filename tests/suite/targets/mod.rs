//! Targets as an analyst makes them: edges drawn by hand on a wreck, points, names, and what leaves
//! the program of them.

mod heights;
mod hulls;
mod shapes;
mod wreck;

use bathyscope::app::{App, Command, Jobs, LogBox};
use bathyscope_log::support::progress::Progress;
use bathyscope_objects::review::{BoxId, Edit, Reviewed};
use bathyscope_objects::targets::Target;
use bathyscope_simulation::{
    Artefacts, BedSettings, ObjectSettings, Scene, Simulated, Terrace, TrackSettings, simulate,
};
use std::path::{Path, PathBuf};

/// A level bed so deep under the boat, one line to the east over it, and nothing that disturbs but
/// speckle.
fn level_scene(depth_m: f64, line_m: f64, objects: Vec<ObjectSettings>) -> Scene {
    Scene {
        bed: BedSettings {
            mean_depth_m: depth_m,
            terrace: Some(Terrace {
                east_m: 0.0,
                north_m: 0.0,
                length_m: 4.0 * line_m,
                width_m: 4.0 * line_m,
                depth_m,
                edge_m: 5.0,
            }),
            ..BedSettings::default()
        },
        track: TrackSettings {
            lines: 1,
            cross_lines: 0,
            length_m: line_m,
            ..TrackSettings::default()
        },
        artefacts: Artefacts::none(),
        objects,
        scattered_objects: 0,
        ..Scene::default()
    }
}

/// Has a recorder see the ground to this range: a gain that follows the level ground, and little
/// noise. With the usual one it sinks to nought beyond some 13 m, and where there is no ground no
/// shadow ends.
fn see_far(scene: &mut Scene, range_m: f64) {
    let recorder = &mut scene.recorder;
    recorder.range_m = range_m;
    recorder.samples_per_side = 2000;
    recorder.tvg_limit_m = range_m;
    recorder.tvg_power = 4.0;
    recorder.electronic_noise *= 0.01;
    recorder.volume_noise *= 0.01;
}

/// A simulated log in a file.
fn written(folder: &Path, name: &str, scene: &Scene, seed: u64) -> (PathBuf, Simulated) {
    scene.check().expect("a scene that can be simulated");
    let truth = simulate(scene, seed, &Progress::new()).expect("nobody cancels");
    let path = folder.join(name);
    std::fs::write(&path, truth.sl2_bytes()).expect("a log");
    (path, truth)
}

/// Lets the app finish what it began.
fn settle(app: &mut App) {
    for _ in 0..200 {
        app.poll();
        let all_done = app.logs.visible().all(|log| !log.is_behind());
        if app.is_idle() && all_done {
            return;
        }
    }
    panic!("it comes to no end");
}

/// The app with a log in it.
fn opened(log: &Path) -> App {
    let mut app = App::new(Jobs::Inline);
    app.apply(Command::Open(log.to_owned()));
    settle(&mut app);
    assert!(app.logs.shown.products.is_some(), "{:?}", app.notices.shown());
    app
}

fn edit(app: &mut App, edit: Edit) {
    app.apply(Command::Edit { edit, live: false });
    settle(app);
}

fn only_box(app: &App) -> Reviewed {
    let mut boxes = app.logs.shown.reviewing.review.boxes();
    let review_box = boxes.next().expect("a box").clone();
    assert_eq!(boxes.next(), None);
    review_box
}

fn target(app: &App, id: BoxId) -> Target {
    let placed = app.logs.shown.reviewing.placed(id).expect("it has a place");
    placed.target.clone()
}

fn log_box(app: &App, id: BoxId) -> LogBox {
    let log = app.logs.shown.id;
    LogBox { log, id }
}

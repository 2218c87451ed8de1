//! One log and fifty of 100 000 pings each, open in one window: the time of a frame, memory, and
//! how soon a moved threshold shows.

use crate::large_log;
use crate::resources::anonymous_mb;
use bathyscope::app::{App, Command, Jobs};
use bathyscope::ui::Shell;
use bathyscope_log::support::progress::Progress;
use bathyscope_simulation::{Scene, simulate};
use eframe::egui_wgpu::{RenderState, RendererOptions};
use egui_kittest::wgpu::{create_render_state, default_wgpu_setup};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};

/// Logs open beside each other.
const COUNTS: [usize; 2] = [1, 50];
/// Pings of a log, and samples a side: fewer than a recorder's, since no frame and no key depends
/// on them.
const PINGS: usize = 100_000;
const SAMPLES: u32 = 200;
/// Frames timed.
const FRAMES: usize = 200;
/// Interval of the checks that work is done: as often as Bathyscope checks.
const LOOK: Duration = Duration::from_millis(2);

/// Figures that one window gave.
struct Figures {
    frame_ms: f64,
    slowest_ms: f64,
    shown_s: f64,
    rest_s: f64,
    kept_mb: f64,
}

/// Prints both and their ratios.
pub(super) fn run() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let paths = write_logs(folder.path(), COUNTS[1]);
    let state = create_render_state(default_wgpu_setup(), RendererOptions::PREDICTABLE);
    let [one, many] = COUNTS.map(|count| {
        let figures = measure(&state, &paths[..count]);
        println!(
            "{count:3} logs: {:.2} ms a frame (slowest tenth {:.2}), threshold moved: shown log after {:.2} s, all after {:.1} s, {:.0} MB",
            figures.frame_ms, figures.slowest_ms, figures.shown_s, figures.rest_s, figures.kept_mb
        );
        figures
    });
    println!("ratio of frames:            {:.2}", many.frame_ms / one.frame_ms);
    println!("ratio of slow frames:       {:.2}", many.slowest_ms / one.slowest_ms);
    println!("ratio of the shown log:     {:.2}", many.shown_s / one.shown_s);
    println!("ratio of all logs, of {}:   {:.2}", COUNTS[1], many.rest_s / one.rest_s);
    println!("ratio of memory:            {:.2}", many.kept_mb / one.kept_mb);
}

/// Logs beside each other, of other bytes each.
fn write_logs(folder: &Path, count: usize) -> Vec<PathBuf> {
    let mut scene = Scene::default();
    scene.recorder.samples_per_side = SAMPLES;
    let survey = simulate(&scene, 1, &Progress::new()).expect("nobody cancels");
    let log = survey.sl2_bytes();
    let pings = survey.pings.len();
    let patches = PINGS.div_ceil(pings);
    let write = |index: usize| {
        let path = folder.join(format!("log-{index:02}.sl2"));
        let first = i32::try_from(index * patches).expect("a small number");
        large_log::write_patches(&path, &log, first, log.len() * patches).expect("a log");
        path
    };
    (0..count).map(write).collect()
}

fn measure(state: &RenderState, paths: &[PathBuf]) -> Figures {
    let before_mb = anonymous_mb().unwrap_or(0.0);
    let mut app = App::new(Jobs::Threads(Arc::new(|| ())));
    app.apply(Command::OpenAll(paths.to_vec()));
    settle(&mut app);
    assert_eq!(app.logs.count(), paths.len(), "{:?}", app.notices.shown());
    let mut shell = Shell::new(app);
    let mut frames = frames(state, &mut shell);
    frames.sort();
    let ms = |time: Duration| 1e3 * time.as_secs_f64();
    let (shown_s, rest_s) = reaction(&mut shell.app);
    Figures {
        frame_ms: ms(frames[FRAMES / 2]),
        slowest_ms: ms(frames[FRAMES * 9 / 10]),
        shown_s,
        rest_s,
        kept_mb: anonymous_mb().unwrap_or(0.0) - before_mb,
    }
}

/// Seconds until the shown log is as a moved threshold makes it, and until all are.
fn reaction(app: &mut App) -> (f64, f64) {
    let mut settings = (*app.document.shared).clone();
    settings.first_return.threshold *= 1.1;
    let started = Instant::now();
    app.apply(Command::Change { settings: Box::new(settings), label: "threshold", live: false });
    while app.logs.shown.stale().is_some() {
        app.poll();
        std::thread::sleep(LOOK);
    }
    let shown_s = started.elapsed().as_secs_f64();
    settle(app);
    (shown_s, started.elapsed().as_secs_f64())
}

fn settle(app: &mut App) {
    loop {
        app.poll();
        if app.is_idle() {
            break;
        }
        std::thread::sleep(LOOK);
    }
}

/// Measures the times that frames of the whole window take on its thread while the pointer moves
/// over the views.
fn frames(state: &RenderState, shell: &mut Shell) -> Vec<Duration> {
    let context = egui::Context::default();
    let size = egui::vec2(1600.0, 1000.0);
    let mut times = Vec::new();
    let mut frame = 0;
    while times.len() < FRAMES {
        let (sin, cos) = (frame as f32 * 0.1).sin_cos();
        let at = egui::pos2(800.0 + 300.0 * cos, 500.0 + 300.0 * sin);
        let input = egui::RawInput {
            screen_rect: Some(egui::Rect::from_min_size(egui::Pos2::ZERO, size)),
            time: Some(frame as f64 / 60.0),
            events: vec![egui::Event::PointerMoved(at)],
            ..Default::default()
        };
        let settled = shell.is_settled();
        let started = Instant::now();
        let output = context.run_ui(input, |ui| shell.frame(ui, Some(state)));
        let shapes = context.tessellate(output.shapes, output.pixels_per_point);
        let elapsed = started.elapsed();
        std::hint::black_box(shapes);
        state.device.poll(wgpu::PollType::wait_indefinitely()).ok();
        if settled {
            times.push(elapsed)
        } else {
            // What is drawn first is made behind the window.
            std::thread::sleep(LOOK)
        }
        frame += 1;
    }
    times
}

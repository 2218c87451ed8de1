//! Memory beyond the map while a 2 GB log is open in the window: processed, drawn, its residuals
//! shown, everything kept.

use crate::large_log;
use crate::resources::anonymous_mb;
use bathyscope::app::{App, Command, Jobs};
use bathyscope::ui::{Shell, offscreen::Studio};
use bathyscope_log::support::progress::Progress;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// Interval of the measurements of memory.
const LOOK: Duration = Duration::from_millis(10);

/// Runs the benchmark and prints anonymous memory; file pages of the map are the system's to take
/// back.
pub(super) fn run() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("large.sl2");
    let bytes = large_log::write(&path, 2 << 30).expect("a large log");
    let studio = Studio::new();
    // An empty window first: what the graphics driver and the fonts take is not the log's.
    if let Ok(studio) = &studio {
        let mut empty = Shell::new(App::new(Jobs::Inline));
        studio.draw(&mut empty, [1280, 800], 1.0, &Progress::new()).expect("an empty window");
    }
    let Some(before_mb) = anonymous_mb() else {
        println!("skipped: this system does not report anonymous memory");
        return;
    };
    let survey = measured("opened", before_mb, || {
        bathyscope_log::formats::open(&path, &Progress::new()).expect("a log that opens")
    });
    drop(survey);
    let start = Instant::now();
    let mut app = App::new(Jobs::Threads(Arc::new(|| ())));
    app.apply(Command::Open(path));
    measured("processed", before_mb, || settle(&mut app));
    let pings = app.logs.shown.survey.as_ref().map_or(0, |survey| survey.side_scan.len());
    println!(
        "{:.2} GB of SL2, {pings} side-scan pings, opened and processed in {:.1} s",
        bytes as f64 / 1e9,
        start.elapsed().as_secs_f64(),
    );
    let mut shell = Shell::new(app);
    let Ok(studio) = studio.inspect_err(|reason| println!("  not drawn: {reason}")) else {
        return;
    };
    let draw = |shell: &mut Shell| studio.draw(shell, [1280, 800], 1.0, &Progress::new());
    measured("window drawn", before_mb, || draw(&mut shell)).expect("a window");
    // Its section may lie below the edge of a panel of this height: asked for as it asks.
    measured("residuals shown", before_mb, || {
        shell.app.apply(Command::CompareWithReference);
        settle(&mut shell.app);
        draw(&mut shell)
    })
    .expect("a window");
    println!("  drawn by {}", studio.adapter());
}

fn settle(app: &mut App) {
    while !app.is_idle() {
        app.poll();
        std::thread::sleep(LOOK);
    }
}

/// Does some work and prints the memory kept after it and the most while it ran, beyond
/// `before_mb`.
fn measured<T>(what: &str, before_mb: f64, work: impl FnOnce() -> T) -> T {
    let done = AtomicBool::new(false);
    let (result, kept_mb, peak_mb) = std::thread::scope(|scope| {
        let looks = scope.spawn(|| {
            let mut peak_mb = 0.0_f64;
            while !done.load(Ordering::Relaxed) {
                peak_mb = peak_mb.max(anonymous_mb().unwrap_or(0.0));
                std::thread::sleep(LOOK);
            }
            peak_mb
        });
        let result = work();
        let kept_mb = anonymous_mb().unwrap_or(0.0);
        done.store(true, Ordering::Relaxed);
        (result, kept_mb, looks.join().unwrap_or(kept_mb).max(kept_mb))
    });
    println!(
        "  {what}: {:.0} MB kept, {:.0} MB at the peak",
        kept_mb - before_mb,
        peak_mb - before_mb
    );
    result
}

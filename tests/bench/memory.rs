//! Memory beyond the map while a 2 GB log is open in the window: processed, drawn, everything kept.

use crate::large_log;
use bathyscope::app::{App, Command, Jobs};
use bathyscope::progress::Progress;
use bathyscope::ui::{Shell, offscreen::Studio};
use std::sync::Arc;
use std::time::Instant;

/// Runs the benchmark and prints anonymous memory; file pages of the map are the system's to take back.
pub fn run() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("large.sl2");
    let bytes = large_log::write(&path, 2 << 30).expect("a large log");
    let studio = Studio::new();
    // An empty window first: what the graphics driver and the fonts take is not the log's.
    if let Ok(studio) = &studio {
        let mut empty = Shell::new(App::new(Jobs::Inline));
        studio
            .draw(&mut empty, [1280, 800], 1.0, &Progress::new())
            .expect("an empty window");
    }
    let Some(before_mb) = anonymous_mb() else {
        println!("skipped: this system does not tell anonymous memory");
        return;
    };
    let survey = bathyscope::formats::open(&path, &Progress::new()).expect("a log that opens");
    println!(
        "  opened: {:.0} MB",
        anonymous_mb().unwrap_or(0.0) - before_mb
    );
    drop(survey);
    println!(
        "  closed: {:.0} MB",
        anonymous_mb().unwrap_or(0.0) - before_mb
    );
    let start = Instant::now();
    let mut app = App::new(Jobs::Threads(Arc::new(|| ())));
    app.apply(Command::Open(path));
    let mut peak_mb = before_mb;
    while !app.is_idle() {
        app.poll();
        peak_mb = peak_mb.max(anonymous_mb().unwrap_or(0.0));
        std::thread::sleep(std::time::Duration::from_millis(20));
    }
    let pings = app
        .survey
        .as_ref()
        .map_or(0, |survey| survey.side_scan.len());
    println!(
        "{:.2} GB of SL2, {pings} side-scan pings",
        bytes as f64 / 1e9
    );
    println!(
        "  opened and processed in {:.1} s: {:.0} MB kept, {:.0} MB at the peak",
        start.elapsed().as_secs_f64(),
        anonymous_mb().unwrap_or(0.0) - before_mb,
        peak_mb - before_mb
    );
    let mut shell = Shell::new(app);
    match studio.and_then(|studio| {
        studio.draw(&mut shell, [1280, 800], 1.0, &Progress::new())?;
        Ok(studio.adapter())
    }) {
        Ok(adapter) => println!(
            "  window drawn by {adapter}: {:.0} MB beyond an empty window",
            anonymous_mb().unwrap_or(0.0) - before_mb
        ),
        Err(reason) => println!("  not drawn: {reason}"),
    }
}

/// Anonymous resident memory of this process in MB (Linux).
fn anonymous_mb() -> Option<f64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find(|line| line.starts_with("RssAnon:"))?;
    line.split_whitespace()
        .nth(1)?
        .parse::<f64>()
        .ok()
        .map(|kb| kb / 1e3)
}

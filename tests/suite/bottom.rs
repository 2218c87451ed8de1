//! Bottom edits: in the window with the mouse and the keys, and headless from the file that the
//! window keeps.

use crate::cli::{refusal, run, stderr_of};
use crate::review::mouse::{at, drag, pull};
use crate::support;
use crate::window::{
    Window, app, demo_window, drawn_window, empty_window, open_step, press, settle,
};
use bathyscope::app::{App, BottomStroke, Command, FileToOpen, FileToWrite, Ink, WorkStep};
use bathyscope_bottom::first_return::Pick;
use bathyscope_log::support::progress::Progress;
use bathyscope_log::survey::Side;
use egui::{Event, Key, Modifiers};
use egui_kittest::kittest::Queryable as _;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Slant range of the first return in force, metres by the recorder's scale.
fn range_m(app: &App, side: Side, ping: usize) -> Option<f64> {
    let products = app.logs.shown.products.as_ref().expect("a result");
    let pick: Pick = products.returns.side(side)[ping];
    let survey = app.logs.shown.survey.as_ref().expect("a survey");
    let span = survey.span(ping, side).expect("a recorded side");
    pick.is_some().then(|| span.range_m(f64::from(pick.sample)))
}

pub(super) fn draw(window: &mut Window, held: Modifiers, from: (f64, f64), to: (f64, f64)) {
    window.event(Event::ModifiersChanged(held));
    let (from, to) = (at(window, from.0, from.1), at(window, to.0, to.1));
    drag(window, from, to);
    window.event(Event::ModifiersChanged(Modifiers::NONE));
    window.run();
}

fn near(found: Option<f64>, expected: f64) -> bool {
    found.is_some_and(|found| (found - expected).abs() < 0.1)
}

#[test]
fn the_pen_draws_the_bottom_takes_it_away_and_gives_it_back() {
    let mut window = demo_window();
    open_step(&mut window, WorkStep::Bottom);
    press(&mut window, Modifiers::NONE, Key::F);
    let found =
        |window: &Window| app(window).logs.shown.products.as_ref().expect("a result").found.clone();
    let (search, before) = (found(&window), range_m(app(&window), Side::Port, 350));
    press(&mut window, Modifiers::NONE, Key::M);
    window.get_by_label_contains(", drawing the bottom");
    draw(&mut window, Modifiers::NONE, (300.0, -6.0), (400.0, -4.0));
    assert!(near(range_m(app(&window), Side::Port, 350), 5.0));
    assert!(near(range_m(app(&window), Side::Port, 302), 6.0));
    assert_eq!(range_m(app(&window), Side::Starboard, 350), starboard(&search, &window));
    assert!(Arc::ptr_eq(&search, &found(&window)), "the search ran again");
    let products = app(&window).logs.shown.products.as_ref().expect("a result");
    assert_eq!(products.returns.port[350].confidence, 1.0);
    window.get_by_label_contains("pings edited");

    // With Ctrl none is detected; with Alt the search counts again, but for what is left beside it.
    draw(&mut window, Modifiers::COMMAND, (320.0, -7.0), (380.0, -7.0));
    assert_eq!(range_m(app(&window), Side::Port, 350), None);
    assert!(near(range_m(app(&window), Side::Port, 310), 5.8));
    draw(&mut window, Modifiers::ALT, (330.0, -7.0), (370.0, -7.0));
    assert_eq!(range_m(app(&window), Side::Port, 350), before);
    assert_eq!(range_m(app(&window), Side::Port, 325), None);

    for expected in [None, Some(5.0), before] {
        press(&mut window, Modifiers::COMMAND, Key::Z);
        let now = range_m(app(&window), Side::Port, 350);
        assert!(now == expected || near(now, expected.unwrap_or(f64::NAN)), "{now:?} {expected:?}");
    }
    assert!(app(&window).logs.shown.settings.bottom.is_empty());
    press(&mut window, Modifiers::COMMAND | Modifiers::SHIFT, Key::Z);
    assert!(near(range_m(app(&window), Side::Port, 350), 5.0));
    window.get_by_label("Remove the bottom edits").click_accesskit();
    window.run();
    assert_eq!(range_m(app(&window), Side::Port, 350), before);
    // Without the pen a drag moves the picture.
    press(&mut window, Modifiers::NONE, Key::Escape);
    draw(&mut window, Modifiers::NONE, (300.0, -6.0), (400.0, -4.0));
    assert!(app(&window).logs.shown.settings.bottom.is_empty());
}

fn starboard(
    returns: &bathyscope_bottom::first_return::FirstReturns,
    window: &Window,
) -> Option<f64> {
    let pick = returns.starboard[350];
    let survey = app(window).logs.shown.survey.as_ref().expect("a survey");
    let span = survey.span(350, Side::Starboard).expect("a side");
    pick.is_some().then(|| span.range_m(f64::from(pick.sample)))
}

#[test]
fn both_sides_are_drawn_at_once_and_keys_move_the_selected_ping() {
    let mut window = demo_window();
    open_step(&mut window, WorkStep::Bottom);
    press(&mut window, Modifiers::NONE, Key::F);
    press(&mut window, Modifiers::NONE, Key::M);
    window.get_by_label("Draw the bottom on both sides").click_accesskit();
    window.run();
    draw(&mut window, Modifiers::NONE, (500.0, 4.0), (600.0, 4.0));
    for side in Side::BOTH {
        assert!(near(range_m(app(&window), side, 550), 4.0), "{side:?}");
    }
    press(&mut window, Modifiers::NONE, Key::Home);
    let before = Side::BOTH.map(|side| range_m(app(&window), side, 0).expect("a return"));
    for (held, key) in [
        (Modifiers::SHIFT, Key::ArrowDown),
        (Modifiers::NONE, Key::ArrowDown),
        (Modifiers::NONE, Key::ArrowUp),
        (Modifiers::NONE, Key::ArrowUp),
    ] {
        press(&mut window, held, key);
    }
    let survey = app(&window).logs.shown.survey.clone().expect("a survey");
    for (side, before_m) in Side::BOTH.into_iter().zip(before) {
        let step_m = survey.span(0, side).expect("a side").metres_per_sample();
        let now_m = range_m(app(&window), side, 0).expect("a return");
        assert!((now_m - before_m - 9.0 * step_m).abs() < 1e-3, "{side:?}: {now_m}");
    }
}

/// The drawing of a sidecar file, headless.
const PROCESS: [&str; 7] =
    ["process", "pond.sl2", "-o", "out", "--no-objects", "--settings", "pond.bottom.toml"];

fn copied(folder: &Path) -> PathBuf {
    let log = folder.join("pond.sl2");
    fs::copy(support::demo_log(), &log).expect("a copy");
    log
}

fn opened(log: &Path) -> Window {
    let mut window = empty_window();
    let open = Command::Open(log.to_owned());
    window.state_mut().app.apply(open);
    window.run();
    window
}

/// Writes the bottom edits of a log into its sidecar file, as earlier versions did, and as
/// `--settings` takes them.
fn write_sidecar(log: &Path, window: &Window) {
    let bottom = toml::Table::try_from(&app(window).logs.shown.settings.bottom).expect("edits");
    let text = toml::to_string(&toml::Table::from_iter([("bottom".to_owned(), bottom.into())]));
    fs::write(log.with_extension("bottom.toml"), text.expect("text")).expect("a file");
}

#[test]
fn bottom_edits_next_to_the_log_are_taken_by_the_window_and_headless() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let log = copied(folder.path());
    let mut window = opened(&log);
    press(&mut window, Modifiers::NONE, Key::F);
    press(&mut window, Modifiers::NONE, Key::M);
    draw(&mut window, Modifiers::NONE, (300.0, -6.0), (400.0, -4.0));
    let drawn = app(&window).logs.shown.settings.bottom.clone();
    assert!(!log.with_extension("bottom.toml").exists(), "the window writes none");
    write_sidecar(&log, &window);
    drop(window);

    let window = opened(&log);
    assert_eq!(app(&window).logs.shown.settings.bottom, drawn);
    assert!(near(range_m(app(&window), Side::Port, 350), 5.0));
    window.get_by_label_contains("were taken from pond.bottom.toml");

    run(folder.path(), &PROCESS);
    let table =
        fs::read_to_string(folder.path().join("out/points/first_returns.csv")).expect("a table");
    let row = table.lines().nth(351).expect("ping 350");
    let sample: f64 = row.split(',').nth(8).and_then(|field| field.parse().ok()).expect("a sample");
    let products = app(&window).logs.shown.products.as_ref().expect("a result");
    assert!((sample - f64::from(products.returns.port[350].sample)).abs() < 0.01, "{row}");
    let report = fs::read_to_string(folder.path().join("out/report.json")).expect("a report");
    let count = drawn.ping_count();
    assert!((95..107).contains(&count), "{count}");
    assert!(report.contains(&format!("{count} first returns are manual picks.")));
    assert!(report.contains("\"bottom\""), "settings are all in the report");

    // Nothing is taken up unasked; that it lies there is said.
    let said = stderr_of(folder.path(), &["process", "pond.sl2", "-o", "plain", "--no-objects"]);
    assert!(said.contains("bottom edits lie next to the log and are not used"), "{said}");
}

/// A track of another receiver over the whole of the demo pond.
fn track_next_to(log: &Path) -> PathBuf {
    let survey = bathyscope_log::formats::open(log, &Progress::new()).expect("the demo");
    let mut text = "time,lon,lat\n".to_owned();
    for fix in survey.track.fixes.iter() {
        let (at, time_s) = (fix.position, survey.start_unix_s.expect("a time") + fix.time_s);
        text += &format!("{time_s:.3},{:.9},{:.9}\n", at.lon_deg, at.lat_deg);
    }
    let path = log.with_file_name("rtk.csv");
    fs::write(&path, text).expect("a track");
    path
}

#[test]
fn a_drawing_stays_under_another_receivers_track() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let log = copied(folder.path());
    let kept = folder.path().join("pond.bottom.toml");
    let track = track_next_to(&log);
    let stroke = |side| {
        Command::DrawBottom(BottomStroke {
            side,
            path: vec![[300.0, 6.0], [400.0, 4.0]],
            ink: Ink::Bottom,
        })
    };
    let mut window = opened(&log);
    window.state_mut().app.apply(stroke(Side::Port));
    let follow = Command::OpenFile(FileToOpen::Track(track.clone()));
    window.state_mut().app.apply(follow);
    window.run();
    assert!(app(&window).logs.shown.survey.as_ref().expect("a survey").track.external.is_some());
    assert!(near(range_m(app(&window), Side::Port, 350), 5.0), "lost under the track");
    // The next stroke joins it.
    window.state_mut().app.apply(stroke(Side::Starboard));
    window.run();
    write_sidecar(&log, &window);
    let text = fs::read_to_string(&kept).expect("the file");
    assert_eq!(text.matches("[[bottom.lines]]").count(), 2, "{text}");
    drop(window);

    let window = opened(&log);
    for side in Side::BOTH {
        assert!(near(range_m(app(&window), side, 350), 5.0), "{side:?}");
    }
    drop(window);

    // As an earlier version kept it, with the bytes of the track: with the track or without, it is
    // the same log.
    let bytes = |path: &Path| fs::metadata(path).expect("a file").len();
    let [own, both] = [bytes(&log), bytes(&log) + bytes(&track)];
    let earlier = text.replace(&format!("log_bytes = {own}"), &format!("log_bytes = {both}"));
    assert_ne!(earlier, text);
    fs::write(&kept, &earlier).expect("a file");
    let window = opened(&log);
    assert_eq!(app(&window).logs.shown.settings.bottom.lines.len(), 2);
    run(folder.path(), &[&PROCESS[..], &["--track", "rtk.csv"]].concat());
    let report = fs::read_to_string(folder.path().join("out/report.json")).expect("a report");
    assert!(report.contains("202 first returns are manual picks."), "{report}");
}

#[test]
fn a_review_that_cannot_be_used_is_kept_when_another_is_saved() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let log = copied(folder.path());
    let path = folder.path().join("pond.review.json");
    fs::write(&path, "years of work").expect("a file");
    let mut window = opened(&log);
    window.get_by_label_contains("this is no review");
    let place = app(&window).logs.shown.review_path().expect("a place");
    window.state_mut().app.apply(Command::Write(FileToWrite::Review(place)));
    window.run();
    let aside = folder.path().join("pond.review-older.json");
    assert_eq!(fs::read_to_string(aside).expect("kept"), "years of work");
    assert!(fs::read_to_string(&path).expect("saved").contains("\"survey\""));
}

#[test]
fn a_drawing_of_another_log_is_left_alone_and_said() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let log = copied(folder.path());
    let kept = folder.path().join("pond.bottom.toml");
    let lines = "[[bottom.lines]]\nside = 'port'\npings = [3, 9]\ncorners = [[3, 2.0]]\n";
    for (text, words) in [
        (format!("[bottom]\npings = 50\n{lines}"), "belongs to a log of 0 bytes and 50 pings"),
        (format!("[bottom]\npings = 5\n{lines}"), "below bottom.pings"),
        ("bottom = 3".to_owned(), "cannot use the bottom edits"),
    ] {
        fs::write(&kept, &text).expect("a file");
        let window = opened(&log);
        assert!(app(&window).logs.shown.settings.bottom.is_empty());
        window.get_by_label_contains(words);
        assert_eq!(fs::read_to_string(&kept).expect("the file"), text);
    }
    fs::write(&kept, format!("[bottom]\npings = 50\n{lines}")).expect("a file");
    run(folder.path(), &PROCESS);
    let report = fs::read_to_string(folder.path().join("out/report.json")).expect("a report");
    assert!(report.contains("it belongs to a log of 0 bytes and 50 pings"), "{report}");
    fs::write(&kept, format!("[bottom]\npings = 5\n{lines}")).expect("a file");
    let sentence = refusal(folder.path(), &PROCESS, 1);
    assert!(sentence.contains("below bottom.pings"), "{sentence}");
}

#[test]
fn the_window_with_the_pen_in_hand_looks_as_it_did() {
    let mut window = drawn_window([1024.0, 680.0]);
    window.state_mut().app.apply(Command::OpenDemo);
    window.run();
    open_step(&mut window, WorkStep::Bottom);
    window.state_mut().show_pings(0..500);
    press(&mut window, Modifiers::NONE, Key::M);
    for (side, path, ink) in [
        (Side::Port, vec![[40.0, 2.6], [90.0, 4.0], [140.0, 2.6]], Ink::Bottom),
        (Side::Starboard, vec![[200.0, 2.0], [300.0, 2.0]], Ink::Silence),
    ] {
        let stroke = BottomStroke { side, path, ink };
        window.state_mut().app.apply(Command::DrawBottom(stroke));
    }
    settle(&mut window);
    // A stroke under way, in the other direction.
    let (from, to) = (at(&window, 420.0, 3.0), at(&window, 340.0, 6.0));
    pull(&mut window, from, to);
    settle(&mut window);
    window.snapshot("window_bottom");
}

//! The window beside a recorder: a writer adds records at 20 times real speed while the program
//! looks on.

use crate::residuals::wait;
use crate::support::{demo_log, real_data};
use bathyscope::app::{
    Action, App, BottomStroke, Command, ExclusionEdit, FileToWrite, FollowStatus, Ink, Jobs,
    LogPlace, is_project,
};
use bathyscope_bottom::calibration::ScaleMode;
use bathyscope_log::formats::open_bytes;
use bathyscope_log::support::progress::Progress;
use bathyscope_log::survey::{LogPart, Side};
use bathyscope_objects::review::{Edit, State};
use std::fs::{File, OpenOptions};
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// Speed at which a log is written, as a multiple of that of its recording.
const SPEED: f64 = 20.0;
/// Time between two pieces that are written, as a recorder's buffer is flushed.
const FLUSH: Duration = Duration::from_millis(20);

fn threads() -> App {
    App::new(Jobs::Threads(Arc::new(|| ())))
}

/// Opens a log and waits for its results.
fn opened(path: &Path) -> App {
    let mut app = threads();
    app.apply(Command::Open(path.to_owned()));
    wait(&mut app);
    assert!(app.logs.shown.products.is_some(), "{:?}", app.notices.shown());
    app
}

fn pings(app: &App) -> usize {
    app.logs.shown.survey.as_ref().map_or(0, |survey| survey.side_scan.len())
}

/// Writes the rest of a log at [`SPEED`]; `duration_s` is that of all of it.
fn record(path: PathBuf, whole: Vec<u8>, from: usize, duration_s: f64) -> JoinHandle<f64> {
    std::thread::spawn(move || {
        let rate = whole.len() as f64 / duration_s * SPEED;
        let mut file = OpenOptions::new().append(true).open(path).expect("a log");
        let start = Instant::now();
        let mut at = from;
        while at < whole.len() {
            let end = from + (start.elapsed().as_secs_f64() * rate) as usize;
            let end = end.min(whole.len());
            file.write_all(&whole[at..end]).expect("room");
            file.flush().expect("room");
            at = end;
            std::thread::sleep(FLUSH);
        }
        (whole.len() - from) as f64 / rate
    })
}

/// Polls until a condition holds; pings never become fewer, and the longest that they were behind
/// is returned, seconds.
fn watch(app: &mut App, mut is_done: impl FnMut(&mut App) -> bool) -> f64 {
    let (start, mut last, mut behind_s) = (Instant::now(), pings(app), 0.0_f64);
    while !is_done(app) {
        app.poll();
        let now = pings(app);
        assert!(now >= last, "{now} pings after {last}");
        last = now;
        if let Some(FollowStatus::Growing { behind, .. }) = app.follow_status() {
            behind_s = behind_s.max(behind.as_secs_f64());
        }
        assert!(
            start.elapsed() < bathyscope_test_support::PATIENCE,
            "{now} pings, {:?}",
            app.notices.shown()
        );
        std::thread::sleep(Duration::from_millis(3));
    }
    behind_s
}

fn toggle(app: &mut App) {
    app.apply(Command::Do(Action::FollowRecording));
}

fn end(app: &mut App) {
    toggle(app);
    watch(app, |app| app.follow_status().is_none());
    wait(app);
}

fn files(folder: &Path) -> Vec<(PathBuf, Vec<u8>)> {
    let mut all = Vec::new();
    for entry in std::fs::read_dir(folder).expect("a folder").flatten() {
        if entry.path().is_dir() {
            all.extend(files(&entry.path()))
        } else {
            all.push((entry.path(), std::fs::read(entry.path()).expect("a file")))
        }
    }
    all.sort();
    all
}

fn export(app: &mut App, folder: &Path) {
    app.apply(Command::Write(FileToWrite::Products(folder.to_owned())));
    wait(app);
    assert!(folder.join("manifest.json").is_file(), "{:?}", app.notices.shown());
}

/// Compares what following came to with the finished file, in results and in files.
fn assert_as_finished(app: &mut App, path: &Path, folder: &Path) {
    let mut fresh = opened(path);
    let both = [&app.logs.shown, &fresh.logs.shown].map(|log| {
        let (survey, products) = (log.survey.clone(), log.products.clone());
        (survey.expect("a log"), products.expect("results"))
    });
    let [(survey, made), (finished, expected)] = both;
    assert!(format!("{:?}", survey.side_scan) == format!("{:?}", finished.side_scan));
    assert_eq!(survey.channels, finished.channels);
    assert_eq!(survey.warnings, finished.warnings);
    assert_eq!(made.settings, expected.settings);
    // NaN is no number that equals itself: what is written tells.
    assert!(format!("{:?}", made.navigation) == format!("{:?}", expected.navigation), "navigation");
    assert!(format!("{:?}", made.returns) == format!("{:?}", expected.returns), "returns");
    assert!(
        format!("{:?}", made.calibration) == format!("{:?}", expected.calibration),
        "calibration"
    );
    assert!(format!("{:?}", made.cloud) == format!("{:?}", expected.cloud), "cloud");
    assert_eq!(made.classes, expected.classes);
    assert!(format!("{:?}", made.depths) == format!("{:?}", expected.depths), "depths");
    let [followed, opened] = ["followed", "opened"].map(|name| folder.join(name));
    export(app, &followed);
    export(&mut fresh, &opened);
    let (one, other) = (files(&followed), files(&opened));
    assert!(one.len() > 10, "{} files", one.len());
    assert_eq!(one.len(), other.len());
    for ((name, one), (_, other)) in one.iter().zip(&other) {
        // The folder that was written into is in none of them.
        assert!(one == other, "{} differs", name.display());
    }
}

/// Follows a log that is written from a share on, and compares the end with the finished file.
fn follow(
    whole: &[u8],
    name: &str,
    share: f64,
    during: impl FnOnce(&mut App),
) -> (tempfile::TempDir, App) {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join(name);
    let from = (whole.len() as f64 * share) as usize;
    let (count, span_s) = {
        let survey = open_bytes(name, whole.to_vec(), &Progress::new()).expect("a log");
        (survey.side_scan.len(), survey.time_span_s().expect("times"))
    };
    std::fs::write(&path, &whole[..from]).expect("a log");
    let mut app = opened(&path);
    let begin = pings(&app);
    toggle(&mut app);
    let writer = record(path.clone(), whole.to_vec(), from, span_s.1 - span_s.0);
    during(&mut app);
    let start = Instant::now();
    let behind_s = watch(&mut app, |_| writer.is_finished());
    let written_s = writer.join().expect("a writer");
    let at_end = pings(&app);
    let late = Instant::now();
    watch(&mut app, |app| pings(app) == count);
    eprintln!(
        "{name}: pings {begin} to {count}, written in {written_s:.1} s ({:.0} pings/s), {at_end} shown when the last was written, all {:.2} s later; behind by {behind_s:.2} s at most; {:.1} s in all",
        (count - begin) as f64 / written_s,
        late.elapsed().as_secs_f64(),
        start.elapsed().as_secs_f64(),
    );
    assert!(app.is_following());
    (folder, app)
}

#[test]
fn every_ping_of_a_growing_log_appears_and_the_end_is_the_finished_file() {
    let demo = std::fs::read(demo_log()).expect("the demo");
    let (folder, mut app) = follow(&demo, "pond.sl2", 0.3, |_| ());
    end(&mut app);
    assert!(app.logs.shown.whole.is_none(), "nothing is provisional");
    assert_as_finished(&mut app, &folder.path().join("pond.sl2"), folder.path());
}

#[test]
fn a_real_recording_is_followed_to_its_end() {
    let Some(data) = real_data() else {
        return;
    };
    let whole = std::fs::read(data.join("lowrance/glencanyon-transcoded.sl2")).expect("a log");
    let (folder, mut app) = follow(&whole, "river.sl2", 0.25, |_| ());
    end(&mut app);
    assert_as_finished(&mut app, &folder.path().join("river.sl2"), folder.path());
}

#[test]
fn what_the_analyst_decides_while_a_log_grows_stays_and_can_be_undone() {
    let demo = std::fs::read(demo_log()).expect("the demo");
    let decide = |app: &mut App| {
        watch(app, |app| app.logs.shown.whole.is_some());
        let before = pings(app);
        app.apply(Command::Select(Some(LogPlace::ping(40))));
        app.apply(Command::DrawBottom(BottomStroke {
            side: Side::Port,
            path: vec![[30.0, 3.0], [60.0, 3.2]],
            ink: Ink::Bottom,
        }));
        let mark = bathyscope_objects::Mark {
            side: Side::Starboard,
            pings: 20..45,
            near_m: 6.0,
            far_m: 9.0,
        };
        let edit = Edit::Add { mark, class: 0 };
        app.apply(Command::Edit { edit, live: false });
        app.apply(Command::Exclude {
            log: app.logs.shown.id,
            part: LogPart::Pings([100, 120]),
            edit: ExclusionEdit::Exclude,
        });
        watch(app, |app| pings(app) > before + 50 && !app.logs.shown.is_behind());
    };
    let (_folder, mut app) = follow(&demo, "pond.sl2", 0.3, decide);
    let drawn = |app: &App| {
        let products = app.logs.shown.products.as_ref().expect("results");
        let boxes = app.logs.shown.reviewing.review.boxes();
        let boxes = boxes.filter(|review_box| review_box.state == State::Added).count();
        (products.returns.is_drawn(Side::Port, 40), boxes, products.exclusions.ping(110).is_some())
    };
    assert_eq!(drawn(&app), (true, 1, true));
    assert_eq!(app.logs.shown.reviewing.review.identity().pings, pings(&app));
    // A box among the pings that came since.
    let last = pings(&app);
    let mark = bathyscope_objects::Mark {
        side: Side::Port,
        pings: last - 30..last - 10,
        near_m: 5.0,
        far_m: 7.0,
    };
    let edit = Edit::Add { mark: mark.clone(), class: 0 };
    app.apply(Command::Edit { edit, live: false });
    assert!(app.logs.shown.reviewing.review.boxes().any(|review_box| review_box.mark == mark));
    for _ in 0..2 {
        app.apply(Command::Do(Action::Undo));
    }
    watch(&mut app, |app| !app.logs.shown.is_behind());
    assert_eq!(drawn(&app), (true, 1, false));
    app.apply(Command::Do(Action::Redo));
    watch(&mut app, |app| !app.logs.shown.is_behind());
    end(&mut app);
    assert_eq!(drawn(&app), (true, 1, true));
    for _ in 0..3 {
        app.apply(Command::Do(Action::Undo));
    }
    wait(&mut app);
    assert_eq!(drawn(&app), (false, 0, false));
    assert_eq!(pings(&app), last, "undo takes no ping back");
}

#[test]
fn objects_are_found_as_they_come_and_decisions_stay() {
    let demo = std::fs::read(demo_log()).expect("the demo");
    let mut rejected = None;
    let (_folder, mut app) = follow(&demo, "pond.sl2", 0.4, |app| {
        app.apply(Command::Do(Action::FindObjects));
        watch(app, |app| app.search_status().is_none());
        let first = app.logs.shown.reviewing.review.boxes().next().map(|review_box| review_box.id);
        rejected = first;
        if let Some(id) = first {
            let edit = Edit::Reject(id);
            app.apply(Command::Edit { edit, live: false });
        }
    });
    let count = pings(&app);
    let searched = |app: &App| {
        let last = app.logs.shown.reviewing.review.searched().last();
        last.map_or(0, |last| last.pings.end)
    };
    watch(&mut app, |app| searched(app) + 150 > count);
    let boxes = app.logs.shown.reviewing.review.boxes().len();
    eprintln!("{boxes} boxes, searched to ping {} of {count}", searched(&app));
    assert!(boxes > 0);
    if let Some(id) = rejected {
        let kept = app.logs.shown.reviewing.review.get(id).map(|review_box| review_box.state);
        assert_eq!(kept, Some(State::Rejected));
    }
    let steps = app.document.history.steps().count();
    assert!(steps <= 2, "what the program finds is no step: {steps}");
}

/// Follows a part of the demo, does something to its file, and returns what is said of it and how
/// many pings stay.
fn spoil(spoil: impl FnOnce(&Path, &[u8])) -> (String, usize) {
    let demo = std::fs::read(demo_log()).expect("the demo");
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("pond.sl2");
    std::fs::write(&path, &demo[..demo.len() / 2]).expect("a log");
    let mut app = opened(&path);
    toggle(&mut app);
    watch(&mut app, |app| matches!(app.follow_status(), Some(FollowStatus::Growing { .. })));
    let mut file = OpenOptions::new().append(true).open(&path).expect("a log");
    let half = demo.len() / 2;
    file.write_all(&demo[half..half + demo.len() / 10]).expect("room");
    drop(file);
    let before = pings(&app);
    watch(&mut app, |app| pings(app) > before);
    let grown = pings(&app);
    let notices = app.notices.shown().len();
    spoil(&path, &demo);
    watch(&mut app, |app| app.follow_status().is_none());
    wait(&mut app);
    let said: Vec<String> =
        app.notices.shown()[notices..].iter().map(|notice| notice.text.clone()).collect();
    assert_eq!(said.len(), 1, "{said:?}");
    assert!(!app.is_following() && app.logs.shown.whole.is_none());
    assert!(app.logs.shown.products.is_some() && !app.logs.shown.is_behind());
    // Every sample can still be read: none of it is a map of the file.
    let survey = app.logs.shown.survey.clone().expect("a log");
    let mut sum = 0_u64;
    let mut samples = Vec::new();
    for ping in 0..survey.side_scan.len() {
        if let Some(found) = survey.samples(ping, Side::Port) {
            found.copy_outward(&mut samples);
            sum += samples.iter().map(|sample| u64::from(*sample)).sum::<u64>();
        }
    }
    assert!(sum > 0);
    assert!(pings(&app) >= grown, "{} of {grown} pings", pings(&app));
    (said[0].clone(), pings(&app))
}

#[test]
fn a_log_that_is_cut_short_replaced_or_gone_ends_it_in_one_sentence() {
    let (cut, _) = spoil(|path, _| {
        let file = OpenOptions::new().write(true).open(path).expect("a log");
        file.set_len(1000).expect("it is cut");
    });
    assert!(cut.contains("it became shorter"), "{cut}");
    let (replaced, _) = spoil(|path, demo| {
        let other: Vec<u8> = demo.iter().map(|byte| byte ^ 0x5A).collect();
        std::fs::write(path, other).expect("a file");
    });
    assert!(replaced.contains("another recording"), "{replaced}");
    let (gone, _) = spoil(|path, _| std::fs::remove_file(path).expect("it was there"));
    assert!(gone.contains("cannot be read any more"), "{gone}");
    eprintln!("{cut}\n{replaced}\n{gone}");
}

#[test]
fn what_cannot_be_followed_is_said() {
    let mut app = threads();
    toggle(&mut app);
    assert!(app.notices.shown()[0].text.contains("open the log"), "{:?}", app.notices.shown());
    app.apply(Command::OpenDemo);
    wait(&mut app);
    toggle(&mut app);
    watch(&mut app, |app| app.follow_status().is_none());
    let last = app.notices.shown().last().expect("a notice");
    assert!(last.text.contains("only a log that is a file"), "{last:?}");
}

#[test]
fn a_log_in_which_nothing_is_written_costs_nothing_and_ends_as_it_was() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("pond.sl2");
    std::fs::copy(demo_log(), &path).expect("a log");
    let mut app = opened(&path);
    let before = app.logs.shown.products.clone().expect("results");
    let bytes = std::fs::read(&path).expect("a log");
    toggle(&mut app);
    let start = Instant::now();
    watch(&mut app, |_| start.elapsed() > Duration::from_secs(6));
    assert!(matches!(app.follow_status(), Some(FollowStatus::Silent { .. })));
    end(&mut app);
    let after = app.logs.shown.products.clone().expect("results");
    assert!(Arc::ptr_eq(&before.cloud, &after.cloud), "nothing was made anew");
    assert_eq!(std::fs::read(&path).expect("a log"), bytes);
}

#[test]
fn a_project_of_a_log_that_grew_is_opened_again() {
    let demo = std::fs::read(demo_log()).expect("the demo");
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("pond.sl2");
    std::fs::write(&path, &demo[..demo.len() / 2]).expect("a log");
    let mut app = opened(&path);
    let project = folder.path().join("lake.bathyscope");
    assert!(is_project(&project));
    app.apply(Command::Write(FileToWrite::Project(project.clone())));
    wait(&mut app);
    toggle(&mut app);
    let mut file: File = OpenOptions::new().append(true).open(&path).expect("a log");
    file.write_all(&demo[demo.len() / 2..demo.len() * 3 / 4]).expect("room");
    let before = pings(&app);
    watch(&mut app, |app| pings(app) > before);
    let mark = bathyscope_objects::Mark {
        side: Side::Port,
        pings: pings(&app) - 30..pings(&app) - 10,
        near_m: 5.0,
        far_m: 7.0,
    };
    let edit = Edit::Add { mark: mark.clone(), class: 0 };
    app.apply(Command::Edit { edit, live: false });
    app.apply(Command::SaveProject);
    wait(&mut app);
    app.keep_all();
    drop(app);
    // The recorder went on.
    file.write_all(&demo[demo.len() * 3 / 4..]).expect("room");
    let mut again = threads();
    again.apply(Command::Open(project));
    wait(&mut again);
    let boxes: Vec<_> = again
        .logs
        .shown
        .reviewing
        .review
        .boxes()
        .map(|review_box| review_box.mark.clone())
        .collect();
    assert_eq!(boxes, [mark], "{:?}", again.notices.shown());
    let whole = opened(&path);
    assert_eq!(pings(&again), pings(&whole));
}

/// Follows a log from a share on with the scale of a flat stretch and none chosen. The stretch that
/// was in use when following began stays in use, at the end too; returns whether a flatter one was
/// offered, with what it was taken for.
fn follow_with_scale(whole: &[u8], name: &str, share: f64) -> (App, Option<String>) {
    let scale = |app: &App| {
        let made = &app.logs.shown.products.as_ref().expect("results").calibration;
        assert_eq!(made.mode, ScaleMode::FlatSpot);
        let pings = made.flat_spot.as_ref().map(|spot| spot.pings.clone());
        (made.factor().expect("a scale"), pings.expect("a stretch"))
    };
    let mut at_start = None;
    let (_folder, mut app) = follow(whole, name, share, |app| {
        let mut settings = bathyscope_products::pipeline::Settings::clone(&app.logs.shown.settings);
        settings.calibration.mode = ScaleMode::FlatSpot;
        app.apply(Command::Change { settings: Box::new(settings), label: "scale", live: false });
        watch(app, |app| !app.logs.shown.is_behind());
        at_start = Some(scale(app));
    });
    let (factor, pings) = at_start.expect("a scale");
    let is_kept = |app: &App| {
        let (now, stretch) = scale(app);
        assert_eq!(stretch, pings, "another stretch");
        // The level of the picture, and with it each first return, is that of the whole log.
        assert!((now / factor - 1.0).abs() < 4e-3, "{now} for {factor}");
    };
    is_kept(&app);
    end(&mut app);
    is_kept(&app);
    let named = app.logs.shown.settings.calibration.pings;
    let named = named.map(|range| range.start..range.end);
    assert_eq!(named, Some(pings.clone()), "a script uses the same stretch");
    let best = app.logs.shown.products.as_ref().expect("results").flat_spots[0].clone();
    println!(
        "{name}: x{factor:.3} at {pings:?}, the whole log has x{:?} at {:?}",
        best.factor, best.pings
    );
    assert_ne!(best.pings, pings, "the whole log has a flatter stretch");
    let notices = app.notices.shown().iter();
    let mut offers = notices.filter(|notice| notice.offer == Some(Action::UseFlatterStretch));
    let offer = offers.next_back().map(|notice| notice.text.clone());
    if offer.is_some() {
        app.apply(Command::Do(Action::UseFlatterStretch));
        wait(&mut app);
        assert_eq!(scale(&app).1, best.pings);
        app.apply(Command::Do(Action::Undo));
        wait(&mut app);
        is_kept(&app);
    }
    (app, offer)
}

#[test]
fn the_scale_in_force_stays_while_a_log_grows() {
    let demo = std::fs::read(demo_log()).expect("the demo");
    follow_with_scale(&demo, "pond.sl2", 0.1);
}

#[test]
fn a_flatter_stretch_is_offered_while_a_log_grows_and_not_taken() {
    let Some(data) = real_data() else {
        return;
    };
    let whole = std::fs::read(data.join("lowrance/glencanyon-transcoded.sl2")).expect("a log");
    let (_, offer) = follow_with_scale(&whole, "river.sl2", 0.25);
    let offer = offer.expect("an offer");
    println!("{offer}");
    assert!(offer.contains("A flatter stretch was found"), "{offer}");
    assert!(offer.contains("depths change by about"), "{offer}");
}

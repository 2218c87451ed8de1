//! A window that pages through a log whose file fails under it: cut, overwritten, replaced,
//! removed, and, where `tests/readers/failing_disk` has made one, on a disk that does not give it
//! any more.

use super::window::{Window, app, settle};
use crate::support::{demo_log, real_data, snapshot_options};
use bathyscope::app::{App, Command, Jobs};
use bathyscope::ui::Shell;
use bathyscope_test_support::PATIENCE;
use egui::{Key, Modifiers};
use egui_kittest::Harness;
use std::fs::{self, File};
use std::os::unix::fs::FileExt as _;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};

/// Pages before the file fails, at most.
const MOST_PAGES: usize = 6;
/// Time in which a window with nothing to report is watched: two checks of its files.
const SILENCE: Duration = Duration::from_millis(2500);

/// Harm to a file.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Harm {
    Cut,
    Overwritten,
    Replaced,
    Removed,
    /// Every read fails.
    Unreadable,
    /// Every read fails, and nothing is known of the file.
    Gone,
}

/// Paths of the log.
struct Disk {
    /// The log as the window opens it, and as it is harmed.
    seen: PathBuf,
    kept: PathBuf,
    /// The file that tells the disk to fail.
    control: Option<PathBuf>,
}

impl Disk {
    /// A folder of the system's own.
    fn plain(folder: &Path) -> Self {
        let log = folder.join("river.sl2");
        Self { seen: log.clone(), kept: log, control: None }
    }

    /// The disk of `tests/readers/failing_disk`.
    fn failing() -> Option<Self> {
        let folder = PathBuf::from(std::env::var_os("BATHYSCOPE_FAILING_DISK")?);
        Some(Self {
            seen: folder.join("seen/river.sl2"),
            kept: folder.join("kept/river.sl2"),
            control: Some(folder.join("control")),
        })
    }

    fn refill(&self) {
        if let Some(control) = &self.control {
            fs::write(control, "").expect("a control file");
        }
        let river = real_data().map(|data| data.join("lowrance/glencanyon-transcoded.sl2"));
        let log = river.filter(|river| river.is_file()).unwrap_or_else(demo_log);
        fs::remove_file(&self.kept).ok();
        fs::copy(log, &self.kept).expect("a copy");
    }

    fn harm(&self, harm: Harm, round: usize) {
        let open = || {
            let file = File::options().write(true).open(&self.kept);
            file.expect("the log")
        };
        let length = fs::metadata(&self.kept).map_or(0, |log| log.len());
        match harm {
            Harm::Cut => open().set_len(length * round as u64 / 23).expect("a cut"),
            Harm::Overwritten => {
                let other = vec![round as u8; length as usize];
                open().write_all_at(&other, 0).expect("other bytes");
            }
            Harm::Replaced => {
                let other = self.kept.with_extension("other");
                fs::write(&other, vec![round as u8; 100_000]).expect("another file");
                fs::rename(other, &self.kept).expect("it takes the place");
            }
            Harm::Removed => fs::remove_file(&self.kept).expect("no file"),
            Harm::Unreadable | Harm::Gone => {
                let word = if harm == Harm::Gone { "gone" } else { "unreadable" };
                let control = self.control.as_ref().expect("a disk that fails");
                fs::write(control, word).expect("a control file");
            }
        }
    }
}

fn window() -> Window {
    let mut window = Harness::builder()
        .with_size([1000.0, 700.0])
        .with_max_steps(24)
        .with_options(snapshot_options())
        .wgpu()
        .build_eframe(|_| Shell::new(App::new(Jobs::Threads(Arc::new(|| ())))));
    window.step();
    window
}

/// Draws frames until something is so.
fn wait(window: &mut Window, patience: Duration, is_so: impl Fn(&App) -> bool) -> bool {
    let start = Instant::now();
    while start.elapsed() < patience {
        window.step();
        window.render().expect("a picture");
        if is_so(app(window)) {
            return true;
        }
        std::thread::sleep(Duration::from_millis(10));
    }
    false
}

fn page(window: &mut Window, pages: usize) {
    for _ in 0..pages {
        for _ in 0..8 {
            window.key_press_modifiers(Modifiers::SHIFT, Key::ArrowRight);
            window.step();
        }
        window.render().expect("a picture");
    }
}

/// Returns the notices of the file.
fn notices(app: &App) -> Vec<String> {
    let notices = app.notices.all().map(|notice| notice.text.clone());
    notices.filter(|text| text.contains("river.sl2")).collect()
}

/// Returns true if the window still has every byte of the log.
fn is_whole(app: &App, kept: &Path) -> bool {
    let survey = app.logs.shown.survey.as_ref().expect("a log is open");
    *survey.bytes[0] == *fs::read(kept).expect("the log")
}

/// One round: the window opens a log, pages through it, and goes on when its file fails.
fn round(disk: &Disk, harm: Harm, round: usize) {
    disk.refill();
    let mut window = window();
    window.state_mut().app.apply(Command::Open(disk.seen.clone()));
    let is_open = |app: &App| app.logs.shown.survey.is_some();
    assert!(wait(&mut window, PATIENCE, is_open), "it does not open");
    let before = notices(app(&window)).len();
    page(&mut window, round % MOST_PAGES);
    disk.harm(harm, round);
    page(&mut window, MOST_PAGES);
    // A file of the system's own that is replaced or removed is there as long as it is open. A disk
    // that another program serves may say of the one that took its place what it says of the log.
    let is_kept = matches!((harm, &disk.control), (Harm::Removed, _) | (Harm::Replaced, None));
    // What the system has read before, it gives without the disk.
    let is_lost = match harm {
        Harm::Unreadable | Harm::Gone => !is_whole(app(&window), &disk.kept),
        _ => !is_kept,
    };
    let is_said = |app: &App| notices(app).len() > before;
    let patience = if is_lost { PATIENCE } else { SILENCE };
    let found = wait(&mut window, patience, is_said);
    assert_eq!(found, is_lost, "{harm:?}, round {round}: {:?}", notices(app(&window)));
    // It goes on as a window that says it once.
    page(&mut window, 2);
    wait(&mut window, SILENCE, |_| false);
    let notices = notices(app(&window));
    assert_eq!(notices.len() - before, usize::from(is_lost), "{harm:?}: {notices:?}");
    settle(&mut window);
    if let Some(text) = notices.last().filter(|_| is_lost) {
        assert!(text.contains("open"), "it does not say what to do: {text}");
        println!(
            "{harm:?}, round {round}: {}",
            text.replace(&*disk.seen.to_string_lossy(), "river.sl2")
        );
    } else if matches!(harm, Harm::Unreadable | Harm::Gone) {
        println!("{harm:?}, round {round}: every byte is still there");
    }
}

fn rounds(harm: Harm, count: usize) {
    let folder = tempfile::tempdir().expect("a folder");
    let disk = Disk::plain(folder.path());
    for number in 1..=count {
        round(&disk, harm, number);
    }
}

#[test]
fn a_window_goes_on_when_its_log_is_cut() {
    rounds(Harm::Cut, 2);
}

#[test]
#[ignore = "minutes: twenty rounds of each harm, tests/nightly"]
fn a_window_goes_on_twenty_times_when_its_log_fails() {
    for harm in [Harm::Cut, Harm::Overwritten, Harm::Replaced, Harm::Removed] {
        rounds(harm, 20);
    }
}

#[test]
#[ignore = "needs the disk of tests/readers/failing_disk"]
fn a_window_goes_on_twenty_times_when_its_disk_fails() {
    let Some(disk) = Disk::failing() else {
        eprintln!("skipped: no disk that fails; run tests/readers/failing_disk");
        return;
    };
    use Harm::{Cut, Gone, Overwritten, Removed, Replaced, Unreadable};
    for harm in [Cut, Overwritten, Replaced, Removed, Unreadable, Gone] {
        for number in 1..=20 {
            round(&disk, harm, number);
        }
    }
}

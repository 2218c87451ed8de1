//! Writes reports of a window that panicked, for the person who fixes the fault. A report stays on
//! this computer: it is a text file beside the window's options, and the next window shows its
//! path.
//!
//! A report contains versions, the system, the panic and the kinds of the open logs: no positions,
//! and no names of logs.

use bathyscope_log::support::calendar::whole_seconds;
use bathyscope_log::support::catch_panic::{cause, is_caught};
use std::backtrace::Backtrace;
use std::fs::{self, File};
use std::io::Write as _;
use std::panic::PanicHookInfo;
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::time::{SystemTime, UNIX_EPOCH};

/// Ending of a report that no window has shown to the analyst yet.
const NEW: &str = "new.txt";
/// Number of reports that are kept.
const KEPT: usize = 10;

/// Folder of the reports of this process, and the descriptions of the open logs in them.
struct Keeper {
    folder: PathBuf,
    open: Vec<String>,
}

static KEEPER: Mutex<Option<Keeper>> = Mutex::new(None);

/// Writes reports of this process into a folder, which need not exist. Returns the newest report
/// there that no window has shown yet, and removes the oldest of many.
pub(crate) fn keep_in(folder: PathBuf) -> Option<PathBuf> {
    let newest = tell(&folder);
    let keeper = Keeper { folder, open: Vec::new() };
    *KEEPER.lock().ok()? = Some(keeper);
    newest
}

/// Sets the descriptions of the open logs, one line each.
pub(crate) fn set_open(logs: Vec<String>) {
    if let Ok(mut keeper) = KEEPER.lock()
        && let Some(keeper) = keeper.as_mut()
    {
        keeper.open = logs;
    }
}

/// Writes a report of a panic; the program's panic hook calls this. Writes nothing if no window
/// keeps reports, or if the panic is caught as an error of its own kind.
pub fn write_crash_report(fault: &PanicHookInfo<'_>) {
    if is_caught() {
        return;
    }
    // A panic while the list of logs is being changed must not wait for the lock.
    if let Ok(keeper) = KEEPER.try_lock()
        && let Some(keeper) = keeper.as_ref()
    {
        let place = fault.location().map(ToString::to_string);
        let what = format!(
            "{} at {}",
            cause(fault.payload()),
            place.unwrap_or_else(|| "an unknown place".to_owned())
        );
        // An error of writing is ignored: no window is left to show it.
        write(keeper, &what, &Backtrace::force_capture().to_string()).ok();
    }
}

fn write(keeper: &Keeper, what: &str, backtrace: &str) -> std::io::Result<()> {
    let now = SystemTime::now().duration_since(UNIX_EPOCH);
    let now_s = now.unwrap_or_default().as_secs();
    let thread = std::thread::current();
    fs::create_dir_all(&keeper.folder)?;
    let name = format!("crash-{now_s}-{}.{NEW}", std::process::id());
    let mut file = File::options().append(true).create(true).open(keeper.folder.join(name))?;
    writeln!(
        file,
        "bathyscope {} on {} {}, {}",
        env!("CARGO_PKG_VERSION"),
        std::env::consts::OS,
        std::env::consts::ARCH,
        whole_seconds(now_s as f64)
    )?;
    writeln!(file, "thread {}", thread.name().unwrap_or("without a name"))?;
    writeln!(file, "{what}")?;
    for log in &keeper.open {
        writeln!(file, "open: {log}")?;
    }
    writeln!(file, "{backtrace}")
}

/// Removes the mark of a new report from all reports; returns the path of the newest of them.
fn tell(folder: &Path) -> Option<PathBuf> {
    let names = |folder: &Path| {
        let files = fs::read_dir(folder).into_iter().flatten().flatten();
        let reports = files.map(|file| file.path()).filter(|path| {
            let name = path.file_name().unwrap_or_default().to_string_lossy();
            name.starts_with("crash-") && name.ends_with(".txt")
        });
        let mut reports: Vec<PathBuf> = reports.collect();
        reports.sort();
        reports
    };
    let mut newest = None;
    for new in names(folder) {
        let name = new.file_name().unwrap_or_default().to_string_lossy();
        if let Some(stem) = name.strip_suffix(NEW) {
            let reported = folder.join(format!("{stem}txt"));
            if fs::rename(&new, &reported).is_ok() {
                newest = Some(reported);
            }
        }
    }
    let all = names(folder);
    for old in &all[..all.len().saturating_sub(KEPT)] {
        fs::remove_file(old).ok();
    }
    newest
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_report_is_told_of_once_and_old_ones_go() {
        let folder = tempfile::tempdir().expect("a folder");
        let folder = folder.path().join("reports");
        assert_eq!(tell(&folder), None);
        let keeper = Keeper {
            folder: folder.clone(),
            open: vec!["Lowrance SL2, 12 bytes, 3 pings".to_owned()],
        };
        write(&keeper, "no more ink at pen.rs:7:1", "0: pen").expect("a report");
        let report = tell(&folder).expect("a report that was not told of");
        let text = fs::read_to_string(&report).expect("a report");
        for part in [
            env!("CARGO_PKG_VERSION"),
            "no more ink at pen.rs:7:1",
            "open: Lowrance SL2, 12 bytes, 3 pings",
            "0: pen",
            std::env::consts::ARCH,
        ] {
            assert!(text.contains(part), "{part}: {text}");
        }
        assert_eq!(tell(&folder), None);
        for number in 10..10 + 2 * KEPT {
            fs::write(folder.join(format!("crash-{number}-1.{NEW}")), "").expect("a report");
        }
        fs::write(folder.join("notes.txt"), "mine").expect("a file");
        assert!(tell(&folder).is_some());
        let left = fs::read_dir(&folder).expect("the folder").count();
        assert_eq!(left, KEPT + 1);
        assert!(folder.join("notes.txt").is_file());
    }

    #[test]
    fn a_panic_of_a_worker_leaves_a_report_and_one_that_is_caught_none() {
        let folder = tempfile::tempdir().expect("a folder");
        assert_eq!(keep_in(folder.path().to_owned()), None);
        set_open(vec!["a log of the trial".to_owned()]);
        let before = std::panic::take_hook();
        std::panic::set_hook(Box::new(write_crash_report));
        bathyscope_log::support::catch_panic::catch_panic::<()>(|| panic!("a caught trial"));
        let worker = std::thread::spawn(|| panic!("a trial of the hook"));
        assert!(worker.join().is_err());
        std::panic::set_hook(before);
        *KEEPER.lock().expect("no panic within") = None;
        let report = tell(folder.path()).expect("a report");
        let text = fs::read_to_string(report).expect("a report");
        assert!(text.contains("a trial of the hook at "), "{text}");
        assert!(text.contains("open: a log of the trial"), "{text}");
        assert!(!text.contains("a caught trial"), "{text}");
    }
}

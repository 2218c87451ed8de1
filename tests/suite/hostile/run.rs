//! Runs the program as its users do, and looks at how it ends and what it took.

use std::fs;
use std::io::Read;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::thread;
use std::time::Duration;

/// Seconds of processor time after which a run is stopped: beside other tests a search for objects
/// takes several times what it does alone.
const STOPPED_AFTER_S: f64 = 90.0;
/// Letters of a line for people; longer ones are cut.
const LONGEST_LINE: usize = 1000;

/// Result of a run.
pub(super) struct Outcome {
    /// `None` where a signal ended it.
    pub code: Option<i32>,
    pub stdout: String,
    pub stderr: String,
    /// Seconds of processor time, of all threads; 0 where the system does not report it.
    pub cpu_s: f64,
    /// Most memory that was resident; 0 where the system does not report it.
    pub peak_mib: u64,
}

/// Runs `bathyscope` in a folder.
pub(super) fn program(folder: &Path, args: &[String]) -> Outcome {
    let mut child = Command::new(crate::support::program())
        .args(args)
        .current_dir(folder)
        .env_remove("DISPLAY")
        .env_remove("WAYLAND_DISPLAY")
        .env_remove("RUST_BACKTRACE")
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("the program starts");
    let stdout = read(child.stdout.take().expect("a pipe"));
    let stderr = read(child.stderr.take().expect("a pipe"));
    let (mut cpu_s, mut peak_mib) = (0.0, 0);
    let status = loop {
        // What the system says last, some milliseconds before the end, is as good as all.
        cpu_s = processor_s(&child).unwrap_or(cpu_s);
        peak_mib = resident_mib(&child).unwrap_or(peak_mib);
        if let Some(status) = child.try_wait().expect("a child") {
            break status;
        }
        if cpu_s > STOPPED_AFTER_S {
            child.kill().expect("a child of ours");
        }
        thread::sleep(Duration::from_millis(2));
    };
    Outcome {
        code: status.code(),
        stdout: stdout.join().expect("a reader"),
        stderr: stderr.join().expect("a reader"),
        cpu_s,
        peak_mib,
    }
}

fn read(mut pipe: impl Read + Send + 'static) -> thread::JoinHandle<String> {
    thread::spawn(move || {
        let mut bytes = Vec::new();
        pipe.read_to_end(&mut bytes).expect("a pipe to read");
        String::from_utf8(bytes).expect("text")
    })
}

fn processor_s(child: &Child) -> Option<f64> {
    let stat = fs::read_to_string(format!("/proc/{}/stat", child.id())).ok()?;
    // The name before may hold spaces; the 14th and 15th field are hundredths of seconds.
    let (_, fields) = stat.rsplit_once(") ")?;
    let ticks = fields.split(' ').skip(11).take(2);
    let ticks: Option<f64> = ticks.map(|field| field.parse::<f64>().ok()).sum();
    Some(ticks? / 100.0)
}

fn resident_mib(child: &Child) -> Option<u64> {
    let status = fs::read_to_string(format!("/proc/{}/status", child.id())).ok()?;
    let peak = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    let kib: u64 = peak.trim().trim_end_matches(" kB").parse().ok()?;
    Some(kib >> 10)
}

/// Fault of how a run ended, in a sentence: it went down, said what no terminal should
/// get, or left half a file.
pub(super) fn fault(outcome: &Outcome, folder: &Path) -> Option<String> {
    let Outcome { code, stderr, .. } = outcome;
    let shows = |letter: char| !letter.is_control() && !matches!(letter, '\u{202a}'..='\u{202e}');
    let printed = outcome.stdout.chars().chain(stderr.chars());
    if let Some(letter) = printed.into_iter().find(|c| !shows(*c) && *c != '\n') {
        return Some(format!("it prints {letter:?}"));
    }
    if stderr.contains("a fault in Bathyscope itself") {
        return Some(format!("it panicked: {stderr}"));
    }
    let refusals = stderr.lines().filter(|line| line.starts_with("bathyscope: ")).count();
    match code {
        Some(0) if refusals == 0 => {}
        // clap reports wrong usage itself.
        Some(2) => {}
        Some(1) if refusals == 1 => {
            if !stderr.lines().last().is_some_and(|line| line.starts_with("bathyscope: ")) {
                return Some(format!("its reason does not come last: {stderr}"));
            }
        }
        _ => return Some(format!("it ends with {code:?}: {stderr}")),
    }
    if *code != Some(2) && stderr.lines().any(|line| line.chars().count() > LONGEST_LINE) {
        return Some("it says more than anybody reads".to_owned());
    }
    leftover(folder).map(|name| format!("it leaves {name}"))
}

/// The name of a half-written file below a folder.
fn leftover(folder: &Path) -> Option<String> {
    let entries = fs::read_dir(folder).ok()?.flatten();
    entries.into_iter().find_map(|entry| {
        let name = entry.file_name().to_string_lossy().into_owned();
        match entry.path().is_dir() {
            // Where a run writes until it is whole.
            true if name == ".bathyscope-run" => Some(name),
            true => leftover(&entry.path()),
            false => name.ends_with(".part").then_some(name),
        }
    })
}

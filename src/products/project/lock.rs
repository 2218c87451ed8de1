//! Lock that lets only one window open a project: the window locks the journal beside the file. On
//! Windows the journal is opened such that no other program can open it for writing.
//!
//! The system releases the lock when the program ends in any way, so that no lock is left over. On
//! a file system without locks, the journal's last entry about its owner is used instead: a program
//! of this computer that no longer runs does not own the project.

use serde::{Deserialize, Serialize};
use std::fmt;
use std::fs::{self, File, TryLockError};
use std::io;
use std::path::Path;
use std::time::{Duration, SystemTime, UNIX_EPOCH};

/// Program that has a project open.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Owner {
    /// Process number of the program.
    pub pid: u32,
    /// Name of the computer on which the program runs; empty if it has no name.
    pub host: String,
    /// Time at which the program opened the project, Unix seconds.
    pub since_unix_s: u64,
}

impl Owner {
    /// Returns this program as the owner from now on.
    pub(crate) fn now() -> Self {
        let since = SystemTime::now().duration_since(UNIX_EPOCH);
        Self {
            pid: std::process::id(),
            host: host(),
            since_unix_s: since.map_or(0, |since| since.as_secs()),
        }
    }

    /// Returns true if the program may still run; always true for another computer, where that is
    /// unknown.
    pub(crate) fn may_run(&self) -> bool {
        let is_here = self.host == host();
        let runs = || Path::new("/proc").join(self.pid.to_string()).exists();
        !is_here || !cfg!(target_os = "linux") || runs()
    }
}

impl fmt::Display for Owner {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "process {}", self.pid)?;
        if self.host != host() {
            write!(f, " on {}", self.host)?;
        }
        Ok(())
    }
}

fn host() -> String {
    let hostname = fs::read_to_string("/proc/sys/kernel/hostname").ok();
    let named =
        || ["COMPUTERNAME", "HOSTNAME"].into_iter().find_map(|name| std::env::var(name).ok());
    hostname.or_else(named).unwrap_or_default().trim().to_owned()
}

/// Result of a request for a lock.
#[derive(Debug, PartialEq, Eq)]
pub(super) enum Locked {
    /// This program has the lock.
    Ours,
    /// Another window has the lock.
    Taken,
    /// The file system has no locks.
    Unknown,
}

/// Number and interval of the requests for a lock that another program has. A process started by
/// that program has copies of its open files, including a lock that was just released, until the
/// process runs its own code.
const ATTEMPTS: u32 = 6;
const APART: Duration = Duration::from_millis(20);

/// Requests the lock of an open file; tries for a tenth of a second if another program has it.
pub(super) fn lock(file: &File) -> io::Result<Locked> {
    for _ in 1..ATTEMPTS {
        match try_lock(file)? {
            Locked::Taken => std::thread::sleep(APART),
            locked => return Ok(locked),
        }
    }
    try_lock(file)
}

fn try_lock(file: &File) -> io::Result<Locked> {
    if cfg!(windows) {
        // The program that could open the file is the only one.
        return Ok(Locked::Ours);
    }
    match file.try_lock() {
        Ok(()) => Ok(Locked::Ours),
        Err(TryLockError::WouldBlock) => Ok(Locked::Taken),
        // The numbers are errors of Linux for file systems without locks.
        Err(TryLockError::Error(error))
            if error.kind() == io::ErrorKind::Unsupported
                || matches!(error.raw_os_error(), Some(37 | 38 | 95)) =>
        {
            Ok(Locked::Unknown)
        }
        Err(TryLockError::Error(error)) => Err(error),
    }
}

/// Returns true if an open file is still the file at the path: another window may have removed it
/// between opening and locking.
#[cfg(unix)]
pub(super) fn is_still(file: &File, path: &Path) -> bool {
    use std::os::unix::fs::MetadataExt as _;
    let [open, there] = [file.metadata(), fs::metadata(path)];
    matches!((open, there), (Ok(open), Ok(there)) if open.ino() == there.ino() && open.dev() == there.dev())
}

/// Returns true if an open file is still the file at the path; no other program can remove an open
/// file here.
#[cfg(not(unix))]
pub(super) fn is_still(_: &File, path: &Path) -> bool {
    path.exists()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_owner_that_ended_owns_nothing() {
        let own = Owner::now();
        assert!(own.may_run());
        // The number is above the largest process number of Linux.
        let ended = Owner { pid: 4_294_967_294, ..own.clone() };
        assert_eq!(ended.may_run(), !cfg!(target_os = "linux"));
        let elsewhere = Owner { host: "another computer".to_owned(), ..ended };
        assert!(elsewhere.may_run());
        assert_eq!(elsewhere.to_string(), "process 4294967294 on another computer");
        assert_eq!(own.to_string(), format!("process {}", std::process::id()));
    }
}

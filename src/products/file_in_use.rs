//! Files that another program has open. On Windows such a file often cannot be written, renamed
//! over or removed; elsewhere it can. It depends on no other module; any may use it.

use std::fs::OpenOptions;
use std::io;
use std::path::Path;
use std::time::Duration;

/// Windows' numbers for what another program keeps from us: `ERROR_SHARING_VIOLATION`,
/// `ERROR_LOCK_VIOLATION`, `ERROR_USER_MAPPED_FILE`.
const IN_USE: [i32; 3] = [32, 33, 1224];
/// `ERROR_ACCESS_DENIED`: what Windows says, too, of renaming over a file that is open.
const DENIED: i32 = 5;
/// Number of attempts, and time between them, for a file that another program may have open for a
/// moment: scanners for viruses and indexers open each new file.
const ATTEMPTS: u32 = 20;
const APART: Duration = Duration::from_millis(50);

/// Returns true if an error says that another program has the file open.
pub fn is_in_use(error: &io::Error) -> bool {
    cfg!(windows) && matches!(error.raw_os_error(), Some(number) if IN_USE.contains(&number))
}

/// Runs work on a file; on Windows repeats it for a second while another program has the file open.
///
/// # Errors
/// The error of the last attempt.
pub(crate) fn patiently<T>(mut work: impl FnMut() -> io::Result<T>) -> io::Result<T> {
    let may_pass = |error: &io::Error| {
        cfg!(windows) && (is_in_use(error) || error.raw_os_error() == Some(DENIED))
    };
    for _ in 1..ATTEMPTS {
        match work() {
            Err(error) if may_pass(&error) => std::thread::sleep(APART),
            done => return done,
        }
    }
    work()
}

/// Sets the options of opening a file so that, on Windows, other programs can read it but neither
/// write, rename nor remove it while it is open; their errors are those of [`is_in_use`]. On other
/// systems the options stay as they are, and a lock has this effect; a lock of Windows would keep
/// others from reading, too.
pub(crate) fn for_one_writer(options: &mut OpenOptions) {
    #[cfg(windows)]
    {
        use std::os::windows::fs::OpenOptionsExt as _;
        const FILE_SHARE_READ: u32 = 1;
        options.share_mode(FILE_SHARE_READ);
    }
    #[cfg(not(windows))]
    let _ = options;
}

/// Returns true if another program has a file open so that it can be neither replaced nor removed;
/// never so but on Windows.
pub fn is_held(path: &Path) -> bool {
    #[cfg(windows)]
    {
        use std::os::windows::fs::OpenOptionsExt as _;
        const DELETE: u32 = 0x0001_0000;
        let open = || OpenOptions::new().access_mode(DELETE).open(path);
        patiently(open).is_err_and(|error| is_in_use(&error))
    }
    #[cfg(not(windows))]
    {
        let _ = path;
        false
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs::{self, File};

    #[test]
    fn one_program_writes_and_others_read() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("lock");
        fs::write(&path, b"one").unwrap();
        assert!(!is_held(&path));
        let mut options = File::options();
        options.read(true).write(true);
        for_one_writer(&mut options);
        let first = options.open(&path).unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"one");
        let second = options.open(&path);
        assert_eq!(second.is_err_and(|error| is_in_use(&error)), cfg!(windows));
        assert_eq!(is_held(&path), cfg!(windows));
        assert_eq!(fs::remove_file(&path).is_err(), cfg!(windows));
        drop(first);
    }

    #[test]
    fn what_another_has_open_for_a_moment_is_waited_for() {
        let mut tries = 0;
        let done = patiently(|| {
            tries += 1;
            match tries {
                3 => Ok(tries),
                _ => Err(io::Error::from_raw_os_error(IN_USE[0])),
            }
        });
        assert_eq!(done.ok(), cfg!(windows).then_some(3));
        assert!(patiently(|| Err::<(), _>(io::Error::other("full"))).is_err());
    }
}

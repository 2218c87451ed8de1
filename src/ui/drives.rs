//! Cards and drives that are not part of the computer: where each system shows them.

use std::fs;
use std::path::{Path, PathBuf};

/// Folders where Linux mounts cards, sticks and drives.
const LINUX: [&str; 3] = ["/media", "/run/media", "/mnt"];

/// Their top folders. Asking takes as long as the slowest of them: a drive of a network may need
/// seconds.
pub(crate) fn drives() -> Vec<PathBuf> {
    match std::env::consts::OS {
        "windows" => {
            let system = std::env::var("SystemDrive").unwrap_or_default();
            letters(&system, Path::is_dir)
        }
        "macos" => volumes(Path::new("/Volumes")),
        _ => {
            let mounts = fs::read("/proc/self/mounts").unwrap_or_default();
            mounted(&String::from_utf8_lossy(&mounts))
        }
    }
}

/// The drives of Windows but the one of the system and those of floppy disks, which make a noise
/// when they are asked.
fn letters(system: &str, is_there: impl Fn(&Path) -> bool) -> Vec<PathBuf> {
    let all = ('C'..='Z').map(|letter| format!("{letter}:"));
    let others = all.filter(|drive| !drive.eq_ignore_ascii_case(system));
    let mut drives: Vec<PathBuf> = others.map(|drive| format!("{drive}\\").into()).collect();
    drives.retain(|drive| is_there(drive));
    drives
}

/// The volumes of macOS. That of the system is a link.
fn volumes(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).into_iter().flatten().flatten();
    let folders = entries.filter(|entry| entry.file_type().is_ok_and(|kind| kind.is_dir()));
    let mut drives: Vec<PathBuf> = folders.map(|entry| entry.path()).collect();
    drives.sort();
    drives
}

/// The mounts of Linux, of lines as `/dev/sdb1 /media/me/NO\040NAME vfat rw 0 0`.
fn mounted(lines: &str) -> Vec<PathBuf> {
    let points = lines.lines().filter_map(|line| line.split(' ').nth(1));
    // The kernel writes these four as octal numbers.
    let points = points.map(|point| {
        let point = point.replace(r"\040", " ").replace(r"\011", "\t");
        PathBuf::from(point.replace(r"\012", "\n").replace(r"\134", r"\"))
    });
    let mut drives: Vec<PathBuf> =
        points.filter(|point| LINUX.iter().any(|folder| point.starts_with(folder))).collect();
    drives.sort();
    drives.dedup();
    drives
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cards_are_mounts_below_the_folders_of_a_desktop() {
        let lines = "/dev/sda1 / ext4 rw 0 0\n/dev/sdb1 /media/me/NO\\040NAME vfat rw 0 0\n\
                     proc /proc proc rw 0 0\n/dev/sdc1 /run/media/me/A\\134B vfat rw 0 0\n\
                     /dev/sdc1 /run/media/me/A\\134B vfat rw 0 0\nbroken\n/dev/sdd1 /mediation x\n";
        let expected = ["/media/me/NO NAME", r"/run/media/me/A\B"];
        assert_eq!(mounted(lines), expected.map(PathBuf::from));
        assert_eq!(mounted(""), Vec::<PathBuf>::new());
    }

    #[test]
    fn drives_of_windows_are_all_letters_but_that_of_the_system() {
        let is_there = |path: &Path| [r"C:\", r"E:\", r"Z:\"].map(Path::new).contains(&path);
        assert_eq!(letters("c:", is_there), [r"E:\", r"Z:\"].map(PathBuf::from));
        assert_eq!(letters("E:", is_there), [r"C:\", r"Z:\"].map(PathBuf::from));
    }

    #[test]
    fn volumes_are_folders_and_no_links() {
        let folder = tempfile::tempdir().expect("a folder");
        fs::create_dir(folder.path().join("GARMIN")).expect("a card");
        fs::write(folder.path().join("note"), "").expect("a file");
        assert_eq!(volumes(folder.path()), [folder.path().join("GARMIN")]);
        assert_eq!(volumes(&folder.path().join("none")), Vec::<PathBuf>::new());
    }
}

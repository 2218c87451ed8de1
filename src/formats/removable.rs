//! Logs on media that come and go: the recorder's card, a stick, a folder of another computer.
//!
//! A mapped log is read where it lies, and when its medium is gone the next touch of a page that is not in memory ends the
//! program (`map`). Whoever works with a log for long takes one on such a medium into memory first, where it fits.

use crate::support::progress::{Cancelled, Progress};
use crate::survey::{Bytes, Survey, Warning};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Bytes of the largest log that is taken into memory: hours of recording, and little for a computer that draws it.
const LARGEST: usize = 1 << 30;
/// Bytes copied between two looks at the progress.
const CHUNK: usize = 1 << 22;
/// File systems of cards and sticks (FAT, exFAT, NTFS) and of other computers, as Linux names them (`mount(8)`).
const COME_AND_GO: [&str; 11] = [
    "vfat", "msdos", "exfat", "ntfs", "ntfs3", "udf", "nfs", "nfs4", "cifs", "smb3", "9p",
];
/// The same for file systems that a program brings (FUSE): phones, cameras, folders over ssh.
const BROUGHT: &str = "fuse";

/// Takes the bytes of a mapped survey into memory where its log lies on a medium that comes and goes. A log that is too large
/// for that stays where it is, with a warning. Only Linux reports what a path lies on; elsewhere nothing changes.
pub(crate) fn load_removable_into_memory(
    survey: &mut Survey,
    progress: &Progress,
) -> Result<(), Cancelled> {
    let log = survey.source.files.first();
    let comes_and_goes = log.is_some_and(|log| {
        let mounts = std::fs::read_to_string("/proc/self/mounts").unwrap_or_default();
        let path = std::fs::canonicalize(log).unwrap_or_else(|_| log.clone());
        comes_and_goes(&mounts, &path)
    });
    if !comes_and_goes {
        return Ok(());
    }
    if !take_in(&mut survey.bytes, LARGEST, progress)? {
        survey.warnings.push(Warning {
            place: None,
            text: "the log lies on a card or on another computer and is too large to be taken into memory: leave it in place \
                   while it is open, or copy it to this computer first"
                .to_owned(),
        });
    }
    Ok(())
}

/// Copies what is mapped; `false` where that is more than `most` bytes, or more than the system gives.
fn take_in(files: &mut [Bytes], most: usize, progress: &Progress) -> Result<bool, Cancelled> {
    let in_all: usize = files.iter().map(|file| file.len()).sum();
    if in_all > most {
        return Ok(false);
    }
    progress.start(in_all as u64);
    for file in files {
        let Bytes::Mapped(map) = file else {
            continue;
        };
        let mut held = Vec::new();
        if held.try_reserve_exact(map.len()).is_err() {
            return Ok(false);
        }
        for chunk in map.chunks(CHUNK) {
            progress.check()?;
            held.extend_from_slice(chunk);
            progress.advance(chunk.len() as u64);
        }
        *file = Bytes::Held(Arc::new(held));
    }
    Ok(true)
}

/// Whether a path lies on such a medium, by the system's table of mounts (`proc(5)`, `/proc/pid/mounts`): the deepest mount
/// that it lies under counts, and of several at one place the last.
fn comes_and_goes(mounts: &str, path: &Path) -> bool {
    let under = mounts.lines().filter_map(|line| {
        let mut fields = line.split_whitespace().skip(1);
        let (place, kind) = (unescaped(fields.next()?), fields.next()?);
        path.starts_with(&place).then_some((place, kind))
    });
    let deepest = under.max_by_key(|(place, _)| place.components().count());
    deepest.is_some_and(|(_, kind)| COME_AND_GO.contains(&kind) || kind.starts_with(BROUGHT))
}

/// A path of the table, in which blanks and the like are written as a backslash and three octal digits.
fn unescaped(field: &str) -> PathBuf {
    let mut parts = field.split('\\');
    let mut path = parts.next().unwrap_or_default().to_owned();
    for part in parts {
        let code = part
            .get(..3)
            .and_then(|code| u8::from_str_radix(code, 8).ok());
        match code {
            Some(code) if code.is_ascii() => {
                path.push(char::from(code));
                path.push_str(&part[3..]);
            }
            _ => {
                path.push('\\');
                path.push_str(part);
            }
        }
    }
    PathBuf::from(path)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::formats::map::map;

    const MOUNTS: &str = "/dev/nvme0n1p2 / ext4 rw,relatime 0 0\n\
        proc /proc proc rw 0 0\n\
        /dev/nvme0n1p3 /data ext4 rw 0 0\n\
        /dev/sdb1 /media/ann/NO\\040NAME vfat rw,nosuid 0 0\n\
        host:/surveys /data/surveys nfs4 rw 0 0\n\
        gvfsd-fuse /run/user/1000/gvfs fuse.gvfsd-fuse rw 0 0\n";

    #[test]
    fn cards_and_other_computers_come_and_go_and_disks_stay() {
        let goes = |path: &str| comes_and_goes(MOUNTS, Path::new(path));
        assert!(goes("/media/ann/NO NAME/Sonar0001.sl2"));
        assert!(goes("/data/surveys/pond/pond.sl2"));
        assert!(goes("/run/user/1000/gvfs/mtp/log.sl3"));
        assert!(!goes("/data/pond.sl2"));
        assert!(!goes("/data/surveys2/pond.sl2"));
        assert!(!goes("/media/ann/NO/pond.sl2"));
        assert!(!comes_and_goes("", Path::new("/media/card/pond.sl2")));
        // A disk mounted over the place of a card.
        let over = format!("{MOUNTS}/dev/sdc1 /media/ann/NO\\040NAME ext4 rw 0 0\n");
        assert!(!comes_and_goes(
            &over,
            Path::new("/media/ann/NO NAME/a.sl2")
        ));
    }

    #[test]
    fn what_is_no_code_stays_as_it_is_written() {
        assert_eq!(unescaped("/a\\040b\\011c"), Path::new("/a b\tc"));
        assert_eq!(unescaped("/a\\09b\\4"), Path::new("/a\\09b\\4"));
        assert_eq!(unescaped("/a\\é"), Path::new("/a\\é"));
    }

    #[test]
    fn a_log_taken_in_outlives_its_file() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("log.bin");
        let bytes: Vec<u8> = (0..CHUNK + 5).map(|index| (index % 251) as u8).collect();
        std::fs::write(&path, &bytes).expect("a file");
        let mut files = [map(&path).expect("a map"), Bytes::Held(Arc::new(vec![1]))];
        let progress = Progress::new();
        assert_eq!(take_in(&mut files, CHUNK, &progress), Ok(false));
        assert!(matches!(files[0], Bytes::Mapped(_)));
        assert_eq!(take_in(&mut files, 2 * CHUNK, &progress), Ok(true));
        // Cut short: touching a map of it would end the program.
        std::fs::write(&path, b"").expect("a file");
        assert!(files[0][..] == bytes[..]);
        progress.cancel();
        std::fs::write(&path, b"log").expect("a file");
        let mut files = [map(&path).expect("a map")];
        assert_eq!(take_in(&mut files, CHUNK, &progress), Err(Cancelled));
    }
}

//! Tests maps of files that are cut, overwritten, removed and replaced while threads read them.
#![cfg(unix)]

use super::*;
use std::fs;
use std::io::Write as _;
use std::os::unix::process::ExitStatusExt as _;
use std::process::Command;
use std::sync::Barrier;
use std::time::{Duration, SystemTime};

/// Number of times that each test is repeated.
const ROUNDS: usize = 20;
/// Number of threads that read at once.
const READERS: usize = 4;
/// Bytes of the files: some hundred pages, and a part of one.
const LENGTH: usize = (1 << 20) + 777;

fn content() -> Vec<u8> {
    (0..LENGTH).map(|at| (at * 7 % 251) as u8 + 1).collect()
}

/// Creates a folder with a file in it, and maps the file.
fn mapped() -> (tempfile::TempDir, std::path::PathBuf, MappedFile) {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("pond.sl2");
    fs::write(&path, content()).expect("a file");
    let map = MappedFile::open(&path).expect("a map");
    assert_eq!(map.fault(&path), None);
    (folder, path, map)
}

/// Reads all bytes in several threads, which begin together, while `act` changes the file. Returns
/// the bytes that each thread reads afterwards.
fn read_while(map: &MappedFile, act: impl FnOnce() + Send) -> Vec<Vec<u8>> {
    let begin = Barrier::new(READERS + 1);
    std::thread::scope(|scope| {
        let reader = |_| {
            scope.spawn(|| {
                begin.wait();
                for _ in 0..3 {
                    std::hint::black_box(map.iter().map(|byte| u64::from(*byte)).sum::<u64>());
                }
            })
        };
        let readers: Vec<_> = (0..READERS).map(reader).collect();
        begin.wait();
        act();
        for reader in readers {
            reader.join().expect("a reader");
        }
    });
    let again = |_| std::thread::scope(|scope| scope.spawn(|| map.to_vec()).join().expect("bytes"));
    (0..READERS).map(again).collect()
}

#[test]
fn a_file_that_is_cut_reads_as_zeros_from_there_on() {
    let page = 4096;
    for to in [0, page / 2, page, LENGTH - 800, LENGTH - 1] {
        for _ in 0..ROUNDS {
            let (_folder, path, map) = mapped();
            let file = File::options().write(true).open(&path).expect("the file");
            let seen = read_while(&map, || file.set_len(to as u64).expect("a cut"));
            // Whole pages, and more than one, become zeros; the pages before the cut stay.
            let kept = to - to % page;
            for seen in seen {
                assert!(seen[..kept] == content()[..kept], "cut to {to}");
                assert!(seen[to..].iter().all(|byte| *byte == 0), "cut to {to}");
            }
            let (from, to) = (LENGTH as u64, to as u64);
            assert_eq!(map.fault(&path), Some(FileFault::Shorter { from, to }));
            // The rest of the last page of a cut file is zeros without a fault.
            let is_lost = LENGTH.div_ceil(page) > (to as usize).div_ceil(page);
            assert_eq!(map.registered.lost_from().is_some(), is_lost, "cut to {to}");
            assert!(map.registered.lost_from().is_none_or(|from| from >= to));
        }
    }
}

#[test]
fn bytes_that_were_lost_stay_lost_when_the_file_is_whole_again() {
    let (_folder, path, map) = mapped();
    let modified = fs::metadata(&path).and_then(|found| found.modified()).expect("a time");
    read_while(&map, || fs::write(&path, b"").expect("a cut"));
    fs::write(&path, content()).expect("a file");
    let file = File::options().write(true).open(&path).expect("the file");
    file.set_modified(modified).expect("a time");
    let from = map.registered.lost_from().expect("lost bytes");
    assert_eq!(map.fault(&path), Some(FileFault::Unreadable { from }));
    assert_eq!(MappedFile::open(&path).expect("a map").to_vec(), content());
}

#[test]
fn a_file_that_is_overwritten_is_told_from_one_that_grew() {
    for round in 0..ROUNDS {
        let (_folder, path, map) = mapped();
        let mut file = File::options().write(true).open(&path).expect("the file");
        read_while(&map, || file.write_all(&[9; LENGTH]).expect("other bytes"));
        // A clock may stand still for some milliseconds.
        let later = SystemTime::now() + Duration::from_secs(round as u64 + 1);
        file.set_modified(later).expect("a time");
        assert_eq!(map.fault(&path), Some(FileFault::Changed));
        assert_eq!(map.registered.lost_from(), None);

        let (_folder, path, map) = mapped();
        let mut file = File::options().append(true).open(&path).expect("the file");
        let seen = read_while(&map, || file.write_all(&[9; 5000]).expect("more"));
        assert!(seen.iter().all(|seen| *seen == content()));
        assert_eq!(map.fault(&path), None);
        // A longer file that was written over the mapped one.
        fs::write(&path, [9; LENGTH + 1]).expect("another file");
        assert_eq!(map.fault(&path), Some(FileFault::Changed));
    }
}

#[test]
fn a_file_that_was_removed_or_exchanged_reads_as_it_was() {
    for _ in 0..ROUNDS {
        let (folder, path, map) = mapped();
        let other = folder.path().join("other");
        fs::write(&other, b"short").expect("a file");
        let seen = read_while(&map, || fs::rename(&other, &path).expect("another file"));
        assert!(seen.iter().all(|seen| *seen == content()));
        assert_eq!(map.fault(&path), None);
        let seen = read_while(&map, || fs::remove_file(&path).expect("no file"));
        assert!(seen.iter().all(|seen| *seen == content()));
        assert_eq!(map.fault(&path), None);
    }
}

#[test]
fn many_maps_come_and_go_while_others_lose_their_bytes() {
    let (_folder, path, _map) = mapped();
    std::thread::scope(|scope| {
        for _ in 0..READERS {
            scope.spawn(|| {
                for _ in 0..10 * ROUNDS {
                    // The file may have been cut between the reading of its size and the mapping:
                    // all bytes of such a map are lost.
                    let map = MappedFile::open(&path).expect("a map");
                    std::hint::black_box(map.iter().map(|byte| u64::from(*byte)).sum::<u64>());
                }
            });
        }
        scope.spawn(|| {
            for _ in 0..10 * ROUNDS {
                fs::write(&path, b"").expect("a cut");
                fs::write(&path, content()).expect("a file");
            }
        });
    });
    assert_eq!(MappedFile::open(&path).expect("a map").to_vec(), content());
}

#[test]
fn empty_files_have_no_bytes() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("empty.sl2");
    fs::write(&path, b"").expect("a file");
    let map = MappedFile::open(&path).expect("a map");
    assert_eq!((map.len(), map.fault(&path)), (0, None));
}

/// Environment variable with the path of the file, for the child process that the fault ends.
const DIES: &str = "BATHYSCOPE_TEST_FAULT";

#[test]
fn a_fault_elsewhere_ends_the_program_as_before() {
    if let Some(path) = std::env::var_os(DIES) {
        fault::install();
        let file = File::options().read(true).write(true).open(path);
        let file = file.expect("the file");
        // SAFETY: as in `MappedFile::beginning`.
        #[allow(unsafe_code)]
        let map = unsafe { memmap2::Mmap::map(&file) }.expect("a map");
        file.set_len(0).expect("a cut");
        std::hint::black_box(map[5]);
        unreachable!("it has ended");
    }
    let (_folder, path, _map) = mapped();
    let (_, module) = module_path!().split_once("::").expect("a module");
    let this = format!("{module}::a_fault_elsewhere_ends_the_program_as_before");
    let child = Command::new(std::env::current_exe().expect("this program"))
        .args(["--exact", &this])
        .env(DIES, &path)
        .output();
    let signal = child.expect("a child").status.signal();
    assert_eq!(signal, Some(libc::SIGBUS));
}

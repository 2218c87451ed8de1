//! Writes the files that are made from the results, several groups of files in parallel.

use super::content::{FileContent, Missing};
use super::order::{Product, When};
use super::registry::{FileWriter, OUTPUT_FILES, OutputFile, WriteFile};
use super::results::Results;
use crate::Error;
use crate::export::make_folder;
use bathyscope_log::support::progress::Progress;
use std::panic::resume_unwind;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread;

/// A requested file: its content, or the missing input without which it cannot be made.
pub(super) type RowFile = (&'static OutputFile, Result<FileContent, Missing>);

/// Files that are written one after the other, because one may contain another that was written
/// before.
type Group = Vec<(&'static OutputFile, WriteFile)>;

/// Largest number of groups that are written in parallel: few of them keep several cores busy, and
/// each needs memory.
const MOST_AT_ONCE: usize = 4;

/// Writes the requested files, several groups in parallel, and returns them in the order of their
/// rows. Most writers use a single thread. The threads do not belong to rayon, because they may
/// wait for each other ([`Results`]).
///
/// # Errors
/// When a file cannot be made or written (the error of the file that failed first), or the work was
/// cancelled.
pub(super) fn write_groups(
    results: &Results<'_>,
    folder: &Path,
    asked: impl Fn(When) -> bool,
) -> Result<Vec<RowFile>, Error> {
    let groups = groups(asked);
    let parts = (results.progress).start_parts(groups.iter().map(|group| share_of_time(group)));
    let next = AtomicUsize::new(0);
    let first_failed = OnceLock::new();
    let work = || {
        let mut written = Vec::new();
        loop {
            let index = next.fetch_add(1, Ordering::Relaxed);
            let (Some(group), Some(part)) = (groups.get(index), parts.get(index)) else {
                return written;
            };
            let files = write_group(results, folder, group, part);
            if files.is_err() {
                first_failed.get_or_init(|| index);
                // All other files would be discarded.
                parts.iter().for_each(Progress::cancel);
            }
            written.push((index, files));
        }
    };
    let threads = rayon::current_num_threads().min(MOST_AT_ONCE);
    let mut written: Vec<(usize, Result<Vec<RowFile>, Error>)> = thread::scope(|scope| {
        let others: Vec<_> = (1..threads).map(|_| scope.spawn(work)).collect();
        let own = work();
        let others = others.into_iter().map(|other| other.join());
        let others = others.flat_map(|files| files.unwrap_or_else(|fault| resume_unwind(fault)));
        others.chain(own).collect()
    });
    results.progress.check()?;
    // The group that failed first has cancelled the others, so its error is returned.
    written.sort_unstable_by_key(|(index, _)| (Some(index) != first_failed.get(), *index));
    let groups: Vec<Vec<RowFile>> =
        (written.into_iter()).map(|(_, files)| files).collect::<Result<_, _>>()?;
    Ok(groups.into_iter().flatten().collect())
}

/// Returns all requested files, group by group.
fn groups(asked: impl Fn(When) -> bool) -> Vec<Group> {
    let rows = OUTPUT_FILES.iter().filter(|row| asked(row.when));
    let rows = rows.filter_map(|row| match row.writer {
        FileWriter::Results(write) => Some((row, write)),
        FileWriter::Run(_) => None,
    });
    let rows: Group = rows.collect();
    let groups = rows.chunk_by(|(one, _), (other, _)| one.when == other.when);
    groups.map(<[_]>::to_vec).collect()
}

/// Returns the approximate time that a group takes relative to the others.
fn share_of_time(group: &Group) -> f32 {
    match group.first().map(|(row, _)| row.when) {
        Some(When::Chosen(Product::Mosaic)) => 8.0,
        Some(When::Chosen(Product::Track | Product::Xyz | Product::Targets)) => 1.0,
        _ => 3.0,
    }
}

fn write_group(
    results: &Results<'_>,
    folder: &Path,
    group: &Group,
    part: &Progress,
) -> Result<Vec<RowFile>, Error> {
    let parts = part.start_parts(group.iter().map(|_| 1.0));
    let files = group.iter().zip(&parts).map(|(&(row, write), part)| {
        let results = results.with_progress(part);
        part.check()?;
        let file = match first_missing(row, &results)? {
            Some(missing) => Err(missing),
            None => Ok(write(&results, &place(folder, row)?)?),
        };
        part.finish();
        Ok((row, file))
    });
    files.collect()
}

/// Returns the first missing input without which a file cannot be made; `None` where nothing is
/// missing.
pub(super) fn first_missing(
    row: &OutputFile,
    results: &Results<'_>,
) -> Result<Option<Missing>, Error> {
    for &need in row.needs {
        if let Some(missing) = results.missing(need)? {
            return Ok(Some(missing));
        }
    }
    Ok(None)
}

/// Returns the path of a file, after making its subfolder.
pub(super) fn place(folder: &Path, row: &OutputFile) -> Result<PathBuf, Error> {
    let path = folder.join(row.name);
    let parent = path.parent().unwrap_or(folder);
    make_folder(parent)?;
    Ok(path)
}

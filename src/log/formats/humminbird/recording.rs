//! Finds the files of a recording: `Rec00001.DAT` and, in the folder `Rec00001` beside it,
//! `B000.SON` to `B004.SON`.

use super::dat::Dat;
use super::ping::byte_order;
use crate::formats::{FileSource, Opened};
use std::path::{Path, PathBuf};

/// The files of a recording.
#[derive(Debug)]
pub(super) struct Recording {
    /// Path that the user opened.
    pub(super) opened: PathBuf,
    /// The DAT file, if any, with its content; the content is `None` where the file is damaged.
    pub(super) dat: Option<(Opened, Option<Dat>)>,
    /// The SON files that contain pings.
    pub(super) sons: Vec<Opened>,
    /// Number of other recordings in the opened folder.
    pub(super) others: usize,
}

/// Recognises a DAT or a SON file by its content, and a damaged DAT by the SON files beside it.
pub(super) fn sniff(files: &FileSource, opened: &Opened) -> Option<Recording> {
    if byte_order(&opened.bytes).is_some() {
        Some(around_son(files, opened))
    } else {
        around_dat(files, opened)
    }
}

/// Returns the recording that a SON file belongs to; at least the file alone.
fn around_son(files: &FileSource, opened: &Opened) -> Recording {
    let path = &opened.path;
    let whole = path.parent().and_then(|folder| gather(files, path, folder, dat_of(files, folder)));
    whole.filter(|recording| recording.sons.iter().any(|son| son.path == *path)).unwrap_or_else(
        || Recording { opened: path.clone(), dat: None, sons: vec![opened.clone()], others: 0 },
    )
}

/// Returns the recording that a DAT file belongs to; its folder of SON files may be missing. `None`
/// where the file is no DAT and has no SON files.
fn around_dat(files: &FileSource, opened: &Opened) -> Option<Recording> {
    let path = &opened.path;
    let folder = path.with_extension("");
    let gathered =
        (folder != *path).then(|| gather(files, path, &folder, Some(path.clone()))).flatten();
    let beside = || {
        let folder = path.parent()?;
        let alone = only_dat(files, folder).is_some_and(|dat| dat == *path);
        alone.then(|| gather(files, path, folder, Some(path.clone())))?
    };
    gathered.or_else(beside).or_else(|| {
        let dat = Dat::parse(&opened.bytes)?;
        Some(Recording {
            opened: path.clone(),
            dat: Some((opened.clone(), Some(dat))),
            sons: Vec::new(),
            others: 0,
        })
    })
}

/// Returns the recording in a folder: the SON files of the folder, or those of the first DAT in it.
pub(super) fn find_in_folder(files: &FileSource, folder: &Path) -> Option<Recording> {
    gather(files, folder, folder, dat_of(files, folder)).or_else(|| {
        let mut dats = files.children(folder);
        dats.retain(|child| has_extension(child, "dat"));
        let others = dats.len().saturating_sub(1);
        let first = dats
            .into_iter()
            .find_map(|dat| gather(files, folder, &dat.with_extension(""), Some(dat)))?;
        Some(Recording { others, ..first })
    })
}

/// Returns true if a folder contains the SON files of one recording.
pub(super) fn is_recording(files: &FileSource, folder: &Path) -> bool {
    gather(files, folder, folder, None).is_some()
}

/// Returns the DAT of a folder of SON files: the DAT beside the folder with its name, else the only
/// DAT in the folder (as in copies of a recording without its folder, for example in the PyHum
/// package).
fn dat_of(files: &FileSource, folder: &Path) -> Option<PathBuf> {
    let is_named = |path: &PathBuf| {
        has_extension(path, "dat")
            && path
                .file_stem()
                .zip(folder.file_name())
                .is_some_and(|(stem, name)| stem.eq_ignore_ascii_case(name))
    };
    let around = folder.parent().map(|parent| files.children(parent)).unwrap_or_default();
    around.into_iter().find(is_named).or_else(|| only_dat(files, folder))
}

/// Returns the DAT in a folder if there is only one.
fn only_dat(files: &FileSource, folder: &Path) -> Option<PathBuf> {
    let mut dats = files.children(folder).into_iter().filter(|path| has_extension(path, "dat"));
    dats.next().filter(|_| dats.next().is_none())
}

/// Most SON files of a recording: a survey numbers its files with a byte, and one may be a DAT.
/// Recorders write five.
const MOST_SONS: usize = 255;

/// Collects the SON files in `folder` that contain pings, and a DAT; `None` without such a SON
/// file.
fn gather(
    files: &FileSource,
    opened: &Path,
    folder: &Path,
    dat: Option<PathBuf>,
) -> Option<Recording> {
    let read = |path: PathBuf| {
        let bytes = files.read(&path).ok()?;
        Some(Opened { path, bytes })
    };
    let sons: Vec<Opened> = files
        .children(folder)
        .into_iter()
        .filter(|path| has_extension(path, "son"))
        .filter_map(read)
        .filter(|son| byte_order(&son.bytes).is_some())
        .take(MOST_SONS)
        .collect();
    if sons.is_empty() {
        return None;
    }
    let dat = dat.and_then(read).map(|dat| {
        let content = Dat::parse(&dat.bytes);
        (dat, content)
    });
    Some(Recording { opened: opened.to_owned(), dat, sons, others: 0 })
}

fn has_extension(path: &Path, requested: &str) -> bool {
    path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case(requested))
}

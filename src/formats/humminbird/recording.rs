//! Which files make up a recording: `Rec00001.DAT` and, in the folder `Rec00001` beside it, `B000.SON` to `B004.SON`.

use super::dat::Dat;
use super::son;
use crate::formats::{Opened, Shelf};
use crate::survey::Bytes;
use std::path::{Path, PathBuf};

/// The files of a recording.
#[derive(Debug)]
pub(in crate::formats) struct Recording {
    /// What the user opened.
    pub(super) opened: PathBuf,
    /// The DAT file: its path and, where it can be read, its content.
    pub(super) dat: Option<(PathBuf, Option<Dat>, u64)>,
    /// The SON files that hold pings.
    pub(super) sons: Vec<(PathBuf, Bytes)>,
}

/// Recognises a DAT or a SON file by its content; a damaged DAT by the SON files that belong to it.
pub(in crate::formats) fn sniff(shelf: &Shelf, opened: &Opened) -> Option<Recording> {
    let path = &opened.path;
    if son::byte_order(&opened.bytes).is_some() {
        let mut recording = match path.parent() {
            Some(folder) => gather(shelf, path, folder, dat_of(shelf, folder)),
            None => None,
        }
        .unwrap_or(Recording {
            opened: path.clone(),
            dat: None,
            sons: Vec::new(),
        });
        if !recording.sons.iter().any(|(son, _)| son == path) {
            recording.sons.push((path.clone(), opened.bytes.clone()));
        }
        return Some(recording);
    }
    let dat = Dat::parse(&opened.bytes);
    let folder = path.with_extension("");
    let found = if folder == *path {
        None
    } else {
        gather(shelf, path, &folder, Some(path.clone()))
    };
    found.or_else(|| {
        dat.map(|dat| Recording {
            opened: path.clone(),
            dat: Some((path.clone(), Some(dat), opened.bytes.len() as u64)),
            sons: Vec::new(),
        })
    })
}

/// The recording in a folder: its own SON files, or those of the first DAT in it.
pub(in crate::formats) fn find_in_folder(shelf: &Shelf, folder: &Path) -> Option<Recording> {
    gather(shelf, folder, folder, dat_of(shelf, folder)).or_else(|| {
        shelf
            .children(folder)
            .into_iter()
            .filter(|child| has_extension(child, "dat"))
            .find_map(|dat| gather(shelf, folder, &dat.with_extension(""), Some(dat)))
    })
}

/// The DAT beside a folder of SON files.
fn dat_of(shelf: &Shelf, folder: &Path) -> Option<PathBuf> {
    let name = folder.file_name()?;
    shelf.children(folder.parent()?).into_iter().find(|path| {
        has_extension(path, "dat")
            && path
                .file_stem()
                .is_some_and(|stem| stem.eq_ignore_ascii_case(name))
    })
}

/// The SON files in `folder` that hold pings; `None` when there is none.
fn gather(shelf: &Shelf, opened: &Path, folder: &Path, dat: Option<PathBuf>) -> Option<Recording> {
    let sons: Vec<(PathBuf, Bytes)> = shelf
        .children(folder)
        .into_iter()
        .filter(|path| has_extension(path, "son"))
        .filter_map(|path| Some((path.clone(), shelf.read(&path).ok()?)))
        .filter(|(_, bytes)| son::byte_order(bytes).is_some())
        .collect();
    if sons.is_empty() {
        return None;
    }
    let dat = dat.map(|path| {
        let bytes = shelf.read(&path).ok();
        let content = bytes.as_ref().and_then(|bytes| Dat::parse(bytes));
        (path, content, bytes.map_or(0, |bytes| bytes.len() as u64))
    });
    Some(Recording {
        opened: opened.to_owned(),
        dat,
        sons,
    })
}

fn has_extension(path: &Path, wanted: &str) -> bool {
    path.extension()
        .is_some_and(|extension| extension.eq_ignore_ascii_case(wanted))
}

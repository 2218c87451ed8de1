//! Converts paths to text and back as a project stores them: relative to the project's folder, with
//! `/`, and with bytes that are not text encoded.
//!
//! An absolute path is written only if there is no relative path from the project's folder (another
//! drive): it would show every reader of the file on whose computer it was written, and change with
//! each writer.

use std::fs;
use std::io;
use std::path::{Component, Path, PathBuf};

/// Returns a path as text, relative to the project's folder. Both must be absolute, or relative to
/// the same folder.
pub(super) fn to_text(path: &Path, folder: &Path) -> String {
    let (path, folder) = (cleaned(path), cleaned(folder));
    let shared = (path.components().zip(folder.components()))
        .take_while(|(one, other)| one == other)
        .count();
    if path.has_root() && shared == 0 {
        let text = encoded(path.as_os_str().as_encoded_bytes());
        return if cfg!(windows) { text.replace('\\', "/") } else { text };
    }
    let up = folder.components().skip(shared).map(|_| "..".to_owned());
    let down = path.components().skip(shared);
    let down = down.map(|part| encoded(part.as_os_str().as_encoded_bytes()));
    up.chain(down).collect::<Vec<_>>().join("/")
}

/// Returns the path for a text, in the project's folder.
pub(super) fn from_text(text: &str, folder: &Path) -> PathBuf {
    // Joining an absolute path replaces the folder.
    cleaned(&folder.join(decoded(text)))
}

/// Returns the last name of a path's text, with either separator, as a path of this system.
pub(super) fn name_from_text(text: &str) -> PathBuf {
    decoded(text.rsplit(['/', '\\']).next().unwrap_or(text))
}

/// Returns a path as it is stored: absolute, with links in its folder resolved, so that relative
/// paths between files do not depend on how the files were opened.
pub(super) fn placed(path: &Path) -> PathBuf {
    let path = std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
    let folder = path.parent().and_then(|folder| canonical(folder).ok());
    match (folder, path.file_name()) {
        (Some(folder), Some(name)) => folder.join(name),
        _ => cleaned(&path),
    }
}

/// Returns the path of the file beside a project whose name is the project's with a suffix.
pub(super) fn beside(project: &Path, suffix: &str) -> PathBuf {
    let mut name = project.file_name().unwrap_or_default().to_owned();
    name.push(suffix);
    project.with_file_name(name)
}

/// Returns the path of an existing file without links. On Windows it has the usual form, without
/// the prefix `\\?\` of the system.
pub(super) fn canonical(path: &Path) -> io::Result<PathBuf> {
    let path = fs::canonicalize(path)?;
    Ok(if cfg!(windows) { path.to_str().and_then(plain).unwrap_or(path) } else { path })
}

/// Returns `C:\lake` for `\\?\C:\lake`, and `\\server\lake` for `\\?\UNC\server\lake`.
fn plain(path: &str) -> Option<PathBuf> {
    let path = path.strip_prefix(r"\\?\")?;
    Some(match path.strip_prefix(r"UNC\") {
        Some(share) => format!(r"\\{share}").into(),
        None => path.into(),
    })
}

/// Returns the path without `.`, and without `..` where possible; links are not resolved.
pub(super) fn cleaned(path: &Path) -> PathBuf {
    let mut clean = PathBuf::new();
    for part in path.components() {
        match part {
            Component::CurDir => {}
            Component::ParentDir
                if matches!(clean.components().next_back(), Some(Component::Normal(_))) =>
            {
                clean.pop();
            }
            part => clean.push(part),
        }
    }
    clean
}

/// Returns the bytes as text, those that are not text as `%FF`, and `%` as `%25`.
fn encoded(bytes: &[u8]) -> String {
    let mut text = String::new();
    for chunk in bytes.utf8_chunks() {
        text.push_str(&chunk.valid().replace('%', "%25"));
        for byte in chunk.invalid() {
            text.push_str(&format!("%{byte:02X}"));
        }
    }
    text
}

#[cfg(unix)]
fn decoded(text: &str) -> PathBuf {
    use std::os::unix::ffi::OsStringExt as _;
    std::ffi::OsString::from_vec(bytes_of(text)).into()
}

#[cfg(not(unix))]
fn decoded(text: &str) -> PathBuf {
    // A name that is not text cannot exist here; the encoded name is used instead.
    String::from_utf8(bytes_of(text)).unwrap_or_else(|_| text.to_owned()).into()
}

fn bytes_of(text: &str) -> Vec<u8> {
    let mut bytes = Vec::with_capacity(text.len());
    let mut rest = text.as_bytes();
    while let Some((&first, after)) = rest.split_first() {
        let digit = |at: usize| char::from(*after.get(at)?).to_digit(16);
        match (first, digit(0), digit(1)) {
            (b'%', Some(high), Some(low)) => {
                bytes.push((high * 16 + low) as u8);
                rest = &after[2..];
            }
            _ => {
                bytes.push(first);
                rest = after;
            }
        }
    }
    bytes
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_lead_from_the_projects_folder() {
        for (path, expected) in [
            ("/lake/day1/pond.sl2", "day1/pond.sl2"),
            ("/lake/pond 2 \"x\".sl2", "pond 2 \"x\".sl2"),
            ("/other/pond.sl2", "../other/pond.sl2"),
            ("/lake/./day1/../pond.sl2", "pond.sl2"),
            ("/lake/50%25.sl2", "50%2525.sl2"),
        ] {
            let text = to_text(Path::new(path), Path::new("/lake"));
            assert_eq!(text, expected);
            assert_eq!(from_text(&text, Path::new("/lake")), cleaned(Path::new(path)));
        }
        // The logs are found after the folder was moved together with them.
        assert_eq!(from_text("day1/a.sl2", Path::new("/new")), Path::new("/new/day1/a.sl2"));
        assert_eq!(name_from_text("C:\\lake\\pond.sl2"), Path::new("pond.sl2"));
        assert_eq!(name_from_text("lake/pond.sl2"), Path::new("pond.sl2"));
    }

    #[test]
    fn a_path_of_windows_is_written_as_people_do() {
        for (verbatim, expected) in
            [(r"\\?\C:\lake\pond.sl2", r"C:\lake\pond.sl2"), (r"\\?\UNC\boat\lake", r"\\boat\lake")]
        {
            assert_eq!(plain(verbatim), Some(expected.into()));
        }
        assert_eq!(plain(r"C:\lake"), None);
    }

    #[cfg(unix)]
    #[test]
    fn names_that_are_no_text_come_back() {
        use std::os::unix::ffi::OsStrExt as _;
        let name = std::ffi::OsStr::from_bytes(b"pond\xff\xfe%41 \xc3\xa9.sl2");
        let path = Path::new("/lake").join(name);
        let text = to_text(&path, Path::new("/lake"));
        assert_eq!(text, "pond%FF%FE%2541 \u{e9}.sl2");
        assert_eq!(from_text(&text, Path::new("/lake")), path);
    }
}

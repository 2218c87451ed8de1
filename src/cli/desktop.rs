//! `bathyscope desktop`: installs for this user that projects and logs open by double click, with
//! manual pages and completions of the shells.
//!
//! `bathyscope desktop --into DIR` writes the files that a package puts into `/usr/share` for all
//! users.

mod share;

use super::{Failure, output};
use bathyscope_products::export::{make_folder, write_bytes};
use share::{APPLICATIONS, MIME, ShareFile};
use std::fmt::Display;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// `bathyscope desktop [--remove] [--into DIR]`.
#[derive(Debug, clap::Args)]
pub(super) struct DesktopArgs {
    /// Take away again what was written
    #[arg(long)]
    remove: bool,
    /// Write into this folder in place of the user's, for packages; the entry then starts
    /// `bathyscope` from the path
    #[arg(long, value_name = "DIR")]
    into: Option<PathBuf>,
}

/// Writes or removes desktop entry, file types, icon, manual pages and completions.
pub(super) fn run(args: &DesktopArgs) -> Result<(), Failure> {
    let (folder, program) = match &args.into {
        Some(folder) => (folder.clone(), None),
        None => (data_folder()?, Some(program()?)),
    };
    let files = share::files(program.as_deref(), super::program());
    for ShareFile { path, content } in &files {
        let path = folder.join(path);
        if args.remove { remove(&path)? } else { write(&path, content)? }
    }
    // A package runs these programs when it is installed. Without them the desktop reads the files
    // at the next login.
    if args.into.is_none() {
        refresh("update-mime-database", &folder.join(MIME));
        refresh("update-desktop-database", &folder.join(APPLICATIONS));
    }
    let did = if args.remove { "removed" } else { "wrote" };
    let paths: Vec<&str> = files.iter().map(|file| file.path.as_str()).collect();
    output::results(format_args!("{did} in {}: {}", folder.display(), paths.join(", ")))
}

/// Returns the folder of the user's data, which holds desktop entries, by the XDG base directory
/// specification.
fn data_folder() -> Result<PathBuf, Failure> {
    if cfg!(windows) {
        return Err("this command is for Linux; on Windows the installer makes the entry of the start menu and the file types".into());
    }
    let set = |name: &str| {
        let value = std::env::var_os(name).map(PathBuf::from);
        value.filter(|path| path.is_absolute())
    };
    let folder = set("XDG_DATA_HOME").or_else(|| Some(set("HOME")?.join(".local/share")));
    folder.ok_or_else(|| {
        "there is no folder for desktop entries here: neither XDG_DATA_HOME nor HOME is set".into()
    })
}

/// Returns the path of this program.
fn program() -> Result<String, Failure> {
    let cannot = |why: &dyn Display| format!("cannot tell where this program lies: {why}");
    let program = std::env::current_exe().map_err(|error| cannot(&error))?;
    match program.to_str() {
        Some(path) => Ok(path.to_owned()),
        None => {
            let why = format_args!("its path is no text: {}", program.display());
            Err(cannot(&why).into())
        }
    }
}

fn write(path: &Path, content: &[u8]) -> Result<(), Failure> {
    let folder = path.parent().unwrap_or(Path::new("."));
    make_folder(folder)?;
    Ok(write_bytes(path, content)?)
}

fn remove(path: &Path) -> Result<(), Failure> {
    match fs::remove_file(path) {
        Err(error) if path.exists() => {
            Err(format!("cannot remove the file: {error}: {}", path.display()).into())
        }
        _ => Ok(()),
    }
}

fn refresh(program: &str, folder: &Path) {
    let mut command = Command::new(program);
    let quiet = command.arg(folder).stdout(Stdio::null()).stderr(Stdio::null());
    quiet.status().ok();
}

//! `bathyscope desktop`: projects and logs open by double click, for this user.
//!
//! A package for all users puts the two files of `assets/desktop` into `/usr/share/applications` and `/usr/share/mime/packages`.

use super::output;
use crate::export::write_aside;
use std::fs;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

const ENTRY: &str = include_str!("../../assets/desktop/bathyscope.desktop");
const TYPES: &str = include_str!("../../assets/desktop/bathyscope.xml");
/// The line of the entry that names the program, which lies anywhere when it was not installed by a package.
const PROGRAM: &str = "Exec=bathyscope ";

/// `bathyscope desktop [--remove]`.
#[derive(Debug, clap::Args)]
pub struct DesktopArgs {
    /// Take the entry and the file types away again
    #[arg(long)]
    remove: bool,
}

/// Writes or removes the desktop entry and the file types.
pub fn run(args: &DesktopArgs) -> Result<(), String> {
    let data = data_folder().ok_or(
        "there is no folder for desktop entries here: neither XDG_DATA_HOME nor HOME is set",
    )?;
    let files = [
        (data.join("applications/bathyscope.desktop"), entry()?),
        (data.join("mime/packages/bathyscope.xml"), TYPES.to_owned()),
    ];
    for (path, text) in &files {
        match args.remove {
            true => remove(path)?,
            false => write(path, text)?,
        }
    }
    // Without these programs the desktop takes the files up at the next login.
    refresh("update-mime-database", &data.join("mime"));
    refresh("update-desktop-database", &data.join("applications"));
    let did = if args.remove { "removed" } else { "wrote" };
    output::results(format_args!(
        "{did} {} and {}",
        files[0].0.display(),
        files[1].0.display()
    ))
}

/// Where a user's desktop entries lie, by the XDG base directory specification.
fn data_folder() -> Option<PathBuf> {
    let set = |name: &str| {
        let value = std::env::var_os(name).map(PathBuf::from);
        value.filter(|path| path.is_absolute())
    };
    set("XDG_DATA_HOME").or_else(|| Some(set("HOME")?.join(".local/share")))
}

/// The entry that starts this program from where it lies.
fn entry() -> Result<String, String> {
    let cannot = |why: String| format!("cannot tell where this program lies: {why}");
    let program = std::env::current_exe().map_err(|error| cannot(error.to_string()))?;
    let program = program
        .to_str()
        .ok_or_else(|| cannot(format!("its path is no text: {}", program.display())))?;
    Ok(ENTRY.replace(PROGRAM, &format!("Exec={} ", quoted(program))))
}

/// A path as an argument of an `Exec` line: quoted, and escaped once for the quotes and once for the file.
fn quoted(path: &str) -> String {
    let mut text = String::from("\"");
    for letter in path.chars() {
        match letter {
            '%' => text.push_str("%%"),
            '"' | '`' | '$' => text.extend(["\\\\", &letter.to_string()]),
            '\\' => text.push_str("\\\\\\\\"),
            letter => text.push(letter),
        }
    }
    text.push('"');
    text
}

fn write(path: &Path, text: &str) -> Result<(), String> {
    let folder = path.parent().unwrap_or(Path::new("."));
    fs::create_dir_all(folder)
        .map_err(|error| format!("cannot make the folder: {error}: {}", folder.display()))?;
    write_aside(path, |mut file| file.write_all(text.as_bytes())).map_err(|error| error.to_string())
}

fn remove(path: &Path) -> Result<(), String> {
    match fs::remove_file(path) {
        Err(error) if path.exists() => Err(format!(
            "cannot remove the file: {error}: {}",
            path.display()
        )),
        _ => Ok(()),
    }
}

fn refresh(program: &str, folder: &Path) {
    let mut command = Command::new(program);
    let quiet = command
        .arg(folder)
        .stdout(Stdio::null())
        .stderr(Stdio::null());
    quiet.status().ok();
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn any_path_is_one_argument() {
        assert_eq!(
            quoted("/opt/sonar tools/bathyscope"),
            "\"/opt/sonar tools/bathyscope\""
        );
        assert_eq!(quoted("/a$b`c\"d"), "\"/a\\\\$b\\\\`c\\\\\"d\"");
        assert_eq!(quoted("/50%\\x"), "\"/50%%\\\\\\\\x\"");
        assert!(ENTRY.contains(PROGRAM));
    }
}

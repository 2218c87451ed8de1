//! `bathyscope desktop`: installs for this user that projects and logs open by double click, with
//! manual pages and completions of the shells.
//!
//! `bathyscope desktop --into DIR` writes the files that a package puts into `/usr/share` for all
//! users.

use super::{Failure, output};
use bathyscope_log::formats::FORMATS;
use bathyscope_products::export::{make_folder, write_bytes};
use clap_complete::{Shell, generate};
use clap_mangen::Man;
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
    let files = share_files(program.as_deref(), super::program());
    for (path, content) in &files {
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
    let paths: Vec<&str> = files.iter().map(|(path, _)| path.as_str()).collect();
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

const ENTRY: &str = include_str!("../../assets/desktop/bathyscope.desktop");
const TYPES: &str = include_str!("../../assets/desktop/bathyscope.xml");
const ICON: &str = include_str!("../../assets/desktop/bathyscope.svg");
/// Beginning of the line of the entry that names the program; its path is not known before the
/// command runs, unless a package installed it.
const PROGRAM: &str = "Exec=bathyscope ";
/// Beginnings of the lines of the entry to which the formats of logs add their search words and
/// file types.
const KEYWORDS: &str = "Keywords=sonar;side-scan;bathymetry;";
const OPENED: &str = "MimeType=application/x-bathyscope;";
/// Tag before which the file types of the formats of logs are inserted.
const END_OF_TYPES: &str = "</mime-info>";
/// Name of the program on a command line.
const NAME: &str = "bathyscope";
/// Files in which the shells search for completions.
const COMPLETIONS: [(Shell, &str); 3] = [
    (Shell::Bash, "bash-completion/completions/bathyscope"),
    (Shell::Fish, "fish/vendor_completions.d/bathyscope.fish"),
    (Shell::Zsh, "zsh/site-functions/_bathyscope"),
];
/// Folder of desktop entries.
const APPLICATIONS: &str = "applications";
/// Folder of file types.
const MIME: &str = "mime";

/// Path of a file within the `share` folder, with `/` between the names, and its content.
type ShareFile = (String, Vec<u8>);

/// Returns desktop entry, file types, icon, manual pages and completions of a command; the entry
/// starts the program at a path, or without one by its name.
fn share_files(program: Option<&str>, command: clap::Command) -> Vec<ShareFile> {
    let entry = match program {
        Some(path) => entry().replace(PROGRAM, &format!("Exec={} ", quoted(path))),
        None => entry(),
    };
    let mut files = vec![
        (format!("{APPLICATIONS}/bathyscope.desktop"), entry.into_bytes()),
        (format!("{MIME}/packages/bathyscope.xml"), types().into_bytes()),
        ("icons/hicolor/scalable/apps/bathyscope.svg".to_owned(), ICON.into()),
    ];
    files.extend(COMPLETIONS.map(|(shell, path)| {
        let mut text = Vec::new();
        generate(shell, &mut command.clone(), NAME, &mut text);
        (path.to_owned(), text)
    }));
    files.extend(manual_pages(command));
    files
}

/// Returns the desktop entry, with the search words and file types of the formats of logs.
fn entry() -> String {
    let (mut words, mut opened) = (KEYWORDS.to_owned(), OPENED.to_owned());
    for format in FORMATS {
        let keywords = format.keywords.iter().map(|word| (*word).to_owned());
        for word in format.log_endings().chain(keywords) {
            words += &format!("{word};");
        }
        if let Some(kind) = format.file_type {
            opened += &format!("{};", kind.mime);
        }
    }
    ENTRY.replace(KEYWORDS, &words).replace(OPENED, &opened)
}

/// Returns the file types: of projects, and of the formats of logs whose endings no other files
/// have.
fn types() -> String {
    let mut types = String::new();
    for format in FORMATS {
        let Some(kind) = format.file_type else {
            continue;
        };
        types += &format!("  <mime-type type=\"{}\">\n", kind.mime);
        types += &format!("    <comment>{}</comment>\n", kind.comment);
        for ending in format.log_endings() {
            types += &format!("    <glob pattern=\"*.{ending}\"/>\n");
        }
        types += "  </mime-type>\n";
    }
    TYPES.replace(END_OF_TYPES, &(types + END_OF_TYPES))
}

/// Returns a manual page of the program, and one of each of its commands: `bathyscope-process.1`.
fn manual_pages(command: clap::Command) -> Vec<ShareFile> {
    let mut command = command.disable_help_subcommand(true);
    command.build();
    let commands = command.get_subcommands().filter(|subcommand| !subcommand.is_hide_set());
    let all = commands.cloned().chain([command.clone()]);
    let page = |command: clap::Command| {
        let page = Man::new(command).manual("Bathyscope");
        let mut text = Vec::new();
        // Writing into memory cannot fail.
        page.render(&mut text).ok();
        (format!("man/man1/{}", page.get_filename()), text)
    };
    all.map(page).collect()
}

/// Returns a path as an argument of an `Exec` line: quoted, and escaped once for the quotes and
/// once for the file.
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn any_path_is_one_argument() {
        assert_eq!(quoted("/opt/sonar tools/bathyscope"), "\"/opt/sonar tools/bathyscope\"");
        assert_eq!(quoted("/a$b`c\"d"), "\"/a\\\\$b\\\\`c\\\\\"d\"");
        assert_eq!(quoted("/50%\\x"), "\"/50%%\\\\\\\\x\"");
        assert!(ENTRY.contains(PROGRAM));
    }

    #[test]
    fn each_format_is_found_and_opened_by_the_desktop() {
        let (entry, types) = (entry(), types());
        let line = |start: &str| {
            let mut lines = entry.lines();
            lines.find(|line| line.starts_with(start)).unwrap().to_owned()
        };
        let keywords = line(KEYWORDS);
        for word in ["sl2", "sl3", "xtf", "rsd", "jsf", "svlog", "lowrance", "humminbird"] {
            assert!(keywords.contains(&format!(";{word};")), "{keywords}");
        }
        let opened = line(OPENED);
        for kind in ["lowrance-sonar", "garmin-rsd", "xtf", "edgetech-jsf"] {
            let kind = format!(";application/x-{kind};");
            assert!(opened.contains(&kind), "{opened}");
        }
        let xtf = "  <mime-type type=\"application/x-xtf\">
    <comment>XTF sonar log</comment>
    <glob pattern=\"*.xtf\"/>
  </mime-type>
";
        assert!(types.contains(xtf) && types.ends_with("</mime-info>\n"), "{types}");
        assert!(types.contains("<glob pattern=\"*.sl2\"/>\n    <glob pattern=\"*.sl3\"/>"));
        // Files of other programs have these endings.
        assert!(!types.to_lowercase().contains("*.dat"));
    }

    #[test]
    fn every_command_has_a_page_and_is_completed() {
        let command = crate::cli::program();
        let files = share_files(None, command.clone());
        let text = |path: &str| {
            let file = files.iter().find(|(found, _)| found == path);
            let (_, content) = file.unwrap_or_else(|| panic!("{path} is missing"));
            String::from_utf8(content.clone()).unwrap()
        };
        let of_program = text("man/man1/bathyscope.1");
        assert!(of_program.contains("bathyscope\\-process(1)"));
        let process = text("man/man1/bathyscope-process.1");
        assert!(process.contains("outliers.radius_m"), "its settings");
        let completions = COMPLETIONS.map(|(_, path)| text(path));
        for subcommand in command.get_subcommands() {
            let name = subcommand.get_name();
            text(&format!("man/man1/bathyscope-{name}.1"));
            assert!(completions.iter().all(|text| text.contains(name)), "{name}");
        }
        assert!(text("applications/bathyscope.desktop").contains("\nExec=bathyscope %F\n"));
        let beside = text("icons/hicolor/scalable/apps/bathyscope.svg");
        assert!(beside.starts_with("<svg "));
    }
}

//! Chooses the folders that commands write into: one for each of several surveys, or the folder of
//! `bathyscope process` when none is named. The latter is in the current folder and is named after
//! the log. A folder with other content is never chosen, except one with an earlier run of the same
//! logs.

use super::survey_logs::OpenedLog;
use crate::app::is_project;
use bathyscope_log::survey::Survey;
use bathyscope_products::file_name::file_name;
use bathyscope_products::outputs;
use std::collections::HashSet;
use std::path::{Path, PathBuf};

/// Name of the folder of a run whose manifest is not yet written.
const SIDE: &str = ".bathyscope-run";
/// Ending of the folder's name if the folder without it has other content, such as the recording
/// itself.
const PRODUCTS: &str = "-products";
/// Name of a survey whose logs' names have no common beginning.
const SURVEY: &str = "survey";
/// Least number of letters of a common beginning.
const LEAST: usize = 3;

/// Chooses folders for surveys, a different one for each: two recorders both begin with `Rec00001`,
/// and neither survey may replace the other's products.
pub(super) struct Folders {
    parent: PathBuf,
    /// Names of the chosen folders, in lower case: on some file systems `REC` and `Rec` are one
    /// folder.
    chosen: HashSet<String>,
}

impl Folders {
    /// Chooses folders in `parent`.
    pub(super) fn in_folder(parent: &Path) -> Self {
        Self { parent: parent.to_owned(), chosen: HashSet::new() }
    }

    /// Returns the folder of the next survey: its name, with `-2`, `-3` ... after it if an earlier
    /// survey has that folder.
    pub(super) fn next(&mut self, name: &str) -> PathBuf {
        let name = file_name(name);
        let mut folder = name.clone();
        let mut count = 1;
        while !self.chosen.insert(folder.to_lowercase()) {
            count += 1;
            folder = format!("{name}-{count}");
        }
        self.parent.join(folder)
    }

    /// Returns the folder of a survey where the user named none: its name, else `NAME-products`,
    /// `NAME-products-2` and so on, the first that is missing, empty or of an earlier run of these
    /// logs.
    pub(super) fn next_free(&mut self, name: &str, logs: &[OpenedLog]) -> PathBuf {
        let surveys: Vec<&Survey> = logs.iter().map(|log| &*log.survey).collect();
        let name = match name.trim_matches(['.', ' ']) {
            "" => SURVEY.to_owned(),
            name => file_name(name),
        };
        let mut count = 0;
        loop {
            let folder = match count {
                0 => name.clone(),
                1 => format!("{name}{PRODUCTS}"),
                count => format!("{name}{PRODUCTS}-{count}"),
            };
            let path = self.parent.join(&folder);
            if !self.chosen.contains(&folder.to_lowercase()) && is_free(&path, &surveys) {
                self.chosen.insert(folder.to_lowercase());
                return path;
            }
            count += 1;
        }
    }
}

/// Returns true if a run may write into a folder that the user did not name: it is missing, empty,
/// or of an earlier run of the surveys.
fn is_free(folder: &Path, surveys: &[&Survey]) -> bool {
    if folder.symlink_metadata().is_err() {
        return true;
    }
    let Ok(mut entries) = folder.read_dir() else {
        return false;
    };
    entries.all(|entry| entry.is_ok_and(|entry| entry.file_name() == SIDE))
        || outputs::is_run_of(folder, surveys)
}

/// Returns the name of a survey: the name of the project, of the log or of the folder of the logs,
/// or the common beginning of the logs' names.
pub(super) fn name_of(arguments: &[PathBuf], logs: &[OpenedLog]) -> String {
    let text =
        |part: Option<&std::ffi::OsStr>| part.map(|part| part.to_string_lossy().into_owned());
    if let [path] = arguments {
        if is_project(path) {
            return text(path.file_stem()).unwrap_or_default();
        }
        if logs.len() > 1 {
            // The name of the folder `.` is found from its absolute path.
            let whole = path.canonicalize().unwrap_or_else(|_| path.clone());
            return text(whole.file_name()).unwrap_or_default();
        }
    }
    let names: Vec<String> = logs.iter().map(|log| log.survey.name()).collect();
    common(&names)
}

/// Returns the common beginning of names, without a number that is cut in two and the characters
/// before it: `Rec` of `Rec00001` and `Rec00002`.
fn common(names: &[String]) -> String {
    let Some((first, others)) = names.split_first() else {
        return SURVEY.to_owned();
    };
    if others.is_empty() {
        return first.clone();
    }
    let alike = |other: &String| {
        let pairs = first.char_indices().zip(other.chars());
        let same = pairs.take_while(|((_, letter), other)| letter == other);
        same.last().map_or(0, |((at, letter), _)| at + letter.len_utf8())
    };
    let length = others.iter().map(alike).min().unwrap_or(0);
    let goes_on = |name: &String| {
        let rest = name.get(length..).unwrap_or_default();
        rest.starts_with(|letter: char| letter.is_ascii_digit())
    };
    let mut part = &first[..length];
    if names.iter().any(goes_on) {
        part = part.trim_end_matches(|letter: char| letter.is_ascii_digit());
    }
    let part = part.trim_end_matches(['-', '_', '.', ' ']);
    match part.chars().count() {
        LEAST.. => part.to_owned(),
        _ => SURVEY.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use bathyscope_log::survey::Bytes;
    use bathyscope_products::outputs::MANIFEST;
    use bathyscope_products::pipeline::Settings;
    use std::fs;
    use std::sync::Arc;

    #[test]
    fn logs_are_called_what_their_names_have_in_common() {
        let called = |names: &[&str]| {
            let names: Vec<String> = names.iter().map(|name| (*name).to_owned()).collect();
            common(&names)
        };
        assert_eq!(called(&["pond"]), "pond");
        assert_eq!(called(&["Rec00001", "Rec00002"]), "Rec");
        assert_eq!(called(&["lake-2024-1", "lake-2024-2"]), "lake-2024");
        assert_eq!(called(&["lake-9", "lake-10"]), "lake");
        assert_eq!(called(&["bay-east", "bay-west", "bay"]), "bay");
        assert_eq!(called(&["Séé-1", "Séè-1"]), SURVEY);
        assert_eq!(called(&["pond", "river"]), SURVEY);
        assert_eq!(called(&[]), SURVEY);
    }

    fn log(path: &Path) -> OpenedLog {
        let mut survey = Survey::default();
        survey.source.files = vec![path.to_owned()];
        survey.bytes = vec![Bytes::Held(Arc::new(b"12345".to_vec()))];
        OpenedLog { survey: Arc::new(survey), settings: Settings::default(), review: None }
    }

    #[test]
    fn what_is_not_of_a_run_of_the_same_log_is_left_alone() {
        let temporary = tempfile::tempdir().unwrap();
        let root = temporary.path();
        let pond = [log(&root.join("pond.sl2"))];
        let next = |name: &str| {
            let folder = Folders::in_folder(root).next_free(name, &pond);
            folder.file_name().unwrap().to_str().unwrap().to_owned()
        };
        assert_eq!(next("pond"), "pond");
        fs::create_dir(root.join("pond")).unwrap();
        assert_eq!(next("pond"), "pond", "an empty one");
        fs::write(root.join("pond/notes.txt"), "mine").unwrap();
        assert_eq!(next("pond"), "pond-products");
        let manifest = |file: &str| {
            format!(
                r#"{{"program":"bathyscope 1","inputs":[{{"file":"elsewhere/{file}","bytes":5}}]}}"#
            )
        };
        fs::write(root.join("pond").join(MANIFEST), manifest("pond.sl2")).unwrap();
        assert_eq!(next("pond"), "pond", "an earlier run of it");
        fs::write(root.join("pond").join(MANIFEST), manifest("pond.sl3")).unwrap();
        assert_eq!(next("pond"), "pond-products", "a run of another log");
        fs::write(root.join("pond-products"), "a file").unwrap();
        assert_eq!(next("pond"), "pond-products-2");
        // The name of a log must not lead out of the folder.
        assert_eq!(next(".."), SURVEY);
        assert_eq!(next("a/../b"), "a-..-b");

        let mut folders = Folders::in_folder(root);
        let both = ["bay", "BAY"].map(|name| folders.next_free(name, &pond));
        assert_eq!(both, ["bay", "BAY-products"].map(|name| root.join(name)));
    }

    #[test]
    fn no_two_surveys_share_a_folder() {
        let mut folders = Folders::in_folder(Path::new("out"));
        let names = ["Rec1", "Rec1-2", "Rec1", "REC1"].map(|name| folders.next(name));
        assert_eq!(
            names,
            ["out/Rec1", "out/Rec1-2", "out/Rec1-3", "out/REC1-4"].map(PathBuf::from)
        );
    }
}

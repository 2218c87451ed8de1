//! Names the logs of one survey, so that no two have the same name.

use super::Survey;
use std::path::Path;

/// A name for each log: the stem of its file; where others have that too, the file name; where
/// others have that too, with its folder; where others have even that, with a number. Recorders
/// begin each card with `Rec00001`.
pub fn distinct_names<'a>(logs: impl Iterator<Item = &'a Survey>) -> Vec<String> {
    let logs: Vec<&Survey> = logs.collect();
    let mut names: Vec<String> = logs.iter().map(|log| log.name()).collect();
    for longer in [file_name, with_folder] {
        let shared = shared(&names);
        for ((name, log), shared) in names.iter_mut().zip(&logs).zip(shared) {
            if let Some(longer) = log.source.files.first().and_then(|file| longer(file))
                && shared
            {
                *name = longer;
            }
        }
    }
    let same: Vec<usize> = (0..names.len())
        .map(|log| names[..log].iter().filter(|name| **name == names[log]).count())
        .collect();
    for (name, before) in names.iter_mut().zip(same) {
        if before > 0 {
            *name = format!("{name} ({})", before + 1);
        }
    }
    names
}

/// Returns for each name true if it occurs more than once.
fn shared(names: &[String]) -> Vec<bool> {
    let count = |name: &String| names.iter().filter(|other| *other == name).count();
    names.iter().map(|name| count(name) > 1).collect()
}

/// `Rec00001.DAT`.
fn file_name(file: &Path) -> Option<String> {
    Some(file.file_name()?.to_string_lossy().into_owned())
}

/// `Rec00001.DAT (card 2)`.
fn with_folder(file: &Path) -> Option<String> {
    let folder = file.parent()?.file_name()?;
    Some(format!("{} ({})", file_name(file)?, folder.to_string_lossy()))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(files: &[&str]) -> Vec<String> {
        let log = |file: &&str| {
            let mut log = Survey::default();
            log.source.files = vec![file.into()];
            log
        };
        let logs: Vec<Survey> = files.iter().map(log).collect();
        distinct_names(logs.iter())
    }

    #[test]
    fn a_name_is_as_long_as_it_must_be() {
        assert_eq!(names(&["a/pond.sl2", "a/lake.sl2"]), ["pond", "lake"]);
        assert_eq!(
            names(&["a/pond.sl2", "a/pond.sl3", "a/lake.sl2"]),
            ["pond.sl2", "pond.sl3", "lake"]
        );
        assert_eq!(
            names(&["a/pond.sl2", "b/pond.sl2", "b/pond.sl3"]),
            ["pond.sl2 (a)", "pond.sl2 (b)", "pond.sl3"]
        );
        assert_eq!(names(&["1/a/pond.sl2", "2/a/pond.sl2"]), ["pond.sl2 (a)", "pond.sl2 (a) (2)"]);
    }
}

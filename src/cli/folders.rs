//! A folder of its own for each of several surveys.

use bathyscope_products::file_name::file_name;
use std::collections::HashSet;
use std::path::{Path, PathBuf};

/// Names folders after surveys; two recorders both begin with `Rec00001`, and neither may replace
/// the other's products.
pub(super) struct Folders {
    parent: PathBuf,
    /// Lower case: on some file systems `REC` and `Rec` are one folder.
    taken: HashSet<String>,
}

impl Folders {
    /// Folders in `parent`.
    pub(super) fn in_folder(parent: &Path) -> Self {
        Self { parent: parent.to_owned(), taken: HashSet::new() }
    }

    /// The folder of the next survey: its name, with `-2`, `-3` ... behind it where that was given
    /// away before.
    pub(super) fn next(&mut self, name: &str) -> PathBuf {
        let name = file_name(name);
        let mut folder = name.clone();
        let mut count = 1;
        while !self.taken.insert(folder.to_lowercase()) {
            count += 1;
            folder = format!("{name}-{count}");
        }
        self.parent.join(folder)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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

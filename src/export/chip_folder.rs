//! The folder of chips changes as a whole: whoever stops a search keeps what an earlier one found.

use super::ExportError;
use crate::detection::Picture;
use image::codecs::png::PngEncoder;
use image::{ExtendedColorType, ImageEncoder as _};
use std::collections::HashSet;
use std::ffi::OsStr;
use std::fs::{self, File};
use std::io::{self, BufWriter, Write as _};
use std::path::{Path, PathBuf};

/// Where the chips lie in the folder of the products.
const FOLDER: &str = "chips";
/// Where they are written until all are there.
const PASSING: &str = "chips.part";
/// The table beside them, which names their classes.
const TABLE: &str = "detections.csv";
/// Class of a box whose model does not name it.
const UNNAMED: &str = "object";

/// Chips on their way. Dropped before [`ChipFolder::finish`], it leaves the earlier ones as they are.
pub struct ChipFolder {
    folder: PathBuf,
    passing: PathBuf,
    /// Classes by index, as part of a file name.
    classes: Vec<String>,
    /// Classes that chips of this and the earlier run may have.
    known: HashSet<String>,
    /// The chips so far.
    names: Vec<String>,
}

/// Tells which file failed.
fn fail(path: &Path) -> impl FnOnce(io::Error) -> ExportError {
    let path = path.to_path_buf();
    |source| ExportError { path, source }
}

impl ChipFolder {
    /// New chips for `output`, the folder of the products, before its table is written anew. What a run that was killed left
    /// half done is cleared away.
    pub fn begin(output: &Path, classes: &[String]) -> Result<Self, ExportError> {
        let [folder, passing] = [FOLDER, PASSING].map(|name| output.join(name));
        fs::create_dir_all(&passing).map_err(fail(&passing))?;
        remove(&passing, |_| true)?;
        let classes: Vec<String> = classes.iter().map(|name| file_safe(name)).collect();
        let mut known = classes_in(&output.join(TABLE));
        known.extend(classes.iter().cloned());
        known.insert(UNNAMED.to_owned());
        Ok(Self {
            folder,
            passing,
            classes,
            known,
            names: Vec::new(),
        })
    }

    /// Writes the next chip, `0001-rock.png` and so on.
    pub fn add(&mut self, class: usize, chip: &Picture) -> Result<(), ExportError> {
        let class = self.classes.get(class).map_or(UNNAMED, String::as_str);
        let name = format!("{:04}-{class}.png", self.names.len() + 1);
        let path = self.passing.join(&name);
        self.names.push(name);
        let colour = if chip.channels == 3 {
            ExtendedColorType::Rgb8
        } else {
            ExtendedColorType::L8
        };
        let write = |file: File| {
            let mut out = BufWriter::new(file);
            PngEncoder::new(&mut out)
                .write_image(&chip.levels, chip.width as u32, chip.height as u32, colour)
                .map_err(io::Error::other)?;
            out.flush()
        };
        File::create(&path).and_then(write).map_err(fail(&path))
    }

    /// Puts the new chips in the place of the earlier ones: those with a number and a class of the model, or of the earlier
    /// table, for a name. Other files stay.
    pub fn finish(self) -> Result<(), ExportError> {
        fs::create_dir_all(&self.folder).map_err(fail(&self.folder))?;
        remove(&self.folder, |class| self.known.contains(class))?;
        for name in &self.names {
            let path = self.folder.join(name);
            fs::rename(self.passing.join(name), &path).map_err(fail(&path))?;
        }
        Ok(())
    }
}

impl Drop for ChipFolder {
    fn drop(&mut self) {
        // Best effort: the next run clears what stays. A folder that holds anything else is not removed.
        remove(&self.passing, |_| true).ok();
        fs::remove_dir(&self.passing).ok();
    }
}

/// Removes the chips of such classes from a folder.
fn remove(folder: &Path, such: impl Fn(&str) -> bool) -> Result<(), ExportError> {
    for entry in fs::read_dir(folder).map_err(fail(folder))? {
        let entry = entry.map_err(fail(folder))?;
        let is_file = entry.file_type().is_ok_and(|kind| kind.is_file());
        let name = entry.file_name();
        if is_file && class_of(&name).is_some_and(&such) {
            fs::remove_file(entry.path()).map_err(fail(&entry.path()))?;
        }
    }
    Ok(())
}

/// Classes that an earlier table names; none where there is no such table.
fn classes_in(table: &Path) -> HashSet<String> {
    let Ok(mut table) = csv::Reader::from_path(table) else {
        return HashSet::new();
    };
    let column = table.headers().ok().and_then(|header| {
        let mut header = header.iter();
        header.position(|name| name == "class")
    });
    let rows = table.records().map_while(Result::ok);
    rows.filter_map(|row| row.get(column?).map(file_safe))
        .collect()
}

fn class_of(name: &OsStr) -> Option<&str> {
    name.to_str().and_then(class_in)
}

/// The class in the name of a chip; `None` for a file that is none.
fn class_in(name: &str) -> Option<&str> {
    let (number, class) = name.strip_suffix(".png")?.split_once('-')?;
    let numbered = number.len() >= 4 && number.bytes().all(|digit| digit.is_ascii_digit());
    (numbered && class == file_safe(class)).then_some(class)
}

/// A class name, which a model's file may have chosen, as part of a file name: letters, digits and hyphens.
fn file_safe(name: &str) -> String {
    let letters = name.chars().take(40);
    letters
        .map(|letter| {
            if letter.is_alphanumeric() {
                letter
            } else {
                '-'
            }
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(folder: &Path) -> Vec<String> {
        let entries = fs::read_dir(folder).unwrap();
        let mut names: Vec<String> = entries
            .map(|entry| entry.unwrap().file_name().into_string().unwrap())
            .collect();
        names.sort();
        names
    }

    /// A run whose model knows these classes and has found each once.
    fn begun(output: &Path, classes: &[&str]) -> ChipFolder {
        let names: Vec<String> = classes.iter().map(|&name| name.to_owned()).collect();
        let mut chips = ChipFolder::begin(output, &names).unwrap();
        for class in 0..names.len() {
            chips.add(class, &Picture::grey(2, 1, vec![0, 9])).unwrap();
        }
        chips
    }

    #[test]
    fn earlier_chips_go_and_other_files_stay() {
        let output = tempfile::tempdir().unwrap();
        let folder = output.path().join(FOLDER);
        begun(output.path(), &["rock", "sunken boat"])
            .finish()
            .unwrap();
        assert_eq!(names(&folder), ["0001-rock.png", "0002-sunken-boat.png"]);
        fs::write(
            output.path().join(TABLE),
            "id,class\n1,rock\n2,sunken boat\n",
        )
        .unwrap();
        let others = [
            "0003-best.png",
            "0003-rock copy.png",
            "0003-rock.txt",
            "3-rock.png",
            "rock.png",
        ];
        for name in others {
            fs::write(folder.join(name), "mine").unwrap();
        }
        fs::create_dir(folder.join("0004-rock.png")).unwrap();
        begun(output.path(), &["tyre"]).finish().unwrap();
        let mut expected = vec!["0001-tyre.png", "0004-rock.png"];
        expected.extend(others);
        expected.sort_unstable();
        assert_eq!(names(&folder), expected);
        assert_eq!(names(output.path()), [FOLDER, TABLE]);
    }

    #[test]
    fn a_stop_leaves_the_earlier_chips_and_nothing_else() {
        let output = tempfile::tempdir().unwrap();
        let folder = output.path().join(FOLDER);
        begun(output.path(), &["rock", "tyre"]).finish().unwrap();
        drop(begun(output.path(), &["tyre"]));
        assert_eq!(names(&folder), ["0001-rock.png", "0002-tyre.png"]);
        assert_eq!(names(output.path()), [FOLDER]);
        // Killed: nothing could tidy up. The next run does.
        std::mem::forget(begun(output.path(), &["tyre", "log", "block"]));
        assert_eq!(names(output.path()), [FOLDER, PASSING]);
        begun(output.path(), &["tyre", "rock"]).finish().unwrap();
        assert_eq!(names(&folder), ["0001-tyre.png", "0002-rock.png"]);
        assert_eq!(names(output.path()), [FOLDER]);
    }
}

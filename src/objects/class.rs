//! Defines what a class name is, and the list of class names that an analyst keeps. Two lists of
//! classes share nothing but the names.

use serde::{Deserialize, Serialize};

/// Class of a box without a known class: drawn before any model has named one, or found by a model
/// whose confidence in its class is too low.
pub const NAMELESS_CLASS: &str = "object";

/// Greatest length of the name of a class, a model or an object, characters.
const LONGEST_NAME: usize = 200;

/// The classes that a survey begins with: the usual ones of side-scan surveys, and the further ones
/// of the shipped detector.
const USUAL_CLASSES: [&str; 14] = [
    "wreck", "anchor", "tree", "pipe", "tyre", "debris", "fish", "rock", "unknown", "block",
    "cylinder", "boat", "log", "effigy",
];

/// `review.*` settings.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ReviewSettings {
    /// The classes that boxes can have, in the order of their keys and of their numbers in labels
    /// for training.
    pub classes: Vec<String>,
}

impl Default for ReviewSettings {
    fn default() -> Self {
        Self { classes: USUAL_CLASSES.map(str::to_owned).to_vec() }
    }
}

impl ReviewSettings {
    /// Checks that every class is a valid name and occurs once.
    ///
    /// # Errors
    /// When a class is no valid name or occurs twice: a sentence that names the key.
    pub fn check(&self) -> Result<(), &'static str> {
        let classes = &self.classes;
        if !classes.iter().all(|name| is_name(name) && name.trim() == name) {
            return Err("review.classes holds names of one line, without spaces around them");
        }
        let is_twice = |(index, name): (usize, &String)| classes[..index].contains(name);
        if classes.iter().enumerate().any(is_twice) {
            Err("review.classes holds each name once")
        } else {
            Ok(())
        }
    }

    /// Returns the settings with one more class, if it is new.
    #[must_use]
    pub fn with(&self, name: &str) -> Self {
        let mut after = self.clone();
        class_index(&mut after.classes, name);
        after
    }

    /// Returns the settings with a class renamed. If the new name is in the list already, the old
    /// one is removed.
    #[must_use]
    pub fn renamed(&self, from: &str, to: &str) -> Self {
        let is_known = from != to && self.classes.iter().any(|name| name == to);
        let renamed = |name: &String| {
            if name == from { (!is_known).then(|| to.to_owned()) } else { Some(name.clone()) }
        };
        Self { classes: self.classes.iter().filter_map(renamed).collect() }
    }
}

/// Returns true if a text can be a name: not empty, of one line, and not too long.
pub(super) fn is_name(name: &str) -> bool {
    let is_usual = name.chars().count() <= LONGEST_NAME && !name.contains(char::is_control);
    is_usual && !name.is_empty()
}

/// Returns the index of a class by its name; appends the class if it is new.
pub(crate) fn class_index(names: &mut Vec<String>, name: &str) -> usize {
    let known = names.iter().position(|known| known == name);
    known.unwrap_or_else(|| {
        names.push(name.to_owned());
        names.len() - 1
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_list_holds_each_name_once_and_a_name_is_something() {
        let list = |names: &[&str]| ReviewSettings {
            classes: names.iter().map(|&name| name.to_owned()).collect(),
        };
        assert_eq!(ReviewSettings::default().check(), Ok(()));
        assert_eq!(list(&[]).check(), Ok(()));
        for wrong in [list(&["a", "a"]), list(&[""]), list(&[" a"]), list(&["a\nb"])] {
            assert!(wrong.check().is_err(), "{wrong:?}");
        }
        let two = list(&["wreck", "anchor"]);
        assert_eq!(two.with("wreck"), two);
        assert_eq!(two.with("buoy"), list(&["wreck", "anchor", "buoy"]));
        assert_eq!(two.renamed("anchor", "buoy"), list(&["wreck", "buoy"]));
        assert_eq!(two.renamed("anchor", "wreck"), list(&["wreck"]));
        assert_eq!(two.renamed("anchor", "anchor"), two);
    }
}

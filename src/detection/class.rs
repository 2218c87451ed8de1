//! Class names, which are what two lists of classes have in common.

/// Class of a box that nobody has named: drawn before any model has named one, or found by a model that is too unsure what it is.
pub const NAMELESS_CLASS: &str = "object";

/// Index of a class by its name; appended when it is new.
pub fn class_index(names: &mut Vec<String>, name: &str) -> usize {
    let known = names.iter().position(|known| known == name);
    known.unwrap_or_else(|| {
        names.push(name.to_owned());
        names.len() - 1
    })
}

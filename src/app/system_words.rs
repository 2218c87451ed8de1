//! Rewrites messages of the system about files, and of libraries about values, in plain words. This
//! module depends on `file_in_use` alone; any module may use it.

use bathyscope_products::file_in_use::is_in_use;
use std::borrow::Cow;
use std::io::{Error, ErrorKind};

/// Start of the suffix that Rust appends to the text of a system error.
const NUMBER: &str = " (os error ";

/// Message about a file that another program has open.
const IN_USE: &str = "another program has the file open; close it there, or choose another";

/// Type names in messages of serde, with plain words for them.
const TYPES: [(&str, &str); 9] = [
    ("expected f64", "expected a number"),
    ("expected f32", "expected a number"),
    ("expected usize", "expected a whole number"),
    ("expected u64", "expected a whole number"),
    ("expected u32", "expected a whole number"),
    ("expected u16", "expected a whole number"),
    ("expected u8", "expected a whole number"),
    ("expected a sequence", "expected a list"),
    ("floating point `", "number `"),
];

/// Returns a message in which the system's text, `No such file or directory (os error 2)`, and the
/// types of values are replaced by plain words. Libraries include such texts in their own messages,
/// so that a message is changed where it is shown.
pub(crate) fn in_plain_words(message: &str) -> Cow<'_, str> {
    let mut plain = Cow::Borrowed(message);
    for (type_name, words) in TYPES {
        if plain.contains(type_name) {
            plain = Cow::Owned(plain.replace(type_name, words));
        }
    }
    // A message contains one or two system errors.
    for _ in 0..4 {
        let Some(error) = number_in(&plain).map(Error::from_raw_os_error) else {
            break;
        };
        let text = error.to_string();
        let words = if is_in_use(&error) { Some(IN_USE) } else { words(error.kind()) };
        let words = match words {
            Some(words) => words.to_owned(),
            None => {
                let text = text.split(NUMBER).next().unwrap_or_default();
                text.trim_end_matches('.').to_lowercase()
            }
        };
        let mended = plain.replace(&text, &words);
        if mended == *plain {
            break;
        }
        plain = Cow::Owned(mended);
    }
    plain
}

fn number_in(message: &str) -> Option<i32> {
    let (_, after) = message.split_once(NUMBER)?;
    after.split(')').next()?.parse().ok()
}

fn words(kind: ErrorKind) -> Option<&'static str> {
    Some(match kind {
        ErrorKind::NotFound => "there is no such file or folder; check the path",
        // Windows reports this error, too, for a file that is open in another program and is to be
        // replaced.
        ErrorKind::PermissionDenied if cfg!(windows) => {
            "this may not be done there; close the file where it is open in another program, check the rights of the file and its folder, or choose another"
        }
        ErrorKind::PermissionDenied => {
            "this user may not do that there; check the rights of the file and its folder, or choose another"
        }
        ErrorKind::IsADirectory => "it is a folder, and a file is expected",
        ErrorKind::NotADirectory => "a part of the path is a file, not a folder; check the path",
        ErrorKind::DirectoryNotEmpty => "the folder is not empty",
        ErrorKind::StorageFull => "the disk is full; make room, or choose another",
        ErrorKind::QuotaExceeded => {
            "this user's share of the disk is full; make room, or choose another"
        }
        ErrorKind::ReadOnlyFilesystem => "the disk can only be read; choose another",
        ErrorKind::FileTooLarge => "the file grows larger than the disk can hold; choose another",
        ErrorKind::InvalidFilename => {
            "the name is too long, or not possible on this disk; choose another"
        }
        ErrorKind::CrossesDevices => "it lies on another disk",
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_systems_words_give_way_wherever_they_stand() {
        let missing = std::fs::read("no/such/log.sl2").unwrap_err();
        let message = format!("cannot read the log: {missing}: no/such/log.sl2");
        assert_eq!(
            in_plain_words(&message),
            "cannot read the log: there is no such file or folder; check the path: no/such/log.sl2"
        );
        let twice = format!("one: {missing}; two: {missing}");
        assert!(!in_plain_words(&twice).contains("os error"));
    }

    #[cfg(windows)]
    #[test]
    fn a_file_that_is_open_elsewhere_is_said_to_be() {
        for (number, words) in [
            (5, "open in another program"),
            (32, "close it there"),
            (33, "close it there"),
            (2, "no such file"),
            (112, "disk is full"),
        ] {
            let message = Error::from_raw_os_error(number).to_string();
            assert!(in_plain_words(&message).contains(words), "{message}");
        }
    }

    #[cfg(unix)]
    #[test]
    fn every_number_is_put_into_words() {
        for number in 1..134 {
            let message = format!("x: {}: y", Error::from_raw_os_error(number));
            let plain = in_plain_words(&message);
            assert!(!plain.contains("os error"), "{plain}");
            assert!(plain.starts_with("x: ") && plain.ends_with(": y"), "{plain}");
        }
        for (number, words) in [
            (13, "rights"),
            (20, "part of the path"),
            (21, "a folder"),
            (28, "disk is full"),
            (30, "only be read"),
        ] {
            let message = Error::from_raw_os_error(number).to_string();
            assert!(in_plain_words(&message).contains(words), "{message}");
        }
    }

    #[test]
    fn types_of_values_are_what_an_analyst_calls_them() {
        #[derive(Debug, serde::Deserialize)]
        struct Scene {
            #[allow(dead_code)]
            length_m: f64,
            #[allow(dead_code)]
            lines: Vec<u32>,
        }
        for (toml, words) in [
            ("length_m = 'long'\nlines = []", "expected a number"),
            ("length_m = 1.0\nlines = 2.5", "`2.5`, expected a list"),
            ("length_m = 1.0\nlines = [2.5]", "number `2.5`, expected a whole number"),
        ] {
            let error = toml::from_str::<Scene>(toml).unwrap_err();
            let plain = in_plain_words(error.message()).into_owned();
            assert!(plain.contains(words), "{plain}");
        }
    }

    #[test]
    fn other_messages_stay_as_they_are() {
        for message in ["", "all well", "log (os error x)", "a file named `pipe (os error 99999)`"]
        {
            assert_eq!(in_plain_words(message), message);
        }
    }
}

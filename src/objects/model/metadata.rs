//! Reads the metadata that Ultralytics' exporter writes with the graph, as Python literals,
//! leniently.

use std::collections::HashMap;

/// The file's key-value pairs.
#[derive(Clone, Debug, Default)]
pub(super) struct Metadata(pub HashMap<String, String>);

impl Metadata {
    /// Class names from `{0: 'rock', 1: "it's"}` or `['rock', 'tyre']`; `None` where there are
    /// none.
    pub(super) fn names(&self) -> Option<Vec<String>> {
        let mut names = quoted(self.0.get("names")?);
        // JSON dictionaries quote their keys as well.
        if names.len().is_multiple_of(2) && names.iter().step_by(2).all(|key| is_number(key)) {
            names = names.into_iter().skip(1).step_by(2).collect();
        }
        (!names.is_empty()).then_some(names)
    }

    /// Height and width from `[640, 640]`.
    pub(super) fn image_size(&self) -> Option<[usize; 2]> {
        let numbers: Vec<usize> = self
            .0
            .get("imgsz")?
            .split(|letter: char| !letter.is_ascii_digit())
            .filter_map(|digits| digits.parse().ok())
            .collect();
        match numbers[..] {
            [size] => Some([size, size]),
            [height, width] => Some([height, width]),
            _ => None,
        }
    }

    /// Returns true if the network suppresses overlapping boxes itself.
    pub(super) fn end_to_end(&self) -> bool {
        ["end2end", "nms"]
            .iter()
            .filter_map(|key| self.0.get(*key))
            .any(|value| value.eq_ignore_ascii_case("true"))
    }

    /// The task, where it is another than finding boxes.
    pub(super) fn other_task(&self) -> Option<&str> {
        let task = self.0.get("task")?.as_str();
        (task != "detect").then_some(task)
    }
}

fn is_number(text: &str) -> bool {
    !text.is_empty() && text.bytes().all(|byte| byte.is_ascii_digit())
}

/// The strings of a Python literal, in either quote, a backslash taking the next letter as it is.
fn quoted(text: &str) -> Vec<String> {
    let mut found = Vec::new();
    let mut open: Option<(char, String)> = None;
    let mut letters = text.chars();
    while let Some(letter) = letters.next() {
        match &mut open {
            None if letter == '\'' || letter == '"' => open = Some((letter, String::new())),
            None => {}
            Some((quote, name)) if letter == *quote => {
                found.push(std::mem::take(name));
                open = None;
            }
            Some((_, name)) if letter == '\\' => name.extend(letters.next()),
            Some((_, name)) => name.push(letter),
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(text: &str) -> Option<Vec<String>> {
        Metadata(HashMap::from([("names".to_owned(), text.to_owned())])).names()
    }

    #[test]
    fn names_are_read_from_what_python_prints() {
        let two = |a: &str, b: &str| Some(vec![a.to_owned(), b.to_owned()]);
        assert_eq!(names("{0: 'rock', 1: 'tyre'}"), two("rock", "tyre"));
        assert_eq!(names(r#"{0: "diver's", 1: 'a\'b'}"#), two("diver's", "a'b"));
        assert_eq!(names("['rock', 'tyre']"), two("rock", "tyre"));
        assert_eq!(names(r#"{"0": "rock", "1": "tyre"}"#), two("rock", "tyre"));
        assert_eq!(names("{0: 'unclosed"), None);
        assert_eq!(names("{}"), None);
    }
}

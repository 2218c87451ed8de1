//! Makes text from untrusted sources safe to show: a name in a file may contain escape sequences
//! that move a terminal's cursor, change its colours or type commands, and the error of a library
//! may have a thousand lines.

use std::fmt::Write as _;

/// Largest number of letters of a sentence; of a longer one the middle is left out.
const LONGEST: usize = 1000;
/// Number of letters, out of [`LONGEST`], that are kept at the end of a shortened sentence:
/// sentences name their file at the end.
const END: usize = 300;

/// Returns a text as one line of at most a thousand letters: line ends become spaces, invisible
/// letters are written as their number (`\u{1b}`), and the middle of a longer text is left out.
pub fn one_line(text: &str) -> String {
    let mut line = String::with_capacity(text.len().min(4 * LONGEST));
    let mut words = text.split(is_line_end).map(str::trim);
    line.extend(words.next().map(shown));
    for word in words.filter(|word| !word.is_empty()) {
        line.push(' ');
        line.push_str(&shown(word));
    }
    shortened(line.trim())
}

/// Returns a name for use in a sentence: between “ and ” where it contains a space, so that its end
/// is visible, and a name such as `5 m` is not read as a measure.
pub fn quoted(name: &str) -> String {
    if name.contains(char::is_whitespace) { format!("“{name}”") } else { name.to_owned() }
}

/// Shortens and escapes each line of a text as [`one_line`] does, and keeps the lines apart. The
/// columns of a table stay aligned.
pub fn lines(text: &str) -> String {
    let lines = text.split('\n');
    let lines = lines.map(|line| shortened(&shown(line.trim_end_matches('\r'))));
    lines.collect::<Vec<_>>().join("\n")
}

/// Returns JSON of the same meaning without anything that a terminal interprets: invisible letters,
/// which JSON allows within strings, are escaped.
pub fn json(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len());
    for letter in text.chars() {
        if is_shown(letter) || matches!(letter, '\n' | '\t') {
            escaped.push(letter);
            continue;
        }
        for unit in letter.encode_utf16(&mut [0; 2]) {
            // Writing to a string cannot fail.
            write!(escaped, "\\u{unit:04x}").ok();
        }
    }
    escaped
}

/// Escapes a text for an XML or HTML file: markup is escaped, characters that XML 1.0 forbids are
/// left out.
pub fn xml(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len());
    for letter in text.chars() {
        match letter {
            '&' => escaped.push_str("&amp;"),
            '<' => escaped.push_str("&lt;"),
            '>' => escaped.push_str("&gt;"),
            '"' => escaped.push_str("&quot;"),
            '\'' => escaped.push_str("&apos;"),
            '\t' | '\n' | '\r' => escaped.push(letter),
            _ if letter.is_control() || matches!(letter, '\u{FFFE}' | '\u{FFFF}') => {}
            _ => escaped.push(letter),
        }
    }
    escaped
}

fn is_line_end(letter: char) -> bool {
    matches!(letter, '\n' | '\r' | '\t' | '\u{b}' | '\u{c}' | '\u{85}' | '\u{2028}' | '\u{2029}')
}

/// Returns true if a letter is visible as itself: neither a control character nor one that changes
/// the direction of the text around it, joins letters, or has no width.
fn is_shown(letter: char) -> bool {
    let hidden = matches!(
        letter,
        '\u{ad}' | '\u{61c}' | '\u{180e}' | '\u{200b}'..='\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2060}'..='\u{206f}'
            | '\u{feff}' | '\u{fff9}'..='\u{fffb}' | '\u{e0000}'..='\u{e0fff}'
    );
    !(letter.is_control() || hidden)
}

fn shown(text: &str) -> String {
    let mut shown = String::with_capacity(text.len());
    for letter in text.chars() {
        if is_shown(letter) { shown.push(letter) } else { shown.extend(letter.escape_unicode()) }
    }
    shown
}

fn shortened(line: &str) -> String {
    // A line has at least as many bytes as letters.
    if line.len() <= LONGEST || line.chars().count() <= LONGEST {
        return line.to_owned();
    }
    let start: String = line.chars().take(LONGEST - END - 3).collect();
    let end = line.char_indices().rev().nth(END - 1);
    let end = end.map_or("", |(at, _)| &line[at..]);
    format!("{start}...{end}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sentence_is_one_line_that_does_nothing() {
        assert_eq!(
            one_line("TOML parse error\n  |\n1 | a\u{1b}[31m = \u{9b}5n\r\n\tbad: x.toml\n"),
            "TOML parse error | 1 | a\\u{1b}[31m = \\u{9b}5n bad: x.toml"
        );
        // A name that is shown from right to left seems to have another suffix than it has.
        assert_eq!(one_line("pond\u{202e}2ls.exe"), "pond\\u{202e}2ls.exe");
        assert_eq!(one_line("Größe  12 m³, 深さ"), "Größe  12 m³, 深さ");
        assert_eq!(one_line("\n"), "");
    }

    #[test]
    fn a_long_sentence_keeps_its_beginning_and_its_end() {
        let long = format!("it cannot be compiled: {}: model.onnx", "é".repeat(900_000));
        let cut = one_line(&long);
        assert_eq!(cut.chars().count(), LONGEST);
        assert!(cut.starts_with("it cannot be compiled") && cut.ends_with("é: model.onnx"));
        assert!(cut.contains("é...é"));
    }

    #[test]
    fn a_table_keeps_its_lines_and_json_its_meaning() {
        assert_eq!(lines("a   b\n\u{1b}[2Jc\r\n\n"), "a   b\n\\u{1b}[2Jc\n\n");
        let name = "a\u{1b}\u{7f}\u{9b}\u{202e}\u{e0041}\"\\é";
        let text = serde_json::to_string_pretty(&serde_json::json!({ "name": name })).unwrap();
        let safe = json(&text);
        assert!(safe.chars().all(|letter| is_shown(letter) || letter == '\n'), "{safe}");
        let read: serde_json::Value = serde_json::from_str(&safe).unwrap();
        assert_eq!(read["name"], name);
    }
}

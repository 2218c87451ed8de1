//! A log's or a survey's name as that of a file or folder. It depends on no other module; any may
//! use it.

/// Characters that Windows forbids in names, by "Naming Files, Paths, and Namespaces" of its
/// documentation, besides control characters.
const FORBIDDEN: [char; 9] = ['<', '>', ':', '"', '/', '\\', '|', '?', '*'];
/// Names of devices there, whatever ending they have. The last two come with a digit.
const DEVICES: [&str; 6] = ["CON", "PRN", "AUX", "NUL", "CONIN$", "CONOUT$"];
const NUMBERED_DEVICES: [&str; 2] = ["COM", "LPT"];

/// A name that a file or folder can have on every system, so that products can be copied from one
/// to another: `2024-05-01T10:00` becomes `2024-05-01T10-00`, `aux` becomes `_aux`. Of nothing but
/// dots and spaces it is `_`.
pub fn file_name(name: &str) -> String {
    let possible = |letter: char| {
        if letter.is_control() || FORBIDDEN.contains(&letter) { '-' } else { letter }
    };
    let name: String = name.chars().map(possible).collect();
    // Windows takes them off, and finds another file then.
    let name = name.trim_end_matches(['.', ' ']);
    if name.is_empty() || is_device(name) { format!("_{name}") } else { name.to_owned() }
}

fn is_device(name: &str) -> bool {
    let name = name.split('.').next().unwrap_or_default().trim_end();
    let is = |device: &&str| device.eq_ignore_ascii_case(name);
    let mut letters = name.chars();
    let number = letters.next_back();
    let is_number = matches!(number, Some('0'..='9' | '¹' | '²' | '³'));
    let is_numbered = |device: &&str| device.eq_ignore_ascii_case(letters.as_str());
    DEVICES.iter().any(is) || is_number && NUMBERED_DEVICES.iter().any(is_numbered)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_is_possible_everywhere() {
        for (name, expected) in [
            ("pond", "pond"),
            ("Größe 3 (2).sl2", "Größe 3 (2).sl2"),
            ("2024-05-01T10:00:00", "2024-05-01T10-00-00"),
            ("a/b\\c<d>e\"f|g?h*i\u{7}", "a-b-c-d-e-f-g-h-i-"),
            ("pond. .", "pond"),
            ("..", "_"),
            ("", "_"),
            ("nul", "_nul"),
            ("Con.day 1", "_Con.day 1"),
            ("COM1", "_COM1"),
            ("lpt².x", "_lpt².x"),
            ("aux .x", "_aux .x"),
            ("console", "console"),
            ("com", "com"),
            ("com10", "com10"),
        ] {
            assert_eq!(file_name(name), expected);
        }
    }
}

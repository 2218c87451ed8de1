//! Columns of lines of text: what stands between them, what the first line names them, and the
//! numbers in them.

/// Returns true if a line is no part of the table: it is empty, or begins with `#` or `//`.
pub(in crate::formats) fn is_comment(line: &str) -> bool {
    let line = line.trim_start();
    line.is_empty() || line.starts_with('#') || line.starts_with("//")
}

/// Returns the separator between the fields of a table with such a line; `None` for runs of spaces.
/// A comma between semicolons or tabs belongs to a number.
pub(in crate::formats) fn separator_of(line: &str) -> Option<char> {
    let stands = |separator: &char| {
        let mut quoted = false;
        line.chars().any(|letter| {
            quoted ^= letter == '"';
            letter == *separator && !quoted
        })
    };
    [';', '\t', ','].into_iter().find(stands)
}

/// The fields of a line, without quotes and outer spaces. A separator within quotes separates
/// nothing.
pub(in crate::formats) fn fields(line: &str, separator: Option<char>) -> Vec<&str> {
    let Some(separator) = separator else {
        return line.split_whitespace().collect();
    };
    let mut quoted = false;
    line.split(|c| {
        quoted ^= c == '"';
        c == separator && !quoted
    })
    .map(|field| field.trim().trim_matches('"').trim())
    .collect()
}

/// The number in a field; it may be written with a decimal comma where commas do not separate. It
/// may be infinite or no number.
pub(in crate::formats) fn number(field: &str, separator: Option<char>) -> Option<f64> {
    let number = field.parse().ok();
    let with_comma = || match separator {
        Some(',') => None,
        _ => field.replacen(',', ".", 1).parse().ok(),
    };
    number.or_else(with_comma)
}

/// Returns true if the fields of the first line name columns: one of them is no number.
pub(in crate::formats) fn is_header(fields: &[&str], separator: Option<char>) -> bool {
    let is_name = |field: &&str| !field.is_empty() && number(field, separator).is_none();
    fields.iter().any(is_name)
}

/// Returns the index of a name in a header, in letters of either case.
pub(in crate::formats) fn position(header: &[&str], name: &str) -> Option<usize> {
    header.iter().position(|field| field.eq_ignore_ascii_case(name))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn decimal_commas_stand_between_other_separators() {
        for (line, separator, expected) in [
            ("1.5,2", Some(','), [1.5, 2.0]),
            ("1,5;2", Some(';'), [1.5, 2.0]),
            ("1,5\t2,25", Some('\t'), [1.5, 2.25]),
            ("\"1;5\",2", Some(','), [f64::NAN, 2.0]),
            ("1,5", Some(','), [1.0, 5.0]),
            ("1.5 2", None, [1.5, 2.0]),
        ] {
            assert_eq!(separator_of(line), separator, "{line}");
            for (field, expected) in fields(line, separator).iter().zip(expected) {
                let found = number(field, separator);
                assert_eq!(found, Some(expected).filter(|number| !number.is_nan()), "{line}");
            }
        }
        assert!(is_header(&["lon", "2"], Some(',')) && !is_header(&["1,5", ""], Some(';')));
    }
}

//! Formats numbers, places and times as text, for Bathyscope and for the report.

use bathyscope_log::support::calendar;
use bathyscope_log::support::geo::{CoordinateFormat, LonLat};

/// Text in place of a missing value.
pub const NONE: &str = "–";

/// Formats a count in groups of three digits: `12 345`.
pub fn count(number: usize) -> String {
    grouped(number, ' ')
}

/// Formats a count for a page with line breaks: groups of three digits, divided by a thin space at
/// which no line breaks.
pub fn typeset_count(number: usize) -> String {
    grouped(number, '\u{202f}')
}

fn grouped(number: usize, separator: char) -> String {
    let digits = number.to_string();
    let mut text = String::with_capacity(digits.len() + digits.len() / 3 * separator.len_utf8());
    for (index, digit) in digits.chars().enumerate() {
        if index > 0 && (digits.len() - index).is_multiple_of(3) {
            text.push(separator);
        }
        text.push(digit);
    }
    text
}

/// Formats a number with a number of decimals; a dash when it is not finite.
pub fn decimal(value: f64, decimals: usize) -> String {
    if value.is_finite() { format!("{value:.decimals$}") } else { NONE.to_owned() }
}

/// Formats the length of a sailed way, no finer than a boat's track is: metres, from two kilometres
/// on kilometres.
pub fn way(length_m: f64) -> String {
    if length_m < 2000.0 {
        format!("{length_m:.0} m")
    } else {
        format!("{:.2} km", length_m / 1000.0)
    }
}

/// Formats a course behind a comma, `, 214°`; empty when it is not finite, as between two equal
/// places.
pub fn and_course(course_rad: f64) -> String {
    if course_rad.is_finite() {
        format!(", {:.0}°", course_rad.to_degrees())
    } else {
        String::new()
    }
}

/// Formats an area on the ground: square metres, from two hectares on hectares, from two square
/// kilometres on square kilometres.
pub fn area(value_m2: f64) -> String {
    match value_m2 {
        _ if !value_m2.is_finite() => NONE.to_owned(),
        ..1000.0 => format!("{value_m2:.1} m²"),
        1000.0..2e4 => format!("{} m²", count(value_m2.round() as usize)),
        2e4..2e6 => format!("{:.2} ha", value_m2 / 1e4),
        _ => format!("{:.2} km²", value_m2 / 1e6),
    }
}

/// Formats a number with its sign for print, `+0.25` or `−0.25` (U+2212); zero never has a minus.
pub fn typeset_signed(value: f64, decimals: usize) -> String {
    let factor = 10_f64.powi(decimals as i32);
    let rounded = (value * factor).round() / factor + 0.0;
    format!("{rounded:+.decimals$}").replace('-', "\u{2212}")
}

/// Formats minutes and seconds, with hours from one hour on: `2:30`, `1:02:30`.
pub fn duration(seconds: f64) -> String {
    if !seconds.is_finite() {
        return NONE.to_owned();
    }
    let sign = if seconds < 0.0 { "-" } else { "" };
    let total = seconds.abs().round() as u64;
    let (hours, minutes, seconds) = (total / 3600, total / 60 % 60, total % 60);
    if hours > 0 {
        format!("{sign}{hours}:{minutes:02}:{seconds:02}")
    } else {
        format!("{sign}{minutes}:{seconds:02}")
    }
}

/// Formats a duration in words: `17 min`, `2 h 05 min`, `48 s`.
pub fn long_duration(seconds: f64) -> String {
    let whole = seconds.max(0.0).round() as u64;
    match whole {
        0..120 => format!("{whole} s"),
        120..7200 => format!("{} min", (seconds / 60.0).round()),
        _ => format!("{} h {:02} min", whole / 3600, whole / 60 % 60),
    }
}

/// Formats a date: `8 September 2014`.
pub fn long_date(unix_s: f64) -> String {
    calendar::moment(unix_s).format("%-d %B %Y").to_string()
}

/// Formats a position to a tenth of a metre: `36.932541° N, 111.488102° W`.
pub fn position(at: LonLat) -> String {
    let format = CoordinateFormat::Degrees;
    let (latitude, longitude) = (format.latitude(at.lat_deg), format.longitude(at.lon_deg));
    format!("{latitude}, {longitude}")
}

/// Formats the time of day in UTC when the recorder knew the time, or else the time since the start
/// of the log.
pub fn clock(start_unix_s: Option<f64>, time_s: f64) -> String {
    match start_unix_s {
        Some(start_unix_s) => format!("{} UTC", calendar::time_of_day(start_unix_s + time_s)),
        None => duration(time_s),
    }
}

/// Formats a number of bytes in the unit that leaves one to three digits before the point.
pub fn bytes(count: u64) -> String {
    match count {
        0..1_000 => format!("{count} B"),
        1_000..1_000_000 => format!("{:.0} kB", count as f64 / 1e3),
        1_000_000..1_000_000_000 => format!("{:.1} MB", count as f64 / 1e6),
        _ => format!("{:.2} GB", count as f64 / 1e9),
    }
}

/// Formats a number with the right form of a noun: `1 warning`, `2 warnings`.
pub fn plural(number: usize, one: &str, many: &str) -> String {
    format!("{} {}", count(number), if number == 1 { one } else { many })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts_are_grouped() {
        assert_eq!(count(0), "0");
        assert_eq!(count(999), "999");
        assert_eq!(count(1_000), "1 000");
        assert_eq!(count(1_234_567), "1 234 567");
    }

    #[test]
    fn clocks_show_utc_or_the_time_since_the_start() {
        assert_eq!(clock(Some(1_410_181_021.0), 0.0), "12:57:01 UTC");
        assert_eq!(clock(None, 150.4), "2:30");
        assert_eq!(duration(3750.0), "1:02:30");
        assert_eq!(duration(-1.2), "-0:01");
    }

    #[test]
    fn a_page_says_it_in_words() {
        assert_eq!(typeset_count(1_234_567), "1\u{202f}234\u{202f}567");
        assert_eq!(long_date(1_410_181_021.0), "8 September 2014");
        assert_eq!([48.0, 1020.0, 7500.0].map(long_duration), ["48 s", "17 min", "2 h 05 min"]);
        assert_eq!([950.4, 2347.0].map(way), ["950 m", "2.35 km"]);
        let place = LonLat::new(-111.488_102, 36.932_541);
        assert_eq!(position(place), "36.932541° N, 111.488102° W");
        assert_eq!([decimal(1.005, 1), decimal(f64::NAN, 2)], ["1.0", NONE]);
    }
}

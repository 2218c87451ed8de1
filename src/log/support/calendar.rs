//! Unix seconds, as logs count them, and the dates that people write, in UTC. It depends on no
//! other module; any may use it.

use chrono::{DateTime, NaiveDateTime, SecondsFormat, Utc};

/// The moment of some Unix seconds, to the nanosecond; what no calendar reaches is the epoch.
pub fn moment(unix_s: f64) -> DateTime<Utc> {
    let nanoseconds = (unix_s - unix_s.floor()) * 1e9;
    DateTime::from_timestamp(unix_s.floor() as i64, nanoseconds as u32).unwrap_or_default()
}

/// The date of some Unix seconds, `2014-09-08`.
pub fn date(unix_s: f64) -> String {
    moment(unix_s).format("%F").to_string()
}

/// The time of day of some Unix seconds, whole seconds passed, `12:57:01`.
pub fn time_of_day(unix_s: f64) -> String {
    moment(unix_s).format("%T").to_string()
}

/// Some Unix seconds as ISO 8601 writes them, whole seconds passed, `2014-09-08T12:57:01Z`.
pub fn whole_seconds(unix_s: f64) -> String {
    moment(unix_s).format("%FT%TZ").to_string()
}

/// Some Unix seconds as ISO 8601 writes them, `2014-09-08T12:57:01.250Z`.
pub fn timestamp(unix_s: f64) -> String {
    let moment = DateTime::from_timestamp_millis((unix_s * 1e3).round() as i64);
    let moment = moment.unwrap_or_default();
    moment.to_rfc3339_opts(SecondsFormat::Millis, true)
}

/// Unix seconds of `2021-10-12T00:53:20.5Z`: a date, `T` or a space, hours and minutes, perhaps
/// seconds, and perhaps `Z` or an offset as `+01:00`; UTC without one. `None` for anything else.
pub fn unix_from_iso(text: &str) -> Option<f64> {
    const FORMS: [(&str, &str); 2] = [
        ("%Y-%m-%dT%H:%M:%S%.f", "%Y-%m-%dT%H:%M:%S%.f%:z"),
        ("%Y-%m-%dT%H:%M", "%Y-%m-%dT%H:%M%:z"),
    ];
    let text = text.trim().to_ascii_uppercase().replacen(' ', "T", 1);
    let utc = text.strip_suffix('Z').unwrap_or(&text);
    let read = |(plain, with_offset): (&str, &str)| {
        let in_utc = NaiveDateTime::parse_from_str(utc, plain).map(|time| time.and_utc());
        in_utc.or_else(|_| DateTime::parse_from_str(&text, with_offset).map(|time| time.to_utc()))
    };
    let moment = FORMS.into_iter().find_map(|form| read(form).ok())?;
    // A leap second has more than 1e9 nanoseconds.
    Some(moment.timestamp() as f64 + f64::from(moment.timestamp_subsec_nanos()) * 1e-9)
}

/// Unix seconds of a number, or of a text that [`unix_from_iso`] knows.
pub(crate) fn unix_from_text(text: &str) -> Option<f64> {
    let number = text.parse().ok().filter(|seconds: &f64| seconds.is_finite());
    number.or_else(|| unix_from_iso(text))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_as_they_are_written() {
        // `date -u -d TEXT +%s`
        for (text, unix_s) in [
            ("2021-10-12T00:53:20Z", 1_634_000_000.0),
            ("2021-10-12 00:53:20.25", 1_634_000_000.25),
            ("2021-10-12T02:53:20+02:00", 1_634_000_000.0),
            ("2000-02-29t23:30-01:30", 951_872_400.0),
            ("2016-12-31T23:59:60Z", 1_483_228_800.0),
            ("2021-10-12T00:53", 1_633_999_980.0),
        ] {
            assert_eq!(unix_from_iso(text), Some(unix_s), "{text}");
        }
        for text in [
            "2021-02-29T00:00Z",
            "2021-13-01T00:00Z",
            "9223372036854775807-01-01T00:00Z",
            "2021-9223372036854775807-01T00:00Z",
            "2021-10-12",
            "12:00",
            "2021-10-12T25:00Z",
            "2021-10-12Tnoon",
        ] {
            assert_eq!(unix_from_iso(text), None, "{text}");
        }
    }

    #[test]
    fn timestamps_are_rounded_to_the_millisecond() {
        for (unix_s, expected) in [
            (1_410_181_021.25, "2014-09-08T12:57:01.250Z"),
            (1_410_181_021.123, "2014-09-08T12:57:01.123Z"),
            (-0.0004, "1970-01-01T00:00:00.000Z"),
            (-0.25, "1969-12-31T23:59:59.750Z"),
        ] {
            assert_eq!(timestamp(unix_s), expected);
        }
        assert_eq!(unix_from_iso(&timestamp(1e9)), Some(1e9));
    }

    #[test]
    fn dates_are_those_of_the_system() {
        // `date -u -d @SECONDS +"%F %T"`
        for (unix_s, expected, time) in [
            (0.0, "1970-01-01", "00:00:00"),
            (-1.0, "1969-12-31", "23:59:59"),
            (951_782_400.0, "2000-02-29", "00:00:00"),
            (1_410_181_021.0, "2014-09-08", "12:57:01"),
            (1_700_000_000.9, "2023-11-14", "22:13:20"),
        ] {
            assert_eq!(date(unix_s), expected);
            assert_eq!(time_of_day(unix_s), time);
        }
    }
}

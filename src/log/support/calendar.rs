//! Converts between Unix seconds, which logs count in, and written dates, in UTC. This module
//! depends on no other module of the crate.

use chrono::{DateTime, NaiveDateTime, SecondsFormat, Utc};

/// Returns the moment of some Unix seconds, to the nanosecond; the epoch where the seconds are
/// outside of what `chrono` can represent.
pub fn moment(unix_s: f64) -> DateTime<Utc> {
    let nanoseconds = (unix_s - unix_s.floor()) * 1e9;
    DateTime::from_timestamp(unix_s.floor() as i64, nanoseconds as u32).unwrap_or_default()
}

/// Formats the date of some Unix seconds: `2014-09-08`.
pub fn date(unix_s: f64) -> String {
    moment(unix_s).format("%F").to_string()
}

/// Formats the time of day of some Unix seconds, rounded down to whole seconds: `12:57:01`.
pub fn time_of_day(unix_s: f64) -> String {
    moment(unix_s).format("%T").to_string()
}

/// Formats some Unix seconds in ISO 8601, rounded down to whole seconds: `2014-09-08T12:57:01Z`.
pub fn whole_seconds(unix_s: f64) -> String {
    moment(unix_s).format("%FT%TZ").to_string()
}

/// Formats some Unix seconds in ISO 8601, rounded to milliseconds: `2014-09-08T12:57:01.250Z`.
pub fn timestamp(unix_s: f64) -> String {
    let moment = DateTime::from_timestamp_millis((unix_s * 1e3).round() as i64);
    let moment = moment.unwrap_or_default();
    moment.to_rfc3339_opts(SecondsFormat::Millis, true)
}

/// Parses a time such as `2021-10-12T00:53:20.5Z` into Unix seconds: a date, `T` or a space, hours
/// and minutes, optional seconds, and an optional `Z` or offset such as `+01:00`; without an offset
/// the time is UTC. `None` for anything else.
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

/// Parses Unix seconds from a finite number, or from a text that [`unix_from_iso`] can read; `None`
/// for anything else.
pub(crate) fn unix_from_text(text: &str) -> Option<f64> {
    let number = text.parse().ok().filter(|seconds: &f64| seconds.is_finite());
    number.or_else(|| unix_from_iso(text))
}

/// Order of day and month in dates that are written with slashes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum DateOrder {
    /// Unknown: there was no date with slashes.
    #[default]
    Unknown,
    /// Ambiguous, as in 08/07/2021: no number is above 12. The month is assumed to come first, as
    /// most programs that write slashes do.
    Ambiguous,
    /// Day first: 26/08/2021.
    DayFirst,
    /// Month first: 08/26/2021.
    MonthFirst,
}

impl DateOrder {
    /// Determines the order of some dates: a number above 12 is a day.
    pub(crate) fn of<'a>(dates: impl IntoIterator<Item = &'a str>) -> Self {
        let mut order = Self::Unknown;
        for date in dates {
            let mut parts = date.trim().split('/');
            let part = |text: Option<&str>| text.and_then(|text| text.parse::<u32>().ok());
            let (first, second) = (part(parts.next()), part(parts.next()));
            match first.zip(second) {
                Some((13.., _)) => return Self::DayFirst,
                Some((_, 13..)) => return Self::MonthFirst,
                Some(_) => order = Self::Ambiguous,
                None => {}
            }
        }
        order
    }
}

/// Parses a date such as `08/26/2021 09:39:00`, with day and month in `order`, or such as
/// `26.08.2021 09:39`, into Unix seconds, UTC; `None` for anything else.
pub(crate) fn unix_from_date(text: &str, order: DateOrder) -> Option<f64> {
    let date = match order {
        DateOrder::DayFirst => "%d/%m/%Y",
        DateOrder::MonthFirst | DateOrder::Ambiguous | DateOrder::Unknown => "%m/%d/%Y",
    };
    let times = ["%H:%M:%S%.f", "%H:%M", "%I:%M:%S %p", "%I:%M %p"];
    let forms = [date, "%d.%m.%Y"].into_iter().flat_map(|date| times.map(|time| (date, time)));
    let read =
        |(date, time)| NaiveDateTime::parse_from_str(text.trim(), &format!("{date} {time}")).ok();
    let moment = forms.into_iter().find_map(read)?.and_utc();
    Some(moment.timestamp() as f64 + f64::from(moment.timestamp_subsec_nanos()) * 1e-9)
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
    fn dates_with_slashes_are_in_the_order_that_a_day_above_twelve_shows() {
        assert_eq!(DateOrder::of(["08/07/2021", "08/26/2021"]), DateOrder::MonthFirst);
        assert_eq!(DateOrder::of(["08/07/2021", "26/08/2021"]), DateOrder::DayFirst);
        assert_eq!(DateOrder::of(["08/07/2021", "08/09/2021"]), DateOrder::Ambiguous);
        assert_eq!(DateOrder::of(["2021-08-26", ""]), DateOrder::Unknown);
        // `date -u -d 2021-08-26T09:39Z +%s`
        for (text, order) in [
            ("08/26/2021 09:39:00", DateOrder::MonthFirst),
            ("8/26/2021 9:39:00 AM", DateOrder::MonthFirst),
            ("26/08/2021 09:39", DateOrder::DayFirst),
            ("26.08.2021 09:39:00.0", DateOrder::Unknown),
        ] {
            assert_eq!(unix_from_date(text, order), Some(1_629_970_740.0), "{text}");
        }
        assert_eq!(unix_from_date("26/08/2021 09:39", DateOrder::MonthFirst), None);
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

//! Dates from Unix seconds and back, in UTC and the proleptic Gregorian calendar, by Howard Hinnant's "chrono-compatible
//! low-level date algorithms". Leans on nothing; any room may use it.

/// Days from 0000-03-01, where the algorithms count from, to 1970-01-01.
const EPOCH_DAYS: i64 = 719_468;
/// Days in 400 years, after which the calendar repeats.
const ERA_DAYS: i64 = 146_097;

/// Days from 1970-01-01 to a date; months and days count from 1.
pub fn days_from_civil(year: i64, month: i64, day: i64) -> i64 {
    // Years begin in March, so that the leap day is the last of its year.
    let year = year - i64::from(month <= 2);
    let year_of_era = year.rem_euclid(400);
    let day_of_year = (153 * (month + if month > 2 { -3 } else { 9 }) + 2) / 5 + day - 1;
    let day_of_era = year_of_era * 365 + year_of_era / 4 - year_of_era / 100 + day_of_year;
    year.div_euclid(400) * ERA_DAYS + day_of_era - EPOCH_DAYS
}

/// Year, month and day of some Unix seconds; months and days count from 1. Inverse of [`days_from_civil`].
pub fn civil_from_unix(unix_s: f64) -> (i64, i64, i64) {
    let days = (unix_s / 86_400.0).floor() as i64 + EPOCH_DAYS;
    let day_of_era = days.rem_euclid(ERA_DAYS);
    let year_of_era =
        (day_of_era - day_of_era / 1460 + day_of_era / 36_524 - day_of_era / 146_096) / 365;
    let day_of_year = day_of_era - (365 * year_of_era + year_of_era / 4 - year_of_era / 100);
    let month_from_march = (5 * day_of_year + 2) / 153;
    let day = day_of_year - (153 * month_from_march + 2) / 5 + 1;
    let month = if month_from_march < 10 {
        month_from_march + 3
    } else {
        month_from_march - 9
    };
    let year = year_of_era + days.div_euclid(ERA_DAYS) * 400 + i64::from(month <= 2);
    (year, month, day)
}

/// The date of some Unix seconds, `2014-09-08`.
pub fn date(unix_s: f64) -> String {
    let (year, month, day) = civil_from_unix(unix_s);
    format!("{year:04}-{month:02}-{day:02}")
}

/// The time of day of some Unix seconds, whole seconds passed, `12:57:01`.
pub fn time_of_day(unix_s: f64) -> String {
    let second = unix_s.rem_euclid(86_400.0) as u64;
    let (hours, minutes, seconds) = (second / 3600, second / 60 % 60, second % 60);
    format!("{hours:02}:{minutes:02}:{seconds:02}")
}

/// Unix seconds of `2021-10-12T00:53:20.5Z`: a date, `T` or a space, hours and minutes, perhaps seconds, and perhaps `Z` or an
/// offset as `+01:00`; UTC without one. `None` for anything else.
pub fn unix_from_iso(text: &str) -> Option<f64> {
    let (date, time) = text.trim().split_once(['T', 't', ' '])?;
    let mut date = date.splitn(3, '-').map(|part| part.parse::<i64>().ok());
    let (year, month, day) = (date.next()??, date.next()??, date.next()??);
    let possible =
        (0..10_000).contains(&year) && (1..=12).contains(&month) && (1..=31).contains(&day);
    let days = possible.then(|| days_from_civil(year, month, day))?;
    let exists = civil_from_unix(days as f64 * 86_400.0).2 == day;
    let time = time.trim_end_matches(['Z', 'z']);
    let (time, offset_s) = match time.rfind(['+', '-']) {
        Some(at) => {
            let (hours, minutes) = time.get(at + 1..)?.split_once(':')?;
            let offset_s = 3600.0 * clock(hours, 24.0)? + 60.0 * clock(minutes, 60.0)?;
            let sign = if time[at..].starts_with('-') {
                -1.0
            } else {
                1.0
            };
            (&time[..at], sign * offset_s)
        }
        None => (time, 0.0),
    };
    let mut parts = time.splitn(3, ':');
    let hours = clock(parts.next()?, 24.0)?;
    let minutes = clock(parts.next()?, 60.0)?;
    let seconds = parts.next().map_or(Some(0.0), |text| clock(text, 61.0))?;
    exists.then_some(days as f64 * 86_400.0 + 3600.0 * hours + 60.0 * minutes + seconds - offset_s)
}

/// Unix seconds of a number, or of a text that [`unix_from_iso`] knows.
pub fn unix_from_text(text: &str) -> Option<f64> {
    let number = text
        .parse()
        .ok()
        .filter(|seconds: &f64| seconds.is_finite());
    number.or_else(|| unix_from_iso(text))
}

/// A number of 0 to below `end`.
fn clock(text: &str, end: f64) -> Option<f64> {
    let value = text.parse().ok();
    value.filter(|value| (0.0..end).contains(value))
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

    #[test]
    fn days_come_back_as_the_date_they_were_made_from() {
        for days in (-800_000..800_000).step_by(97) {
            let (year, month, day) = civil_from_unix(days as f64 * 86_400.0);
            assert_eq!(days_from_civil(year, month, day), days);
        }
    }
}

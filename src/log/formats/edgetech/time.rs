//! The date and time of a trace.

use chrono::NaiveDate;

/// Milliseconds of a day.
const DAY_MS: i64 = 86_400_000;

/// Unix milliseconds of a trace: of its Unix seconds, or where those are not set of its year, day
/// of the year, hour, minute and second; with the milliseconds since midnight, which lie within 2 s
/// of them unless they are of another clock.
pub(super) fn unix_ms(unix_s: i64, calendar: [i16; 5], today_ms: u32) -> i64 {
    let [year, day, hour, minute, second] = calendar.map(i64::from);
    let date = i32::try_from(year).ok().zip(u32::try_from(day).ok());
    let date = date.and_then(|(year, day)| NaiveDate::from_yo_opt(year, day));
    let from_calendar_s = || {
        let days = i64::from(date?.to_epoch_days());
        Some(((days * 24 + hour) * 60 + minute) * 60 + second)
    };
    let seconds_ms = 1000 * if unix_s > 0 { unix_s } else { from_calendar_s().unwrap_or(0) };
    let today_ms = i64::from(today_ms);
    let after_ms =
        (today_ms - seconds_ms.rem_euclid(DAY_MS) + DAY_MS / 2).rem_euclid(DAY_MS) - DAY_MS / 2;
    if today_ms <= DAY_MS && after_ms.abs() <= 2000 {
        seconds_ms + after_ms
    } else {
        seconds_ms + today_ms % 1000
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_have_milliseconds() {
        // `date -u -d "2021-06-05 23:59:59" +%s`; day 156 of the year.
        const S: i64 = 1_622_937_599;
        let calendar = [2021, 156, 23, 59, 59];
        assert_eq!(unix_ms(S, calendar, 86_399_250), S * 1000 + 250);
        assert_eq!(unix_ms(0, calendar, 86_399_250), S * 1000 + 250);
        // The milliseconds are of the next day, of another zone, or not set.
        assert_eq!(unix_ms(S, calendar, 40), S * 1000 + 1040);
        assert_eq!(unix_ms(S, calendar, 7_199_250), S * 1000 + 250);
        assert_eq!(unix_ms(S, calendar, 0), S * 1000 + 1000);
        assert_eq!(unix_ms(0, [0; 5], 7_250), 250);
        assert_eq!(unix_ms(0, [i16::MAX; 5], u32::MAX), 295);
    }
}

//! The date and time of a ping.

use super::raw::{PacketTime, PingHeader};
use crate::support::calendar::moment;
use chrono::{Datelike as _, NaiveDate};

/// Years in which a log can have been recorded: side-scan went to disk from the eighties on. Zeros
/// and counters that never were set lie outside.
const YEARS: std::ops::RangeInclusive<i32> = 1980..=2100;

/// Unix seconds of a time in thousandths of them; `None` when no log can be of that time.
pub(super) fn unix_s(unix_ms: i64) -> Option<f64> {
    let unix_s = unix_ms as f64 / 1000.0;
    YEARS.contains(&moment(unix_s).year()).then_some(unix_s)
}

/// The year that a recorder meant: of two digits, or counted from 1900 as C's `tm_year` is.
fn year_meant(recorded: u16) -> i32 {
    match i32::from(recorded) {
        year @ 0..80 => 2000 + year,
        year @ 80..200 => 1900 + year,
        year => year,
    }
}

/// Unix seconds of a date and time; of one without a date that exists, those of its time of day.
pub(super) fn seconds(time: PacketTime) -> i64 {
    let date = NaiveDate::from_ymd_opt(year_meant(time.year), time.month.into(), time.day.into());
    let days = date.map_or(0, |date| i64::from(date.to_epoch_days()));
    let minutes = i64::from(time.hour) * 60 + i64::from(time.minute);
    days * 86_400 + minutes * 60 + i64::from(time.second)
}

/// Thousandths of Unix seconds of a ping's date and time, as [`seconds`] has them. The time of day
/// is in hundredths; where the time for attitude packets is the same moment of the day, it has the
/// thousandths too.
pub(super) fn unix_ms(ping: &PingHeader) -> i64 {
    let &PingHeader {
        year, month, day, hour, minute, second, hundredths, attitude_time_ms, ..
    } = ping;
    let time = PacketTime { year, month, day, hour, minute, second };
    let unix_ms = seconds(time) * 1000 + i64::from(hundredths) * 10;
    let day_ms = unix_ms.rem_euclid(86_400_000);
    let attitude_ms = i64::from(attitude_time_ms);
    let is_same = attitude_ms / 10 == day_ms / 10;
    unix_ms + if is_same { attitude_ms - day_ms } else { 0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use bytemuck::Zeroable;

    #[test]
    fn dates_become_unix_seconds() {
        let mut ping = PingHeader::zeroed();
        (ping.year, ping.month, ping.day) = (2009, 11, 8);
        (ping.hour, ping.minute, ping.second, ping.hundredths) = (12, 36, 34, 33);
        // `date -u -d "2009-11-08 12:36:34" +%s`
        assert_eq!(unix_ms(&ping), 1_257_683_794_330);
        // Milliseconds of the same moment of the day, and of another.
        ping.attitude_time_ms = 45_394_337;
        assert_eq!(unix_ms(&ping), 1_257_683_794_337);
        ping.attitude_time_ms = 45_394_340;
        assert_eq!(unix_ms(&ping), 1_257_683_794_330);
        (ping.year, ping.month, ping.day) = (2024, 2, 29);
        assert_eq!(unix_ms(&ping) / 1000, 1_709_210_194);
        (ping.year, ping.month, ping.day) = (1996, 7, 31);
        // `date -u -d "1996-07-31 12:36:34" +%s`
        assert_eq!(unix_s(unix_ms(&ping)), Some(838_816_594.33));
        for year in [200, 1970, 1979, 2101, u16::MAX] {
            ping.year = year;
            assert_eq!(unix_s(unix_ms(&ping)), None, "{year}");
        }
        for (year, meant) in [(96, 1996), (80, 1980), (0, 2000), (9, 2009), (109, 2009)] {
            let of = |year| {
                ping.year = year;
                unix_s(unix_ms(&ping))
            };
            let [recorded, meant] = [year, meant].map(of);
            assert!(recorded.is_some() && recorded == meant, "{year}");
        }
        // A date that never was set is no first of January.
        (ping.year, ping.month, ping.day) = (0, 0, 0);
        assert_eq!(unix_s(unix_ms(&ping)), None);
    }
}

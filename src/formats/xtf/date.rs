//! The date and time of a ping.

use super::raw::PingHeader;
use crate::calendar::days_from_civil;

/// The year 2000 in hundredths of Unix seconds: earlier dates are none.
const YEAR_2000_UNIX_CS: i64 = 94_668_480_000;

/// Unix seconds of a time in hundredths of them; `None` when it is before the age of such recorders.
pub(super) fn unix_s(unix_cs: i64) -> Option<f64> {
    (unix_cs > YEAR_2000_UNIX_CS).then(|| unix_cs as f64 / 100.0)
}

/// Hundredths of Unix seconds of a ping's date and time.
pub(super) fn unix_cs(ping: &PingHeader) -> i64 {
    let days = days_from_civil(ping.year.into(), ping.month.into(), ping.day.into());
    let minutes = i64::from(ping.hour) * 60 + i64::from(ping.minute);
    let seconds = days * 86_400 + minutes * 60 + i64::from(ping.second);
    seconds * 100 + i64::from(ping.hundredths)
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
        assert_eq!(unix_cs(&ping), 125_768_379_433);
        (ping.year, ping.month, ping.day) = (2024, 2, 29);
        assert_eq!(unix_cs(&ping) / 100, 1_709_210_194);
    }
}

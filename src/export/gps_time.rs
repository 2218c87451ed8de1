//! GPS time, which LAS counts in: it runs on where UTC inserts a leap second.

use crate::calendar::days_from_civil;

/// Unix seconds of GPS time zero, 1980-01-06.
const GPS_ZERO_UNIX_S: f64 = 315_964_800.0;
/// What LAS takes off, so that a double keeps its fraction of a second (LAS 1.4 R15, table 3, global encoding bit 0).
const ADJUSTED_S: f64 = 1e9;
/// Year and month from whose first day on GPS was one second more ahead of UTC (IERS Bulletin C).
const LEAPS: [(i64, i64); 18] = [
    (1981, 7),
    (1982, 7),
    (1983, 7),
    (1985, 7),
    (1988, 1),
    (1990, 1),
    (1991, 1),
    (1992, 7),
    (1993, 7),
    (1994, 7),
    (1996, 1),
    (1997, 7),
    (1999, 1),
    (2006, 1),
    (2009, 1),
    (2012, 7),
    (2015, 7),
    (2017, 1),
];

/// Adjusted standard GPS time of some Unix seconds: seconds of GPS time less 1e9.
pub(super) fn adjusted_standard_s(unix_s: f64) -> f64 {
    let is_past = |&&(year, month): &&(i64, i64)| {
        let begins_s = days_from_civil(year, month, 1) as f64 * 86_400.0;
        unix_s >= begins_s
    };
    let leaps = LEAPS.iter().take_while(is_past).count() as f64;
    unix_s - GPS_ZERO_UNIX_S + leaps - ADJUSTED_S
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gps_time_is_that_of_the_published_conversions() {
        // UTC as `date -u -d TEXT +%s` has it, GPS seconds as the converters of LIGO and NOAA print them.
        for (unix_s, gps_s) in [
            (315_964_800.0, 0.0),
            (362_793_599.0, 46_828_799.0),
            (362_793_600.0, 46_828_801.0),
            (1_315_964_785.0, 1_000_000_000.0),
            (1_483_228_799.5, 1_167_264_016.5),
            (1_483_228_800.0, 1_167_264_018.0),
            (1_634_000_000.0, 1_318_035_218.0),
        ] {
            assert_eq!(adjusted_standard_s(unix_s), gps_s - 1e9, "{unix_s}");
        }
    }
}

//! GPS time, which LAS counts in: it runs on where UTC inserts a leap second.

/// Unix seconds of GPS time zero, 1980-01-06.
const GPS_ZERO_UNIX_S: f64 = 315_964_800.0;
/// Seconds that LAS subtracts, so that a double keeps its fraction of a second (LAS 1.4 R15, table
/// 3, global encoding bit 0).
const ADJUSTED_S: f64 = 1e9;
/// Unix seconds from which on GPS was one second more ahead of UTC (IERS Bulletin C). `chrono`
/// knows no leap seconds, and none has been announced since 2016.
const LEAPS_UNIX_S: [f64; 18] = [
    362_793_600.0,   // 1981-07-01
    394_329_600.0,   // 1982-07-01
    425_865_600.0,   // 1983-07-01
    489_024_000.0,   // 1985-07-01
    567_993_600.0,   // 1988-01-01
    631_152_000.0,   // 1990-01-01
    662_688_000.0,   // 1991-01-01
    709_948_800.0,   // 1992-07-01
    741_484_800.0,   // 1993-07-01
    773_020_800.0,   // 1994-07-01
    820_454_400.0,   // 1996-01-01
    867_715_200.0,   // 1997-07-01
    915_148_800.0,   // 1999-01-01
    1_136_073_600.0, // 2006-01-01
    1_230_768_000.0, // 2009-01-01
    1_341_100_800.0, // 2012-07-01
    1_435_708_800.0, // 2015-07-01
    1_483_228_800.0, // 2017-01-01
];

/// Adjusted standard GPS time of some Unix seconds: seconds of GPS time less 1e9.
pub(super) fn adjusted_standard_s(unix_s: f64) -> f64 {
    let leaps = LEAPS_UNIX_S.partition_point(|begins_s| *begins_s <= unix_s) as f64;
    unix_s - GPS_ZERO_UNIX_S + leaps - ADJUSTED_S
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gps_time_is_that_of_the_published_conversions() {
        // UTC as `date -u -d TEXT +%s` has it, GPS seconds as the converters of LIGO and NOAA print
        // them.
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

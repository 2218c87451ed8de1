//! Numbers, places and times as the analyst reads them.

use crate::calendar;
use crate::calibration::FlatSpot;

/// What stands where there is no value.
pub const NONE: &str = "–";

/// A count with thin groups of three: `12 345`.
pub fn count(number: usize) -> String {
    let digits = number.to_string();
    let mut text = String::with_capacity(digits.len() + digits.len() / 3);
    for (index, digit) in digits.chars().enumerate() {
        if index > 0 && (digits.len() - index).is_multiple_of(3) {
            text.push(' ');
        }
        text.push(digit);
    }
    text
}

/// A number with a unit, or a dash when it is not a number.
pub fn measure(value: f64, decimals: usize, unit: &str) -> String {
    if value.is_finite() {
        format!("{value:.decimals$} {unit}")
    } else {
        NONE.to_owned()
    }
}

/// A length on the ground: metres, from a kilometre on kilometres.
pub fn length(value_m: f64) -> String {
    match value_m {
        _ if !value_m.is_finite() => NONE.to_owned(),
        ..100.0 => format!("{value_m:.2} m"),
        100.0..1000.0 => format!("{value_m:.1} m"),
        _ => format!("{:.3} km", value_m / 1000.0),
    }
}

/// A course, `214°`, behind a comma; nothing where two places are one.
pub fn and_course(course_rad: f64) -> String {
    match course_rad.is_finite() {
        true => format!(", {:.0}°", course_rad.to_degrees()),
        false => String::new(),
    }
}

/// An area on the ground: square metres, from a tenth of a square kilometre on hectares, from ten on square kilometres.
pub fn area(value_m2: f64) -> String {
    match value_m2 {
        _ if !value_m2.is_finite() => NONE.to_owned(),
        ..1000.0 => format!("{value_m2:.1} m²"),
        1000.0..1e5 => format!("{} m²", count(value_m2.round() as usize)),
        1e5..1e7 => format!("{:.2} ha", value_m2 / 1e4),
        _ => format!("{:.3} km²", value_m2 / 1e6),
    }
}

/// A difference in centimetres below one metre, else in metres.
pub fn difference(value_m: f64) -> String {
    if value_m.abs() < 1.0 {
        format!("{:.1} cm", value_m * 100.0)
    } else {
        format!("{value_m:.2} m")
    }
}

/// [`difference`] with its sign also above 0.
pub fn signed_difference(value_m: f64) -> String {
    let sign = if value_m > 0.0 { "+" } else { "" };
    format!("{sign}{}", difference(value_m))
}

/// How flat a stretch is and what its first returns say, in three lines.
pub fn flat_stretch(spot: &FlatSpot) -> String {
    let [port, starboard] = spot.picks;
    let scale = match spot.ppd.zip(spot.factor) {
        Some((ppd, factor)) => format!(
            "PPD {:.2} ±{:.2} px/m, the recorded range times {factor:.3}",
            ppd.px_per_m, ppd.spread_px_per_m
        ),
        None => "too few for a scale".to_owned(),
    };
    format!(
        "pings {}..{}, {:.2} m deep as recorded, slope {:.1} %, scatter {:.1} cm\n{scale}\n{port} first returns to port, {starboard} to starboard",
        spot.pings.start,
        spot.pings.end,
        spot.depth_m,
        100.0 * spot.slope.abs(),
        100.0 * spot.scatter_m,
    )
}

/// Minutes and seconds, with hours when there are any: `2:30`, `1:02:30`.
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

/// Time of day in UTC when the recorder knew the time, else the time since the start of the log.
pub fn clock(start_unix_s: Option<f64>, time_s: f64) -> String {
    match start_unix_s {
        Some(start_unix_s) => format!("{} UTC", calendar::time_of_day(start_unix_s + time_s)),
        None => duration(time_s),
    }
}

/// Bytes in the unit that leaves one to three digits before the point.
pub fn bytes(count: u64) -> String {
    match count {
        0..1_000 => format!("{count} B"),
        1_000..1_000_000 => format!("{:.0} kB", count as f64 / 1e3),
        1_000_000..1_000_000_000 => format!("{:.1} MB", count as f64 / 1e6),
        _ => format!("{:.2} GB", count as f64 / 1e9),
    }
}

/// `1 warning`, `2 warnings`.
pub fn plural(number: usize, one: &str, many: &str) -> String {
    format!("{} {}", count(number), if number == 1 { one } else { many })
}

/// The smallest of 1, 2, 5, 10, 20, 50 ... and 0.5, 0.2, 0.1 ... that is at least `least`: the step between ticks.
pub fn round_step(least: f64) -> f64 {
    let decade = 10_f64.powf(least.max(1e-9).log10().floor());
    [1.0, 2.0, 5.0]
        .into_iter()
        .map(|factor| factor * decade)
        .find(|step| *step >= least * (1.0 - 1e-9))
        .unwrap_or(10.0 * decade)
}

/// Metres at a tick, with as many decimals as the step between ticks needs.
pub fn metres(value_m: f64, step_m: f64) -> String {
    let decimals = (-step_m.log10().floor()).clamp(0.0, 3.0) as usize;
    format!("{value_m:.decimals$} m")
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
    fn lengths_and_areas_change_their_unit_where_they_grow_long() {
        let lengths = [12.345, 99.994, 123.45, 999.94, 1234.5, f64::NAN].map(length);
        assert_eq!(
            lengths,
            ["12.35 m", "99.99 m", "123.5 m", "999.9 m", "1.234 km", NONE]
        );
        let areas = [12.34, 12_345.6, 123_456.0, 2.5e7].map(area);
        assert_eq!(areas, ["12.3 m²", "12 346 m²", "12.35 ha", "25.000 km²"]);
    }

    #[test]
    fn clocks_show_utc_or_the_time_since_the_start() {
        assert_eq!(clock(Some(1_410_181_021.0), 0.0), "12:57:01 UTC");
        assert_eq!(clock(None, 150.4), "2:30");
        assert_eq!(duration(3750.0), "1:02:30");
        assert_eq!(duration(-1.2), "-0:01");
    }

    #[test]
    fn ticks_step_by_one_two_or_five_and_show_no_more() {
        let steps = [
            (0.03, 0.05),
            (1.0, 1.0),
            (1.1, 2.0),
            (3.0, 5.0),
            (7.0, 10.0),
            (51.0, 100.0),
        ];
        for (least, step) in steps {
            assert!((round_step(least) - step).abs() < 1e-12, "{least}");
        }
        assert_eq!(metres(5.0, 5.0), "5 m");
        assert_eq!(metres(2.5, 0.5), "2.5 m");
        assert_eq!(metres(0.25, 0.05), "0.25 m");
    }
}

//! Numbers and places in words.

use crate::calendar;
use crate::geo::LonLat;

/// To the centimetre; a dash where it is not known.
pub fn metres(value_m: f64) -> String {
    match value_m.is_finite() {
        true => format!("{value_m:.2}"),
        false => "\u{2013}".to_owned(),
    }
}

/// `36.932541° N, 111.488102° W`: a tenth of a metre.
pub fn position(position: LonLat) -> String {
    let letter = |value: f64, positive: char, negative: char| match value < 0.0 {
        true => negative,
        false => positive,
    };
    format!(
        "{:.6}\u{b0} {}, {:.6}\u{b0} {}",
        position.lat_deg.abs(),
        letter(position.lat_deg, 'N', 'S'),
        position.lon_deg.abs(),
        letter(position.lon_deg, 'E', 'W'),
    )
}

/// With a thin space at every third digit: `12 345`.
pub fn count(number: usize) -> String {
    let digits = number.to_string();
    let mut grouped = String::with_capacity(digits.len() + digits.len() / 3 * 3);
    for (index, digit) in digits.chars().enumerate() {
        if index > 0 && (digits.len() - index).is_multiple_of(3) {
            grouped.push('\u{202f}');
        }
        grouped.push(digit);
    }
    grouped
}

/// `8 September 2014`.
pub fn date(unix_s: f64) -> String {
    const MONTHS: [&str; 12] = [
        "January",
        "February",
        "March",
        "April",
        "May",
        "June",
        "July",
        "August",
        "September",
        "October",
        "November",
        "December",
    ];
    let (year, month, day) = calendar::civil_from_unix(unix_s);
    let name = usize::try_from(month - 1)
        .ok()
        .and_then(|index| MONTHS.get(index));
    format!("{day} {} {year}", name.unwrap_or(&""))
}

/// `17 min`, `2 h 05 min`, `48 s`.
pub fn duration(seconds: f64) -> String {
    let whole = seconds.max(0.0).round() as u64;
    match whole {
        0..120 => format!("{whole} s"),
        120..7200 => format!("{} min", (seconds / 60.0).round()),
        _ => format!("{} h {:02} min", whole / 3600, whole / 60 % 60),
    }
}

/// An area in the unit that fits it.
pub fn area(square_m: f64) -> String {
    match square_m {
        ..20_000.0 => format!("{} m\u{b2}", count(square_m.round() as usize)),
        ..2_000_000.0 => format!("{:.2} ha", square_m / 10_000.0),
        _ => format!("{:.2} km\u{b2}", square_m / 1e6),
    }
}

/// A length in the unit that fits it.
pub fn length(length_m: f64) -> String {
    match length_m < 2000.0 {
        true => format!("{length_m:.0} m"),
        false => format!("{:.2} km", length_m / 1000.0),
    }
}

/// Bytes as people read them.
pub fn bytes(bytes: u64) -> String {
    match bytes {
        0..10_000 => format!("{bytes} bytes"),
        10_000..10_000_000 => format!("{:.0} kB", bytes as f64 / 1e3),
        _ => format!("{:.0} MB", bytes as f64 / 1e6),
    }
}

/// The largest of 1, 2, 5 times a power of ten that is not above a number.
pub fn one_two_five(at_most: f64) -> f64 {
    let decade = 10f64.powf(at_most.log10().floor());
    let step = [5.0, 2.0, 1.0]
        .into_iter()
        .find(|step| step * decade <= at_most * (1.0 + 1e-9));
    step.unwrap_or(1.0) * decade
}

/// Round numbers within a span, about five of them.
pub fn ticks(from: f64, to: f64) -> Vec<f64> {
    let step = one_two_five((to - from) / 4.0);
    if !(step > 0.0 && step.is_finite()) {
        return Vec::new();
    }
    let first = (from / step - 1e-9).ceil() as i64;
    let last = (to / step + 1e-9).floor() as i64;
    (first..=last).map(|index| index as f64 * step).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_read_as_people_write_them() {
        assert_eq!(count(1_234_567), "1\u{202f}234\u{202f}567");
        assert_eq!(count(100), "100");
        assert_eq!(date(1_410_181_021.0), "8 September 2014");
        assert_eq!(
            [duration(48.0), duration(1020.0), duration(7500.0)],
            ["48 s", "17 min", "2 h 05 min"]
        );
        assert_eq!([area(950.4), area(43_210.0)], ["950 m\u{b2}", "4.32 ha"]);
        let place = LonLat {
            lon_deg: -111.488_102,
            lat_deg: 36.932_541,
        };
        assert_eq!(position(place), "36.932541\u{b0} N, 111.488102\u{b0} W");
        assert_eq!(metres(f64::NAN), "\u{2013}");
    }

    #[test]
    fn ticks_are_round_and_lie_within() {
        assert_eq!([one_two_five(73.0), one_two_five(0.2)], [50.0, 0.2]);
        assert_eq!(
            ticks(0.0, 1000.0),
            [0.0, 200.0, 400.0, 600.0, 800.0, 1000.0]
        );
        // 1.2 to 2.4 by 0.2.
        assert_eq!(ticks(1.16, 2.4).len(), 7);
        assert_eq!(ticks(2.0, 2.0), [0.0; 0]);
    }
}

//! Converts sentences in metres into the units in use: the rest of the program writes its sentences
//! in metres, and Bathyscope shows them in the units that the analyst chose.

use super::{FEET_PER_FATHOM, LengthUnit, METRES_PER_NAUTICAL_MILE, SpeedUnit, Units};
use bathyscope_log::support::geo::METRES_PER_FOOT;
use std::ops::Range;

/// Limit between speeds of boats and speeds of sound, metres a second.
const FASTEST_BOAT_MPS: f64 = 1000.0;
/// Texts between two numbers that share the unit after the second number.
const JOINTS: [&str; 4] = [" to ", " × ", " ± ", " ±"];
/// Units that are converted, longer ones before those that they begin with.
const UNITS: [&str; 4] = ["m/s", "cm", "km", "m"];

impl Units {
    /// Returns the unit of the speed of sound, as its speed in metres a second, and its symbol. It
    /// depends on the unit of lengths, since the speed of sound is never given in knots.
    pub fn sound_speed(self) -> (f64, &'static str) {
        match self.length {
            LengthUnit::Metres => (1.0, "m/s"),
            LengthUnit::Feet | LengthUnit::Fathoms => (METRES_PER_FOOT, "ft/s"),
        }
    }

    /// Converts the figures of a sentence in metres, centimetres, kilometres and metres a second to
    /// the units in use. A figure is a number, a space and the unit; in `1 to 2 m` and `1 × 2 m`
    /// both numbers are figures. All other text stays as it is, including pixels per metre and
    /// names: text between “ and ” or between two `, and paths.
    pub fn sentence(self, text: &str) -> String {
        let names = names(text);
        let is_name = |number: &Range<usize>| names.iter().any(|name| name.contains(&number.start));
        let mut numbers = numbers(text);
        numbers.retain(|number| !is_name(number));
        let mut units = vec![None; numbers.len()];
        for (index, number) in numbers.iter().enumerate().rev() {
            let between = numbers.get(index + 1);
            let joint = between.map(|next| &text[number.end..next.start]);
            units[index] = match joint.filter(|joint| JOINTS.contains(joint)) {
                Some(_) => units[index + 1],
                None => unit_after(&text[number.end..]),
            };
        }
        let mut turned = String::with_capacity(text.len());
        let mut done = 0;
        for (number, unit) in numbers.iter().zip(units) {
            let Some(unit) = unit else { continue };
            let Some((value, symbol)) = self.turned(&text[number.clone()], unit) else {
                continue;
            };
            turned += &text[done..number.start];
            turned += &value;
            done = number.end;
            let behind = &text[done..];
            if behind.strip_prefix(' ').is_some_and(|rest| rest.starts_with(unit)) {
                turned += " ";
                turned += symbol;
                done += 1 + unit.len();
            }
        }
        turned + &text[done..]
    }

    /// Converts a number with its unit to the unit in use; `None` where the unit stays the same.
    fn turned(self, number: &str, unit: &str) -> Option<(String, &'static str)> {
        let value: f64 = number.parse().ok()?;
        let is_metric = self.length == LengthUnit::Metres;
        let (factor, symbol) = match unit {
            "m/s" if value >= FASTEST_BOAT_MPS && !is_metric => {
                let (per, symbol) = self.sound_speed();
                (1.0 / per, symbol)
            }
            "m/s" if value < FASTEST_BOAT_MPS && self.speed == SpeedUnit::Knots => {
                (1.0 / self.speed.metres_per_second(), self.speed.symbol())
            }
            _ if is_metric || unit == "m/s" => return None,
            "cm" => (0.12 / METRES_PER_FOOT, "in"),
            "km" => (1000.0 / METRES_PER_NAUTICAL_MILE, "NM"),
            _ => (1.0 / self.length.metres(), self.symbol()),
        };
        let written = number.split_once('.').map_or(0, |(_, behind)| behind.len());
        let value = factor * value;
        // A whole number of metres is not known to a tenth of a foot, but 3 ft would be too coarse
        // for 1 m.
        let decimals = match written {
            0 if value >= 10.0 * FEET_PER_FATHOM => 0,
            some => some.clamp(1, 2),
        };
        let shown = if value == 0.0 { "0".to_owned() } else { format!("{value:.decimals$}") };
        Some((shown, symbol))
    }
}

/// Finds the ranges of names: between “ and ” or between two `, and from the beginning of an
/// absolute path to the next colon or semicolon.
fn names(text: &str) -> Vec<Range<usize>> {
    let mut found = Vec::new();
    let mut from = 0;
    while let Some(start) = text[from..].find(['“', '`', '/']).map(|at| from + at) {
        let opens = text[start..].chars().next().unwrap_or_default();
        let inside = start + opens.len_utf8();
        from = inside;
        // A slash in the middle of a word belongs to a ratio, such as `px/m`, or to the rest of a
        // path.
        let before = text[..start].chars().next_back();
        if opens == '/' && before.is_some_and(|c| !(c.is_whitespace() || c == '(')) {
            continue;
        }
        let ends: &[&str] = match opens {
            '“' => &["”"],
            '`' => &["`"],
            _ => &[": ", "; "],
        };
        let end = ends.iter().filter_map(|end| text[inside..].find(end)).min();
        let end = end.map_or(text.len(), |end| inside + end);
        found.push(start..end);
        // The character that closes a name does not open another one.
        let closes = text[end..].chars().next().filter(|c| *c == opens);
        from = end + closes.map_or(0, char::len_utf8);
    }
    found
}

/// Finds the ranges of plain numbers, without their signs, and without the digits of a name or of a
/// time of day.
fn numbers(text: &str) -> Vec<Range<usize>> {
    let is_part = |c: char| c.is_ascii_digit() || c == '.';
    let mut found: Vec<Range<usize>> = Vec::new();
    let mut from = 0;
    while let Some(start) = text[from..].find(|c: char| c.is_ascii_digit()) {
        let start = from + start;
        let length = text[start..].find(|c| !is_part(c));
        let end = length.map_or(text.len(), |length| start + length);
        from = end;
        // A full stop after a number ends the sentence.
        let end = start + text[start..end].trim_end_matches('.').len();
        let before = text[..start].chars().next_back();
        if before.is_none_or(|c| !(c.is_alphanumeric() || "_:/\\".contains(c))) {
            found.push(start..end);
        }
    }
    found
}

/// Returns the unit after a number; `None` where no unit of [`UNITS`] follows, or a longer word
/// begins with it.
fn unit_after(text: &str) -> Option<&'static str> {
    let behind = text.strip_prefix(' ')?;
    let unit = UNITS.into_iter().find(|unit| behind.starts_with(unit))?;
    let mut rest = behind[unit.len()..].chars();
    let ends = match rest.next() {
        None => true,
        // A full stop, not the beginning of an extension.
        Some('.') => rest.next().is_none_or(char::is_whitespace),
        Some(next) => next.is_whitespace() || ",;:)]…·".contains(next),
    };
    ends.then_some(unit)
}

#[cfg(test)]
mod tests {
    use super::*;

    const FEET: Units = Units { length: LengthUnit::Feet, speed: SpeedUnit::Knots };

    #[test]
    fn figures_in_metres_are_turned_and_all_else_stays() {
        for (metric, feet) in [
            ("ranges -0.12 m", "ranges -0.39 ft"),
            ("3.05 to 6.10 m, noise", "10.01 to 20.01 ft, noise"),
            ("0.61 × 1.22 m", "2.00 × 4.00 ft"),
            ("range ±30.5 m; soundings", "range ±100.1 ft; soundings"),
            ("within 25 cm of the ground.", "within 9.8 in of the ground."),
            ("No value farther than 30 m.", "No value farther than 98 ft."),
            ("1500 m/s in most, 1 m/s here", "4921 ft/s in most, 1.9 kn here"),
            ("22.31 ±0.4 px/m over 12 pings", "22.31 ±0.4 px/m over 12 pings"),
            ("lake 5 m.sl2, 12:30 min, 3 made", "lake 5 m.sl2, 12:30 min, 3 made"),
            ("0 m (k 1.002 b +0.10 ±0.05 m)", "0 ft (k 1.002 b +0.33 ±0.16 ft)"),
        ] {
            assert_eq!(FEET.sentence(metric), feet);
            assert_eq!(Units::default().sentence(metric), metric);
        }
    }

    #[test]
    fn names_stay_as_they_are() {
        for (metric, feet) in [
            ("“lake 5 m deep” is 5 m deep", "“lake 5 m deep” is 16.4 ft deep"),
            ("no sonar log: /data/lake 5 m deep.sl2", "no sonar log: /data/lake 5 m deep.sl2"),
            ("Wrote into /data/at 3 m: 2 m of it", "Wrote into /data/at 3 m: 6.6 ft of it"),
            (
                "cannot read `/data/lake 5 m deep.sl2`: 2 m of it",
                "cannot read `/data/lake 5 m deep.sl2`: 6.6 ft of it",
            ),
            ("20 px/m at 2 m; “open", "20 px/m at 6.6 ft; “open"),
        ] {
            assert_eq!(FEET.sentence(metric), feet);
        }
    }

    #[test]
    fn sound_goes_with_lengths_and_a_boat_with_speeds() {
        let knots = Units { speed: SpeedUnit::Knots, ..Units::default() };
        assert_eq!(knots.sentence("1463 m/s, 0.5 m/s"), "1463 m/s, 1.0 kn");
        let fathoms = Units { length: LengthUnit::Fathoms, ..Units::default() };
        assert_eq!(fathoms.sentence("1463 m/s, 0.5 m/s"), "4800 ft/s, 0.5 m/s");
    }
}

//! Converts lengths, depths, areas and speeds to the units that they are shown in. Results,
//! settings and files are in metres and seconds; only shown values are converted.

mod sentence;

use super::text::{self, NONE};
use super::ticks;
use bathyscope_log::named;
use bathyscope_log::support::geo::{METRES_PER_FOOT, MPS_PER_KNOT};
use serde::{Deserialize, Serialize};

/// Number of feet in a fathom.
const FEET_PER_FATHOM: f64 = 6.0;
/// Number of metres in a nautical mile (1929).
const METRES_PER_NAUTICAL_MILE: f64 = 1852.0;
/// Number of square feet in an acre.
const SQUARE_FEET_PER_ACRE: f64 = 43_560.0;

/// Unit that lengths and depths are shown in.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum LengthUnit {
    /// Metres.
    #[default]
    Metres,
    /// International feet of 0.3048 m.
    Feet,
    /// Fathoms of six feet, as for depths on older charts, for all lengths.
    Fathoms,
}

/// Unit that speeds are shown in.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum SpeedUnit {
    /// Metres a second.
    #[default]
    MetresPerSecond,
    /// Knots: nautical miles an hour.
    Knots,
}

/// Units that values are shown in.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default)]
pub struct Units {
    /// Unit of lengths and depths.
    pub length: LengthUnit,
    /// Unit of speeds.
    pub speed: SpeedUnit,
}

named! {
    /// All units of length, in the order of the menu.
    pub LengthUnit {
        Metres: "metres",
        Feet: "feet",
        Fathoms: "fathoms",
    }
}

impl LengthUnit {
    /// Returns the length of the unit, metres.
    pub fn metres(self) -> f64 {
        match self {
            Self::Metres => 1.0,
            Self::Feet => METRES_PER_FOOT,
            Self::Fathoms => FEET_PER_FATHOM * METRES_PER_FOOT,
        }
    }

    /// Returns the symbol of the unit: `m`, `ft` or `fm`.
    pub fn symbol(self) -> &'static str {
        match self {
            Self::Metres => "m",
            Self::Feet => "ft",
            Self::Fathoms => "fm",
        }
    }

    /// Returns the number of decimals about as precise as `of_metres` decimals of metres:
    /// hundredths of a metre are tenths of a foot, but whole feet are too coarse for a length known
    /// to a tenth of a metre; a fathom is about two metres.
    fn decimals(self, of_metres: usize) -> usize {
        match (self, of_metres) {
            (Self::Feet, 2..) => of_metres - 1,
            _ => of_metres,
        }
    }

    /// Returns [`LengthUnit::decimals`] for small lengths: at least two where metres have two or
    /// more.
    fn fine_decimals(self, of_metres: usize) -> usize {
        self.decimals(of_metres).max(of_metres.min(2))
    }
}

named! {
    /// All units of speed, in the order of the menu.
    pub SpeedUnit {
        MetresPerSecond: "metres a second",
        Knots: "knots",
    }
}

impl SpeedUnit {
    /// Returns the speed of one unit, metres a second.
    pub fn metres_per_second(self) -> f64 {
        match self {
            Self::MetresPerSecond => 1.0,
            Self::Knots => MPS_PER_KNOT,
        }
    }

    /// Returns the symbol of the unit: `m/s` or `kn`.
    pub fn symbol(self) -> &'static str {
        match self {
            Self::MetresPerSecond => "m/s",
            Self::Knots => "kn",
        }
    }
}

impl Units {
    /// Converts a length to the unit in use.
    pub fn in_unit(self, value_m: f64) -> f64 {
        value_m / self.length.metres()
    }

    /// Returns the symbol of the unit of lengths, such as `m`.
    pub fn symbol(self) -> &'static str {
        self.length.symbol()
    }

    /// Formats a length without its unit, as precise as `decimals_of_metres` decimals of metres; a
    /// dash when it is not finite.
    pub fn number(self, value_m: f64, decimals_of_metres: usize) -> String {
        text::decimal(self.in_unit(value_m), self.length.decimals(decimals_of_metres))
    }

    /// Formats a length with its unit, as precise as `decimals_of_metres` decimals of metres; a
    /// dash when it is not finite.
    pub fn measure(self, value_m: f64, decimals_of_metres: usize) -> String {
        if value_m.is_finite() {
            format!("{} {}", self.number(value_m, decimals_of_metres), self.symbol())
        } else {
            NONE.to_owned()
        }
    }

    /// Formats a length and its standard deviation with one unit: `0.51 ± 0.12 m`; without the
    /// standard deviation when it is not finite, and a dash when the length is not.
    pub fn with_sigma(self, value_m: f64, sigma_m: f64, decimals_of_metres: usize) -> String {
        if !(value_m.is_finite() && sigma_m.is_finite()) {
            return self.measure(value_m, decimals_of_metres);
        }
        format!(
            "{} ± {}",
            self.number(value_m, decimals_of_metres),
            self.measure(sigma_m, decimals_of_metres)
        )
    }

    /// Formats a small length with its unit and its sign, also above 0.
    pub fn signed(self, value_m: f64, decimals_of_metres: usize) -> String {
        let decimals = self.length.fine_decimals(decimals_of_metres);
        format!("{:+.decimals$} {}", self.in_unit(value_m), self.symbol())
    }

    /// Formats the error of a small length, without its unit.
    pub fn spread(self, value_m: f64, decimals_of_metres: usize) -> String {
        let decimals = self.length.fine_decimals(decimals_of_metres);
        text::decimal(self.in_unit(value_m), decimals)
    }

    /// Formats a small length and its possible error: `+0.12 ±0.05 m`.
    pub fn signed_within(self, value_m: f64, spread_m: f64, decimals_of_metres: usize) -> String {
        let decimals = self.length.fine_decimals(decimals_of_metres);
        let spread = self.spread(spread_m, decimals_of_metres);
        let value = self.in_unit(value_m);
        format!("{value:+.decimals$} ±{spread} {}", self.symbol())
    }

    /// Formats two lengths with one unit: `1.2 to 3.4 m`.
    pub fn span(self, [low_m, high_m]: [f64; 2], decimals_of_metres: usize) -> String {
        format!(
            "{} to {}",
            self.number(low_m, decimals_of_metres),
            self.measure(high_m, decimals_of_metres)
        )
    }

    /// Formats a speed with its unit; a dash when it is not finite.
    pub fn speed(self, value_mps: f64, decimals: usize) -> String {
        let value = value_mps / self.speed.metres_per_second();
        if value.is_finite() {
            format!("{value:.decimals$} {}", self.speed.symbol())
        } else {
            NONE.to_owned()
        }
    }

    /// Formats a length that was measured on the ground: metres, from a kilometre on kilometres;
    /// feet or fathoms, from a nautical mile on nautical miles.
    pub fn ground_length(self, value_m: f64) -> String {
        let (long_m, symbol) = match self.length {
            LengthUnit::Metres => (1000.0, "km"),
            _ => (METRES_PER_NAUTICAL_MILE, "NM"),
        };
        match value_m {
            _ if !value_m.is_finite() => NONE.to_owned(),
            _ if value_m >= long_m => format!("{:.3} {symbol}", value_m / long_m),
            ..100.0 => self.measure(value_m, 2),
            _ => self.measure(value_m, 1),
        }
    }

    /// Formats the length of a sailed way, no finer than a boat's track is.
    pub fn way(self, length_m: f64) -> String {
        match self.length {
            LengthUnit::Metres => text::way(length_m),
            _ if length_m >= METRES_PER_NAUTICAL_MILE => {
                format!("{:.2} NM", length_m / METRES_PER_NAUTICAL_MILE)
            }
            _ => self.measure(length_m, 0),
        }
    }

    /// Formats an area on the ground: square metres, hectares and square kilometres, or square feet
    /// and acres.
    pub fn area(self, value_m2: f64) -> String {
        let square_feet = value_m2 / (METRES_PER_FOOT * METRES_PER_FOOT);
        match self.length {
            LengthUnit::Metres => text::area(value_m2),
            _ if !value_m2.is_finite() => NONE.to_owned(),
            _ if square_feet < SQUARE_FEET_PER_ACRE => {
                format!("{} ft²", text::count(square_feet.round() as usize))
            }
            _ => format!("{:.2} acres", square_feet / SQUARE_FEET_PER_ACRE),
        }
    }

    /// Formats a difference of depths: centimetres below a metre, inches below a foot.
    pub fn difference(self, value_m: f64) -> String {
        let feet = value_m / METRES_PER_FOOT;
        match self.length {
            _ if !value_m.is_finite() => NONE.to_owned(),
            LengthUnit::Metres if value_m.abs() < 1.0 => format!("{:.1} cm", 100.0 * value_m),
            LengthUnit::Metres => format!("{value_m:.2} m"),
            _ if feet.abs() < 1.0 => format!("{:.1} in", 12.0 * feet),
            _ => format!("{feet:.2} ft"),
        }
    }

    /// Formats a difference as [`Units::difference`] does, with its sign also above 0.
    pub fn signed_difference(self, value_m: f64) -> String {
        let sign = if value_m > 0.0 { "+" } else { "" };
        format!("{sign}{}", self.difference(value_m))
    }

    /// Formats a small difference as a whole number of centimetres or inches, with its sign.
    pub fn small_difference(self, value_m: f64) -> String {
        match self.length {
            LengthUnit::Metres => format!("{:+.0} cm", 100.0 * value_m),
            _ => format!("{:+.0} in", 12.0 * value_m / METRES_PER_FOOT),
        }
    }

    /// Formats a length that was chosen in the settings, with no more decimals than needed: at most
    /// three.
    pub fn chosen(self, value_m: f64) -> String {
        let value = (self.in_unit(value_m) * 1e3).round() / 1e3 + 0.0;
        format!("{value} {}", self.symbol())
    }

    /// Returns the smallest length of at least `least_m` that is round in the unit in use, metres.
    pub fn round_up_m(self, least_m: f64) -> f64 {
        ticks::round_up(self.in_unit(least_m)) * self.length.metres()
    }

    /// Returns the smallest step that is round in the unit in use and divides a span into at most
    /// `most` parts; both in metres.
    pub fn round_step_m(self, span_m: f64, most: f64) -> f64 {
        ticks::round_step(self.in_unit(span_m), most) * self.length.metres()
    }

    /// Formats the number at a tick, with as many decimals as the step between ticks needs.
    pub fn tick(self, value_m: f64, step_m: f64) -> String {
        ticks::label(self.in_unit(value_m), self.in_unit(step_m))
    }

    /// Formats the number at a tick with its unit.
    pub fn tick_with_unit(self, value_m: f64, step_m: f64) -> String {
        format!("{} {}", self.tick(value_m, step_m), self.symbol())
    }

    /// Returns a round length of at least `least_m` for a scale bar, in metres, and its label.
    pub fn scale_bar(self, least_m: f64) -> (f64, String) {
        let is_far = least_m >= METRES_PER_NAUTICAL_MILE && self.length != LengthUnit::Metres;
        if is_far {
            let miles = ticks::round_up(least_m / METRES_PER_NAUTICAL_MILE);
            let label = format!("{} NM", ticks::label(miles, miles));
            return (miles * METRES_PER_NAUTICAL_MILE, label);
        }
        let length_m = self.round_up_m(least_m);
        let label = match self.length {
            LengthUnit::Metres => ticks::bar_label(length_m),
            _ => self.tick_with_unit(length_m, length_m),
        };
        (length_m, label)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const FEET: Units = Units { length: LengthUnit::Feet, speed: SpeedUnit::Knots };
    const FATHOMS: Units = Units { length: LengthUnit::Fathoms, speed: SpeedUnit::Knots };

    #[test]
    fn a_length_says_the_same_in_all_units() {
        assert_eq!(Units::default().measure(3.048, 2), "3.05 m");
        assert_eq!(FEET.measure(3.048, 2), "10.0 ft");
        assert_eq!(FATHOMS.measure(3.6576, 2), "2.00 fm");
        assert_eq!(FEET.span([1.524, 3.048], 1), "5.0 to 10.0 ft");
        assert_eq!(FEET.measure(f64::NAN, 2), NONE);
        assert_eq!(FEET.signed(-0.3048, 2), "-1.00 ft");
        assert_eq!([2, 3].map(|of_metres| FEET.spread(0.06, of_metres)), ["0.20"; 2]);
        assert_eq!(FEET.signed_within(0.3048, 0.03048, 2), "+1.00 ±0.10 ft");
    }

    #[test]
    fn speeds_are_knots_by_the_nautical_mile() {
        assert_eq!(FEET.speed(1852.0 / 3600.0, 1), "1.0 kn");
        assert_eq!(Units::default().speed(1.5, 1), "1.5 m/s");
    }

    #[test]
    fn long_ways_and_areas_take_the_larger_unit() {
        assert_eq!(FEET.ground_length(30.48), "100.0 ft");
        assert_eq!(FEET.ground_length(3704.0), "2.000 NM");
        assert_eq!(FEET.way(1852.0), "1.00 NM");
        assert_eq!(FEET.area(0.092_903_04 * 500.0), "500 ft²");
        assert_eq!(FEET.area(4_046.856_422_4 * 2.0), "2.00 acres");
        assert_eq!(FEET.difference(0.0254), "1.0 in");
        assert_eq!(FEET.signed_difference(0.6096), "+2.00 ft");
    }

    #[test]
    fn steps_are_round_in_the_unit_that_is_shown() {
        let step_m = FEET.round_step_m(30.0, 5.0);
        assert_eq!(FEET.tick_with_unit(step_m, step_m), "20 ft");
        let (length_m, label) = FEET.scale_bar(14.0);
        assert!((length_m - 15.24).abs() < 1e-9 && label == "50 ft", "{label}");
        let (length_m, label) = FEET.scale_bar(3000.0);
        assert!((length_m - 3704.0).abs() < 1e-9 && label == "2 NM", "{label}");
        let (length_m, label) = Units::default().scale_bar(700.0);
        assert!((length_m - 1000.0).abs() < 1e-9 && label == "1 km", "{label}");
        assert_eq!(FATHOMS.tick_with_unit(9.144, 0.9144), "5.0 fm");
    }

    #[test]
    fn a_length_that_was_chosen_has_the_decimals_that_it_needs() {
        assert_eq!(Units::default().chosen(30.0), "30 m");
        assert_eq!(FEET.chosen(0.3 * 3.048), "3 ft");
        assert_eq!(FEET.chosen(0.25), "0.82 ft");
    }

    #[test]
    fn lengths_and_areas_change_their_unit_where_they_grow_long() {
        let units = Units::default();
        let lengths = [12.345, 99.994, 123.45, 999.94, 1234.5, f64::NAN];
        assert_eq!(
            lengths.map(|length_m| units.ground_length(length_m)),
            ["12.35 m", "99.99 m", "123.5 m", "999.9 m", "1.234 km", NONE]
        );
        let areas = [12.34, 12_345.6, 123_456.0, 2.5e7].map(|area_m2| units.area(area_m2));
        assert_eq!(areas, ["12.3 m²", "12 346 m²", "12.35 ha", "25.00 km²"]);
        let differences = [0.123, -1.5, f64::NAN].map(|value_m| units.difference(value_m));
        assert_eq!(differences, ["12.3 cm", "-1.50 m", NONE]);
    }

    #[test]
    fn ticks_show_no_more_than_their_step() {
        let units = Units::default();
        let ticks = [(5.0, 5.0), (2.5, 0.5), (0.25, 0.05)];
        let said = ticks.map(|(value_m, step_m)| units.tick_with_unit(value_m, step_m));
        assert_eq!(said, ["5 m", "2.5 m", "0.25 m"]);
    }
}

//! Converts a number of the settings to the unit that the window shows, with the range of its
//! control, and back. The setting itself stays in metres.

use super::{Number, SettingKind, SettingRow, Settings};
use bathyscope_bottom::presentation::units::Units;

/// Lowest limit of a setting in m/s that is taken for a sound speed, metres a second: no boat is as
/// fast.
const SLOWEST_SOUND_MPS: f64 = 1000.0;

/// Number in the unit that its control shows.
#[derive(Clone, Debug)]
pub struct ShownNumber<'a> {
    number: &'a Number,
    /// Size of one shown unit in the unit of the setting.
    per: f64,
    /// Ends of the control, in the shown unit: beyond the allowed values by less than a step.
    pub ends: [f64; 2],
    /// Smallest step of the control, in the shown unit.
    pub step: f64,
    /// Digits after the decimal point.
    pub decimals: usize,
    /// Unit shown after the number, ` ft` or `°`.
    pub suffix: String,
}

impl Number {
    /// Returns the number in the shown units.
    pub fn shown_in(&self, units: Units) -> ShownNumber<'_> {
        let (per, symbol) = match self.unit {
            "m" => (units.length.metres(), units.symbol()),
            "m/s" if self.range[0] >= SLOWEST_SOUND_MPS => units.sound_speed(),
            "m/s" => (units.speed.metres_per_second(), units.speed.symbol()),
            unit => (1.0, unit),
        };
        let [least, most] = self.ends();
        if per == 1.0 {
            return ShownNumber {
                number: self,
                per,
                ends: [least, most],
                step: self.step,
                decimals: self.decimals,
                suffix: self.suffix(),
            };
        }
        // A power of ten, so that every number with this many decimals can be typed.
        let exponent = (self.step / per).log10().floor() as i32;
        let step = 10f64.powi(exponent);
        ShownNumber {
            number: self,
            per,
            // A control counts its steps from its lower end, so that end is a multiple of the step.
            ends: [(least / per / step).floor() * step, (most / per / step).ceil() * step],
            step,
            decimals: self.decimals.max(exponent.min(0).unsigned_abs() as usize),
            suffix: format!(" {symbol}"),
        }
    }
}

impl ShownNumber<'_> {
    /// Returns the value for the control; 0 if the setting has none.
    pub fn value(&self, settings: &Settings) -> f64 {
        (self.number.get)(settings).unwrap_or(0.0) / self.per
    }

    /// Returns the value of the setting for a value of the control, rounded in the shown unit. A
    /// value below the least becomes no value if the setting may have none.
    pub fn in_setting(&self, value: f64) -> Option<f64> {
        let [least, most] = self.number.range;
        let per_unit = 10f64.powi(self.decimals as i32);
        let rounded = (value * per_unit).round() / per_unit * self.per;
        let is_none = self.number.zero_is_none() && rounded < least && value * self.per < least;
        // Rounding must not move an allowed value beyond its limit.
        (!is_none).then_some(rounded.clamp(least, most))
    }

    /// Returns a value of the setting as its control shows it: `5.00 ft`.
    pub fn said(&self, value: f64) -> String {
        format!("{:.*}{}", self.decimals, value / self.per, self.suffix)
    }
}

impl SettingRow {
    /// Returns the value of the setting as its control shows it, in the shown units; empty for a
    /// file or a list.
    pub fn value_in_words(&self, settings: &Settings, units: Units) -> String {
        match &self.kind {
            SettingKind::Number(number) => match (number.get)(settings) {
                Some(value) => number.shown_in(units).said(value),
                None => number.none_word().unwrap_or_default().to_owned(),
            },
            SettingKind::Choice(choice) => {
                let value = (choice.get)(settings);
                let named = choice.names.iter().find(|name| name.value == value);
                named.map_or(value, |name| name.label.to_owned())
            }
            SettingKind::Numbers { .. } | SettingKind::Text(_) => String::new(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pipeline::settings::rows;
    use crate::pipeline::settings::rows::ROWS;
    use bathyscope_bottom::presentation::units::{LengthUnit, SpeedUnit};

    fn number(row: &'static crate::pipeline::settings::SettingRow) -> &'static Number {
        match &row.kind {
            SettingKind::Number(number) => number,
            _ => panic!("{} is no number", row.key),
        }
    }

    /// Sets a setting as its control does.
    fn take(shown: &ShownNumber<'_>, settings: &mut Settings, value: f64) {
        (shown.number.set)(settings, shown.in_setting(value));
    }

    #[test]
    fn feet_set_metres_and_show_as_they_were_typed() {
        let feet = Units { length: LengthUnit::Feet, speed: SpeedUnit::Knots };
        let mut settings = Settings::default();
        let draft = number(&rows::DRAFT).shown_in(feet);
        take(&draft, &mut settings, 5.0);
        assert!((settings.draft_m - 1.524).abs() < 1e-12);
        assert_eq!(draft.said(settings.draft_m), "5.00 ft");
        assert_eq!([draft.step, draft.ends[0]], [0.01, 0.0]);
        let stops = number(&rows::MIN_SPEED).shown_in(feet);
        take(&stops, &mut settings, 1.0);
        let mps = settings.excluded.min_speed_mps.unwrap();
        assert!((mps - 1852.0 / 3600.0).abs() < 1e-12);
        take(&stops, &mut settings, 0.0);
        assert_eq!(settings.excluded.min_speed_mps, None);
        let recorder = number(&rows::RECORDER_SPEED).shown_in(feet);
        take(&recorder, &mut settings, 4800.0);
        assert!((settings.sound_speed.recorder_m_s - 1463.04).abs() < 1e-9);
        assert_eq!(recorder.suffix, " ft/s");
    }

    #[test]
    fn a_value_is_written_as_its_control_writes_it() {
        let units = Units::default();
        let mut settings = Settings { draft_m: 0.3, ..Settings::default() };
        assert_eq!(rows::DRAFT.value_in_words(&settings, units), "0.30 m");
        let scale = rows::SCALE.value_in_words(&settings, units);
        assert_eq!(scale, "recorded range");
        settings.excluded.min_speed_mps = None;
        assert_eq!(rows::MIN_SPEED.value_in_words(&settings, units), "none");
    }

    #[test]
    fn the_ends_of_every_control_are_allowed_in_every_unit() {
        for length in LengthUnit::ALL {
            for speed in SpeedUnit::ALL {
                for row in ROWS {
                    let SettingKind::Number(number) = &row.kind else {
                        continue;
                    };
                    let shown = number.shown_in(Units { length, speed });
                    for end in shown.ends {
                        let mut settings = Settings::default();
                        take(&shown, &mut settings, end);
                        assert!(row.check(&settings).is_ok(), "{} at {end}", row.key);
                        let none = end == 0.0 && number.zero_is_none();
                        assert_eq!((number.get)(&settings).is_none(), none, "{}", row.key);
                    }
                }
            }
        }
    }
}

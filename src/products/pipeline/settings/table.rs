//! Defines a row of the table of settings: its words, the allowed values, and the check of a value.
//!
//! Converts a number of the settings to the unit that the window shows, too, with the range of its
//! control, and back. The setting itself stays in metres.

use super::{Settings, SettingsError};
use bathyscope_bottom::presentation::units::Units;
use serde::Serialize;
use serde::de::DeserializeOwned;

/// Setting: its key, its words, and the allowed values.
#[derive(Debug)]
pub struct SettingRow {
    /// Key in files and for `--set`, such as `surface.max_gap_m`.
    pub key: &'static str,
    /// Label before the control.
    pub label: &'static str,
    /// Name in a sentence, such as `gap of the depth map`.
    pub name: &'static str,
    /// Explanation of the effect, with the paper's symbol if there is one.
    pub hint: &'static str,
    /// Logs to which a value applies.
    pub scope: SettingScope,
    /// Kind of the setting, with the allowed values.
    pub kind: SettingKind,
}

/// Logs to which a value of a setting applies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SettingScope {
    /// All logs of a survey, except logs that have a value of their own.
    Survey,
    /// Usually one log: a change is stored with that log, but logs may share a value.
    UsuallyOneLog,
    /// One log: its value has no meaning for another log, so that none is shared.
    OneLog,
}

/// Kind of a setting, with the allowed values.
#[derive(Debug)]
pub enum SettingKind {
    /// A number.
    Number(Number),
    /// One of several names.
    Choice(SettingChoice),
    /// List of any number of numbers.
    Numbers {
        /// Unit of all numbers.
        unit: &'static str,
        /// Least and greatest value of each number.
        range: [f64; 2],
        /// Function that reads the numbers.
        get: fn(&Settings) -> &[f64],
    },
    /// Other values, described in words: a file, a stretch of pings.
    Text(&'static str),
}

/// Value that a control gives to a setting.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ControlValue {
    /// Number in the unit of the setting; `None` for no value.
    Number(Option<f64>),
    /// One of several names.
    Name(&'static str),
}

/// Setting that is a number.
#[derive(Debug)]
pub struct Number {
    /// Unit such as `m` or `°/s`; empty if there is none.
    pub unit: &'static str,
    /// Least and greatest value, both allowed.
    pub range: [f64; 2],
    /// Smallest step of the control; whole numbers if it is 1 and there are no decimals.
    pub step: f64,
    /// Digits after the decimal point.
    pub decimals: usize,
    /// Control that changes the number.
    pub control: Control,
    /// Explanation of the effect of no value; `None` if a value is required.
    pub without: Option<&'static str>,
    /// Function that reads the number; `None` for no value.
    pub get: fn(&Settings) -> Option<f64>,
    /// Function that sets the number; `None` for no value, if that is allowed.
    pub set: fn(&mut Settings, Option<f64>),
}

/// Control that changes a number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Control {
    /// Slider with a linear scale.
    Slider,
    /// Slider with a logarithmic scale: for ranges of more than two useful decades.
    LogSlider,
    /// Field whose last digit is changed by dragging: for ranges that are too wide for a slider.
    Drag,
}

impl Number {
    /// Returns true if zero on the control means no value: no value is allowed, and zero is below
    /// the least value.
    pub fn zero_is_none(&self) -> bool {
        self.without.is_some() && self.range[0] > 0.0
    }

    /// Returns the word that the control shows for no value: `none` if no value disables the
    /// effect, else `automatic`. `None` if a value is required.
    pub fn none_word(&self) -> Option<&'static str> {
        let does_nothing = |without: &str| without.starts_with("no ");
        let word = |without| if does_nothing(without) { "none" } else { "automatic" };
        self.without.map(word)
    }

    /// Returns true if the setting only accepts whole numbers.
    fn is_whole(&self) -> bool {
        let mut settings = Settings::default();
        (self.set)(&mut settings, Some(0.5));
        (self.get)(&settings) != Some(0.5)
    }

    /// Returns the unit as it is shown after a number, ` m` or `°`.
    fn suffix(&self) -> String {
        match self.unit {
            "" | "°" => self.unit.to_owned(),
            unit => format!(" {unit}"),
        }
    }

    /// Returns the number in the shown units.
    pub fn shown_in(&self, units: Units) -> ShownNumber<'_> {
        let (per, symbol) = match self.unit {
            "m" => (units.length.metres(), units.symbol()),
            "m/s" if self.range[0] >= SLOWEST_SOUND_MPS => units.sound_speed(),
            "m/s" => (units.speed.metres_per_second(), units.speed.symbol()),
            unit => (1.0, unit),
        };
        let [least, most] = self.range;
        let least = if self.zero_is_none() { 0.0 } else { least };
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

/// Setting that is one of several names.
#[derive(Debug)]
pub struct SettingChoice {
    /// Names to choose from.
    pub names: &'static [Named],
    /// Form of the other values allowed in a file, such as `EPSG:NUMBER`; empty if there are none.
    pub others: &'static str,
    /// Function that reads the name.
    pub get: fn(&Settings) -> String,
    /// Function that sets the setting by a name; a name that is not allowed changes nothing.
    pub set: fn(&mut Settings, &str),
}

/// Name that a setting may have.
#[derive(Debug)]
pub struct Named {
    /// Value in files and for `--set`.
    pub value: &'static str,
    /// Label in a panel.
    pub label: &'static str,
    /// Meaning of the value.
    pub meaning: &'static str,
}

/// Number of the settings, of any type; `None` for no value.
pub(super) trait Numeric {
    fn get(&self) -> Option<f64>;
    fn set(&mut self, value: Option<f64>);
}

/// Implements [`Numeric`] for types of numbers, by the conversions to and from `f64`.
macro_rules! numeric {
    ($($kind:ty: $get:expr, $set:expr;)+) => { $(
        impl Numeric for $kind {
            fn get(&self) -> Option<f64> {
                let get: fn($kind) -> f64 = $get;
                Some(get(*self))
            }

            fn set(&mut self, value: Option<f64>) {
                let set: fn(f64) -> $kind = $set;
                *self = value.map_or(*self, set);
            }
        }
    )+ };
}

numeric! {
    f64: |value| value, |value| value;
    // The value 0.3 as f32 is not 0.3 as f64: rounded to four decimals, it is.
    f32: |value| (f64::from(value) * 1e4).round() / 1e4, |value| value as f32;
    usize: |value| value as f64, |value| value.round() as usize;
    u32: f64::from, |value| value.round() as u32;
}

impl<T: Numeric + Default> Numeric for Option<T> {
    fn get(&self) -> Option<f64> {
        self.as_ref().and_then(Numeric::get)
    }

    fn set(&mut self, value: Option<f64>) {
        *self = value.map(|value| {
            let mut number = T::default();
            number.set(Some(value));
            number
        });
    }
}

/// Returns the name of a choice, as it is written in files.
pub(super) fn name_of<T: Serialize>(chosen: &T) -> String {
    match toml::Value::try_from(chosen) {
        Ok(toml::Value::String(name)) => name,
        Ok(other) => other.to_string(),
        Err(_) => String::new(),
    }
}

/// Sets a choice by its name; an unknown name changes nothing.
pub(super) fn choose<T: DeserializeOwned>(chosen: &mut T, name: &str) {
    let value = match name.parse() {
        Ok(flag) => toml::Value::Boolean(flag),
        Err(_) => toml::Value::String(name.to_owned()),
    };
    if let Ok(value) = T::deserialize(value) {
        *chosen = value;
    }
}

impl SettingRow {
    /// Gives the setting the value of its control; a value of another kind changes nothing.
    pub fn set(&self, settings: &mut Settings, value: ControlValue) {
        match (&self.kind, value) {
            (SettingKind::Number(number), ControlValue::Number(value)) => {
                (number.set)(settings, value);
            }
            (SettingKind::Choice(choice), ControlValue::Name(name)) => (choice.set)(settings, name),
            _ => {}
        }
    }

    /// Checks that the value of the setting is in its range.
    pub(super) fn check(&self, settings: &Settings) -> Result<(), SettingsError> {
        let ([least, most], values) = match &self.kind {
            SettingKind::Number(number) => {
                (number.range, (number.get)(settings).into_iter().collect())
            }
            SettingKind::Numbers { range, get, .. } => (*range, get(settings).to_vec()),
            SettingKind::Choice(_) | SettingKind::Text(_) => return Ok(()),
        };
        let fits = |value: &f64| (least..=most).contains(value);
        if values.iter().all(fits) {
            Ok(())
        } else {
            Err(SettingsError(format!("{} must lie between {least} and {most}", self.key)))
        }
    }

    /// Returns the allowed values as text: `0.1 to 1000 m`, `threshold | tracker`.
    pub fn values(&self) -> String {
        match &self.kind {
            SettingKind::Number(number) => {
                let [least, most] = number.range;
                format!("{least} to {most}{}", number.suffix())
            }
            SettingKind::Numbers { unit, range, .. } => {
                format!("[A, B, ...], each {} to {} {unit}", range[0], range[1])
            }
            SettingKind::Choice(choice) => {
                let names = choice.names.iter().map(|name| name.value);
                let others = Some(choice.others).filter(|others| !others.is_empty());
                names.chain(others).collect::<Vec<_>>().join(" | ")
            }
            SettingKind::Text(what) => (*what).to_owned(),
        }
    }

    /// Returns the allowed values as text, with their kind: `a number, 0.1 to 1000 m`.
    pub(super) fn in_words(&self) -> String {
        let kind = match &self.kind {
            SettingKind::Number(number) if number.is_whole() => "a whole number, ",
            SettingKind::Number(_) => "a number, ",
            SettingKind::Numbers { .. } => "a list of numbers, ",
            SettingKind::Choice(_) | SettingKind::Text(_) => "",
        };
        format!("{kind}{}", self.values())
    }

    /// Returns the explanation of the effect, and that of no value if no value is allowed.
    pub fn meaning(&self) -> String {
        match &self.kind {
            SettingKind::Number(Number { without: Some(without), .. }) => {
                format!("{} Without one: {without}.", self.hint)
            }
            _ => self.hint.to_owned(),
        }
    }
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
    use crate::pipeline::settings::rows::{self, ROWS};
    use bathyscope_bottom::presentation::units::{LengthUnit, SpeedUnit};

    fn number(row: &'static SettingRow) -> &'static Number {
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

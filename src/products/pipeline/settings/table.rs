//! Row of the table of settings: its words, the values that it may have, and the check of a value.

use super::{Settings, SettingsError};
use serde::Serialize;
use serde::de::DeserializeOwned;

/// A setting: its key, its words, and the values that it may have.
#[derive(Debug)]
pub struct SettingRow {
    /// The key of files and of `--set`, `surface.max_gap_m`.
    pub key: &'static str,
    /// Label in front of its control.
    pub label: &'static str,
    /// Name in a sentence, `gap of the depth map`.
    pub name: &'static str,
    /// Explanation of its effect, with the paper's symbol where it has one.
    pub hint: &'static str,
    /// Values that it may have.
    pub kind: SettingKind,
}

/// Values that a setting may have.
#[derive(Debug)]
pub enum SettingKind {
    /// A number.
    Number(Number),
    /// One of several names.
    Choice(SettingChoice),
    /// Numbers, as many as requested.
    Numbers {
        /// Unit of all.
        unit: &'static str,
        /// Least and greatest that each may be.
        range: [f64; 2],
        /// Reads them.
        get: fn(&Settings) -> &[f64],
    },
    /// Anything else, in words: a file, a stretch of pings.
    Text(&'static str),
}

/// A setting that is a number.
#[derive(Debug)]
pub struct Number {
    /// `m`, `°/s`; empty where it has none.
    pub unit: &'static str,
    /// Least and greatest value, both allowed.
    pub range: [f64; 2],
    /// Smallest step of its control; whole where it is 1 and there are no decimals.
    pub step: f64,
    /// Digits behind the point.
    pub decimals: usize,
    /// Control that changes it.
    pub control: Control,
    /// Explanation of what is done without a value, where it may have none.
    pub without: Option<&'static str>,
    /// Reads it.
    pub get: fn(&Settings) -> Option<f64>,
    /// Writes it; `None` where it may have no value.
    pub set: fn(&mut Settings, Option<f64>),
}

/// Control that changes a number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Control {
    /// A slider along a line.
    Slider,
    /// A slider along a line on which each decade is as long as the next: where more than two of
    /// them are of use.
    LogSlider,
    /// A field whose last digit is dragged: where no line is long enough.
    Drag,
}

impl Number {
    /// Returns true if its control has a zero that stands for no value: where it may have none, and
    /// zero is none that it may have.
    pub fn zero_is_none(&self) -> bool {
        self.without.is_some() && self.range[0] > 0.0
    }

    /// Returns the word that its control shows without a value: `none` where nothing is done then,
    /// else `automatic`. `None` where it always has a value.
    pub fn none_word(&self) -> Option<&'static str> {
        let does_nothing = |without: &str| without.starts_with("no ");
        let word = |without| if does_nothing(without) { "none" } else { "automatic" };
        self.without.map(word)
    }

    /// The ends of its control.
    pub fn ends(&self) -> [f64; 2] {
        if self.zero_is_none() { [0.0, self.range[1]] } else { self.range }
    }

    /// Returns true if it is counted, not measured.
    fn is_whole(&self) -> bool {
        let mut settings = Settings::default();
        (self.set)(&mut settings, Some(0.5));
        (self.get)(&settings) != Some(0.5)
    }

    /// The unit behind a number, ` m` or `°`.
    pub fn suffix(&self) -> String {
        match self.unit {
            "" | "°" => self.unit.to_owned(),
            unit => format!(" {unit}"),
        }
    }
}

/// A setting that is one of several names.
#[derive(Debug)]
pub struct SettingChoice {
    /// Names to choose from.
    pub names: &'static [Named],
    /// Form of the other values that it may have in a file, `EPSG:NUMBER`; empty where there are
    /// none.
    pub others: &'static str,
    /// Reads its name.
    pub get: fn(&Settings) -> String,
    /// Writes it by its name; what it cannot be changes nothing.
    pub set: fn(&mut Settings, &str),
}

/// One of the names that a setting may be.
#[derive(Debug)]
pub struct Named {
    /// Name in files and for `--set`.
    pub value: &'static str,
    /// Name in a panel.
    pub label: &'static str,
    /// Meaning of the value.
    pub meaning: &'static str,
}

/// A number of the settings, of whatever type.
pub(super) trait Numeric {
    fn get(&self) -> Option<f64>;
    fn set(&mut self, value: Option<f64>);
}

/// Numbers by how they become one of 64 bits, and how they are made of it.
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
    // 0.3 as f32 is not 0.3 as f64; a hundredth stays a hundredth.
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

/// The name of a choice, as files have it.
pub(super) fn name_of<T: Serialize>(chosen: &T) -> String {
    match toml::Value::try_from(chosen) {
        Ok(toml::Value::String(name)) => name,
        Ok(other) => other.to_string(),
        Err(_) => String::new(),
    }
}

/// Chooses by the name; what is none of them changes nothing.
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
    /// Refuses a value that no stage can work with.
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

    /// Returns the values that it may have, in words: `0.1 to 1000 m`, `threshold | tracker`.
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

    /// Returns the values that it may have, with their kind: `a number, 0.1 to 1000 m`.
    pub(super) fn in_words(&self) -> String {
        let kind = match &self.kind {
            SettingKind::Number(number) if number.is_whole() => "a whole number, ",
            SettingKind::Number(_) => "a number, ",
            SettingKind::Numbers { .. } => "a list of numbers, ",
            SettingKind::Choice(_) | SettingKind::Text(_) => "",
        };
        format!("{kind}{}", self.values())
    }

    /// Returns the explanation of its effect, and of what is done without a value where it may have
    /// none.
    pub fn meaning(&self) -> String {
        match &self.kind {
            SettingKind::Number(Number { without: Some(without), .. }) => {
                format!("{} Without one: {without}.", self.hint)
            }
            _ => self.hint.to_owned(),
        }
    }
}

//! Corrects recorded depths to depths below a level: for sound speed, draft, and the water's own
//! height over time.
//!
//! In: recorded depths and slant ranges, and the settings for the water. Out: depths below the
//! chosen level.
//!
//! The correction is applied where points are made, because a sound speed scales slant ranges
//! before any geometry, and so that soundings, side-scan points and all their products are
//! corrected alike and once.

use bathyscope_log::support::calendar;
use bathyscope_log::survey::{Gauge, Survey};
use serde::{Deserialize, Serialize};
use std::path::PathBuf;
use std::sync::Arc;

/// `water_level.*` settings.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct WaterLevelSettings {
    /// Readings of a gauge or tide over the time of the survey, as
    /// [`bathyscope_log::formats::read_gauge`] reads them.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub file: Option<PathBuf>,
    /// Readings in the file; `None` until it has been read.
    #[serde(skip)]
    pub gauge: Option<Arc<Gauge>>,
}

/// Known properties of water and transducer.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct DepthSettings {
    /// Depth of the transducer below the water's surface, metres.
    pub draft_m: f64,
    /// Height of the water's surface above the level that depths count from, metres; with readings,
    /// the height of the gauge's zero.
    pub water_level_m: f64,
    /// Readings of the water's height.
    pub water_level: WaterLevelSettings,
    /// Height added to every elevation, metres, so that the log agrees with others of its survey
    /// (`bathymetry::height_offsets`).
    pub height_offset_m: f64,
    /// Settings of the sound speed.
    pub sound_speed: SoundSpeedSettings,
}

/// Reason why readings of the water's height are not in force: one sentence, the path last.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{0}")]
pub struct WaterLevelError(String);

/// Correction of the depths of one survey.
///
/// With the sound speed `c`, that of the recorder `c0`, the draft `t`, the water's height `h` at
/// the time and the height offset `o`, a depth `d` below the transducer becomes `d c / c0 + t - h -
/// o`; a slant range `r` becomes `r c / c0`.
///
/// A clock that is wrong by `e` takes the reading of another time, so depths are off by `e` times
/// the rate at which the water rises: 1 cm for 6 minutes where it rises 10 cm an hour, and as much
/// as the height of a tide for hours. The part of this error that is the same all along the log is
/// in the height offset that crossings show; the part that changes along the log stays, unless
/// `mounting.clock_offset_s` gives the delay of the clock. Recorders take the time from the
/// satellites, so a drift within a log is below a second.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Correction {
    settings: DepthSettings,
    /// Time zero of the log by its corrected clock, Unix seconds; `None` where no readings are in
    /// force.
    start_unix_s: Option<f64>,
    /// Offset added to the log's clock, seconds.
    clock_offset_s: f64,
    /// The water's height in the middle of the survey, metres above the level that depths count
    /// from.
    pub middle_level_m: f64,
    /// Reason why the readings of the water's height are not in force, if any.
    pub refused: Option<WaterLevelError>,
    /// Readings before and after a gap in which the level of the survey is a guess, Unix seconds
    /// and metres.
    gap: Option<[(f64, f64); 2]>,
}

/// Longest time between readings, seconds, and largest difference of their levels, metres: where
/// both are exceeded, the water's height is not known, as it may have risen first and fallen later.
const LONGEST_BRIDGE_S: f64 = 3600.0;
const BRIDGED_M: f64 = 0.02;
/// Standard deviation of a level that is interpolated between such readings, in units of their
/// difference: a tide between its low and its high water is off by a tenth, and a flood by more.
const GAP_SHARE: f64 = 0.25;

impl Correction {
    /// Creates the correction of a survey. Readings that do not cover the survey are not applied,
    /// and [`Correction::refused`] holds the reason.
    pub fn new(settings: DepthSettings, survey: &Survey) -> Self {
        let over = over_survey(&settings.water_level, survey);
        let mut made = Self {
            middle_level_m: settings.water_level_m,
            clock_offset_s: survey.clock_offset_s,
            settings,
            ..Self::default()
        };
        match over {
            Ok(Some((start_unix_s, [from_s, to_s]))) => {
                made.start_unix_s = Some(start_unix_s);
                made.middle_level_m = made.level_m(0.5 * (from_s + to_s));
                let over_s = [from_s, to_s].map(|time_s| start_unix_s + time_s);
                made.gap = made.gauge().and_then(|gauge| gauge.widest_gap(over_s)).filter(
                    |[before, after]| {
                        after.0 - before.0 > LONGEST_BRIDGE_S
                            && (after.1 - before.1).abs() > BRIDGED_M
                    },
                );
            }
            Ok(None) => {}
            Err(why) => made.refused = Some(why),
        }
        made
    }

    /// Returns the standard deviation of the water's height where it is interpolated between
    /// readings that are far apart, metres; 0 without such a gap.
    pub fn gap_sigma_m(&self) -> f64 {
        self.gap.map_or(0.0, |[before, after]| GAP_SHARE * (after.1 - before.1).abs())
    }

    /// Returns the factor on slant ranges and depths, `c / c0`.
    pub fn range_factor(&self) -> f64 {
        let speed = &self.settings.sound_speed;
        speed.water_m_s().map_or(1.0, |water_m_s| water_m_s / speed.recorder_m_s)
    }

    /// Returns true if a sound speed is given or computed.
    pub fn knows_sound_speed(&self) -> bool {
        self.settings.sound_speed.water_m_s().is_some()
    }

    /// Returns true if a draft is given.
    pub fn knows_draft(&self) -> bool {
        self.settings.draft_m > 0.0
    }

    /// Returns the elevation of a place that lies `below_m` metres, by the true speed of sound,
    /// below the transducer at a time of the log.
    pub fn z_m(&self, time_s: f64, below_m: f64) -> f64 {
        self.level_m(time_s) + self.settings.height_offset_m - self.settings.draft_m - below_m
    }

    /// Returns the corrected depth for a depth recorded at a time of the log, metres.
    pub fn depth_m(&self, time_s: f64, recorded_m: f64) -> f64 {
        -self.z_m(time_s, recorded_m * self.range_factor())
    }

    /// Returns the height added to every elevation so that the log agrees with others, metres.
    pub fn height_offset_m(&self) -> f64 {
        self.settings.height_offset_m
    }

    /// Returns the readings in force, if any.
    pub fn gauge(&self) -> Option<&Gauge> {
        self.start_unix_s.and(self.settings.water_level.gauge.as_deref())
    }

    /// Returns the water's height at a time of the log, metres.
    fn level_m(&self, time_s: f64) -> f64 {
        let reading_m = match (self.start_unix_s, self.gauge()) {
            (Some(start_unix_s), Some(gauge)) => gauge.level_m(start_unix_s + time_s),
            _ => 0.0,
        };
        self.settings.water_level_m + reading_m
    }

    /// Returns sentences about what depths count from, what was applied, and what was not.
    pub fn statement(&self) -> String {
        self.sentences().join(" ")
    }

    /// Returns the sentences of [`Correction::statement`] in two parts: what depths count from and
    /// what was applied, then what was not.
    pub fn sentences(&self) -> [String; 2] {
        let applied = match self.applied().as_slice() {
            [] => "nothing".to_owned(),
            some => some.join("; "),
        };
        [
            format!("Depths are below {}. Applied: {applied}.", self.reference().in_words()),
            format!("Not corrected: {}.", self.missing().join(", ")),
        ]
    }

    /// Returns the reference that depths count from.
    pub fn reference(&self) -> DepthReference {
        match (self.knows_level(), self.knows_draft()) {
            (true, _) => DepthReference::Level,
            (false, true) => DepthReference::Surface,
            (false, false) => DepthReference::Transducer,
        }
    }

    /// Returns true if a water level is given, or readings of it are in force.
    pub fn knows_level(&self) -> bool {
        self.settings.water_level_m != 0.0 || self.gauge().is_some()
    }

    /// Returns a warning about readings of the water's height that are far apart; `None` where they
    /// are close enough.
    pub fn gap_warning(&self) -> Option<String> {
        let ([before, after], gauge) = (self.gap?, self.gauge()?);
        let name = gauge.path.file_name().unwrap_or_default().to_string_lossy();
        Some(format!(
            "{name} has no reading of the water level from {} to {} UTC, while it went from {} m to {} m: the level of the survey is drawn straight between them, with a standard deviation of {:.2} m; add the readings that are missing.",
            moment(before.0),
            moment(after.0),
            before.1,
            after.1,
            self.gap_sigma_m()
        ))
    }

    fn applied(&self) -> Vec<String> {
        let settings = &self.settings;
        let speed = &settings.sound_speed;
        let mut applied = Vec::new();
        if let Some(water_m_s) = speed.water_m_s() {
            let source = match speed.temperature_c {
                Some(celsius) => format!(
                    " (Chen and Millero 1977 at {celsius} C, salinity {}, {} m)",
                    speed.salinity_psu, speed.depth_m
                ),
                None => String::new(),
            };
            applied.push(format!(
                "sound speed {water_m_s:.1} m/s{source} in place of the recorder's {} m/s, ranges and depths times {:.5}",
                speed.recorder_m_s,
                self.range_factor()
            ));
        }
        if self.knows_draft() {
            applied.push(format!("draft {} m added", settings.draft_m));
        }
        if let Some(gauge) = self.gauge() {
            let name = gauge.path.file_name().unwrap_or_default().to_string_lossy();
            let zero = match settings.water_level_m {
                0.0 => String::new(),
                zero_m => format!(" and its zero at {zero_m} m"),
            };
            let clock = match self.clock_offset_s {
                0.0 => String::new(),
                offset_s => format!(", {offset_s} s later than the log's clock says,"),
            };
            applied.push(format!("water level by the readings of {name}{zero}{clock} taken off"));
        } else if settings.water_level_m != 0.0 {
            applied.push(format!("water level {} m taken off", settings.water_level_m));
        }
        if settings.height_offset_m != 0.0 {
            applied.push(format!(
                "height offset {:+} m, so that the log agrees with others of its survey",
                settings.height_offset_m
            ));
        }
        applied
    }

    fn missing(&self) -> Vec<&'static str> {
        let known = [
            (self.knows_draft(), "draft"),
            (self.knows_level(), "water level or tide"),
            (self.knows_sound_speed(), "sound speed"),
        ];
        let unknown = known.iter().filter(|(known, _)| !known);
        unknown.map(|(_, name)| *name).chain(["roll and pitch"]).collect()
    }
}

/// Returns the Unix seconds of the log's time zero, and the times of its start and end, where
/// readings cover the survey; `None` without readings.
fn over_survey(
    level: &WaterLevelSettings,
    survey: &Survey,
) -> Result<Option<(f64, [f64; 2])>, WaterLevelError> {
    let Some(path) = &level.file else {
        return Ok(None);
    };
    let refused = |why: &str| WaterLevelError(format!("{why}: {}", path.display()));
    let unread = || refused("the readings of the water level have not been read");
    let gauge = level.gauge.as_ref().ok_or_else(unread)?;
    let Some(start_unix_s) = survey.start_unix_s else {
        return Err(refused(
            "the log does not know the time, so readings of the water level cannot be applied to it; give one water_level_m instead",
        ));
    };
    let Some((from_s, to_s)) = record_span_s(survey) else {
        return Ok(Some((start_unix_s, [0.0; 2])));
    };
    let (readings_s, log_s) = (gauge.span_s(), [from_s, to_s].map(|s| start_unix_s + s));
    if log_s[0] < readings_s[0] || log_s[1] > readings_s[1] {
        let [first, last, start, end] =
            [readings_s[0], readings_s[1], log_s[0], log_s[1]].map(moment);
        return Err(refused(&format!(
            "the readings of the water level go from {first} to {last} UTC, but the log from {start} to {end}; add the readings that are missing"
        )));
    }
    Ok(Some((start_unix_s, [from_s, to_s])))
}

/// Returns the first and last time of the records that give points; `None` without any.
fn record_span_s(survey: &Survey) -> Option<(f64, f64)> {
    let pings = survey.side_scan.iter().map(|ping| ping.time_s);
    let times = pings.chain(survey.soundings.iter().map(|sounding| sounding.time_s));
    let times = times.chain(survey.swath.iter().map(|ping| ping.time_s));
    times.fold(None, |span, time_s| {
        let (from_s, to_s) = span.unwrap_or((time_s, time_s));
        Some((time_s.min(from_s), time_s.max(to_s)))
    })
}

/// Returns the date and time of day, UTC.
fn moment(unix_s: f64) -> String {
    format!("{} {}", calendar::date(unix_s), calendar::time_of_day(unix_s))
}

/// Reference that depths count from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DepthReference {
    /// The transducer: no draft is known.
    Transducer,
    /// The water's surface as it was.
    Surface,
    /// The level that the water level counts from.
    Level,
}

impl DepthReference {
    /// Returns the reference in words for a label, after a depth.
    pub fn name(self) -> &'static str {
        match self {
            Self::Transducer => "below transducer",
            Self::Surface => "below surface",
            Self::Level => "below water level zero",
        }
    }

    /// Returns the title of a scale of depths in some unit, such as `m`; short where nothing was
    /// corrected, as is usual.
    pub fn title(self, unit: &str) -> String {
        match self {
            Self::Transducer => format!("depth, {unit}"),
            Self::Surface => format!("{unit} below surface"),
            Self::Level => format!("{unit} below level"),
        }
    }

    /// Returns the reference in words for a sentence.
    fn in_words(self) -> &'static str {
        match self {
            Self::Transducer => "the transducer",
            Self::Surface => "the water's surface as it was",
            Self::Level => "the level that the water level counts from",
        }
    }
}

/// Speed of sound that a recorder is taken to assume: 1500 m/s, usual for sea water. Some recorders
/// assume 4800 feet a second (1463 m/s), usual for fresh water, or let their owner choose; logs of
/// fish-finders do not record it.
const RECORDER_M_S: f64 = 1500.0;

/// `sound_speed.*` settings. Without `m_s` and `temperature_c` ranges stay as the recorder computed
/// them.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct SoundSpeedSettings {
    /// Speed of sound, metres a second, as measured.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub m_s: Option<f64>,
    /// Temperature of the water, degrees Celsius, to compute the speed from ([`sound_speed_m_s`]).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub temperature_c: Option<f64>,
    /// Practical salinity: 0 in fresh water, 35 in the ocean.
    pub salinity_psu: f64,
    /// Depth at which temperature and salinity hold, metres: half the water's depth where they are
    /// the same throughout.
    pub depth_m: f64,
    /// Speed of sound that the recorder computed its ranges and depths with, metres a second.
    pub recorder_m_s: f64,
}

impl Default for SoundSpeedSettings {
    fn default() -> Self {
        Self {
            m_s: None,
            temperature_c: None,
            salinity_psu: 0.0,
            depth_m: 0.0,
            recorder_m_s: RECORDER_M_S,
        }
    }
}

impl SoundSpeedSettings {
    /// Returns the speed of sound, metres a second; `None` where the settings give none.
    pub fn water_m_s(&self) -> Option<f64> {
        let computed = |celsius| sound_speed_m_s(celsius, self.salinity_psu, self.depth_m);
        self.m_s.or(self.temperature_c.map(computed))
    }

    /// Checks that the settings give the speed in one way only.
    ///
    /// # Errors
    /// A sentence if they give both a speed and a temperature.
    pub fn check(&self) -> Result<(), &'static str> {
        match (self.m_s, self.temperature_c) {
            (Some(_), Some(_)) => Err(
                "sound_speed.m_s and sound_speed.temperature_c say the same thing twice; give one of them",
            ),
            _ => Ok(()),
        }
    }
}

/// Coefficients of Chen and Millero: `c = Cw + A s + B s^1.5 + D s^2`, each a polynomial in
/// temperature (columns) and pressure in bar (rows).
const C_W: [[f64; 6]; 4] = [
    [1402.388, 5.03711, -5.80852e-2, 3.3420e-4, -1.478e-6, 3.1464e-9],
    [0.153563, 6.8982e-4, -8.1788e-6, 1.3621e-7, -6.1185e-10, 0.0],
    [3.126e-5, -1.7107e-6, 2.5974e-8, -2.5335e-10, 1.0405e-12, 0.0],
    [-9.7729e-9, 3.8504e-10, -2.3643e-12, 0.0, 0.0, 0.0],
];
const A: [[f64; 5]; 4] = [
    [1.389, -1.262e-2, 7.164e-5, 2.006e-6, -3.21e-8],
    [9.4742e-5, -1.2580e-5, -6.4885e-8, 1.0507e-8, -2.0122e-10],
    [-3.9064e-7, 9.1041e-9, -1.6002e-10, 7.988e-12, 0.0],
    [1.1e-10, 6.649e-12, -3.389e-13, 0.0, 0.0],
];
const B: [[f64; 2]; 2] = [[-1.922e-2, -4.42e-5], [7.3637e-5, 1.7945e-7]];
const D: [[f64; 1]; 2] = [[1.727e-3], [-7.9836e-6]];

/// Returns the speed of sound, metres a second, in water of a temperature (0 to 40 C) and a
/// practical salinity (0 to 40) at a depth.
///
/// The UNESCO equation: Chen and Millero, J. Acoust. Soc. Am. 62 (1977) 1129, as printed by
/// Fofonoff and Millard, UNESCO Technical Papers in Marine Science 44 (1983) 46. It holds in fresh
/// water too, which the equations of Mackenzie (1981) and Del Grosso (1974) do not. The pressure is
/// taken as a tenth of a bar a metre, within 3 %: in 100 m that is 0.05 m/s.
fn sound_speed_m_s(temperature_c: f64, salinity_psu: f64, depth_m: f64) -> f64 {
    at_pressure(temperature_c, salinity_psu, 0.1 * depth_m)
}

fn at_pressure(t: f64, s: f64, bar: f64) -> f64 {
    polynomial(&C_W, t, bar)
        + polynomial(&A, t, bar) * s
        + polynomial(&B, t, bar) * s.powf(1.5)
        + polynomial(&D, t, bar) * s * s
}

/// Returns a polynomial by Horner's rule over rows of pressure and columns of temperature.
fn polynomial<const N: usize>(rows: &[[f64; N]], t: f64, bar: f64) -> f64 {
    let row = |row: &[f64; N]| row.iter().rev().fold(0.0, |sum, factor| sum * t + factor);
    rows.iter().rev().fold(0.0, |sum, factors| sum * bar + row(factors))
}

#[cfg(test)]
mod tests;

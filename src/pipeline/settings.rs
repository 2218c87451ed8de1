//! All settings of the pipeline under the keys that scripts use, and the two presets.

use crate::bathymetry::SurfaceSettings;
use crate::bathymetry::isobaths::IsobathSettings;
use crate::calibration::{CalibrationSettings, OffsetMode, PpdReach, ScaleMode};
use crate::cloud::correction::{SoundSpeedSettings, WaterLevelSettings};
use crate::cloud::{CloudSettings, DepthSettings, DownScan, Geometry, OutlierSettings};
use crate::detection::DetectorSettings;
use crate::first_return::{BottomSettings, FirstReturnSettings, ImageSettings, Method, SampleMode};
use crate::formats::{GaugeError, read_gauge};
use crate::geo::CrsChoice;
use crate::mosaic::MosaicSettings;
use crate::survey::{HeadingSettings, HeadingSource, LeftOutSettings, Projection, TrackSettings};
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// Settings that cannot be understood, in one sentence.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct SettingsError(pub String);

/// A named set of settings.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, clap::ValueEnum)]
#[serde(rename_all = "snake_case")]
pub enum Preset {
    /// The paper's formulas to the digit, so that its figures can be reproduced.
    Published,
    /// What measures best on surveys of known truth.
    #[default]
    Recommended,
}

impl Preset {
    /// `published` or `recommended`.
    pub fn name(self) -> &'static str {
        match self {
            Preset::Published => "published",
            Preset::Recommended => "recommended",
        }
    }
}

/// Everything that decides what the pipeline computes. The field names are the setting keys.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Settings {
    /// `projection`.
    pub projection: Projection,
    /// `crs`: the system of maps and of the point files for other programs.
    pub crs: CrsChoice,
    /// How deep the transducer hangs below the water's surface, metres: added to every depth.
    pub draft_m: f64,
    /// Height of the water's surface above the level that depths count from, metres: taken off every one. With readings, the
    /// height of their zero.
    pub water_level_m: f64,
    /// `water_level.*`: readings over time.
    pub water_level: WaterLevelSettings,
    /// What is added to every elevation of the log, metres, so that it agrees with others of its survey: `height_offsets` finds it
    /// from crossings.
    pub height_offset_m: f64,
    /// `sound_speed.*`.
    pub sound_speed: SoundSpeedSettings,
    /// `image.*`.
    pub image: ImageSettings,
    /// `first_return.*`.
    pub first_return: FirstReturnSettings,
    /// `bottom.*`: the bottom drawn by hand.
    #[serde(skip_serializing_if = "BottomSettings::is_empty")]
    pub bottom: BottomSettings,
    /// `calibration.*`.
    pub calibration: CalibrationSettings,
    /// `cloud.*`.
    pub cloud: CloudSettings,
    /// `heading.*`.
    pub heading: HeadingSettings,
    /// `track.*`, for a track from another receiver; it acts when the track is laid over the log, before any stage.
    pub track: TrackSettings,
    /// `left_out.*`: turns, stops and other stretches that count for nothing.
    pub left_out: LeftOutSettings,
    /// `outliers.*`.
    pub outliers: OutlierSettings,
    /// `detector.*`, for `process`. The window has its own choice of model and confidence.
    pub detector: DetectorSettings,
    /// `mosaic.*`.
    pub mosaic: MosaicSettings,
    /// `surface.*`.
    pub surface: SurfaceSettings,
    /// `isobaths.*`.
    pub isobaths: IsobathSettings,
}

impl Settings {
    /// Reads the water levels that `water_level.file` names, if any.
    ///
    /// # Errors
    /// When the file cannot be read, or holds no water levels.
    pub fn load_water_level(&mut self) -> Result<(), GaugeError> {
        let file = self.water_level.file.as_deref();
        self.water_level.gauge = file.map(read_gauge).transpose()?.map(Arc::new);
        Ok(())
    }

    /// The settings of a preset.
    pub fn preset(preset: Preset) -> Self {
        match preset {
            Preset::Recommended => Self::default(),
            Preset::Published => Self {
                projection: Projection::Mercator,
                image: ImageSettings {
                    samples: SampleMode::Words,
                },
                first_return: FirstReturnSettings {
                    method: Method::Threshold,
                    threshold: 0.30,
                    // 24 of the published picture's pixels, at its 0.033977 m a pixel, on either side of the middle.
                    dead_zone_m: 0.815,
                    min_confidence: 0.0,
                    ..FirstReturnSettings::default()
                },
                calibration: CalibrationSettings {
                    mode: ScaleMode::FlatSpot,
                    pings: None,
                    ppd: PpdReach::Constant,
                    offset: OffsetMode::None,
                },
                cloud: CloudSettings {
                    geometry: Geometry::Published,
                    alpha2_deg: 16.0,
                    down_scan: DownScan::All,
                },
                heading: HeadingSettings {
                    source: HeadingSource::Steps,
                    ..HeadingSettings::default()
                },
                outliers: OutlierSettings {
                    radius_m: 3.011,
                    min_neighbors: 10,
                },
                detector: DetectorSettings::default(),
                mosaic: MosaicSettings::default(),
                ..Self::default()
            },
        }
    }

    /// What is known of water and transducer.
    pub fn depth(&self) -> DepthSettings {
        DepthSettings {
            draft_m: self.draft_m,
            water_level_m: self.water_level_m,
            water_level: self.water_level.clone(),
            height_offset_m: self.height_offset_m,
            sound_speed: self.sound_speed.clone(),
        }
    }

    /// These settings, with what holds for one survey only (its bottom, its flat spot, its water, its transducer) from others.
    pub fn with_survey_of(&self, other: &Self) -> Self {
        let mut settings = self.clone();
        settings.bottom = other.bottom.clone();
        settings.calibration.pings = other.calibration.pings;
        settings.track = other.track.clone();
        settings.left_out.log = other.left_out.log.clone();
        settings.left_out.stretches = other.left_out.stretches.clone();
        settings.draft_m = other.draft_m;
        settings.water_level_m = other.water_level_m;
        settings.water_level = other.water_level.clone();
        settings.height_offset_m = other.height_offset_m;
        settings.sound_speed = other.sound_speed.clone();
        settings
    }

    /// The preset that these settings are, if any; what holds for one survey, and the choices of detector and maps, do not count.
    pub fn matching_preset(&self) -> Option<Preset> {
        let mut plain = self.with_survey_of(&Self::default());
        plain.detector = DetectorSettings::default();
        plain.mosaic = MosaicSettings::default();
        plain.surface = SurfaceSettings::default();
        plain.isobaths = IsobathSettings::default();
        plain.crs = CrsChoice::default();
        [Preset::Recommended, Preset::Published]
            .into_iter()
            .find(|&preset| plain == Self::preset(preset))
    }

    /// Lays the keys of a TOML text over these settings.
    pub fn with_toml(&self, text: &str) -> Result<Self, SettingsError> {
        self.overlaid(text)
            .map_err(|error| SettingsError(format!("settings: {}", one_line(&error, text))))
    }

    fn overlaid(&self, text: &str) -> Result<Self, toml::de::Error> {
        let over: toml::Table = text.parse()?;
        let mut table = toml::Table::try_from(self).map_err(serde::de::Error::custom)?;
        merge(&mut table, over);
        table.try_into()
    }

    /// Applies one `key=value`, for example `first_return.threshold=0.35`.
    pub fn with_assignment(&self, assignment: &str) -> Result<Self, SettingsError> {
        let (key, value) = assignment.split_once('=').ok_or_else(|| {
            SettingsError(format!(
                "a setting is written key=value; got `{assignment}`"
            ))
        })?;
        let (key, value) = (key.trim(), value.trim());
        // A bare word is a string; numbers and booleans stay what TOML says they are.
        let as_toml = format!("{key} = {value}");
        let quoted = format!("{key} = {}", toml::Value::String(value.to_owned()));
        let text = if as_toml.parse::<toml::Table>().is_ok() {
            as_toml
        } else {
            quoted
        };
        self.overlaid(&text).map_err(|error| {
            let reason = error.message().lines().collect::<Vec<_>>().join(" ");
            SettingsError(format!("`{key}` cannot be `{value}`: {reason}"))
        })
    }

    /// Refuses values that no stage can work with.
    pub fn check(&self) -> Result<(), SettingsError> {
        let depth = self.depth().check();
        depth
            .and_then(|()| self.bottom.check())
            .and_then(|()| self.left_out.check())
            .map_err(|rule| SettingsError(rule.to_owned()))?;
        let rules = [
            (
                (0.0..=1.0).contains(&self.first_return.threshold),
                "first_return.threshold must lie between 0 and 1",
            ),
            (
                (0.0..=50.0).contains(&self.first_return.dead_zone_m),
                "first_return.dead_zone_m must lie between 0 and 50",
            ),
            (
                (0.0..=10.0).contains(&self.first_return.canopy_margin_m),
                "first_return.canopy_margin_m must lie between 0 and 10",
            ),
            (
                (0.0..=1.0).contains(&self.first_return.min_confidence),
                "first_return.min_confidence must lie between 0 and 1",
            ),
            (
                (0.0..90.0).contains(&self.cloud.alpha2_deg),
                "cloud.alpha2_deg must lie between 0 and 90",
            ),
            (
                self.outliers.radius_m > 0.0 && self.outliers.radius_m.is_finite(),
                "outliers.radius_m must be above 0",
            ),
            (
                self.outliers.min_neighbors >= 1,
                "outliers.min_neighbors must be at least 1",
            ),
            (
                (0.2..=120.0).contains(&self.heading.window_s),
                "heading.window_s must lie between 0.2 and 120",
            ),
            (
                self.track.offset_s.is_finite(),
                "track.offset_s must be a number",
            ),
            (
                (0.01..=100.0).contains(&self.mosaic.cell_m),
                "mosaic.cell_m must lie between 0.01 and 100",
            ),
            (
                (0.0..=60.0).contains(&self.mosaic.nadir_gap_deg),
                "mosaic.nadir_gap_deg must lie between 0 and 60",
            ),
            (
                self.mosaic.most_turn_deg_s > 0.0,
                "mosaic.most_turn_deg_s must be above 0",
            ),
            (
                self.surface
                    .cell_m
                    .is_none_or(|cell_m| (0.01..=1000.0).contains(&cell_m)),
                "surface.cell_m must lie between 0.01 and 1000",
            ),
            (
                (0.1..=10_000.0).contains(&self.surface.max_gap_m),
                "surface.max_gap_m must lie between 0.1 and 10000",
            ),
            (
                self.surface.longest_canopy_m >= 0.0,
                "surface.longest_canopy_m must be 0 or more",
            ),
            (
                (16..=32_768).contains(&self.surface.max_side),
                "surface.max_side must lie between 16 and 32768",
            ),
            (
                self.surface.down_scan_weight >= 0.0 && self.surface.side_scan_weight >= 0.0,
                "surface.down_scan_weight and surface.side_scan_weight must be 0 or more",
            ),
            (
                self.isobaths
                    .interval_m
                    .is_none_or(|interval_m| interval_m > 0.0),
                "isobaths.interval_m must be above 0",
            ),
            (
                self.isobaths.smooth <= 8,
                "isobaths.smooth must be 8 at most",
            ),
        ];
        rules
            .iter()
            .find(|(holds, _)| !holds)
            .map_or(Ok(()), |(_, rule)| Err(SettingsError((*rule).to_owned())))?;
        self.crs
            .check()
            .map_err(|error| SettingsError(error.to_string()))
    }
}

/// What is wrong with the TOML, with its line where it is not TOML at all, else with the key's name.
fn one_line(error: &toml::de::Error, text: &str) -> String {
    let before = error.span().and_then(|span| text.get(..span.start));
    match before {
        Some(before) => {
            let line = before.matches('\n').count() + 1;
            let reason = error.message().lines().collect::<Vec<_>>().join(" ");
            format!("line {line}: {reason}")
        }
        None => error.to_string().lines().collect::<Vec<_>>().join(" "),
    }
}

fn merge(base: &mut toml::Table, over: toml::Table) {
    for (key, value) in over {
        match (base.get_mut(&key), value) {
            (Some(toml::Value::Table(inner)), toml::Value::Table(value)) => merge(inner, value),
            (_, value) => {
                base.insert(key, value);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn assignments_take_bare_words_numbers_and_ranges() {
        let settings = Settings::default()
            .with_assignment("first_return.method=threshold")
            .and_then(|s| s.with_assignment("first_return.threshold = 0.41"))
            .and_then(|s| s.with_assignment("calibration.pings=400..600"))
            .and_then(|s| s.with_assignment("outliers.min_neighbors=4"))
            .unwrap();
        assert_eq!(settings.first_return.method, Method::Threshold);
        assert_eq!(settings.first_return.threshold, 0.41);
        assert_eq!(
            settings.calibration.pings.map(String::from),
            Some("400..600".to_owned())
        );
        assert_eq!(settings.outliers.min_neighbors, 4);
    }

    #[test]
    fn unknown_keys_and_bad_values_are_named() {
        let unknown = Settings::default()
            .with_assignment("first_return.treshold=0.3")
            .unwrap_err();
        assert!(unknown.0.contains("treshold"), "{unknown}");
        let bad = Settings::default()
            .with_assignment("cloud.geometry=flat")
            .unwrap_err();
        assert!(bad.0.contains("flat"), "{bad}");
        assert!(Settings::default().with_assignment("nonsense").is_err());
    }

    #[test]
    fn presets_are_recognised_whatever_the_flat_spot() {
        for preset in [Preset::Published, Preset::Recommended] {
            let settings = Settings::preset(preset)
                .with_assignment("calibration.pings=1..9")
                .unwrap();
            assert_eq!(settings.matching_preset(), Some(preset));
        }
        assert_eq!(
            Settings::default()
                .with_assignment("cloud.alpha2_deg=12")
                .unwrap()
                .matching_preset(),
            None
        );
    }
}

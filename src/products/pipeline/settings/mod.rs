//! Defines all settings of the pipeline under the keys that scripts use, and the two presets.
//!
//! In: keys with values, as text. Out: checked settings, and their explanations.
//!
//! `rows` is the table of the settings: key, range, unit, words. `table` defines a row, checks
//! values against it and converts a number to the unit of the window, `keys` applies files and
//! assignments to settings, and makes the help and the manual's page.

mod keys;
pub mod rows;
mod table;

pub(crate) use keys::{flattened, in_one_line, insert};
pub use keys::{help, markdown, renamed, row, slips};
pub use table::{
    Control, ControlValue, Number, SettingChoice, SettingKind, SettingRow, SettingScope,
    ShownNumber,
};

use bathyscope_bottom::bathymetry::SurfaceSettings;
use bathyscope_bottom::bathymetry::isobaths::IsobathSettings;
use bathyscope_bottom::calibration::{CalibrationSettings, OffsetMode, PpdReach, ScaleMode};
use bathyscope_bottom::cloud::correction::{SoundSpeedSettings, WaterLevelSettings};
use bathyscope_bottom::cloud::{
    ClassRules, CloudSettings, DepthSettings, DownScan, Geometry, OutlierSettings,
};
use bathyscope_bottom::first_return::{
    BottomSettings, FirstReturnSettings, ImageSettings, Method, SampleMode,
};
use bathyscope_bottom::mosaic::MosaicSettings;
use bathyscope_bottom::picture::PictureSettings;
use bathyscope_log::formats::{read_area, read_gauge};
use bathyscope_log::named;
use bathyscope_log::support::geo::{CrsChoice, SourceCrs};
use bathyscope_log::survey::{
    ExclusionSettings, HeadingSettings, HeadingSource, MountingSettings, PositionSettings,
    PositionShift, Projection, TrackSettings,
};
use bathyscope_objects::{DetectorSettings, ReviewSettings};
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// Error of invalid settings, in one sentence.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct SettingsError(pub String);

/// Named set of settings.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, clap::ValueEnum)]
#[serde(rename_all = "snake_case")]
pub enum Preset {
    /// The paper's formulas to the digit, so that its figures can be reproduced.
    Published,
    /// The settings that measure best on surveys of known truth.
    #[default]
    Recommended,
}

named! {
    /// All presets, the default one first.
    pub Preset {
        Recommended: "recommended",
        Published: "published",
    }
}

/// All settings that decide what the pipeline computes. The field names are the setting keys.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Settings {
    /// `projection`.
    pub projection: Projection,
    /// `crs`: the coordinate system of maps and of the point files for other programs.
    pub crs: CrsChoice,
    /// Depth of the transducer below the water's surface, metres: added to every depth.
    pub draft_m: f64,
    /// Height of the water's surface above the level from which depths count, metres: subtracted
    /// from every depth. With readings, the height of their zero.
    pub water_level_m: f64,
    /// `water_level.*`: readings over time.
    pub water_level: WaterLevelSettings,
    /// Offset that is added to every elevation of the log, metres, so that it agrees with the other
    /// logs of its survey: `height_offsets` computes it from crossings.
    pub height_offset_m: f64,
    /// `sound_speed.*`.
    pub sound_speed: SoundSpeedSettings,
    /// `image.*`.
    pub image: ImageSettings,
    /// `first_return.*`.
    pub first_return: FirstReturnSettings,
    /// `bottom.*`: the bottom edits.
    #[serde(skip_serializing_if = "BottomSettings::is_empty")]
    pub bottom: BottomSettings,
    /// `calibration.*`.
    pub calibration: CalibrationSettings,
    /// `cloud.*`.
    pub cloud: CloudSettings,
    /// `heading.*`.
    pub heading: HeadingSettings,
    /// `mounting.*`; sides and clock are applied to the log before any stage, the others when pings
    /// are placed.
    pub mounting: MountingSettings,
    /// `position_shift.*`.
    pub position_shift: PositionShift,
    /// `source.*`: facts that the log itself lacks; applied before any stage.
    pub source: SourceSettings,
    /// `track.*`, for a track from another receiver; applied with the track to the log, before any
    /// stage.
    pub track: TrackSettings,
    /// `excluded.*`, formerly `left_out.*`: turns, stops and other excluded stretches.
    #[serde(alias = "left_out")]
    pub excluded: ExclusionSettings,
    /// `outliers.*`.
    pub outliers: OutlierSettings,
    /// `detector.*`, for `process`. The window has its own choice of model and confidence.
    pub detector: DetectorSettings,
    /// `review.*`: the analyst's classes. The detections do not depend on them.
    pub review: ReviewSettings,
    /// `picture.*`, for the waterfall and the pictures written of it; no result depends on it.
    pub picture: PictureSettings,
    /// `mosaic.*`.
    pub mosaic: MosaicSettings,
    /// `surface.*`.
    pub surface: SurfaceSettings,
    /// `isobaths.*`.
    pub isobaths: IsobathSettings,
    /// `points.*`.
    pub points: PointFileSettings,
    /// `report.*`.
    pub report: ReportSettings,
}

/// `source.*` settings: facts about a log that its file lacks.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct SourceSettings {
    /// Coordinate system of positions in metres; not needed for a log whose positions are degrees.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub crs: Option<SourceCrs>,
    /// Frequency of the side-scan that is shown, kHz, for a log with several; `None` for the one
    /// that the reader chooses.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub frequency_khz: Option<f64>,
}

/// `points.*` settings: the files of points that are written.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct PointFileSettings {
    /// True if `cloud.las` is written beside `cloud.copc.laz`, for programs that cannot unpack LAZ.
    pub las: bool,
}

/// `report.*` settings: the contents of the report.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ReportSettings {
    /// True if undecided proposals have a section each, like targets.
    pub proposals: bool,
}

impl Settings {
    /// Reads the files that the settings name: the water levels of `water_level.file`, and the area
    /// of `isobaths.clip` if it is not yet loaded. Each is loaded even if the other cannot be read.
    ///
    /// # Errors
    /// A sentence, when a file cannot be read, or has other contents.
    pub fn load_files(&mut self) -> Result<(), SettingsError> {
        let area = self.load_area();
        let file = self.water_level.file.as_deref();
        let gauge = file.map(read_gauge).transpose();
        let gauge = gauge.map_err(|error| SettingsError(error.to_string()));
        self.water_level.gauge = gauge?.map(Arc::new);
        area
    }

    /// Reads the area of `isobaths.clip` if it is not yet loaded.
    ///
    /// # Errors
    /// A sentence, when the file cannot be read, or contains no area.
    pub(crate) fn load_area(&mut self) -> Result<(), SettingsError> {
        let isobaths = &mut self.isobaths;
        let Some(file) = isobaths.clip.as_deref().filter(|_| isobaths.area.is_none()) else {
            return Ok(());
        };
        let area = read_area(file).map_err(|error| SettingsError(error.to_string()))?;
        isobaths.area = Some(Arc::new(area));
        Ok(())
    }

    /// Returns the settings of a preset.
    pub fn preset(preset: Preset) -> Self {
        match preset {
            Preset::Recommended => Self::default(),
            Preset::Published => Self {
                projection: Projection::Mercator,
                image: ImageSettings { samples: SampleMode::Words },
                first_return: FirstReturnSettings {
                    method: Method::Threshold,
                    threshold: 0.30,
                    // 24 of the published picture's pixels, at its 0.033977 m a pixel, on either
                    // side of the middle.
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
                outliers: OutlierSettings { radius_m: 3.011, min_neighbors: 10 },
                surface: SurfaceSettings { above_bottom: true, ..SurfaceSettings::default() },
                ..Self::default()
            },
        }
    }

    /// Returns the settings that decide the places of pings.
    pub fn position_settings(&self) -> PositionSettings<'_> {
        PositionSettings {
            heading: &self.heading,
            mounting: &self.mounting,
            shift: &self.position_shift,
            projection: self.projection,
        }
    }

    /// Returns the settings that decide the class of each point.
    pub fn class_rules(&self) -> ClassRules<'_> {
        ClassRules {
            min_confidence: self.first_return.min_confidence,
            above_bottom: self.surface.above_bottom,
            longest_above_bottom_m: self.surface.longest_above_bottom_m,
            outliers: &self.outliers,
        }
    }

    /// Returns the settings of water and transducer that correct depths.
    pub fn depth(&self) -> DepthSettings {
        DepthSettings {
            draft_m: self.draft_m,
            water_level_m: self.water_level_m,
            water_level: self.water_level.clone(),
            height_offset_m: self.height_offset_m,
            sound_speed: self.sound_speed.clone(),
        }
    }

    /// Returns these settings, with those that apply to one survey only (its bottom, flat spot,
    /// water and shore, transducer, classes of objects, picture) taken from others.
    pub fn with_survey_of(&self, other: &Self) -> Self {
        let mut settings = self.clone();
        settings.bottom = other.bottom.clone();
        settings.calibration.pings = other.calibration.pings;
        settings.track = other.track.clone();
        settings.mounting = other.mounting;
        settings.position_shift = other.position_shift;
        settings.source = other.source.clone();
        settings.excluded.log = other.excluded.log.clone();
        settings.excluded.stretches = other.excluded.stretches.clone();
        settings.draft_m = other.draft_m;
        settings.water_level_m = other.water_level_m;
        settings.water_level = other.water_level.clone();
        settings.height_offset_m = other.height_offset_m;
        settings.sound_speed = other.sound_speed.clone();
        settings.review = other.review.clone();
        settings.picture = other.picture.clone();
        settings.isobaths.clip = other.isobaths.clip.clone();
        settings.isobaths.area = other.isobaths.area.clone();
        settings
    }

    /// Returns the preset that these settings equal, if any; settings that apply to one survey
    /// only, and those of detector and maps, are ignored.
    pub fn matching_preset(&self) -> Option<Preset> {
        let mut plain = self.with_survey_of(&Self::default());
        plain.detector = DetectorSettings::default();
        plain.mosaic = MosaicSettings::default();
        plain.surface = SurfaceSettings {
            above_bottom: self.surface.above_bottom,
            longest_above_bottom_m: self.surface.longest_above_bottom_m,
            ..SurfaceSettings::default()
        };
        plain.isobaths = IsobathSettings::default();
        plain.points = PointFileSettings::default();
        plain.report = ReportSettings::default();
        plain.crs = CrsChoice::default();
        Preset::ALL.into_iter().find(|&preset| plain == Self::preset(preset))
    }

    /// Checks that every value is allowed.
    ///
    /// # Errors
    /// A sentence that names the key of a value that is not allowed.
    pub fn check(&self) -> Result<(), SettingsError> {
        rows::ROWS.iter().try_for_each(|row| row.check(self))?;
        let rules = self.sound_speed.check().and_then(|()| self.bottom.check());
        let rules = rules.and_then(|()| self.excluded.check());
        let rules = rules.and_then(|()| self.review.check());
        rules.map_err(|rule| SettingsError(rule.to_owned()))?;
        let crs = self.crs.check();
        let source = self.source.crs.map(SourceCrs::system).transpose();
        let systems = crs.and_then(|()| source.map(|_| ()));
        systems.map_err(|error| SettingsError(error.to_string()))
    }
}

/// Tests of the table of settings against serde's own lists of fields and variants.
#[cfg(test)]
mod tests {
    use super::rows::{self, ROWS};
    use super::{Preset, SettingKind, Settings, help, markdown, row};
    use bathyscope_bottom::presentation::units::Units;
    use std::collections::BTreeSet;

    /// Returns the names that serde lists as expected in place of one that does not exist.
    fn expected(toml: &str) -> Vec<String> {
        let error = toml::from_str::<Settings>(toml).expect_err("no such name");
        let text = error.message().to_owned();
        let list = text.split_once("expected").map_or("", |(_, list)| list);
        let names = list.split('`').skip(1).step_by(2);
        names.map(str::to_owned).collect()
    }

    #[test]
    fn every_setting_has_a_row_and_every_row_a_setting() {
        let groups = expected("no_such_key = 1");
        let mut keys = BTreeSet::new();
        // The old name of a group is read, but has no rows.
        for group in groups.iter().filter(|group| *group != "bottom" && *group != "left_out") {
            // For an unknown key, serde lists the fields of a group; a setting without fields gives
            // another error.
            match toml::from_str::<Settings>(&format!("[{group}]\nno_such_key = 1")) {
                Err(error) if error.message().contains("unknown field") => {
                    let fields = expected(&format!("[{group}]\nno_such_key = 1"));
                    keys.extend(fields.iter().map(|field| format!("{group}.{field}")));
                }
                _ => {
                    keys.insert(group.clone());
                }
            }
        }
        let in_table: BTreeSet<String> = ROWS.iter().map(|row| row.key.to_owned()).collect();
        assert_eq!(in_table, keys);
        assert_eq!(in_table.len(), ROWS.len(), "a key has one row");
    }

    #[test]
    fn every_preset_lies_within_the_table() {
        for preset in Preset::ALL {
            assert_eq!(Settings::preset(preset).check(), Ok(()));
        }
    }

    #[test]
    fn a_number_is_checked_at_both_ends_of_its_range() {
        for row in ROWS {
            let SettingKind::Number(number) = &row.kind else {
                continue;
            };
            let [least, most] = number.range;
            assert!(least < most && number.step > 0.0, "{}", row.key);
            let check = |value: f64| {
                let assigned = Settings::default().with_assignment(&format!("{}={value}", row.key));
                assigned.and_then(|settings| settings.check().map(|()| settings))
            };
            for end in [least, most] {
                let settings =
                    check(end).unwrap_or_else(|error| panic!("{} {end}: {error}", row.key));
                assert_eq!((number.get)(&settings), Some(end), "{}", row.key);
            }
            // Values outside the range by one step, if the type can hold them.
            for beyond in [least - number.step, most + number.step] {
                let error = check(beyond).expect_err(row.key);
                assert!(error.0.contains(row.key), "{error}");
            }
            let mut settings = Settings::default();
            let control = number.shown_in(Units::default());
            (number.set)(&mut settings, control.in_setting(0.5 * (least + most)));
            let shown = control.value(&settings);
            assert!((shown - 0.5 * (least + most)).abs() <= 0.5, "{}", row.key);
            (number.set)(&mut settings, control.in_setting(0.0));
            if number.zero_is_none() {
                assert_eq!((number.get)(&settings), None, "{}", row.key);
            }
        }
        assert!(
            Settings::default()
                .with_assignment("isobaths.depths_m=[1.0, nan]")
                .and_then(|settings| settings.check())
                .is_err()
        );
    }

    #[test]
    fn a_choice_has_all_names_that_its_type_has() {
        for row in ROWS {
            let SettingKind::Choice(choice) = &row.kind else {
                continue;
            };
            let names: BTreeSet<String> =
                (choice.names.iter().map(|name| name.value.to_owned())).collect();
            let toml = match row.key.split_once('.') {
                Some((group, key)) => format!("[{group}]\n{key} = \"no_such_name\""),
                None => format!("{} = \"no_such_name\"", row.key),
            };
            // A flag is not an enumeration, and a coordinate system may have any number.
            if !names.contains("true") && choice.others.is_empty() {
                let mut known: BTreeSet<String> = expected(&toml).into_iter().collect();
                if row.key == "surface.method" {
                    // These names are read from older projects, but not listed anywhere.
                    known.retain(|name| name != "auto" && name != "smooth");
                }
                assert_eq!(names, known, "{}", row.key);
            }
            let mut settings = Settings::default();
            for name in choice.names {
                (choice.set)(&mut settings, name.value);
                assert_eq!((choice.get)(&settings), name.value, "{}", row.key);
            }
            let before = settings.clone();
            (choice.set)(&mut settings, "no_such_name");
            assert_eq!(settings, before);
        }
    }

    #[test]
    fn help_and_manual_hold_every_key() {
        let (help, page) = (help(), markdown());
        // The help breaks its lines, so meanings are compared word by word.
        let words = |text: &str| text.split_whitespace().collect::<Vec<_>>().join(" ");
        let in_one_line = words(&help);
        for row in ROWS {
            let said = format!("\n{} = {}, ", row.key, row.values());
            assert!(help.contains(&said), "{said}");
            assert!(in_one_line.contains(&words(&row.meaning())), "{}", row.key);
            assert!(page.contains(&format!("| `{}` |", row.key)), "{}", row.key);
        }
        for line in help.lines().filter(|line| line.starts_with(' ')) {
            assert!(line.chars().count() <= 88, "{line}");
        }
        let radius = help.lines().find(|line| line.starts_with("outliers.radius_m "));
        assert_eq!(radius, Some("outliers.radius_m = 0.01 to 100 m, default 3.011"));
        assert!(help.contains("\ncloud.geometry = slope | "));
        assert!(help.contains("\n      nadir: Straight below the boat"), "{help}");
        let line = page.lines().find(|line| line.contains("`projection`"));
        let line = line.expect("a line");
        assert!(line.contains("enu \\| mercator | enu | mercator |"), "{line}");
        assert_eq!(row("draft_m").map(|row| row.label), Some(rows::DRAFT.label));
    }

    #[test]
    fn presets_are_recognised_whatever_the_flat_spot() {
        for preset in Preset::ALL {
            let settings =
                Settings::preset(preset).with_assignment("calibration.pings=1..9").unwrap();
            assert_eq!(settings.matching_preset(), Some(preset));
        }
        assert_eq!(
            Settings::default().with_assignment("cloud.alpha2_deg=12").unwrap().matching_preset(),
            None
        );
    }
}

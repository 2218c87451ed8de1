//! States what was and was not corrected, in words for every product.

use super::{Correction, moment};

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

impl Correction {
    /// Returns sentences about what depths count from, what was applied, and what was not.
    pub fn statement(&self) -> String {
        self.sentences().join(" ")
    }

    /// Returns the sentences of [`Correction::statement`] in two parts: what depths count from and
    /// what was applied, then what was not.
    pub fn sentences(&self) -> [String; 2] {
        let applied = self.applied();
        let missing = self.missing();
        let applied = match applied.as_slice() {
            [] => "Applied: nothing".to_owned(),
            some => format!("Applied: {}", some.join("; ")),
        };
        [
            format!("Depths are below {}. {applied}.", self.reference().in_words()),
            format!("Not corrected: {}.", missing.join(", ")),
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
        if settings.draft_m > 0.0 {
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
        let settings = &self.settings;
        let known = [
            (settings.draft_m > 0.0, "draft"),
            (self.knows_level(), "water level or tide"),
            (settings.sound_speed.water_m_s().is_some(), "sound speed"),
        ];
        let unknown = known.iter().filter(|(known, _)| !known);
        unknown.map(|(_, name)| *name).chain(["roll and pitch"]).collect()
    }
}

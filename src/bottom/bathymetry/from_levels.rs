//! Defines the setting and the result of depths between the lines that come from the levels of the
//! echoes.

use serde::{Deserialize, Serialize};
use std::fmt;

/// Setting for depths between the lines from the levels of the echoes (`crate::swath`).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum SwathDepth {
    /// Levels are not used: depths between the lines are interpolated.
    Off,
    /// Levels are used if left-out soundings show that they improve the depths.
    #[default]
    Auto,
    /// Levels are used wherever they can be read.
    Always,
}

/// Result of depths from levels on a surface.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum FromLevels {
    /// Levels are switched off, or the surface does not come from logs.
    #[default]
    Off,
    /// Levels are used.
    Used {
        /// Root mean square of the errors of left-out soundings by triangles and with levels,
        /// metres; `None` where too few could be left out.
        left_out_m: Option<[f64; 2]>,
    },
    /// Levels are not used, for this reason.
    Refused(LevelsRefused),
}

/// Reason why depths do not come from levels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LevelsRefused {
    /// No log has side-scan echoes with places.
    NoSideScan,
    /// The meaning of the recorder's levels cannot be determined.
    NoLaw,
    /// Too few echoes lie where depths were measured.
    TooFewEchoes,
    /// Too little of the bottom is insonified from two sides.
    OneSide,
    /// The logs have too many recorders and range settings between them to learn the curves of
    /// each.
    TooManySettings,
    /// The survey has too many cells.
    TooLarge,
    /// The equations have no solution in numbers.
    NotSolved,
    /// Too few soundings can be left out.
    NoTest,
    /// Left-out soundings are predicted no better; root mean squares of their errors by triangles
    /// and with levels, metres.
    NoBetter {
        /// Error by triangles, metres.
        without_m: f64,
        /// Error with levels, metres.
        with_m: f64,
    },
}

impl fmt::Display for LevelsRefused {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::NoSideScan => "no log has side-scan echoes with positions",
            Self::NoLaw => "too few echoes tell what the recorder's levels mean",
            Self::TooFewEchoes => "too few echoes lie near measured depths",
            Self::OneSide => {
                "too little of the ground is seen from two sides, as from neighbouring lines"
            }
            Self::TooManySettings => {
                "the logs have more than eight recorders and range settings between them; `surface.swath` = `always` uses them all the same, slowly"
            }
            Self::TooLarge => "the survey is too large",
            Self::NotSolved => "the equations have no solution",
            Self::NoTest => "too few soundings can be left out to test them",
            Self::NoBetter { without_m, with_m } => {
                return write!(
                    f,
                    "left-out soundings are missed by {:.1} cm with them and by {:.1} cm without",
                    100.0 * with_m,
                    100.0 * without_m
                );
            }
        })
    }
}

impl FromLevels {
    /// Returns a sentence for reports; `None` if levels are off.
    pub fn sentence(&self) -> Option<String> {
        (*self != Self::Off).then(|| format!("Depths between the lines are {self}."))
    }
}

impl fmt::Display for FromLevels {
    /// Writes the source of depths between the lines: `interpolated`, or `from echo levels (...)`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Off => f.write_str("interpolated"),
            Self::Used { left_out_m: None } => f.write_str("from echo levels"),
            Self::Used { left_out_m: Some([without_m, with_m]) } => write!(
                f,
                "from echo levels (left-out soundings are missed by {:.1} cm with them, by {:.1} cm without)",
                100.0 * with_m,
                100.0 * without_m
            ),
            Self::Refused(why) => write!(f, "interpolated, not from echo levels: {why}"),
        }
    }
}

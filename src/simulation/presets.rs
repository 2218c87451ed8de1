//! Ready scenes, and scenes from TOML.

use super::scene::Scene;
use super::scene::TrackSettings;
use super::scene::{BedKind, BedSettings};

/// A scene that cannot be simulated, in one sentence.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct SceneError(pub String);

/// The demo survey's scene, as it lies beside its log.
const DEMO: &str = include_str!("../../assets/demo.toml");

impl Scene {
    /// A pond with long swells and slopes up to 4 degrees; the default.
    pub fn gentle() -> Self {
        Self::default()
    }

    /// Ridges and troughs with slopes up to 20 degrees.
    pub fn steep() -> Self {
        Self::of_kind(BedKind::Steep, 3.2)
    }

    /// Gravel and stones.
    pub fn rough() -> Self {
        Self::of_kind(BedKind::Rough, 2.6)
    }

    /// The bundled demo survey: a retention pond with banks, a level terrace, crossing lines and a
    /// few objects.
    pub fn demo() -> Self {
        // A test parses the bundled text, so the default is never seen.
        Self::from_toml(DEMO).unwrap_or_default()
    }

    fn of_kind(kind: BedKind, mean_depth_m: f64) -> Self {
        Self {
            bed: BedSettings { kind, mean_depth_m, ..BedSettings::default() },
            ..Self::default()
        }
    }

    /// A default scene with about `pings` pings a side: longer lines, at the same speed. For
    /// benchmarks.
    pub fn with_pings(pings: u32) -> Self {
        let track = TrackSettings::default();
        let metres = f64::from(pings) * track.speed_mps / track.ping_rate_hz;
        Self {
            track: TrackSettings { lines: 1, cross_lines: 0, length_m: metres, ..track },
            ..Self::default()
        }
    }

    /// Reads a scene from TOML; what is left out keeps its default.
    ///
    /// # Errors
    /// When the text is not TOML, names an unknown setting, or describes a scene that
    /// [`Scene::check`] refuses.
    pub fn from_toml(text: &str) -> Result<Self, SceneError> {
        let scene: Self = toml::from_str(text).map_err(|error| SceneError(sentence(&error)))?;
        scene.check()?;
        Ok(scene)
    }
}

/// Fault of the TOML, on one line.
fn sentence(error: &toml::de::Error) -> String {
    error.message().lines().collect::<Vec<_>>().join(", ")
}

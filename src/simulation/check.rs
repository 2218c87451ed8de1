//! Creates preset scenes and reads scenes from TOML; refuses scenes that make no sense or would not
//! fit into memory or the format.

use super::path::Path;
use super::scene::{BedKind, BedSettings, Scene, TrackSettings};
use std::ops::RangeInclusive;

/// Error of a scene that cannot be simulated; its text is one sentence.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct SceneError(pub String);

/// Largest number of pings of a scene.
const MAX_PINGS: f64 = 500_000.0;
/// Largest number of bytes of a log: offsets in SL2 are 32 bits, and the whole log is built in
/// memory.
const MAX_BYTES: f64 = 2e9;
/// Scene of the demo survey, from the file beside its log.
const DEMO: &str = include_str!("../../assets/demo.toml");

/// Returns an error from the calling function for the first setting of a part of a scene that is
/// outside of its bounds.
macro_rules! all_within {
    ($part:literal, $of:expr, { $($field:ident: $bounds:expr,)+ }) => {
        $(check_within(concat!($part, ".", stringify!($field)), $of.$field.into(), $bounds)?;)+
    };
}

impl Scene {
    /// Creates a pond with long swells and slopes up to 4 degrees; the default.
    pub fn gentle() -> Self {
        Self::default()
    }

    /// Creates a scene with ridges and troughs with slopes up to 20 degrees.
    pub fn steep() -> Self {
        Self::of_kind(BedKind::Steep, 3.2)
    }

    /// Creates a scene with gravel and stones.
    pub fn rough() -> Self {
        Self::of_kind(BedKind::Rough, 2.6)
    }

    /// Returns the scene of the bundled demo survey: a retention pond with banks, a level terrace,
    /// crossing lines and a few objects.
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

    /// Creates a default scene with about `pings` pings on one straight line, at the default speed,
    /// for benchmarks.
    pub fn with_pings(pings: u32) -> Self {
        let track = TrackSettings::default();
        let metres = f64::from(pings) * track.speed_mps / track.ping_rate_hz;
        Self {
            track: TrackSettings { lines: 1, cross_lines: 0, length_m: metres, ..track },
            ..Self::default()
        }
    }

    /// Reads a scene from TOML; settings that are left out keep their defaults.
    ///
    /// # Errors
    /// When the text is not TOML, names an unknown setting, or describes a scene that
    /// [`Scene::check`] refuses.
    pub fn from_toml(text: &str) -> Result<Self, SceneError> {
        let on_one_line = |error: toml::de::Error| {
            SceneError(error.message().lines().collect::<Vec<_>>().join(", "))
        };
        let scene: Self = toml::from_str(text).map_err(on_one_line)?;
        scene.check()?;
        Ok(scene)
    }

    /// Checks that the scene can be simulated.
    ///
    /// # Errors
    /// One sentence about the first setting that is out of bounds.
    pub fn check(&self) -> Result<(), SceneError> {
        self.check_ground()?;
        self.check_survey()?;
        self.check_objects()?;
        self.check_clutter()?;
        self.check_size()
    }

    fn check_ground(&self) -> Result<(), SceneError> {
        let bed = &self.bed;
        check_within("longitude_deg", self.longitude_deg, -180.0..=180.0)?;
        check_within("latitude_deg", self.latitude_deg, -80.0..=80.0)?;
        check_within("duration_s", self.duration_s.unwrap_or(1.0), 0.1..=1e6)?;
        all_within!("bed", bed, {
            mean_depth_m: 0.5..=200.0,
        });
        if let Some(terrace) = &bed.terrace {
            all_within!("bed.terrace", terrace, {
                depth_m: 0.3..=200.0,
                length_m: 0.0..=1e5,
                width_m: 0.0..=1e5,
                edge_m: 0.1..=1e5,
                east_m: -1e5..=1e5,
                north_m: -1e5..=1e5,
            });
        }
        if let Some(bank) = &bed.bank {
            all_within!("bed.bank", bank, {
                length_m: 1.0..=1e6,
                width_m: 1.0..=1e6,
                slope_deg: 1.0..=60.0,
            });
        }
        if let Some(ripples) = &bed.ripples {
            all_within!("bed.ripples", ripples, {
                wavelength_m: 0.05..=1e3,
                height_m: 0.0..=10.0,
                heading_deg: -360.0..=360.0,
            });
        }
        all_within!("bed", bed, {
            scatter_power: 0.0..=20.0,
            patch_factor: 0.0..=10.0,
        });
        few("mounds", bed.mounds.len())?;
        for mound in &bed.mounds {
            all_within!("bed.mounds", mound, {
                east_m: -1e5..=1e5,
                north_m: -1e5..=1e5,
                radius_m: 0.05..=100.0,
                height_m: -20.0..=20.0,
            });
        }
        few("pits", bed.pits.len())?;
        for pit in &bed.pits {
            all_within!("bed.pits", pit, {
                east_m: -1e5..=1e5,
                north_m: -1e5..=1e5,
                radius_m: 0.05..=100.0,
                depth_m: 0.0..=20.0,
            });
        }
        Ok(())
    }

    /// Checks track, recorder, mounting and faults.
    fn check_survey(&self) -> Result<(), SceneError> {
        let track = &self.track;
        few("corners", track.corners_m.len())?;
        for corner in track.corners_m.iter().flatten() {
            check_within("track.corners_m", *corner, -1e5..=1e5)?;
        }
        all_within!("track", track, {
            lines: 0.0..=1000.0,
            cross_lines: 0.0..=1000.0,
            length_m: 1.0..=1e5,
            cross_length_m: 1.0..=1e5,
            spacing_m: 0.1..=1e4,
            turn_radius_m: 0.1..=1e3,
            bend_deg_per_m: -45.0..=45.0,
            speed_mps: 0.1..=20.0,
            ping_rate_hz: 0.5..=100.0,
            fix_rate_hz: 0.1..=100.0,
        });
        all_within!("recorder", self.recorder, {
            range_m: 1.0..=500.0,
            samples_per_side: 64.0..=32_000.0,
            beam_axis_deg: 0.0..=90.0,
            beam_width_deg: 5.0..=180.0,
            beam_azimuth_deg: 0.05..=10.0,
            pulse_m: 0.0..=0.5,
            range_offset_m: -1.0..=1.0,
            absorption_db_per_km: 0.0..=2000.0,
            tvg_limit_m: 0.5..=1e4,
            tvg_power: 0.0..=6.0,
            electronic_noise: 0.0..=1.0,
            volume_noise: 0.0..=1.0,
            bottom_byte: 1.0..=255.0,
            bytes_per_db: 0.1..=50.0,
            smoothing_samples: 0.0..=20.0,
            sonar_samples: 16.0..=60_000.0,
            sonar_every: 1.0..=1e6,
        });
        all_within!("mounting", self.mounting, {
            forward_m: -200.0..=200.0,
            right_m: -100.0..=100.0,
            heading_offset_deg: -180.0..=180.0,
            clock_offset_s: -864_000.0..=864_000.0,
            latency_s: -10.0..=10.0,
            sounding_lag_s: 0.0..=10.0,
        });
        all_within!("artefacts", self.artefacts, {
            ring_down: 0.0..=1e3,
            gain_wander_db: 0.0..=20.0,
            fish: 0.0..=0.5,
            interference: 0.0..=1.0,
            weed_m: 0.0..=1e4,
            gain_drop: 1e-3..=1.0,
            second_echo_db: 0.0..=100.0,
            roll_deg: 0.0..=45.0,
            depth_noise_m: 0.0..=1.0,
            depth_scale: 0.1..=10.0,
            depth_offset_m: -10.0..=10.0,
            position_m: 0.0..=100.0,
            dropouts: 0.0..=0.5,
            range_change: 0.25..=4.0,
            surface_m: 0.0..=100.0,
            glints: 0.0..=1.0,
        });
        Ok(())
    }

    fn check_objects(&self) -> Result<(), SceneError> {
        let scattered = f64::from(self.scattered_objects);
        check_within("scattered_objects", scattered, 0.0..=10_000.0)?;
        let count = self.objects.len() as f64;
        check_within("the number of objects", count, 0.0..=10_000.0)?;
        for object in &self.objects {
            all_within!("objects", object, {
                east_m: -1e5..=1e5,
                north_m: -1e5..=1e5,
                length_m: 0.05..=100.0,
                width_m: 0.05..=30.0,
                height_m: 0.01..=20.0,
                heading_deg: -360.0..=360.0,
                buried_m: 0.0..=20.0,
            });
            let strength_db = object.strength_db.unwrap_or(0.0);
            check_within("objects.strength_db", strength_db, -60.0..=60.0)?;
        }
        Ok(())
    }

    fn check_clutter(&self) -> Result<(), SceneError> {
        few("shoals", self.shoals.len())?;
        for shoal in &self.shoals {
            all_within!("shoals", shoal, {
                east_m: -1e5..=1e5,
                north_m: -1e5..=1e5,
                depth_m: 0.0..=200.0,
                radius_m: 0.05..=100.0,
                count: 0.0..=1000.0,
                strength_db: -60.0..=60.0,
            });
        }
        few("weed clumps", self.weed_clumps.len())?;
        for clump in &self.weed_clumps {
            all_within!("weed_clumps", clump, {
                east_m: -1e5..=1e5,
                north_m: -1e5..=1e5,
                diameter_m: 0.05..=1e4,
            });
        }
        Ok(())
    }

    /// Returns the number of pings along a way, or until the survey ends; it may have a fraction.
    pub(super) fn pings_along(&self, path: &Path) -> f64 {
        let whole_s = path.length_m() / self.track.speed_mps;
        let seconds = self.duration_s.map_or(whole_s, |end| end.min(whole_s));
        seconds * self.track.ping_rate_hz
    }

    fn check_size(&self) -> Result<(), SceneError> {
        if self.track.lines == 0 && self.track.cross_lines == 0 {
            return Err(SceneError(
                "the track has no line: set track.lines or track.cross_lines to at least 1".into(),
            ));
        }
        let pings = self.pings_along(&Path::new(&self.track));
        if pings > MAX_PINGS {
            return Err(SceneError(format!(
                "the track gives {pings:.0} pings, more than {MAX_PINGS}: shorten the lines or lower track.ping_rate_hz"
            )));
        }
        let recorder = &self.recorder;
        let side_scan = 2.0 * f64::from(recorder.samples_per_side) + 144.0;
        let sonar = 2.0 * (f64::from(recorder.sonar_samples) + 144.0);
        let bytes = pings * (side_scan + sonar / f64::from(recorder.sonar_every));
        if bytes > MAX_BYTES {
            return Err(SceneError(format!(
                "the log would hold {:.1} GB, more than {:.1}: shorten the lines or lower recorder.samples_per_side",
                bytes / 1e9,
                MAX_BYTES / 1e9
            )));
        }
        Ok(())
    }
}

/// Checks that there are at most 1000 things of a kind.
fn few(what: &str, count: usize) -> Result<(), SceneError> {
    check_within(&format!("the number of {what}"), count as f64, 0.0..=1000.0)
}

/// Checks that a number is within its bounds; NaN is not.
fn check_within(name: &str, value: f64, bounds: RangeInclusive<f64>) -> Result<(), SceneError> {
    if bounds.contains(&value) {
        return Ok(());
    }
    let (low, high) = bounds.into_inner();
    Err(SceneError(format!("{name} is {value}, but must lie between {low} and {high}")))
}

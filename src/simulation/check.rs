//! Refuses scenes that make no sense or would not fit into memory or the format.

use super::path::Path;
use super::presets::SceneError;
use super::scene::Scene;

/// Most pings of a scene.
const MAX_PINGS: f64 = 500_000.0;
/// Most bytes of a log: offsets in SL2 are 32 bits, and the whole log is built in memory.
const MAX_BYTES: f64 = 2e9;

impl Scene {
    /// Whether the scene can be simulated.
    ///
    /// # Errors
    /// One sentence about the first setting that is out of bounds.
    pub(crate) fn check(&self) -> Result<(), SceneError> {
        self.check_ground()?;
        self.check_track()?;
        self.check_recorder()?;
        self.check_mounting()?;
        self.check_artefacts()?;
        self.check_objects()?;
        self.check_clutter()?;
        self.check_size()
    }

    fn check_ground(&self) -> Result<(), SceneError> {
        let bed = &self.bed;
        within("longitude_deg", self.longitude_deg, -180.0, 180.0)?;
        within("latitude_deg", self.latitude_deg, -80.0, 80.0)?;
        within("duration_s", self.duration_s.unwrap_or(1.0), 0.1, 1e6)?;
        within("bed.mean_depth_m", bed.mean_depth_m, 0.5, 200.0)?;
        if let Some(terrace) = &bed.terrace {
            within("bed.terrace.depth_m", terrace.depth_m, 0.3, 200.0)?;
            within("bed.terrace.length_m", terrace.length_m, 0.0, 1e5)?;
            within("bed.terrace.width_m", terrace.width_m, 0.0, 1e5)?;
            within("bed.terrace.edge_m", terrace.edge_m, 0.1, 1e5)?;
            within("bed.terrace.east_m", terrace.east_m, -1e5, 1e5)?;
            within("bed.terrace.north_m", terrace.north_m, -1e5, 1e5)?;
        }
        if let Some(bank) = &bed.bank {
            within("bed.bank.length_m", bank.length_m, 1.0, 1e6)?;
            within("bed.bank.width_m", bank.width_m, 1.0, 1e6)?;
            within("bed.bank.slope_deg", bank.slope_deg, 1.0, 60.0)?;
        }
        if let Some(ripples) = &bed.ripples {
            within("bed.ripples.wavelength_m", ripples.wavelength_m, 0.05, 1e3)?;
            within("bed.ripples.height_m", ripples.height_m, 0.0, 10.0)?;
            within(
                "bed.ripples.heading_deg",
                ripples.heading_deg,
                -360.0,
                360.0,
            )?;
        }
        within("bed.scatter_power", bed.scatter_power, 0.0, 20.0)?;
        within("bed.patch_factor", bed.patch_factor, 0.0, 10.0)?;
        few("mounds", bed.mounds.len())?;
        for mound in &bed.mounds {
            all_within(&[
                ("bed.mounds.east_m", mound.east_m, -1e5, 1e5),
                ("bed.mounds.north_m", mound.north_m, -1e5, 1e5),
                ("bed.mounds.radius_m", mound.radius_m, 0.05, 100.0),
                ("bed.mounds.height_m", mound.height_m, -20.0, 20.0),
            ])?;
        }
        few("pits", bed.pits.len())?;
        for pit in &bed.pits {
            all_within(&[
                ("bed.pits.east_m", pit.east_m, -1e5, 1e5),
                ("bed.pits.north_m", pit.north_m, -1e5, 1e5),
                ("bed.pits.radius_m", pit.radius_m, 0.05, 100.0),
                ("bed.pits.depth_m", pit.depth_m, 0.0, 20.0),
            ])?;
        }
        Ok(())
    }

    fn check_track(&self) -> Result<(), SceneError> {
        let track = &self.track;
        few("corners", track.corners_m.len())?;
        for corner in track.corners_m.iter().flatten() {
            within("track.corners_m", *corner, -1e5, 1e5)?;
        }
        all_within(&[
            ("track.lines", track.lines.into(), 0.0, 1000.0),
            ("track.cross_lines", track.cross_lines.into(), 0.0, 1000.0),
            ("track.length_m", track.length_m, 1.0, 1e5),
            ("track.cross_length_m", track.cross_length_m, 1.0, 1e5),
            ("track.spacing_m", track.spacing_m, 0.1, 1e4),
            ("track.turn_radius_m", track.turn_radius_m, 0.1, 1e3),
            ("track.bend_deg_per_m", track.bend_deg_per_m, -45.0, 45.0),
            ("track.speed_mps", track.speed_mps, 0.1, 20.0),
            ("track.ping_rate_hz", track.ping_rate_hz, 0.5, 100.0),
            ("track.fix_rate_hz", track.fix_rate_hz, 0.1, 100.0),
        ])
    }

    fn check_mounting(&self) -> Result<(), SceneError> {
        let mounting = &self.mounting;
        all_within(&[
            ("mounting.forward_m", mounting.forward_m, -200.0, 200.0),
            ("mounting.right_m", mounting.right_m, -100.0, 100.0),
            (
                "mounting.heading_offset_deg",
                mounting.heading_offset_deg,
                -180.0,
                180.0,
            ),
            (
                "mounting.clock_offset_s",
                mounting.clock_offset_s,
                -864_000.0,
                864_000.0,
            ),
            ("mounting.latency_s", mounting.latency_s, -10.0, 10.0),
        ])
    }

    fn check_recorder(&self) -> Result<(), SceneError> {
        let recorder = &self.recorder;
        let absorption = recorder.absorption_db_per_km;
        all_within(&[
            ("recorder.range_m", recorder.range_m, 1.0, 500.0),
            (
                "recorder.samples_per_side",
                recorder.samples_per_side.into(),
                64.0,
                32_000.0,
            ),
            ("recorder.beam_axis_deg", recorder.beam_axis_deg, 0.0, 90.0),
            (
                "recorder.beam_width_deg",
                recorder.beam_width_deg,
                5.0,
                180.0,
            ),
            (
                "recorder.beam_azimuth_deg",
                recorder.beam_azimuth_deg,
                0.05,
                10.0,
            ),
            ("recorder.pulse_m", recorder.pulse_m, 0.0, 0.5),
            (
                "recorder.range_offset_m",
                recorder.range_offset_m,
                -1.0,
                1.0,
            ),
            ("recorder.absorption_db_per_km", absorption, 0.0, 2000.0),
            ("recorder.tvg_limit_m", recorder.tvg_limit_m, 0.5, 1e4),
            ("recorder.tvg_power", recorder.tvg_power, 0.0, 6.0),
            (
                "recorder.electronic_noise",
                recorder.electronic_noise,
                0.0,
                1.0,
            ),
            ("recorder.volume_noise", recorder.volume_noise, 0.0, 1.0),
            ("recorder.bottom_byte", recorder.bottom_byte, 1.0, 255.0),
            ("recorder.bytes_per_db", recorder.bytes_per_db, 0.1, 50.0),
            (
                "recorder.smoothing_samples",
                recorder.smoothing_samples,
                0.0,
                20.0,
            ),
            (
                "recorder.sonar_samples",
                recorder.sonar_samples.into(),
                16.0,
                60_000.0,
            ),
            (
                "recorder.sonar_every",
                recorder.sonar_every.into(),
                1.0,
                1e6,
            ),
        ])
    }

    fn check_artefacts(&self) -> Result<(), SceneError> {
        let artefacts = &self.artefacts;
        all_within(&[
            ("artefacts.ring_down", artefacts.ring_down, 0.0, 1e3),
            (
                "artefacts.gain_wander_db",
                artefacts.gain_wander_db,
                0.0,
                20.0,
            ),
            ("artefacts.fish", artefacts.fish, 0.0, 0.5),
            ("artefacts.interference", artefacts.interference, 0.0, 1.0),
            ("artefacts.weed_m", artefacts.weed_m, 0.0, 1e4),
            ("artefacts.gain_drop", artefacts.gain_drop, 1e-3, 1.0),
            (
                "artefacts.second_echo_db",
                artefacts.second_echo_db,
                0.0,
                100.0,
            ),
            ("artefacts.roll_deg", artefacts.roll_deg, 0.0, 45.0),
            ("artefacts.depth_noise_m", artefacts.depth_noise_m, 0.0, 1.0),
            ("artefacts.depth_scale", artefacts.depth_scale, 0.1, 10.0),
            (
                "artefacts.depth_offset_m",
                artefacts.depth_offset_m,
                -10.0,
                10.0,
            ),
            ("artefacts.position_m", artefacts.position_m, 0.0, 100.0),
            ("artefacts.dropouts", artefacts.dropouts, 0.0, 0.5),
            ("artefacts.range_change", artefacts.range_change, 0.25, 4.0),
            ("artefacts.surface_m", artefacts.surface_m, 0.0, 100.0),
            ("artefacts.glints", artefacts.glints, 0.0, 1.0),
        ])
    }

    fn check_objects(&self) -> Result<(), SceneError> {
        within(
            "scattered_objects",
            f64::from(self.scattered_objects),
            0.0,
            10_000.0,
        )?;
        within(
            "the number of objects",
            self.objects.len() as f64,
            0.0,
            10_000.0,
        )?;
        for object in &self.objects {
            within("objects.east_m", object.east_m, -1e5, 1e5)?;
            within("objects.north_m", object.north_m, -1e5, 1e5)?;
            within("objects.length_m", object.length_m, 0.05, 100.0)?;
            within("objects.width_m", object.width_m, 0.05, 30.0)?;
            within("objects.height_m", object.height_m, 0.01, 20.0)?;
            within("objects.heading_deg", object.heading_deg, -360.0, 360.0)?;
            within("objects.buried_m", object.buried_m, 0.0, 20.0)?;
            within(
                "objects.strength_db",
                object.strength_db.unwrap_or(0.0),
                -60.0,
                60.0,
            )?;
        }
        Ok(())
    }

    fn check_clutter(&self) -> Result<(), SceneError> {
        few("shoals", self.shoals.len())?;
        for shoal in &self.shoals {
            all_within(&[
                ("shoals.east_m", shoal.east_m, -1e5, 1e5),
                ("shoals.north_m", shoal.north_m, -1e5, 1e5),
                ("shoals.depth_m", shoal.depth_m, 0.0, 200.0),
                ("shoals.radius_m", shoal.radius_m, 0.05, 100.0),
                ("shoals.count", shoal.count.into(), 0.0, 1000.0),
                ("shoals.strength_db", shoal.strength_db, -60.0, 60.0),
            ])?;
        }
        few("weed clumps", self.weed_clumps.len())?;
        for clump in &self.weed_clumps {
            all_within(&[
                ("weed_clumps.east_m", clump.east_m, -1e5, 1e5),
                ("weed_clumps.north_m", clump.north_m, -1e5, 1e5),
                ("weed_clumps.diameter_m", clump.diameter_m, 0.05, 1e4),
            ])?;
        }
        Ok(())
    }

    fn check_size(&self) -> Result<(), SceneError> {
        if self.track.lines == 0 && self.track.cross_lines == 0 {
            return Err(SceneError(
                "the track has no line: set track.lines or track.cross_lines to at least 1".into(),
            ));
        }
        let whole_s = Path::new(&self.track).length_m() / self.track.speed_mps;
        let seconds = self.duration_s.map_or(whole_s, |end| end.min(whole_s));
        let pings = seconds * self.track.ping_rate_hz;
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

/// Refuses more things of a kind than a survey holds.
fn few(what: &str, count: usize) -> Result<(), SceneError> {
    within(&format!("the number of {what}"), count as f64, 0.0, 1000.0)
}

/// Refuses the first number outside its bounds: name, value, lowest, highest.
fn all_within(numbers: &[(&str, f64, f64, f64)]) -> Result<(), SceneError> {
    let mut numbers = numbers.iter();
    numbers.try_for_each(|&(name, value, low, high)| within(name, value, low, high))
}

/// Refuses a number outside its bounds, NaN included.
fn within(name: &str, value: f64, low: f64, high: f64) -> Result<(), SceneError> {
    if (low..=high).contains(&value) {
        return Ok(());
    }
    Err(SceneError(format!(
        "{name} is {value}, but must lie between {low} and {high}"
    )))
}

//! Options of a log's side-scan view that the commands for pictures, pages and films share.

use super::Failure;
use super::settings::{SettingsArgs, check_against};
use crate::app::{App, Command, Jobs, LogOrigin};
use bathyscope_bottom::calibration::PingRange;
use bathyscope_bottom::waterfall::RangeAxis;
use bathyscope_log::survey::Survey;
use bathyscope_products::pipeline::{self, Settings};
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Duration;

/// Quantity across the side-scan picture.
#[derive(Clone, Copy, Debug, Default, clap::Args)]
pub(super) struct GeometryArgs {
    /// Distance on level ground instead of slant range
    #[arg(long)]
    ground: bool,
    /// Leave the water column out: slant range from the first return on
    #[arg(long)]
    no_water: bool,
}

impl GeometryArgs {
    /// Sets the geometry of the app's waterfall to these options.
    pub(super) fn apply(self, app: &mut App) {
        let waterfall = &mut app.view.options.waterfall;
        waterfall.ground_range = self.ground;
        waterfall.water_column = !self.no_water;
    }
}

/// A log, and how it is shown.
#[derive(Debug, clap::Args)]
pub(super) struct WaterfallArgs {
    /// The log; the bundled demo survey when left out
    survey: Option<PathBuf>,
    /// Side-scan pings to show, B left out; all of them when left out
    #[arg(long, value_name = "A..B")]
    pings: Option<PingRange>,
    #[command(flatten)]
    geometry: GeometryArgs,
    /// Draw the first return
    #[arg(long)]
    first_return: bool,
    #[command(flatten)]
    settings: SettingsArgs,
}

/// Log that was opened and processed, with the pings that are shown.
pub(super) struct WaterfallLog {
    /// State from which pictures are drawn.
    pub app: App,
    /// Pings that are shown: the first, and one after the last.
    pub pings: PingRange,
    /// Extent of the pings and of the range.
    pub axis: RangeAxis,
    /// Name of the log.
    pub name: String,
}

impl WaterfallLog {
    /// Returns the number of pings on `along` pixels with which a metre along the track is as long
    /// as one across, if both sides together take `across` pixels; one ping for each pixel if the
    /// boat's speed is unknown.
    pub(super) fn one_to_one(&self, along: u32, across: u32) -> f64 {
        let (along, pixel_m) = (f64::from(along), 2.0 * self.axis.far_m / f64::from(across));
        self.axis.ping_m.map_or(along, |ping_m| along * pixel_m / ping_m)
    }
}

impl WaterfallArgs {
    /// Opens the log and waits until its picture can be drawn.
    ///
    /// # Errors
    /// When the log or a setting cannot be used, or the log has no side-scan picture.
    pub(super) fn open(self) -> Result<WaterfallLog, Failure> {
        let settings = self.settings.resolve()?;
        let mut app = App::new(Jobs::Threads(Arc::new(|| ())));
        app.use_settings(&settings);
        self.geometry.apply(&mut app);
        let waterfall = &mut app.view.options.waterfall;
        waterfall.first_return = self.first_return;
        waterfall.flat_stretches = false;
        waterfall.boxes = false;
        open(&mut app, &self.survey.map_or(LogOrigin::Demo, LogOrigin::Path))?;
        take_over(&mut app, settings)?;
        let survey = app.logs.shown.survey.clone().unwrap_or_default();
        let axis = RangeAxis::of(&survey).filter(|_| survey.has_side_scan());
        let axis = axis.ok_or("the log holds no side-scan that could be shown")?;
        Ok(WaterfallLog {
            pings: requested_pings(&survey, self.pings)?,
            axis,
            name: survey.name(),
            app,
        })
    }
}

/// Returns the requested pings, or all pings of a log.
///
/// # Errors
/// When the log has fewer pings than requested.
pub(super) fn requested_pings(
    survey: &Survey,
    pings: Option<PingRange>,
) -> Result<PingRange, Failure> {
    let count = survey.side_scan.len();
    let pings = pings.unwrap_or(PingRange { start: 0, end: count });
    if pings.end > count {
        return Err(format!(
            "the log has {count} side-scan pings; pings {}..{} were asked for",
            pings.start, pings.end
        )
        .into());
    }
    Ok(pings)
}

/// Parses a size, `WxH`.
///
/// # Errors
/// When the text is not `WxH`, or a side is not between 16 and 16384 pixels.
pub(super) fn parse_size(text: &str) -> Result<[u32; 2], String> {
    let parsed = text
        .split_once(['x', 'X', '×'])
        .and_then(|(width, height)| Some([width.parse().ok()?, height.parse().ok()?]));
    parsed
        .filter(|size: &[u32; 2]| size.iter().all(|side| (16..=16_384).contains(side)))
        .ok_or_else(|| {
            format!("a size is written WxH in pixels, 16 to 16384 a side, for example 1600x1000; got `{text}`")
        })
}

/// Opens the log and waits for all results.
///
/// # Errors
/// When the log cannot be opened or processed.
pub(super) fn open(app: &mut App, origin: &LogOrigin) -> Result<(), Failure> {
    app.apply(match origin {
        LogOrigin::Path(path) => Command::Open(path.clone()),
        LogOrigin::Demo => Command::OpenDemo,
    });
    wait(app)
}

/// Sets all settings of the app, including those of this survey only: its flat spot, water, track
/// and picture. A log that was just opened has lost them, since in the window they would be those
/// of the log before.
///
/// # Errors
/// When the settings do not fit the log.
pub(super) fn take_over(app: &mut App, settings: Settings) -> Result<(), Failure> {
    if settings == *app.logs.shown.settings {
        return Ok(());
    }
    if let Some(survey) = &app.logs.shown.survey {
        let recorded = Survey::clone(survey);
        let mounted = pipeline::as_mounted(recorded, &settings.mounting, &settings.source);
        check_against(&mounted?, &settings)?;
    }
    app.apply(Command::Change { settings: Box::new(settings), label: "settings", live: false });
    wait(app)
}

/// Waits until nothing is being opened or computed.
///
/// # Errors
/// When the app has a notice of an error: its text.
pub(super) fn wait(app: &mut App) -> Result<(), Failure> {
    app.poll();
    while !app.is_idle() {
        std::thread::sleep(Duration::from_millis(2));
        app.poll();
    }
    match app.notices.shown().iter().find(|notice| notice.is_error) {
        Some(error) => Err(error.text.clone().into()),
        None => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_are_width_times_height() {
        assert_eq!(parse_size("640x480"), Ok([640, 480]));
        for wrong in ["640", "0x10", "axb", "99999x10"] {
            assert!(parse_size(wrong).is_err(), "{wrong}");
        }
    }
}

//! Converts the picture settings of the shown log into the parameters of the renderer.

use super::lens::Lens;
use crate::app::{App, Orientation};
use crate::ui::render::waterfall::{EchoStyle, GainBuffer, WaterfallPicture};
use bathyscope_bottom::picture::{LogPicture, PictureGeometry};
use bathyscope_bottom::waterfall::Levels;
use bathyscope_log::survey::Side;
use bathyscope_products::pipeline::Same;
use eframe::egui_wgpu::RenderState;
use std::sync::Arc;

/// Share of the maximum in the picture: large enough for a bright spot of one sample to stay
/// visible in an overview, small enough to preserve the texture of the ground.
const HIGHLIGHT: f32 = 0.3;
/// Least difference of white and black, as a share of the colours.
const LEAST_CONTRAST: f32 = 1e-3;
/// Bits of [`EchoStyle::filters`].
const GAIN: u32 = 1;
const STRIPES: u32 = 2;
const MEDIAN: u32 = 4;

/// The gain of a log on the GPU.
pub(super) struct UploadedGain {
    of: Option<Same<LogPicture>>,
    pub gain: GainBuffer,
}

impl UploadedGain {
    /// Returns true if the gain was uploaded for this picture.
    pub(super) fn is_of(&self, picture: Option<&Arc<LogPicture>>) -> bool {
        self.of == picture.cloned().map(Same)
    }
}

/// Puts on the GPU the gain that a log is shown with.
pub(super) fn upload(
    renderer: &WaterfallPicture,
    state: &RenderState,
    picture: Option<&Arc<LogPicture>>,
) -> UploadedGain {
    let gain = picture.and_then(|picture| picture.gain.as_ref());
    let [port, starboard] =
        Side::BOTH.map(|side| gain.map_or((&[][..], &[][..]), |gain| gain.curves(side)));
    let curves = [port.0, port.1, starboard.0, starboard.1];
    UploadedGain {
        of: picture.cloned().map(Same),
        gain: renderer.upload_gain(&state.device, &state.queue, curves),
    }
}

/// Returns the parameters of the renderer. `first` are the levels that suit the echoes as recorded;
/// they are used until the levels with gain have been counted.
pub(super) fn look(
    app: &App,
    lens: &Lens,
    picture: Option<&LogPicture>,
    first: Levels,
) -> EchoStyle {
    let settings = &app.logs.shown.settings.picture;
    let tone = settings.tone();
    let automatic = app.histogram().map_or(first, |counted| counted.automatic);
    let level = |fixed: Option<f64>, automatic: f32| {
        fixed.map_or(automatic, |level| (level / 255.0) as f32)
    };
    let black = level(settings.black, automatic.black);
    let white = level(settings.white, automatic.white);
    let gain = picture.and_then(|picture| picture.gain.as_deref());
    let filter = |is_on: bool, bit: u32| if is_on { bit } else { 0 };
    // Gain depends on the scales of the pings, which are not known without a picture.
    let known = picture.is_some();
    let [port, starboard] = tone.sides;
    EchoStyle {
        geometry: match lens.geometry() {
            PictureGeometry::Slant => 0,
            PictureGeometry::SlantBeyondWater => 1,
            PictureGeometry::Ground => 2,
        },
        filters: filter(tone.is_normalised && gain.is_some(), GAIN)
            + filter(tone.is_even && known, STRIPES)
            + filter(settings.despeckle, MEDIAN),
        spreading: if known { tone.spreading_db } else { 0.0 },
        absorption: if known { tone.absorption_db_m } else { 0.0 },
        middle_m: picture.map_or(1.0, |picture| picture.middle_m),
        port,
        starboard,
        curve_far_m: gain.map_or(1.0, |gain| gain.far_m as f32),
        curve_factor: gain.map_or(1.0, |gain| gain.stretch),
        ..plain_look(app, lens, Levels { black, white })
    }
}

/// Returns the parameters for echoes as recorded, with levels that suit them.
pub(super) fn plain_look(app: &App, lens: &Lens, levels: Levels) -> EchoStyle {
    EchoStyle {
        gamma: app.logs.shown.settings.picture.gamma.max(0.01) as f32,
        highlight: HIGHLIGHT,
        black: levels.black,
        white: levels.white.max(levels.black + LEAST_CONTRAST),
        time_is_down: u32::from(lens.orientation == Orientation::Vertical),
        linear_target: 0,
        geometry: 0,
        filters: 0,
        spreading: 0.0,
        absorption: 0.0,
        middle_m: 1.0,
        port: 1.0,
        starboard: 1.0,
        curve_far_m: 1.0,
        curve_factor: 1.0,
        padding: 0.0,
    }
}

#[cfg(test)]
mod tests {
    use bathyscope_bottom::mosaic::GainTable;
    use bathyscope_bottom::picture::LEAST_RANGE_M;

    #[test]
    fn the_shader_knows_the_curves_as_they_are() {
        let source = include_str!("../../../../shaders/waterfall.wgsl");
        let constant = |name: &str| -> f32 {
            let line = source.lines().find(|line| line.contains(&format!("const {name}:")));
            let value = line.and_then(|line| line.split(['=', ';']).nth(1));
            value.and_then(|value| value.trim().parse().ok()).expect(name)
        };
        assert_eq!(constant("RANGE_BINS"), GainTable::RANGES as f32);
        assert_eq!(constant("ANGLE_BINS"), GainTable::ANGLES as f32);
        assert_eq!(constant("LEAST_FACTOR"), GainTable::BOUNDS[0]);
        assert_eq!(constant("MOST_FACTOR"), GainTable::BOUNDS[1]);
        assert_eq!(constant("LEAST_RANGE_M"), LEAST_RANGE_M);
    }
}

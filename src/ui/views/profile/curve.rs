//! Draws the curves: raw samples faint behind, normalised intensity in front, with the
//! normalisation of the whole picture.

use super::{ProfilePlot, Shown};
use crate::app::ViewOptions;
use crate::ui::flat::{PaintedArea, RasterTexture};
use crate::ui::{ViewContext, place, theme};
use bathyscope_bottom::cloud::Reduction;
use bathyscope_bottom::first_return::{ImageSettings, Normalisation, SampleMode};
use bathyscope_log::survey::{Side, SideSpan, Survey};
use bathyscope_products::pipeline::Background;
use egui::{Color32, Painter, Pos2, pos2};
use std::sync::Arc;

/// Width of a curve, points.
const WIDTH: f32 = 1.0;

/// Inputs for which a measured normalisation is valid.
#[derive(Clone, PartialEq)]
pub(super) struct ScaleKey {
    survey_serial: u64,
    image: ImageSettings,
    dead_zone_m: f64,
}

/// The normalisation of the whole picture, measured in a background thread. It is measured again
/// when survey, image or dead zone change; the newest request wins.
pub(super) type ScaleJob = Background<ScaleKey, (ScaleKey, Normalisation)>;

/// Returns the normalisation for the present settings; during the measurement the last one with the
/// same survey and image, or else the full scale of a sample.
pub(super) fn normalisation(
    job: &mut ScaleJob,
    context: &ViewContext<'_>,
    survey: &Arc<Survey>,
) -> Normalisation {
    let settings = &context.app.logs.shown.settings;
    let key = ScaleKey {
        survey_serial: context.app.view.survey_serial,
        image: settings.image.clone(),
        dead_zone_m: settings.first_return.dead_zone_m,
    };
    let (requested, survey) = (key.clone(), survey.clone());
    job.ask(key.clone(), context.app.jobs.workers(), move |progress| {
        let (image, dead_zone_m) = (&requested.image, requested.dead_zone_m);
        let measured = Normalisation::measure(&survey, image, dead_zone_m, progress).ok()?;
        Some((requested, measured))
    });
    let usable = job
        .result()
        .filter(|(known, _)| known.survey_serial == key.survey_serial && known.image == key.image);
    match usable {
        // The dead zone follows its slider at once; its effect on the extremes follows when the
        // measurement has ended.
        Some((_, measured)) => Normalisation { dead_zone_m: key.dead_zone_m, ..measured.clone() },
        None => full_scale(&key),
    }
}

fn full_scale(key: &ScaleKey) -> Normalisation {
    Normalisation {
        samples: key.image.samples,
        dead_zone_m: key.dead_zone_m,
        lowest: 0,
        highest: match key.image.samples {
            SampleMode::Bytes => i32::from(u8::MAX),
            SampleMode::Words => i32::MAX,
        },
    }
}

/// Draws both curves on both sides.
pub(super) fn draw(
    painter: &Painter,
    plot: &ProfilePlot,
    shown: &Shown<'_>,
    normalisation: &Normalisation,
    options: &ViewOptions,
    picture: &mut Option<RasterTexture>,
) {
    let ink = theme::plot_ink(options);
    let mut raster = PaintedArea::new(painter, plot.area.expand(1.0), Color32::TRANSPARENT);
    for side in Side::BOTH {
        let Some(span) = shown.recorded.side(side) else {
            continue;
        };
        if let Some(samples) = shown.survey.samples(shown.ping, side) {
            let raw: Vec<f32> =
                (0..samples.len()).map(|index| f32::from(samples.get(index)) / 255.0).collect();
            let faint = ink.gamma_multiply(0.45);
            let points = points(plot, shown.reduction, span, side, &raw);
            raster.line(&points, WIDTH, faint);
        }
        let normalised = normalisation.profile(shown.survey, shown.ping, side);
        let points = points(plot, shown.reduction, span, side, &normalised);
        raster.line(&points, WIDTH, ink);
    }
    raster.show(painter, picture);
}

/// Returns one vertex for each value, or the largest and smallest value of a pixel column if
/// several values are in one.
fn points(
    plot: &ProfilePlot,
    reduction: Reduction<'_>,
    span: &SideSpan,
    side: Side,
    values: &[f32],
) -> Vec<Pos2> {
    let samples_per_value = f64::from(span.count) / values.len().max(1) as f64;
    let x = |index: usize| {
        let range_m = reduction.range_m(span, (index as f64 + 0.5) * samples_per_value);
        plot.x(place::across_m(side, range_m))
    };
    let mut points: Vec<Pos2> = Vec::new();
    let mut column: Option<(f32, f32, f32)> = None;
    let mut finish = |column: Option<(f32, f32, f32)>| {
        if let Some((x, low, high)) = column {
            points.push(pos2(x, plot.y(low)));
            if high > low {
                points.push(pos2(x, plot.y(high)));
            }
        }
    };
    for (index, &value) in values.iter().enumerate() {
        let x = x(index);
        column = match column {
            Some((at, low, high)) if (at - x).abs() < 1.0 => {
                Some((at, low.min(value), high.max(value)))
            }
            before => {
                finish(before);
                Some((x, value, value))
            }
        };
    }
    finish(column);
    points
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::app::{App, Command, Jobs, View};
    use bathyscope_log::support::progress::Progress;

    #[test]
    fn the_first_frame_of_a_picture_has_the_scale_of_its_survey() {
        let mut app = App::new(Jobs::Inline);
        app.apply(Command::OpenDemo);
        app.poll();
        let survey = app.logs.shown.survey.clone().expect("the demo");
        let context = ViewContext {
            app: &app,
            render_state: None,
            target: View::Waterfall,
            commands: &mut Vec::new(),
        };
        let mut job = ScaleJob::default();
        let shown = normalisation(&mut job, &context, &survey);
        assert!(!job.is_running());
        let settings = &app.logs.shown.settings;
        let (image, dead_zone_m) = (&settings.image, settings.first_return.dead_zone_m);
        let measured = Normalisation::measure(&survey, image, dead_zone_m, &Progress::new());
        assert_eq!(format!("{shown:?}"), format!("{:?}", measured.expect("not cancelled")));
    }
}

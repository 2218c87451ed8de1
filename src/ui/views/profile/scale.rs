//! The normalisation of the whole picture, measured once in a background thread.

use crate::ui::ViewContext;
use bathyscope_bottom::first_return::{ImageSettings, Normalisation, SampleMode};
use bathyscope_log::survey::Survey;
use bathyscope_products::pipeline::Background;
use std::sync::Arc;

/// Inputs that a measurement is valid for.
#[derive(Clone, PartialEq)]
struct ScaleKey {
    survey_serial: u64,
    image: ImageSettings,
    dead_zone_m: f64,
}

/// Measures again when survey, image or dead zone change; the newest request wins.
#[derive(Default)]
pub(super) struct ScaleJob(Background<ScaleKey, (ScaleKey, Normalisation)>);

impl ScaleJob {
    /// The normalisation for the present settings; while it is measured, the last one, or the full
    /// scale of a sample.
    pub(super) fn of(&mut self, context: &ViewContext<'_>, survey: &Arc<Survey>) -> Normalisation {
        let settings = &context.app.log.settings;
        let key = ScaleKey {
            survey_serial: context.app.view.survey_serial,
            image: settings.image.clone(),
            dead_zone_m: settings.first_return.dead_zone_m,
        };
        let (requested, survey) = (key.clone(), survey.clone());
        self.0.ask(key.clone(), context.app.jobs(), move |progress| {
            let (image, dead_zone_m) = (&requested.image, requested.dead_zone_m);
            let measured = Normalisation::measure(&survey, image, dead_zone_m, progress).ok()?;
            Some((requested, measured))
        });
        let usable = self.0.result().filter(|(known, _)| {
            known.survey_serial == key.survey_serial && known.image == key.image
        });
        match usable {
            // The dead zone follows its slider at once; its effect on the extremes comes with the
            // measurement.
            Some((_, measured)) => {
                Normalisation { dead_zone_m: key.dead_zone_m, ..measured.clone() }
            }
            None => full_scale(&key),
        }
    }

    /// Returns true if the scale is that of the settings, or cannot be measured.
    pub(super) fn is_settled(&self) -> bool {
        !self.0.is_running()
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
        let survey = app.log.survey.clone().expect("the demo");
        let context = ViewContext {
            app: &app,
            render_state: None,
            target: View::Waterfall,
            commands: &mut Vec::new(),
        };
        let mut job = ScaleJob::default();
        let shown = job.of(&context, &survey);
        assert!(job.is_settled());
        let settings = &app.log.settings;
        let (image, dead_zone_m) = (&settings.image, settings.first_return.dead_zone_m);
        let measured = Normalisation::measure(&survey, image, dead_zone_m, &Progress::new());
        assert_eq!(format!("{shown:?}"), format!("{:?}", measured.expect("not cancelled")));
    }
}

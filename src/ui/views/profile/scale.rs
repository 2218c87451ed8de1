//! The normalisation of the whole picture, measured once off the window's thread.

use crate::first_return::{ImageSettings, Normalisation, SampleMode};
use crate::progress::Progress;
use crate::survey::Survey;
use crate::ui::ViewContext;
use std::sync::{Arc, mpsc};

/// What a measurement is valid for.
#[derive(Clone, PartialEq)]
struct Key {
    survey_serial: u64,
    image: ImageSettings,
    dead_zone_m: f64,
}

/// Measures again when survey, image or dead zone change; the newest wish wins.
#[derive(Default)]
pub(super) struct ScaleJob {
    known: Option<(Key, Normalisation)>,
    running: Option<(Key, Progress, mpsc::Receiver<Normalisation>)>,
}

impl ScaleJob {
    /// The normalisation for the present settings; while it is measured, the last one, or the full scale of a sample.
    pub fn of(
        &mut self,
        ctx: &egui::Context,
        context: &ViewContext<'_>,
        survey: &Arc<Survey>,
    ) -> Normalisation {
        let settings = &context.app.settings;
        let key = Key {
            survey_serial: context.app.survey_serial,
            image: settings.image.clone(),
            dead_zone_m: settings.first_return.dead_zone_m,
        };
        self.collect();
        let is_known = self.known.as_ref().is_some_and(|(known, _)| *known == key);
        let is_running = self
            .running
            .as_ref()
            .is_some_and(|(running, ..)| *running == key);
        if !is_known && !is_running {
            self.start(key.clone(), survey.clone(), ctx.clone());
        }
        let usable = self.known.as_ref().filter(|(known, _)| {
            known.survey_serial == key.survey_serial && known.image == key.image
        });
        match usable {
            // The dead zone follows its slider at once; its effect on the extremes comes with the measurement.
            Some((_, measured)) => Normalisation {
                dead_zone_m: key.dead_zone_m,
                ..measured.clone()
            },
            None => full_scale(&key),
        }
    }

    fn collect(&mut self) {
        let Some((key, _, result)) = &self.running else {
            return;
        };
        match result.try_recv() {
            Ok(measured) => {
                self.known = Some((key.clone(), measured));
                self.running = None;
            }
            // A worker that died leaves the full scale in force; it is not started again for the same key.
            Err(mpsc::TryRecvError::Disconnected | mpsc::TryRecvError::Empty) => {}
        }
    }

    fn start(&mut self, key: Key, survey: Arc<Survey>, ctx: egui::Context) {
        if let Some((_, progress, _)) = self.running.take() {
            progress.cancel();
        }
        let progress = Progress::new();
        let (sender, result) = mpsc::channel();
        self.running = Some((key.clone(), progress.clone(), result));
        std::thread::spawn(move || {
            let measured = Normalisation::measure(&survey, &key.image, key.dead_zone_m, &progress);
            if let Ok(measured) = measured {
                // Nobody listens when the wish was replaced.
                sender.send(measured).ok();
                ctx.request_repaint_after(std::time::Duration::from_millis(1));
            }
        });
    }
}

fn full_scale(key: &Key) -> Normalisation {
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

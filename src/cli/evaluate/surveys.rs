//! Searches logs whose objects are known, as `bathyscope detect` does, and pairs the boxes with the
//! known objects.

use super::{BoxSource, Boxes};
use crate::cli::Failure;
use crate::cli::status_line::StatusLine;
use bathyscope_log::formats;
use bathyscope_log::support::progress::Progress;
use bathyscope_log::survey::{Identity, Navigation, Side, Survey, navigate};
use bathyscope_objects::labels::Paired;
use bathyscope_objects::metrics::Image;
use bathyscope_objects::truth::{self, RasterTruth, SurveyTruth};
use bathyscope_objects::{DetectError, DetectorSettings, Model, Raster, Scored, find};
use bathyscope_products::pipeline::Settings;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Score from which boxes take part in average precision, as in `training/evaluate.py`.
const LEAST_SCORE: f32 = 0.01;

/// Searches every log twice. The boxes shown are those from `score` on, by the model's own rule of
/// which boxes suppress which. The boxes for average precision are those from [`LEAST_SCORE`] on,
/// where a box suppresses only others of its class, as in Darknet and COCO.
pub(super) fn search(
    logs: &[PathBuf],
    truth: Option<&Path>,
    model: Option<&Path>,
    score: Option<f64>,
) -> Result<Boxes, Failure> {
    if let (Some(_), [_, _, ..]) = (truth, logs) {
        return Err(
            "--truth is about one log; of several each has its LOG.objects.csv beside it".into()
        );
    }
    let shown = Model::load_or_shipped(model)?;
    let mut ranked = Model::load_or_shipped(model)?;
    ranked.nms.across_classes = false;
    let score = score.unwrap_or(f64::from(shown.score));
    let mut found = Found { classes: shown.classes().to_vec(), ..Found::default() };
    let searches = [(ranked, LEAST_SCORE), (shown, score as f32)];
    let status = StatusLine::new();
    for (number, log) in (1..).zip(logs) {
        status.step(&format!("log {number} of {}", logs.len()));
        let known = Known::open(log, truth, searches[0].0.pixel_m)?;
        let searched = found.add(&known, &searches);
        searched.map_err(|error| format!("{error}: {}", log.display()))?;
        known.survey.check_files()?;
    }
    drop(status);
    Ok(found.finish(logs, score))
}

/// Log and its known objects.
struct Known {
    survey: Survey,
    navigation: Navigation,
    raster: Raster,
    on_raster: RasterTruth,
}

impl Known {
    fn open(log: &Path, truth: Option<&Path>, pixel_m: f64) -> Result<Self, Failure> {
        let progress = Progress::new();
        let survey = formats::open(log, &progress)?;
        let sidecar = log.with_extension(truth::SIDECAR);
        let path = truth.unwrap_or(&sidecar);
        if truth.is_none() && !path.is_file() {
            return Err(format!(
                "nothing is known of the objects in this log; name a table of them or a review with --truth: {}",
                log.display()
            ).into());
        }
        let truth = SurveyTruth::read(path, &Identity::of(&survey))?;
        let settings = Settings::default();
        let navigation = navigate(&survey, &settings.heading, settings.projection, &progress)?;
        let raster = Raster::new(&survey, &navigation, pixel_m);
        let on_raster = RasterTruth::new(&raster, Arc::new(truth));
        Ok(Self { survey, navigation, raster, on_raster })
    }

    /// Searches the log and returns the boxes of each side.
    fn search(&self, model: &Model, score: f32) -> Result<[Vec<Scored>; 2], DetectError> {
        let settings = DetectorSettings {
            score: Some(score),
            // The quality of the class names is part of what is evaluated.
            name_score: Some(0.0),
            ..DetectorSettings::default()
        };
        let progress = Progress::new();
        let found = find(&self.survey, &self.navigation, model, &settings, &progress, |_| ())?;
        Ok(Side::BOTH.map(|side| {
            let of_side = found.iter().filter(|detection| detection.mark.side == side);
            let scored = of_side.map(|detection| Scored {
                class: detection.class,
                score: detection.score,
                rect: self.raster.rect_of(&detection.mark),
            });
            scored.collect()
        }))
    }
}

/// Boxes found so far: a picture for each side of each log.
#[derive(Default)]
struct Found {
    classes: Vec<String>,
    names: Vec<String>,
    ranked: Vec<Image>,
    shown: Vec<Image>,
}

impl Found {
    /// Searches a log with both models: first for the ranked boxes, then for the shown ones.
    fn add(&mut self, known: &Known, searches: &[(Model, f32); 2]) -> Result<(), DetectError> {
        let name = known.survey.name();
        let images = known.on_raster.images(&mut self.classes);
        for ((model, score), into) in searches.iter().zip([&mut self.ranked, &mut self.shown]) {
            let boxes = known.search(model, *score)?;
            let pictures = images
                .iter()
                .zip(boxes)
                .map(|(image, predicted)| Image { truth: image.truth.clone(), predicted });
            into.extend(pictures);
        }
        let sides = Side::BOTH.map(|side| format!("{name}, {}", side.name()));
        self.names.extend(sides);
        Ok(())
    }

    fn finish(self, logs: &[PathBuf], score: f64) -> Boxes {
        let path = match logs {
            [log] => log.display().to_string(),
            [first, rest @ ..] => format!("{} and {} more", first.display(), rest.len()),
            [] => String::new(),
        };
        let source = |format: &str, boxes: usize| BoxSource {
            format: format.to_owned(),
            pictures: self.names.len(),
            boxes,
            path: path.clone(),
        };
        let counted = |image: &Image| image.truth.iter().filter(|object| !object.ignored).count();
        let unseen = |image: &Image| image.truth.iter().filter(|object| object.ignored).count();
        let unseen: usize = self.shown.iter().map(unseen).sum();
        let note = format!(
            "{unseen} more objects lie there that nobody could see in the echoes; they count neither as found nor as missed"
        );
        Boxes {
            truth: source("known objects", self.shown.iter().map(counted).sum()),
            predicted: source(
                "objects found",
                self.shown.iter().map(|image| image.predicted.len()).sum(),
            ),
            paired: Paired {
                names: self.names,
                images: self.shown,
                classes: self.classes,
                notes: if unseen > 0 { vec![note] } else { Vec::new() },
            },
            ranked: Some(self.ranked),
            score,
        }
    }
}

//! Finds first returns ahead of the pipeline, so that the drawn line follows the slider.
//!
//! The plain threshold is evaluated for the whole log from its index of running maxima; the tracker
//! is run over the visible pings. One job runs at a time, and the newest request waits for it: if
//! each request cancelled the last job, nothing at all would appear during a long drag.

use super::App;
use super::jobs::{JobKey, JobQueue};
use bathyscope_bottom::first_return::{
    BottomSettings, FirstReturnSettings, FirstReturns, ImageSettings, Method, Normalisation,
    SampleMode, ThresholdIndex, track_range,
};
use bathyscope_log::support::progress::{Cancelled, Progress};
use bathyscope_log::survey::Survey;
use bathyscope_products::pipeline::Settings;
use std::ops::Range;
use std::sync::Arc;

/// Request for the first returns of some settings.
pub(super) struct PreviewRequest {
    pub survey: Arc<Survey>,
    pub image: ImageSettings,
    pub first_return: FirstReturnSettings,
    /// Manual picks that replace the found ones.
    pub bottom: BottomSettings,
    /// Visible pings.
    pub visible: Range<usize>,
    /// The last result, which pings outside the visible ones keep.
    pub base: Arc<FirstReturns>,
}

impl PreviewRequest {
    fn key(&self) -> PreviewKey {
        PreviewKey {
            method: self.first_return.method,
            samples: self.image.samples,
            dead_zone_m: self.first_return.dead_zone_m,
        }
    }
}

/// A measurement of the log that is made once and kept between drags: the plain threshold needs its
/// index, the tracker only the scale of the picture, which takes no memory.
enum Measured {
    Index(ThresholdIndex),
    Scale(Normalisation),
}

impl Measured {
    fn measure(request: &PreviewRequest, progress: &Progress) -> Result<Self, Cancelled> {
        let (survey, image) = (&request.survey, &request.image);
        let dead_zone_m = request.first_return.dead_zone_m;
        match request.first_return.method {
            Method::Threshold => {
                ThresholdIndex::build(survey, image, dead_zone_m, progress).map(Self::Index)
            }
            Method::Tracker => {
                Normalisation::measure(survey, image, dead_zone_m, progress).map(Self::Scale)
            }
        }
    }
}

/// Inputs of [`Measured`] besides the survey.
#[derive(Clone, Copy, PartialEq)]
struct PreviewKey {
    method: Method,
    samples: SampleMode,
    dead_zone_m: f64,
}

/// First returns that were found with some settings.
struct Preview {
    image: ImageSettings,
    first_return: FirstReturnSettings,
    returns: Arc<FirstReturns>,
}

impl Preview {
    /// Returns true if the first returns were found with the settings in force.
    fn is_for(&self, settings: &Settings) -> bool {
        self.image == settings.image && self.first_return.finds_the_same(&settings.first_return)
    }
}

struct Answer {
    key: PreviewKey,
    measured: Arc<Measured>,
    preview: Option<Preview>,
}

/// The measurements of the shown log, and the request that waits for the running one.
#[derive(Default)]
pub(super) struct Previewer {
    measured: Option<(PreviewKey, Arc<Measured>)>,
    queued: Option<PreviewRequest>,
}

impl Previewer {
    /// Makes the measurement for `request` in advance, so that the first drag does not have to wait
    /// for it.
    pub(super) fn warm_up(&mut self, request: PreviewRequest, jobs: &mut JobQueue) {
        let known = self.measured.as_ref().map(|(key, _)| *key);
        if known != Some(request.key()) && !jobs.is_running(&JobKey::Preview) {
            self.start(request, jobs, false);
        }
    }

    /// Requests first returns; an older request that has not begun is dropped.
    pub(super) fn want(&mut self, request: PreviewRequest, jobs: &mut JobQueue) {
        if jobs.is_running(&JobKey::Preview) {
            self.queued = Some(request);
        } else {
            self.start(request, jobs, true);
        }
    }

    fn start(&mut self, request: PreviewRequest, jobs: &mut JobQueue, requested: bool) {
        let key = request.key();
        let known = self.measured.as_ref().filter(|(known, _)| *known == key);
        let known = known.map(|(_, measured)| measured.clone());
        jobs.run(
            JobKey::Preview,
            move |progress| answer(request, known, requested, progress).ok(),
            App::take_preview,
        );
    }
}

impl App {
    /// Shows first returns that were found ahead of the pipeline, if their settings are still in
    /// force, and starts the search that waited.
    fn take_preview(&mut self, answer: Option<Answer>) {
        if let Some(Answer { key, measured, preview }) = answer {
            self.pipeline.previewer.measured = Some((key, measured));
            let is_current = |preview: &Preview| preview.is_for(&self.logs.shown.settings);
            if let Some(preview) = preview.filter(is_current)
                && self.logs.shown.stale().is_some()
            {
                self.logs.shown.preview = Some(preview.returns);
            }
        }
        if let Some(request) = self.pipeline.previewer.queued.take() {
            self.pipeline.previewer.start(request, &mut self.jobs, true);
        }
    }
}

fn answer(
    request: PreviewRequest,
    known: Option<Arc<Measured>>,
    requested: bool,
    progress: &Progress,
) -> Result<Answer, Cancelled> {
    let key = request.key();
    let measured = match known {
        Some(measured) => measured,
        None => Arc::new(Measured::measure(&request, progress)?),
    };
    let preview = if requested {
        let mut returns = search(&request, &measured, progress)?;
        request.bottom.apply(&request.survey, &mut returns);
        Some(Preview {
            image: request.image,
            first_return: request.first_return,
            returns: Arc::new(returns),
        })
    } else {
        None
    };
    Ok(Answer { key, measured, preview })
}

fn search(
    request: &PreviewRequest,
    measured: &Measured,
    progress: &Progress,
) -> Result<FirstReturns, Cancelled> {
    let settings = &request.first_return;
    match measured {
        Measured::Index(index) => {
            Ok(index.detect(&request.survey, settings.threshold, settings.above_bottom_margin_m))
        }
        Measured::Scale(normalisation) => {
            let end = request.visible.end.min(request.base.port.len());
            let pings = request.visible.start.min(end)..end;
            let seen =
                track_range(&request.survey, normalisation, settings, pings.clone(), progress)?;
            let mut all = FirstReturns::clone(&request.base);
            let sides = [(&mut all.port, &seen.port), (&mut all.starboard, &seen.starboard)];
            for (all, seen) in sides {
                Arc::make_mut(all)[pings.clone()].copy_from_slice(seen);
            }
            all.warnings = seen.warnings;
            Ok(all)
        }
    }
}

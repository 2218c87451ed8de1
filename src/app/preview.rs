//! First returns ahead of the pipeline, so that the line follows the slider.
//!
//! The plain threshold is answered for the whole log from its index of running maxima; the tracker
//! is run over the pings on screen. One job runs at a time and the newest request waits for it:
//! cancelling each time would show nothing at all during a long drag.

use super::{Jobs, Task, TaskOutcome};
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
    /// Manual picks that replace what is found.
    pub bottom: BottomSettings,
    /// Pings on screen.
    pub visible: Range<usize>,
    /// The last result; pings that are not on screen keep it.
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

/// Measurement that is made once and kept between drags: the plain threshold needs its index, the
/// tracker only the picture's scale, which takes no memory.
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

/// First returns of some settings.
pub(super) struct Preview {
    image: ImageSettings,
    first_return: FirstReturnSettings,
    pub returns: Arc<FirstReturns>,
}

impl Preview {
    /// Returns true if these are still the settings in force.
    pub(super) fn is_for(&self, settings: &Settings) -> bool {
        self.image == settings.image && self.first_return.finds_the_same(&settings.first_return)
    }
}

struct Answer {
    key: PreviewKey,
    measured: Arc<Measured>,
    preview: Option<Preview>,
}

type Running = Task<Result<Answer, Cancelled>>;

/// Answers requests one after the other, leaving out those that a newer one replaced.
#[derive(Default)]
pub(super) struct Previewer {
    measured: Option<(PreviewKey, Arc<Measured>)>,
    running: Option<Running>,
    queued: Option<PreviewRequest>,
}

impl Previewer {
    /// Drops everything that belongs to the survey and whatever is under way.
    pub(super) fn forget(&mut self) {
        *self = Self::default();
    }

    /// Returns true if an answer is still to come.
    pub(super) fn is_busy(&self) -> bool {
        self.running.is_some() || self.queued.is_some()
    }

    /// Measures what `request` would need, so that the first drag finds it.
    pub(super) fn warm_up(&mut self, request: PreviewRequest, jobs: &Jobs) {
        let known = self.measured.as_ref().map(|(key, _)| *key);
        if known != Some(request.key()) && !self.is_busy() {
            self.start(request, jobs, false);
        }
    }

    /// Asks for first returns; an older request that has not begun is dropped.
    pub(super) fn want(&mut self, request: PreviewRequest, jobs: &Jobs) {
        if self.running.is_some() {
            self.queued = Some(request);
        } else {
            self.start(request, jobs, true);
        }
    }

    fn start(&mut self, request: PreviewRequest, jobs: &Jobs, requested: bool) {
        let key = request.key();
        let known = self.measured.as_ref().filter(|(known, _)| *known == key);
        let known = known.map(|(_, measured)| measured.clone());
        self.running =
            Some(Task::start(jobs, move |progress| answer(request, known, requested, progress)));
    }

    /// The newest answer, once.
    pub(super) fn poll(&mut self, jobs: &Jobs) -> Option<Preview> {
        let outcome = self.running.as_ref()?.poll();
        let answer = match outcome {
            TaskOutcome::Pending => return None,
            TaskOutcome::Done(answer) => answer.ok(),
            TaskOutcome::Failed => None,
        };
        self.running = None;
        let preview = answer.and_then(|answer| {
            self.measured = Some((answer.key, answer.measured));
            answer.preview
        });
        if let Some(request) = self.queued.take() {
            self.start(request, jobs, true);
        }
        preview
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

//! First returns ahead of the pipeline, so that the line follows the slider.
//!
//! The plain threshold is answered for the whole log from its index of running maxima; the tracker is run over the pings
//! on screen. One job runs at a time and the newest request waits for it: cancelling each time would show nothing at all
//! during a long drag.

use super::{Jobs, Outcome, Task};
use crate::first_return::{
    FirstReturnSettings, FirstReturns, ImageSettings, Method, SampleMode, ThresholdIndex,
    track_range,
};
use crate::pipeline::Settings;
use crate::progress::{Cancelled, Progress};
use crate::survey::Survey;
use std::ops::Range;
use std::sync::Arc;

/// What is asked for.
pub(super) struct Request {
    pub survey: Arc<Survey>,
    pub image: ImageSettings,
    pub first_return: FirstReturnSettings,
    /// Pings on screen.
    pub visible: Range<usize>,
    /// The last result; pings that are not on screen keep it.
    pub base: Arc<FirstReturns>,
}

impl Request {
    fn key(&self) -> IndexKey {
        IndexKey {
            samples: self.image.samples,
            dead_zone_m: self.first_return.dead_zone_m,
        }
    }
}

/// What an index depends on besides the survey.
#[derive(Clone, Copy, PartialEq)]
struct IndexKey {
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
    /// Whether these are still the settings in force.
    pub fn is_for(&self, settings: &Settings) -> bool {
        self.image == settings.image && self.first_return == settings.first_return
    }
}

struct Answer {
    key: IndexKey,
    index: Arc<ThresholdIndex>,
    preview: Option<Preview>,
}

type Running = Task<Result<Answer, Cancelled>>;

/// Answers requests one after the other, leaving out those that a newer one replaced.
#[derive(Default)]
pub(super) struct Previewer {
    index: Option<(IndexKey, Arc<ThresholdIndex>)>,
    running: Option<Running>,
    queued: Option<Request>,
}

impl Previewer {
    /// Drops everything that belongs to the survey and whatever is under way.
    pub fn forget(&mut self) {
        *self = Self::default();
    }

    /// Whether an answer is still to come.
    pub fn is_busy(&self) -> bool {
        self.running.is_some() || self.queued.is_some()
    }

    /// Builds the index that `request` would need, so that the first drag finds it.
    pub fn warm_up(&mut self, request: Request, jobs: &Jobs) {
        let known = self.index.as_ref().map(|(key, _)| *key);
        if known != Some(request.key()) && !self.is_busy() {
            self.start(request, jobs, false);
        }
    }

    /// Asks for first returns; an older request that has not begun is dropped.
    pub fn want(&mut self, request: Request, jobs: &Jobs) {
        if self.running.is_some() {
            self.queued = Some(request);
        } else {
            self.start(request, jobs, true);
        }
    }

    fn start(&mut self, request: Request, jobs: &Jobs, wanted: bool) {
        let key = request.key();
        let known = self.index.as_ref().filter(|(known, _)| *known == key);
        let known = known.map(|(_, index)| index.clone());
        self.running = Some(Task::start(jobs, move |progress| {
            answer(request, known, wanted, progress)
        }));
    }

    /// The newest answer, once.
    pub fn poll(&mut self, jobs: &Jobs) -> Option<Preview> {
        let outcome = self.running.as_ref()?.poll();
        let answer = match outcome {
            Outcome::Pending => return None,
            Outcome::Done(answer) => answer.ok(),
            Outcome::Failed => None,
        };
        self.running = None;
        let preview = answer.and_then(|answer| {
            self.index = Some((answer.key, answer.index));
            answer.preview
        });
        if let Some(request) = self.queued.take() {
            self.start(request, jobs, true);
        }
        preview
    }
}

fn answer(
    request: Request,
    known: Option<Arc<ThresholdIndex>>,
    wanted: bool,
    progress: &Progress,
) -> Result<Answer, Cancelled> {
    let key = request.key();
    let dead_zone_m = request.first_return.dead_zone_m;
    let index = match known {
        Some(index) => index,
        None => Arc::new(ThresholdIndex::build(
            &request.survey,
            &request.image,
            dead_zone_m,
            progress,
        )?),
    };
    let preview = if wanted {
        let returns = Arc::new(search(&request, &index, progress)?);
        Some(Preview {
            image: request.image,
            first_return: request.first_return,
            returns,
        })
    } else {
        None
    };
    Ok(Answer {
        key,
        index,
        preview,
    })
}

fn search(
    request: &Request,
    index: &ThresholdIndex,
    progress: &Progress,
) -> Result<FirstReturns, Cancelled> {
    let settings = &request.first_return;
    match settings.method {
        Method::Threshold => Ok(index.detect(
            &request.survey,
            settings.threshold,
            settings.canopy_margin_m,
        )),
        Method::Tracker => {
            let end = request.visible.end.min(request.base.port.len());
            let pings = request.visible.start.min(end)..end;
            let normalisation = index.normalisation();
            let seen = track_range(
                &request.survey,
                normalisation,
                settings,
                pings.clone(),
                progress,
            )?;
            let mut all = FirstReturns::clone(&request.base);
            all.port[pings.clone()].copy_from_slice(&seen.port);
            all.starboard[pings].copy_from_slice(&seen.starboard);
            all.warnings = seen.warnings;
            Ok(all)
        }
    }
}

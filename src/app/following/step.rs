//! Reads the new bytes of a followed log in a background thread, and computes results from them.

use crate::app::error::AppError;
use bathyscope_log::formats::{GrowingError, GrowingLog, open_at_hand, open_growing, open_tail};
use bathyscope_log::support::geo::LocalFrame;
use bathyscope_log::support::progress::{Cancelled, Progress};
use bathyscope_log::survey::{Bytes, Survey, SurveyVersions};
use bathyscope_products::pipeline::{
    GrowingResults, LogSettings, ProcessedLog, Products, Settings, SourceKey, as_set, extend, run,
};
use std::path::PathBuf;
use std::sync::Arc;

/// Least share by which the log must grow before more is shown: each shown state is a copy of the
/// whole log, and with this share the work for each ping does not grow with the log.
const LEAST_SHARE: f64 = 1.0 / 4000.0;

/// A state of the log, with its settings and results.
#[derive(Clone)]
pub(super) struct FollowedLog {
    /// The recording as it was read.
    pub read: Arc<Survey>,
    /// The recording with its settings applied.
    pub survey: Arc<Survey>,
    pub products: Products,
    pub shared: Arc<Settings>,
    pub own: Arc<LogSettings>,
}

impl FollowedLog {
    /// Returns the recording with its results.
    pub(super) fn settled(&self) -> ProcessedLog {
        ProcessedLog::new(self.survey.clone(), self.products.clone())
    }

    /// Returns the log's own settings and the composed settings, assigned to a longer state of the
    /// log.
    fn settings_over(
        &self,
        survey: &Survey,
    ) -> Result<(Arc<LogSettings>, Arc<Settings>), AppError> {
        let Some(own) = self.own.carried_to(survey) else {
            return Ok((self.own.clone(), self.products.settings.clone()));
        };
        let settings = own.compose(&self.shared)?;
        Ok((Arc::new(own), Arc::new(settings)))
    }
}

/// State that one step passes to the next: the copy of the log, and the state from which its
/// records and results continue.
pub(super) struct Tools {
    pub growing: GrowingLog,
    /// The first bytes of the log, as many as it had when following began.
    pub beginning: Vec<Bytes>,
    versions: SurveyVersions,
    results: Option<(Arc<Settings>, GrowingResults)>,
}

/// Result of a step.
pub(super) enum Grown {
    /// No bytes were added, or too few to be shown yet; the number of waiting bytes.
    Waits(u64),
    /// The log with the added bytes.
    Longer(Box<FollowedLog>),
    /// The added bytes do not show how the log continues: the whole log has to be read again.
    Anew,
}

impl Tools {
    /// Begins to follow a log: copies its present bytes.
    pub(super) fn start(survey: &Survey, progress: &Progress) -> Result<Self, GrowingError> {
        let growing = GrowingLog::start(survey, progress)?;
        let lengths: Vec<usize> = survey.bytes.iter().map(|bytes| bytes.len()).collect();
        Ok(Self {
            beginning: growing.beginning(&lengths)?,
            growing,
            versions: SurveyVersions::default(),
            results: None,
        })
    }

    /// Reads the added bytes, and computes results from them if they are enough, or if `waits` is
    /// false.
    pub(super) fn step(
        &mut self,
        ground: &FollowedLog,
        waits: bool,
        progress: &Progress,
    ) -> Result<Grown, AppError> {
        self.growing.look(progress)?;
        let known = ground.survey.source.byte_count;
        let added = self.growing.byte_count().saturating_sub(known);
        if added == 0 || (waits && (added as f64) < LEAST_SHARE * known as f64) {
            return Ok(Grown::Waits(added));
        }
        let Some(seam) = ground.read.seam() else {
            return Ok(Grown::Anew);
        };
        let tail = open_tail(&ground.read, &seam, self.growing.bytes()?, progress)?;
        let Some(read) = ground.read.extended(tail, &seam, &mut self.versions) else {
            return Ok(Grown::Anew);
        };
        let read = Arc::new(read);
        let frame = &ground.survey.track.frame;
        let survey = as_it_is_set(&read, &ground.products.settings, Some(frame))?;
        let unchanged = survey.side_scan.partition_point(|ping| ping.time_s < seam.time_s);
        let (own, settings) = ground.settings_over(&survey)?;
        let results = self.results_for(ground, progress)?;
        let products = extend(&survey, unchanged, &ground.products, &settings, results, progress)?;
        Ok(Grown::Longer(Box::new(FollowedLog {
            read,
            survey,
            products,
            shared: ground.shared.clone(),
            own,
        })))
    }

    /// Returns the state from which the results continue by the settings in force; it is measured
    /// over the whole log again if the settings changed.
    fn results_for(
        &mut self,
        ground: &FollowedLog,
        progress: &Progress,
    ) -> Result<&mut GrowingResults, Cancelled> {
        let settings = &ground.products.settings;
        let is_same = |known: &Settings| {
            known.image == settings.image
                && known.first_return.dead_zone_m == settings.first_return.dead_zone_m
        };
        let known = self.results.take().filter(|(known, _)| is_same(known));
        let results = match known {
            Some(known) => known,
            None => {
                let measured = GrowingResults::measure(&ground.survey, settings, progress)?;
                (settings.clone(), measured)
            }
        };
        Ok(&mut self.results.insert(results).1)
    }
}

/// Reads all of a log that is still being written and runs every stage over it.
pub(super) fn whole(
    files: Vec<(PathBuf, Bytes)>,
    is_finished: bool,
    frame: Option<&LocalFrame>,
    ground: &FollowedLog,
    progress: &Progress,
) -> Result<FollowedLog, AppError> {
    let survey =
        if is_finished { open_at_hand(files, progress)? } else { open_growing(files, progress)? };
    let read = Arc::new(survey);
    let survey = as_it_is_set(&read, &ground.own.compose(&ground.shared)?, frame)?;
    let own = ground.own.carried_to(&survey);
    let own = own.map_or_else(|| ground.own.clone(), Arc::new);
    let settings = own.compose(&ground.shared)?;
    let products = run(&survey, &settings, None, progress, |_| ())?;
    Ok(FollowedLog { read, survey, products, shared: ground.shared.clone(), own })
}

/// Returns a recording with the settings of its source applied, in a local coordinate frame; the
/// same `Arc` if these change nothing.
fn as_it_is_set(
    read: &Arc<Survey>,
    settings: &Settings,
    frame: Option<&LocalFrame>,
) -> Result<Arc<Survey>, AppError> {
    let is_as_read = SourceKey::of(settings) == SourceKey::default();
    let is_there = frame.is_none_or(|frame| frame.origin() == read.track.frame.origin());
    if is_as_read && is_there {
        return Ok(read.clone());
    }
    let set = as_set(Survey::clone(read), settings, None)?;
    Ok(Arc::new(match frame {
        Some(frame) => set.in_frame(frame),
        None => set,
    }))
}

//! Finds the passes that saw a place, for the menu of the map and to go from a selected place to
//! the next pass over it. The search lays out the logs in a background thread; it is dropped when
//! its result is not needed any more.

use super::jobs::JobKey;
use super::{App, LogId, LogPlace, VisibleLog};
use bathyscope_log::support::geo::LonLat;
use bathyscope_log::support::progress::{Cancelled, Progress};
use bathyscope_products::pipeline::{Derived, Pass, passes_over, place_of};

const NO_PLACE: &str = "select a place to port or starboard first, with a click in the waterfall";
const NO_OTHER: &str = "no other pass of the visible logs saw this place";
const NO_PASS: &str = "no pass of the visible logs saw this place";

/// A pass, and the id of its log.
pub type LogPass = (LogId, Pass);

/// State and result of a search for the passes over a place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PassesFound<'a> {
    /// The search is running.
    Searching,
    /// The last search for the menu was for another place, or there was none.
    Unasked,
    /// The search was stopped.
    Stopped,
    /// All passes that were found.
    Found(&'a [LogPass]),
}

/// The last search for the menu of the map, with its result, and the pass that is searched to go to
/// it.
#[derive(Default)]
pub(super) struct Passes {
    listed: Option<(LonLat, Option<Vec<LogPass>>)>,
    next: Option<Goal>,
}

/// A pass to go to.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Goal {
    /// The pass after the one that this place of a log belongs to.
    After(LogId, LogPlace),
    /// The first pass over a position, preferably in the shown log.
    FirstOver(LonLat),
}

/// Returns the place in the middle of a pass, which the other views show.
pub fn mark_of(pass: &Pass) -> LogPlace {
    let (ping, sample) = pass.middle;
    LogPlace { side: Some(pass.side), sample: Some(sample as f32), ..LogPlace::ping(ping) }
}

impl App {
    /// Returns the passes of all visible logs over a position, in the order of the list of logs, or
    /// the state of their search.
    pub fn passes_at(&self, at: LonLat) -> PassesFound<'_> {
        let listed = self.findings.passes.listed.as_ref().filter(|(place, _)| *place == at);
        match listed {
            Some(_) if self.jobs.is_running(&JobKey::ListPasses) => PassesFound::Searching,
            Some((_, Some(found))) => PassesFound::Found(found),
            Some((_, None)) => PassesFound::Stopped,
            None => PassesFound::Unasked,
        }
    }

    /// Starts to search for the passes over a position; the search for another position is dropped.
    pub(super) fn find_passes(&mut self, at: LonLat) {
        let (shown, results) = (self.logs.with_results(), self.pipeline.deriving.results.clone());
        self.findings.passes.listed = Some((at, None));
        self.jobs.run(
            JobKey::ListPasses,
            move |progress| found(&shown, at, &results, progress).ok(),
            move |app, found| app.findings.passes.listed = Some((at, found)),
        );
    }

    /// Starts to search for the next pass over the selected place, and shows the place in it; after
    /// the last pass comes the first.
    pub(super) fn next_pass(&mut self) {
        let Some((id, mark)) = self.selected().filter(|(_, mark)| mark.side.is_some()) else {
            return self.notices.warn(NO_PLACE);
        };
        self.go_to(Goal::After(id, mark));
    }

    /// Starts to search for the first pass of the visible logs over a position, and shows the
    /// position in it.
    pub(super) fn show_place(&mut self, at: LonLat) {
        self.go_to(Goal::FirstOver(at));
    }

    fn go_to(&mut self, to: Goal) {
        let is_searched = self.jobs.is_running(&JobKey::NextPass);
        if self.findings.passes.next.replace(to) == Some(to) && is_searched {
            return;
        }
        let (shown, results) = (self.logs.with_results(), self.pipeline.deriving.results.clone());
        let work = move |progress: &Progress| {
            let at = match to {
                Goal::After(id, mark) => ground_of(&shown, (id, mark), &results, progress).ok()?,
                Goal::FirstOver(at) => Some(at),
            };
            match at {
                Some(at) => found(&shown, at, &results, progress).ok().map(Some),
                None => Some(None),
            }
        };
        let from = self.selected();
        self.jobs.run(JobKey::NextPass, work, move |app, found| {
            // An analyst who has selected another place meanwhile should stay there.
            let Some(passes) = found.filter(|_| app.selected() == from) else {
                return;
            };
            let Some(passes) = passes else {
                return app.notices.warn(NO_PLACE);
            };
            let (next, none) = match to {
                Goal::After(id, mark) => (next_of(&passes, id, mark), NO_OTHER),
                Goal::FirstOver(_) => {
                    let is_shown = |(log, _): &&LogPass| *log == app.logs.shown.id;
                    (passes.iter().find(is_shown).or(passes.first()), NO_PASS)
                }
            };
            match next {
                Some((log, pass)) => app.reveal_in(*log, mark_of(pass)),
                None => app.notices.notify(none),
            }
        });
    }

    fn selected(&self) -> Option<(LogId, LogPlace)> {
        self.view.selection.map(|mark| (self.logs.shown.id, mark))
    }
}

/// Returns the pass after the one that a place of a log belongs to, after the last pass the first;
/// `None` if there is no other.
fn next_of(passes: &[LogPass], id: LogId, mark: LogPlace) -> Option<&LogPass> {
    let is_here = |(log, pass): &LogPass| {
        let [first, last] = pass.pings;
        let is_in = (first.saturating_sub(1)..=last + 1).contains(&mark.ping);
        *log == id && Some(pass.side) == mark.side && is_in
    };
    match passes.iter().position(is_here) {
        Some(here) => passes.iter().cycle().skip(here + 1).take(passes.len() - 1).next(),
        None => passes.first(),
    }
}

/// Returns the passes of some logs over a position, in the order of the logs.
fn found(
    shown: &[VisibleLog],
    at: LonLat,
    results: &Derived,
    progress: &Progress,
) -> Result<Vec<LogPass>, Cancelled> {
    progress.start(shown.len() as u64);
    let mut all = Vec::new();
    for VisibleLog { id, log, .. } in shown {
        let place = log.products.navigation.to_plane(&log.survey.track, at);
        let passes = passes_over(log, place, results, progress)?;
        all.extend(passes.into_iter().map(|pass| (*id, pass)));
        progress.advance(1);
    }
    Ok(all)
}

/// Returns the position of a sample of a log in `shown`; `None` where the sample shows no ground.
fn ground_of(
    shown: &[VisibleLog],
    (id, mark): (LogId, LogPlace),
    results: &Derived,
    progress: &Progress,
) -> Result<Option<LonLat>, Cancelled> {
    let Some(VisibleLog { log, .. }) = shown.iter().find(|shown| shown.id == id) else {
        return Ok(None);
    };
    let Some((side, sample)) = mark.side.zip(mark.sample) else {
        return Ok(None);
    };
    let layout = results.layout(log, progress)?;
    let place = place_of(&layout, mark.ping, side, f64::from(sample));
    let navigation = &log.products.navigation;
    Ok(place.map(|[east_m, north_m]| navigation.to_lon_lat(&log.survey.track, east_m, north_m)))
}

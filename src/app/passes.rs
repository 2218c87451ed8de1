//! Which passes saw a place: for the menu of the map, and from a selected place to the next look at it.

use super::{App, LogId, Mark};
use crate::geo::LonLat;
use crate::pipeline::{Pass, passes_over, place_of};
use rayon::prelude::*;

const NO_PLACE: &str = "select a place beside the track first, with a click in the waterfall, to see it in its other passes";
const NO_OTHER: &str = "no other pass of the visible logs saw this place";

/// The place of a pass that the other views show.
pub fn mark_of(pass: &Pass) -> Mark {
    let (ping, sample) = pass.middle;
    Mark {
        side: Some(pass.side),
        sample: Some(sample as f32),
        ..Mark::ping(ping)
    }
}

impl App {
    /// The passes of all visible logs over a position, in the order of the list of logs.
    pub fn passes_at(&self, at: LonLat) -> Vec<(LogId, Pass)> {
        let shown = self.shown_logs();
        let passes = shown.par_iter().map(|shown| {
            let navigation = &shown.log.products.navigation;
            let place = navigation.to_plane(&shown.log.survey.track, at);
            let passes = passes_over(&shown.log, place).into_iter();
            passes.map(|pass| (shown.id, pass)).collect::<Vec<_>>()
        });
        passes.collect::<Vec<_>>().concat()
    }

    /// Goes from the selected place to the same place in the next pass that saw it, and from the last one to the first.
    pub(super) fn next_pass(&mut self) {
        let Some((at, mark)) = self.selected_ground() else {
            return self.notify(NO_PLACE.to_owned(), true);
        };
        let passes = self.passes_at(at);
        let is_here = |(log, pass): &(LogId, Pass)| {
            let [first, last] = pass.pings;
            let is_in = (first.saturating_sub(1)..=last + 1).contains(&mark.ping);
            *log == self.log.id && Some(pass.side) == mark.side && is_in
        };
        let next = match passes.iter().position(is_here) {
            Some(here) => passes
                .iter()
                .cycle()
                .skip(here + 1)
                .take(passes.len() - 1)
                .next(),
            None => passes.first(),
        };
        match next {
            Some((log, pass)) => self.reveal_in(*log, mark_of(pass)),
            None => self.notify(NO_OTHER.to_owned(), false),
        }
    }

    /// Where the selected sample lies.
    fn selected_ground(&self) -> Option<(LonLat, Mark)> {
        let mark = self.selection?;
        let shown = self.shown_logs();
        let shown = shown.iter().find(|shown| shown.id == self.log.id)?;
        let [east_m, north_m] =
            place_of(&shown.log, mark.ping, mark.side?, f64::from(mark.sample?))?;
        let navigation = &shown.log.products.navigation;
        Some((
            navigation.to_lon_lat(&shown.log.survey.track, east_m, north_m),
            mark,
        ))
    }
}

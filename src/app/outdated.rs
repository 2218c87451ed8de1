//! Drops or corrects what is out of date after a change of the open logs, for each kind of change.
//!
//! Most of what is made of logs follows them by itself: results are asked for where they are older
//! than the settings ([`App::schedule`]), and what is made of results where these are others
//! ([`bathyscope_products::pipeline::Background`]). Here is what nothing replaces: it is dropped,
//! or put right.

use super::{App, LogId};
use bathyscope_log::survey::Side;

/// A change of the open logs.
#[derive(Clone, Copy)]
pub(super) enum LogsChange {
    /// All were closed: another survey is opened.
    AllClosed,
    /// The last one was closed; undo opens it again.
    LastClosed,
    /// One was opened in an empty window.
    FirstOpened,
    /// Another one is shown, or none.
    OtherShown,
    /// They lie in another plane.
    OtherPlane,
    /// The sides of this one were exchanged.
    SidesExchanged(LogId),
    /// This one has more pings.
    Grown(LogId),
}

impl App {
    /// Drops what a change puts out of date, or puts it right.
    pub(super) fn follow_change(&mut self, change: LogsChange) {
        match change {
            LogsChange::AllClosed => {
                self.forget_steps();
                self.map.comparing.leave();
                self.findings.heights = Default::default();
                self.findings.positions = Default::default();
                self.findings.objects = Default::default();
            }
            LogsChange::LastClosed => self.map.comparing.leave(),
            // What was closed and measured before lay in another plane.
            LogsChange::FirstOpened => self.forget_steps(),
            LogsChange::OtherShown => {
                self.view.survey_serial += 1;
                self.view.selection = None;
                self.view.hover = None;
                self.view.visible = 0..0;
                self.findings.reference_comparison = Default::default();
                self.pipeline.previewer.forget();
            }
            LogsChange::OtherPlane => {
                self.view.plane_serial += 1;
                // It was counted in the plane of before.
                self.view.options.cloud.clip = None;
                self.view.options.cloud.cut = false;
            }
            LogsChange::SidesExchanged(id) => {
                self.forget_preview(id);
                // What is found in the log as it was would come to the other side.
                self.findings.search.leave(id);
                if id == self.log.id {
                    self.exchange_marks();
                }
            }
            LogsChange::Grown(id) => self.forget_preview(id),
        }
    }

    /// Forgets what undo goes back to, and what is measured on the map.
    fn forget_steps(&mut self) {
        self.logs.closed.clear();
        self.document.history = Default::default();
        self.map.measuring = Default::default();
    }

    /// Forgets what was found ahead of the results of a log, and what was measured of it for the
    /// next time.
    fn forget_preview(&mut self, id: LogId) {
        if let Some(log) = self.log_mut(id) {
            log.preview = None;
        }
        if id == self.log.id {
            self.pipeline.previewer.forget();
        }
    }

    /// Has marks point to the same echo of the shown log once its sides are exchanged.
    fn exchange_marks(&mut self) {
        let marks = [&mut self.view.selection, &mut self.view.hover];
        for mark in marks.into_iter().flatten() {
            mark.side = mark.side.map(Side::other);
        }
    }
}

//! Drops or corrects state that is out of date after a change of the open logs, for each kind of
//! change.
//!
//! Most state that is derived from logs is updated elsewhere: results are computed again if they
//! are older than the settings ([`App::schedule`]), and state derived from results if these changed
//! ([`App::keep`]). This module drops or corrects the state that
//! nothing else replaces.

use super::jobs::JobKey;
use super::{App, LogId};
use bathyscope_log::survey::Side;

/// A change of the open logs.
#[derive(Clone, Copy)]
pub(super) enum LogsChange {
    /// All logs were closed, because another survey is opened.
    AllClosed,
    /// The last log was closed; undo opens it again.
    LastClosed,
    /// A log was opened in an empty window.
    FirstOpened,
    /// Another log is shown, or none.
    OtherShown,
    /// The logs have moved to another plane.
    OtherPlane,
    /// The sides of this log were exchanged.
    SidesExchanged(LogId),
    /// This log has got more pings.
    Grown(LogId),
}

impl App {
    /// Drops or corrects the state that is out of date after a change.
    pub(super) fn follow_change(&mut self, change: LogsChange) {
        match change {
            LogsChange::AllClosed => {
                self.forget_steps();
                self.leave_reference();
                self.jobs.stop(&JobKey::CompareHeights);
                self.findings.heights = Default::default();
                self.jobs.stop(&JobKey::ComparePositions);
                self.findings.positions = None;
                self.number_objects(Default::default());
            }
            LogsChange::LastClosed => self.leave_reference(),
            // Logs that were closed before, and their measurements, are in another plane.
            LogsChange::FirstOpened => self.forget_steps(),
            LogsChange::OtherShown => {
                self.view.survey_serial += 1;
                self.view.selection = None;
                self.view.hover = None;
                self.view.visible = 0..0;
                self.forget_agreement();
                self.forget_previews();
            }
            LogsChange::OtherPlane => {
                self.view.plane_serial += 1;
                // The ends of the clip box were in the earlier plane.
                self.view.options.cloud.clip = None;
                self.view.options.cloud.cut = false;
            }
            LogsChange::SidesExchanged(id) => {
                self.forget_preview(id);
                // The results of a search of the log as it was would be put on the wrong side.
                self.leave_search(id);
                if id == self.logs.shown.id {
                    // The marks stay on the same echo.
                    let marks = [&mut self.view.selection, &mut self.view.hover];
                    for mark in marks.into_iter().flatten() {
                        mark.side = mark.side.map(Side::other);
                    }
                }
            }
            LogsChange::Grown(id) => self.forget_preview(id),
        }
    }

    /// Drops the undo steps, the closed logs and the measurement on the map.
    fn forget_steps(&mut self) {
        self.logs.closed.clear();
        self.document.history = Default::default();
        self.map.measuring = Default::default();
    }

    /// Drops the first returns that were computed ahead of the results of a log, and the
    /// measurements that are kept for the next ones.
    fn forget_preview(&mut self, id: LogId) {
        if let Some(log) = self.logs.get_mut(id) {
            log.preview = None;
        }
        if id == self.logs.shown.id {
            self.forget_previews();
        }
    }
}

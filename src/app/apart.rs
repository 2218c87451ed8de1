//! Hides logs that do not form a survey with the others: they are opened, but not shown on the map
//! until the analyst asks for them.

use super::{Action, App, LogId};
use bathyscope_log::support::printable::quoted;
use bathyscope_log::survey::{Apart, Survey, apart};

impl App {
    /// Hides the newly opened logs that do not form a survey with the others, and offers to show
    /// them.
    pub(super) fn set_apart(&mut self) {
        let arrived = std::mem::take(&mut self.logs.arrived);
        let logs: Vec<(LogId, bool, &Survey)> = self
            .logs
            .visible()
            .filter_map(|log| {
                let survey = log.survey.as_deref()?;
                Some((log.id, !arrived.contains(&log.id), survey))
            })
            .collect();
        let known: Vec<bool> = logs.iter().map(|(_, known, _)| *known).collect();
        let surveys: Vec<&Survey> = logs.iter().map(|(.., survey)| *survey).collect();
        let why = apart(&surveys, &known);
        let found: Vec<(LogId, Option<Apart>)> = (logs.iter().zip(why))
            .filter(|((_, known, _), _)| !known)
            .map(|((id, ..), why)| (*id, why))
            .collect();
        let mut names = Vec::new();
        for (id, why) in found.iter().filter_map(|(id, why)| Some((*id, (*why)?))) {
            if let Some(log) = self.logs.get_mut(id) {
                log.is_visible = false;
                log.apart = Some(why);
                names.push(format!("{} ({why})", quoted(&log.name())));
            }
        }
        if names.is_empty() {
            return;
        }
        let first = self.logs.visible().next().map(|log| log.id);
        if let (false, Some(first)) = (self.logs.shown.is_visible, first) {
            self.show_log(first);
        }
        // The plane of a distant log would distort the positions of the other logs.
        self.document.is_plane_moved = true;
        self.settle_plane();
        let text = format!("Open, but not part of this survey: {}", names.join(", "));
        self.notices.offer(text, Action::ShowTogether);
        self.keep_project("logs apart");
        self.schedule();
    }

    /// Shows all logs on one map, whatever the distance between them, as an undo step.
    pub(super) fn show_together(&mut self) {
        let before = self.step_now();
        for log in self.logs.all_mut().filter(|log| log.apart.is_some()) {
            log.is_visible = true;
            log.apart = None;
        }
        self.record_named(&before, "show all logs together".to_owned());
        self.notices.withdraw(Action::ShowTogether);
        self.schedule();
    }
}

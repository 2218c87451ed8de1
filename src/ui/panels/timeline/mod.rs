//! The time line: depth and speed over the whole log, where the views are, and where to go.

mod columns;
mod drawing;
mod strips;

use crate::app::{Command, Outcome, Task};
use crate::pipeline::Products;
use crate::ui::{ViewContext, theme};
use drawing::Frame;
use egui::{Sense, Ui};
use std::sync::Arc;
use strips::Strips;

/// Height of the panel, points.
pub const HEIGHT: f32 = 104.0;

/// Which survey and results the strips belong to.
type Key = (u64, [usize; 3]);

/// State of the time line: the strips of the open survey.
#[derive(Default)]
pub struct TimeLine {
    shown: Option<(Key, Option<Strips>)>,
    task: Option<(Key, Task<Option<Strips>>)>,
    /// The pointer was over the panel in the last frame.
    was_over: bool,
}

impl TimeLine {
    /// Whether the strips shown are those of the survey and its last result.
    pub fn is_settled(&self) -> bool {
        self.task.is_none()
    }

    fn refresh(&mut self, context: &ViewContext<'_>) {
        let app = context.app;
        let Some(survey) = &app.survey else {
            *self = Self::default();
            return;
        };
        let products = app.products.clone();
        let address = |products: &Products| {
            let kept = Arc::as_ptr(&products.kept) as usize;
            let correction = Arc::as_ptr(&products.correction) as usize;
            [Arc::as_ptr(&products.navigation) as usize, kept, correction]
        };
        let key = (app.survey_serial, products.as_ref().map_or([0; 3], address));
        let known = self.shown.as_ref().map(|(known, _)| *known);
        let coming = self.task.as_ref().map(|(coming, _)| *coming);
        if known != Some(key) && coming != Some(key) {
            let survey = survey.clone();
            let work = move |_: &_| Strips::of(&survey, products.as_ref());
            self.task = Some((key, Task::start(app.jobs(), work)));
        }
        if let Some((key, task)) = &self.task {
            match task.poll() {
                Outcome::Pending => {}
                Outcome::Done(strips) => {
                    self.shown = Some((*key, strips));
                    self.task = None;
                }
                Outcome::Failed => self.task = None,
            }
        }
    }

    /// Draws the panel.
    pub fn ui(&mut self, ui: &mut Ui, context: &mut ViewContext<'_>) {
        self.refresh(context);
        let (outer, response) =
            ui.allocate_exact_size(ui.available_size(), Sense::click_and_drag());
        let count = context
            .app
            .survey
            .as_ref()
            .map_or(0, |survey| survey.side_scan.len());
        let ping = context.app.selection.map_or(0, |mark| mark.ping);
        response.widget_info(|| {
            let depth = self
                .shown
                .as_ref()
                .and_then(|(_, strips)| strips.as_ref()?.deepest());
            let depth = depth.map_or(String::new(), |depth| format!(", depth {depth}"));
            let name = format!("Time line, ping {ping} of {count}{depth}");
            egui::WidgetInfo::slider(true, ping as f64, name)
        });
        let Some((_, Some(strips))) = &self.shown else {
            let empty = "Time line: depth and speed over the log appear here.";
            let font = egui::FontId::proportional(theme::SMALL);
            let weak = ui.visuals().weak_text_color();
            ui.painter().text(
                outer.center(),
                egui::Align2::CENTER_CENTER,
                empty,
                font,
                weak,
            );
            return;
        };
        let frame = Frame::new(outer);
        frame.strips(ui, context, strips);
        frame.marks(ui, context, strips);
        frame.pointer(&response, context, strips);
        if self.was_over && !response.hovered() {
            context.push(Command::Hover(None));
        }
        self.was_over = response.hovered();
    }
}

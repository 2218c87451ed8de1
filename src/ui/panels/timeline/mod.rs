//! Draws the time line: depth and speed over the whole log, the places that the views show, and the
//! pointer that selects a ping.
//!
//! The panel reads the state of the app, draws curves over time, and sends commands.

mod drawing;
mod strips;

use crate::app::Command;
use crate::ui::raster::RasterTexture;
use crate::ui::{ViewContext, place, stretch_text, theme};
use bathyscope_bottom::cloud::{Correction, PingDepth};
use bathyscope_log::survey::{Navigation, Survey};
use bathyscope_products::pipeline::Products;
use bathyscope_products::pipeline::{Background, Same};
use drawing::TimelineLayout;
use egui::{Sense, Ui};
use std::sync::Arc;
use strips::Strips;

/// Height of the panel, points.
pub(crate) const HEIGHT: f32 = 104.0;

/// The results from which the strips are made.
type StripResults = (Same<Navigation>, Same<Vec<PingDepth>>, Same<Correction>);

/// The survey and the results from which the strips are made.
#[derive(PartialEq)]
struct StripsKey {
    survey: Same<Survey>,
    results: Option<StripResults>,
}

impl StripsKey {
    fn of(survey: &Arc<Survey>, products: Option<&Products>) -> Self {
        let results = |products: &Products| {
            let correction = Same(products.correction.clone());
            let depths = Same(products.depths.clone());
            (Same(products.navigation.clone()), depths, correction)
        };
        Self { survey: Same(survey.clone()), results: products.map(results) }
    }
}

/// State of the time line: the strips of the open survey.
#[derive(Default)]
pub(crate) struct TimeLine {
    /// The inner `None` means that the log has no times.
    strips: Background<StripsKey, Option<Strips>>,
    /// Textures of the drawn depth and speed.
    pictures: [Option<RasterTexture>; 2],
    seen_survey: u64,
    /// True if the pointer was over the panel in the last frame.
    was_over: bool,
}

impl TimeLine {
    /// Returns true if the drawn strips are those of the present survey and its last results.
    pub(crate) fn is_settled(&self) -> bool {
        !self.strips.is_running()
    }

    fn refresh(&mut self, context: &ViewContext<'_>) {
        let app = context.app;
        let Some(survey) = app.logs.shown.judged() else {
            *self = Self::default();
            return;
        };
        if self.seen_survey != app.view.survey_serial {
            // Without this reset, the strips of another log would be drawn until those of this log
            // exist.
            self.seen_survey = app.view.survey_serial;
            self.strips = Background::default();
        }
        let key = StripsKey::of(survey, app.logs.shown.products.as_ref());
        let (survey, products) = (survey.clone(), app.logs.shown.products.clone());
        let work = move |_: &_| Some(Strips::of(&survey, products.as_ref()));
        self.strips.ask(key, app.jobs.workers(), work);
    }

    /// Draws the panel.
    pub(crate) fn ui(&mut self, ui: &mut Ui, context: &mut ViewContext<'_>) {
        self.refresh(context);
        let (outer, response) =
            ui.allocate_exact_size(ui.available_size(), Sense::click_and_drag());
        let count = place::ping_count(context.app);
        let ping = context.app.view.selection.map_or(0, |mark| mark.ping);
        response.widget_info(|| {
            let strips = self.strips.result().and_then(Option::as_ref);
            let depth = strips.and_then(|strips| strips.deepest(context.units()));
            let depth = depth.map_or(String::new(), |depth| format!(", depth {depth}"));
            let excluded = stretch_text::and_stretches(context.app);
            let name = format!("Time line, ping {ping} of {count}{depth}{excluded}");
            egui::WidgetInfo::slider(true, ping as f64, name)
        });
        let Some(Some(strips)) = self.strips.result() else {
            let empty = "Time line: depth and speed over the log appear here.";
            let font = egui::FontId::proportional(theme::SMALL);
            let weak = ui.visuals().weak_text_color();
            let (at, middle) = (outer.center(), egui::Align2::CENTER_CENTER);
            ui.painter().text(at, middle, empty, font, weak);
            return;
        };
        let frame = TimelineLayout::new(outer);
        frame.strips(ui, context, strips, &mut self.pictures);
        frame.marks(ui, context, strips);
        frame.pointer(&response, context, strips);
        if self.was_over && !response.hovered() {
            context.push(Command::Hover(None));
        }
        self.was_over = response.hovered();
    }
}

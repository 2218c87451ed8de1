//! Draws the dialog for the size of a printed view, and the text around the view on the sheet.

use super::{Shell, Views};
use crate::app::{App, JobKey, Paper, PrintOptions, PrintText, Sheet, View};
use crate::ui::controls::{DropDown, number_field};
use crate::ui::dialogs::PathPurpose;
use crate::ui::{ViewContext, theme};
use egui::{Id, Label, Modal, Panel, RichText, Ui};

/// Notice while products are still being written.
pub(super) const BUSY: &str = "products are still being written; wait, or cancel that first";

/// State of the dialog: the view to print, and whether the dialog is open.
#[derive(Default)]
pub(super) struct Printing {
    pub(super) view: Option<View>,
    is_open: bool,
}

impl Printing {
    /// Opens the dialog for a view.
    pub(super) fn ask(&mut self, view: View) {
        self.view = Some(view);
        self.is_open = true;
    }

    /// Returns true if the dialog is shown.
    pub(super) fn is_open(&self) -> bool {
        self.is_open
    }

    /// Draws the dialog while it is open; returns true if the analyst wants to name the file now.
    pub(super) fn ui(
        &mut self,
        ctx: &egui::Context,
        context: &mut ViewContext<'_>,
        views: &Views,
    ) -> bool {
        let Some(mut view) = self.view.filter(|_| self.is_open) else {
            return false;
        };
        let mut shown = context.options().clone();
        let options = &mut shown.print;
        let modal = Modal::new(Id::unique("print")).show(ctx, |ui| {
            ui.set_width(320.0);
            ui.heading("Print view");
            choices(ui, &mut view, options);
            let sheet = options.sheet(views.size(view));
            ui.label(sheet_summary(view, sheet, views));
            ui.add_space(6.0);
            ui.horizontal(|ui| (ui.button("Save…").clicked(), ui.button("Cancel").clicked())).inner
        });
        self.view = Some(view);
        context.show(shown);
        let (save, cancel) = modal.inner;
        if save || cancel || modal.should_close() {
            self.is_open = false;
        }
        save
    }
}

fn choices(ui: &mut Ui, view: &mut View, options: &mut PrintOptions) {
    egui::Grid::new("print").num_columns(2).spacing([12.0, 6.0]).show(ui, |ui| {
        ui.label("View");
        DropDown::new("printed view", view.title())
            .pick(ui, view, View::PICTURES, View::title)
            .accessible_name("View to print");
        ui.end_row();
        ui.label("Size");
        DropDown::new("paper", options.paper.name())
            .pick(ui, &mut options.paper, Paper::ALL, Paper::name)
            .accessible_name("Paper");
        ui.end_row();
        if options.paper == Paper::Pixels {
            let label = ui.label("Width");
            let width = number_field(&mut options.width_px).range(PrintOptions::WIDTHS_PX);
            ui.add(width.suffix(" px")).labelled_by(label.id);
        } else {
            let label = ui.label("Resolution");
            let dpi = number_field(&mut options.dpi).range(PrintOptions::DPI);
            ui.add(dpi.suffix(" dpi")).labelled_by(label.id);
            ui.end_row();
            ui.label("");
            ui.checkbox(&mut options.landscape, "Landscape");
        }
        ui.end_row();
        ui.label("");
        ui.checkbox(&mut options.light, "On white");
        ui.end_row();
    });
}

/// Returns the size in words, with the scale of the map on paper.
fn sheet_summary(view: View, sheet: Sheet, views: &Views) -> String {
    let [width, height] = sheet.size_px;
    let size = format!("{width} x {height} pixels");
    match map_scale(sheet, views).filter(|_| view == View::Map) {
        Some(denominator) => format!("{size}, about 1 : {denominator:.0} on paper"),
        None => size,
    }
}

/// Returns the scale of the map on a sheet of [`PrintOptions::POINT_M`] points, as the length in
/// nature divided by the length on paper; `None` without a map.
pub(super) fn map_scale(sheet: Sheet, views: &Views) -> Option<f64> {
    let [width, height] = sheet.size_px.map(|side| side as f32 / sheet.pixels_per_point);
    let inside = [width, (height - ABOVE - BELOW).max(1.0)];
    let metres = views.map.metres_per_point_on(inside)?;
    Some(metres / PrintOptions::POINT_M)
}

/// Height of the title of a print, and of the facts below its view, points.
const ABOVE: f32 = 30.0;
const BELOW: f32 = 70.0;

/// Draws title and facts of a print above and below its view.
pub(super) fn frame(ui: &mut Ui, app: &App, text: &PrintText) {
    let fill = theme::canvas_colour(&app.view.options);
    let ink = theme::canvas_text_colour(&app.view.options);
    let frame = egui::Frame::new().fill(fill).inner_margin(egui::Margin::symmetric(10, 6));
    Panel::top("print title").frame(frame).exact_size(ABOVE).show(ui, |ui| {
        let title = RichText::new(&text.title).size(16.0).strong().color(ink);
        ui.add(Label::new(title).truncate());
    });
    Panel::bottom("print facts").frame(frame).min_size(BELOW).resizable(false).show(ui, |ui| {
        ui.spacing_mut().item_spacing.y = 1.0;
        for fact in &text.facts {
            let fact = RichText::new(fact).size(theme::SMALL).color(ink);
            ui.add(Label::new(fact).wrap());
        }
    });
}

impl Shell {
    /// Opens the dialog, or notifies the analyst of the reason why not.
    pub(super) fn ask_to_print(&mut self) {
        if self.app.logs.shown.products.is_none() {
            self.say("there is nothing to print yet; open a log first");
        } else if self.app.jobs.fraction(&JobKey::Export).is_some() {
            self.say(BUSY);
        } else {
            let target = self.layout.target();
            let is_picture = View::PICTURES.contains(&target);
            self.printing.ask(if is_picture { target } else { View::Map });
        }
    }

    /// Asks for the file, with a proposed name made of log and view.
    pub(super) fn name_print(&mut self) {
        let view = self.printing.view.unwrap_or(View::Map);
        let ending = match view {
            View::Waterfall => "waterfall.png",
            View::Map => "map.png",
            View::Cloud | View::Objects | View::Profile => "cloud.png",
        };
        self.ask_beside_log(PathPurpose::PrintInto, ending);
    }
}

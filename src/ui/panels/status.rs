//! The bottom line: what is under the pointer, and what the program is doing.

use crate::app::{Action, Command, Mark};
use crate::pipeline::EngineStatus;
use crate::survey::Side;
use crate::ui::{ViewContext, place, theme};
use egui::{RichText, Ui};

/// A job that takes longer than this is shown.
const PATIENCE_S: f64 = 0.4;

/// Draws the line.
pub fn ui(ui: &mut Ui, context: &mut ViewContext<'_>) {
    ui.horizontal_centered(|ui| {
        ui.spacing_mut().item_spacing.x = 14.0;
        match context.app.hover.or(context.app.selection) {
            Some(mark) => cursor(ui, context, mark),
            None => {
                ui.label(RichText::new("Nothing under the pointer").weak());
            }
        }
        ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
            ui.spacing_mut().item_spacing.x = 8.0;
            jobs(ui, context);
            rest(ui, context);
        });
    });
}

fn cell(ui: &mut Ui, text: String) {
    ui.add(egui::Label::new(RichText::new(text).monospace()));
}

fn cursor(ui: &mut Ui, context: &ViewContext<'_>, mark: Mark) {
    let app = context.app;
    let units = app.options.units;
    let Some(ping) = app
        .log
        .survey
        .as_ref()
        .and_then(|survey| survey.side_scan.get(mark.ping))
    else {
        return;
    };
    if let Some(at) = place::lon_lat(app, mark) {
        cell(ui, place::written(app, at));
    }
    cell(ui, format!("ping {}", mark.ping));
    if let Some(range) = place::range_m(app, mark) {
        let side = match mark.side {
            Some(Side::Port) => " port",
            Some(Side::Starboard) => " stbd",
            None => "",
        };
        cell(ui, format!("range {}{side}", units.measure(range, 2)));
    }
    cell(ui, format!("depth {}", place::depth(app, ping)));
    let speed = app
        .log
        .products
        .as_ref()
        .and_then(|products| products.navigation.pings.get(mark.ping))
        .map_or(f64::NAN, |here| here.speed_mps);
    cell(ui, units.speed(speed, 1));
}

fn rest(ui: &mut Ui, context: &ViewContext<'_>) {
    // The rate of the last frames that followed each other; an idle window draws none.
    let rate = egui::Id::unique("frame rate");
    let frame_s = ui.input(|input| input.stable_dt);
    if frame_s < 0.1 {
        ui.data_mut(|data| data.insert_temp(rate, 1.0 / frame_s.max(1e-3)));
    }
    if let Some(fps) = ui.data(|data| data.get_temp::<f32>(rate)) {
        let shown = RichText::new(format!("{fps:.0} fps")).weak().small();
        ui.label(shown)
            .on_hover_text("Frames a second when they last followed each other.");
    }
    let map = context.app.options.waterfall.colour_map.name();
    ui.label(RichText::new(map).weak().small());
}

fn jobs(ui: &mut Ui, context: &mut ViewContext<'_>) {
    let job = match (context.app.load_status(), context.app.engine_status()) {
        (Some(load), _) => Some((format!("opening {}", load.name), load.fraction)),
        (None, EngineStatus::Running { stage, fraction }) => {
            Some((stage.name().to_owned(), fraction))
        }
        (None, EngineStatus::Idle) => {
            let detecting = context.app.search_status().map(|status| status.share);
            let exporting = context.app.export_fraction();
            let base_map = context.app.base_map_fraction();
            let comparing = context.app.comparing_fraction();
            (detecting.map(|share| ("finding objects".to_owned(), share)))
                .or(exporting.map(|share| ("exporting".to_owned(), share)))
                .or(comparing.map(|share| ("comparing".to_owned(), share)))
                .or(base_map.map(|share| ("opening the base map".to_owned(), share)))
        }
    };
    let since = egui::Id::unique("job since");
    let now = ui.input(|input| input.time);
    let Some((what, share)) = job else {
        ui.data_mut(|data| data.remove::<f64>(since));
        stopped(ui, context);
        return;
    };
    // Short jobs come and go without a flicker.
    let started = ui.data_mut(|data| *data.get_temp_mut_or(since, now));
    if now - started < PATIENCE_S {
        return;
    }
    let stop = ui.small_button("Cancel");
    if stop
        .accessible_name(Action::Cancel.label())
        .on_hover_text(Action::Cancel.hint())
        .clicked()
    {
        context.push(Command::Do(Action::Cancel));
    }
    let text = format!("{what} {:.0} %", f64::from(share) * 100.0);
    let bar = egui::ProgressBar::new(share)
        .desired_width(110.0)
        .desired_height(8.0)
        .fill(theme::accent_colour(context.app.options.theme));
    ui.add(bar);
    ui.label(RichText::new(text).small());
}

/// Offers to go on after processing was stopped. While a slider is dragged, results are behind on purpose.
fn stopped(ui: &mut Ui, context: &mut ViewContext<'_>) {
    if !context.app.is_stopped() || ui.input(|input| input.pointer.any_down()) {
        return;
    }
    let action = Action::Update;
    let update = ui.small_button(action.label());
    if update.on_hover_text(action.hint()).clicked() {
        context.push(Command::Do(action));
    }
    let text = RichText::new("stopped before it was done").small();
    ui.label(text.color(theme::stale_colour(context.app.options.theme)));
}

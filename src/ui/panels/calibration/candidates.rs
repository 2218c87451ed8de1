//! Lists the ranked flat stretches in a table, with the objections to them below; a click proposes
//! a stretch.

use crate::app::{Command, LogPlace, Tool};
use crate::ui::list_keys::ListKeys;
use crate::ui::panels::parts;
use crate::ui::{ViewContext, stretch_text, text, theme};
use bathyscope_bottom::calibration::{FlatSpot, PingRange};
use bathyscope_log::survey::Survey;
use bathyscope_products::pipeline::Products;
use egui::{Align2, Color32, FontId, Response, Role, Sense, TextStyle, Ui, WidgetInfo, pos2, vec2};

/// Heading, hint and right edge of each column; the edge is a share of the width.
const COLUMNS: [(&str, &str, f32); 6] = [
    ("No.", "Rank: 1 is the best stretch.", 0.08),
    ("Ping", "First ping of the stretch.", 0.25),
    ("Long", "Length along the track.", 0.40),
    ("Relief", "Difference between greatest and least recorded depth.", 0.60),
    ("Scale", "Recorded depth divided by recorded range: the factor for ranges.", 0.81),
    ("SD", "Standard deviation of the scale of single pings.", 1.0),
];

/// Draws the table.
pub(super) fn ui(ui: &mut Ui, context: &mut ViewContext<'_>, survey: &Survey, products: &Products) {
    let spots = &products.flat_spots;
    if spots.is_empty() {
        return parts::remark(ui, "No flat stretch was found in this log.");
    }
    let title = text::plural(spots.len(), "flat stretch", "flat stretches");
    let log = &context.app.logs.shown;
    let is_asked_for = log.reviewing.tool == Tool::Calibrate || log.proposed_stretch().is_some();
    egui::CollapsingHeader::new(title)
        .id_salt("ranked flat stretches")
        .open(is_asked_for.then_some(true))
        .show(ui, |ui| {
            headings(ui);
            let keys = ListKeys::read(ui, "flat stretches", spots.len());
            for (rank, spot) in spots.iter().enumerate() {
                let row = candidate(ui, context, (rank + 1, spot), survey, spots);
                keys.row(ui, rank, &row);
            }
        });
}

fn headings(ui: &mut Ui) {
    let size = vec2(ui.available_width(), 14.0);
    let (rect, response) = ui.allocate_exact_size(size, Sense::hover());
    let ink = ui.visuals().weak_text_color();
    let font = FontId::proportional(theme::SMALL);
    for (heading, _, end) in COLUMNS {
        let at = pos2(rect.left() + end * rect.width(), rect.center().y);
        ui.painter().text(at, Align2::RIGHT_CENTER, heading, font.clone(), ink);
    }
    let names = COLUMNS.map(|(heading, ..)| heading).join(", ");
    response.widget_info(|| WidgetInfo::labeled(Role::Label, true, &names));
    let hints = COLUMNS.map(|(heading, hint, _)| format!("{heading}: {hint}"));
    response.on_hover_text(hints.join("\n"));
}

fn candidate(
    ui: &mut Ui,
    context: &mut ViewContext<'_>,
    (rank, spot): (usize, &FlatSpot),
    survey: &Survey,
    spots: &[FlatSpot],
) -> Response {
    let units = context.units();
    let objections = spot.objections(survey, spots.first());
    let range = spot.range();
    let factor = stretch_text::factor(spot);
    let cells = [
        rank.to_string(),
        range.start.to_string(),
        units.measure(spot.length_m, 0),
        stretch_text::relief(spot, units),
        factor.unwrap_or_else(|| "none".to_owned()),
        stretch_text::spread(spot).unwrap_or_default(),
    ];
    let is_proposed = context.app.logs.shown.proposed_stretch() == Some(range);
    let worse = objections.first().map(|why| units.sentence(why));
    let brief = || stretch_text::brief(spot, units);
    let words = worse.as_ref().map_or_else(brief, |why| format!("worse: {why}"));
    let (PingRange { start, end }, depth) = (range, units.measure(spot.depth_m, 2));
    let name = format!("Flat stretch {rank}, pings {start}..{end}, {depth} deep, {words}");
    let response = row(ui, &cells, is_proposed, &name);
    let mut hint = units.sentence(&spot.summary());
    for why in &objections {
        hint += &format!("\n{}", units.sentence(why));
    }
    let response = response.on_hover_text(hint + "\nClick to propose it for the scale.");
    if response.clicked() {
        propose(context, range);
    }
    if let Some(why) = worse {
        parts::warning(ui, context, &format!("Worse. {why}"));
    }
    response
}

/// Proposes a stretch and shows it in all views.
fn propose(context: &mut ViewContext<'_>, range: PingRange) {
    context.push(Command::ProposeStretch(range));
    let middle = usize::midpoint(range.start, range.end);
    context.push(Command::Reveal(LogPlace::ping(middle)));
}

/// Draws a row of the table, which is a button.
fn row(ui: &mut Ui, cells: &[String; 6], is_chosen: bool, name: &str) -> Response {
    let size = vec2(ui.available_width(), 18.0);
    let (rect, response) = ui.allocate_exact_size(size, Sense::click());
    let style = ui.style().interact_selectable(&response, is_chosen);
    if is_chosen || response.hovered() || response.has_focus() {
        ui.painter().rect_filled(rect, 2.0, style.weak_bg_fill);
    }
    if response.has_focus() {
        let stroke = ui.visuals().widgets.hovered.fg_stroke;
        let kind = egui::StrokeKind::Inside;
        ui.painter().rect_stroke(rect, 2.0, stroke, kind);
    }
    let ink: Color32 = style.text_color();
    let font = TextStyle::Small.resolve(ui.style());
    for (cell, (_, _, end)) in cells.iter().zip(COLUMNS) {
        let at = pos2(rect.left() + end * rect.width(), rect.center().y);
        ui.painter().text(at, Align2::RIGHT_CENTER, cell, font.clone(), ink);
    }
    response.widget_info(|| WidgetInfo::selected(Role::Button, true, is_chosen, name));
    response
}

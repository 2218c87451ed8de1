//! Draws the calibration, from samples to metres: the scale in use, the flat stretches on which one
//! can be measured, in a ranked table with the objections to them, and the proposed stretch.
//!
//! The panel reads the state of the app, draws controls and texts, and sends commands.

use super::find_setting;
use super::parts::{self, PlotAxes, fact, setting};
use crate::app::{Action, Command, LogPlace, Tool, ViewOptions};
use crate::ui::controls::{self, ListKeys};
use crate::ui::{ViewContext, place, text, theme};
use bathyscope_bottom::calibration::{
    Calibration, FlatSpot, PingRange, RangeAtDepth, Scale, ScaleMode,
};
use bathyscope_bottom::presentation::plot::Axis;
use bathyscope_bottom::presentation::units::Units;
use bathyscope_log::survey::{RangeSource, Survey};
use bathyscope_products::pipeline::settings::rows;
use bathyscope_products::pipeline::{Products, ScaleEffect, ScaleTrial};
use egui::{
    Align, Align2, Button, Color32, FontId, Frame, Painter, Rect, Response, RichText, Role, Sense,
    Stroke, TextStyle, Ui, WidgetInfo, pos2, vec2,
};
use std::sync::Arc;

/// Title of the section.
pub(super) const TITLE: &str = "Calibration";

/// Draws the section.
pub(super) fn ui(ui: &mut Ui, context: &mut ViewContext<'_>) {
    let is_new = has_new_proposal(ui, context);
    let now = context.app.logs.shown.proposed_stretch();
    ui.data_mut(|data| data.insert_temp(proposal_id(), now));
    let Some(products) = context.app.logs.shown.products.clone() else {
        return parts::remark(ui, "No result yet.");
    };
    let calibration = &products.calibration;
    let survey = context.app.logs.shown.survey.clone();
    let source = survey.as_ref().map(|survey| survey.range_source).unwrap_or_default();
    in_use(ui, calibration, source, context.units());
    setting(
        ui,
        context,
        match calibration.mode {
            ScaleMode::FlatSpot => &rows::PPD_REACH,
            ScaleMode::Header => &rows::OFFSET,
        },
    );
    let Some(survey) = survey.filter(|survey| !survey.soundings.is_empty()) else {
        return parts::remark(ui, "This log records no depth to measure a scale against.");
    };
    for text in &calibration.warnings {
        parts::warning(ui, context, &context.units().sentence(text));
    }
    tools(ui, context, calibration.mode);
    proposed(ui, context, &products, is_new);
    candidates(ui, context, &survey, &products);
}

fn proposal_id() -> egui::Id {
    egui::Id::unique("stretch proposed when the section was drawn last")
}

/// Returns true if a stretch is proposed that the section did not show when it was drawn last.
pub(super) fn has_new_proposal(ui: &Ui, context: &ViewContext<'_>) -> bool {
    let now = context.app.logs.shown.proposed_stretch();
    let before: Option<PingRange> = ui.data(|data| data.get_temp(proposal_id())).flatten();
    if now.is_none() {
        ui.data_mut(|data| data.insert_temp(proposal_id(), now));
    }
    now.is_some() && now != before
}

fn scale(scale: Option<&Scale>) -> String {
    scale.map_or_else(
        || text::NONE.to_owned(),
        |scale| format!("{:.2} ±{:.2} pixels/m", scale.px_per_m, scale.spread_px_per_m),
    )
}

/// Draws the scale in use, and the available scales.
fn in_use(ui: &mut Ui, calibration: &Calibration, source: RangeSource, units: Units) {
    let is_estimated = source == RangeSource::Estimated;
    let spot = calibration.flat_spot.as_ref();
    let in_use = match (calibration.mode, spot) {
        (ScaleMode::FlatSpot, Some(spot)) => format!("flat stretch, {}", pings(spot.range())),
        _ if is_estimated => "estimated range".to_owned(),
        _ => "recorded range".to_owned(),
    };
    let hint = "What turns samples into metres: the range that the recorder wrote, or a flat stretch where first returns are compared with soundings.";
    fact(ui, "Scale in use", hint, in_use);
    let hint = range_hint(calibration, units);
    fact(ui, "Slant ranges", &hint, ranges(calibration, source, units));
    let header = calibration.header.as_ref();
    match header.filter(|_| is_estimated) {
        Some(header) => {
            let hint = "Pixels per metre by the size of the transducer: the recorder writes no range, and this may be off by some percent. Calibrate it on a flat stretch.";
            let value = format!("{:.1} pixels/m, to some percent", header.px_per_m);
            fact(ui, "Estimated", hint, value);
        }
        None => {
            let hint = "Pixels per metre by the ranges that the recorder wrote: median over the log and robust spread.";
            fact(ui, "From recorder", hint, scale(header));
        }
    }
    let hint = "Pixels per metre (PPD of Pulido et al.) on the flat stretch: first return over recorded depth, median over its pings and robust spread.";
    fact(ui, "From stretch", hint, scale(calibration.ppd().as_ref()));
    if calibration.beams.overlap_rad > 0.0 {
        let hint = "How far the beam of each side looks past the point below the boat, to the other side, as first returns over slopes show it. On a slope the first return of the lower side comes from there.";
        let value = format!("{:.1}° past the nadir", calibration.beams.overlap_rad.to_degrees());
        fact(ui, "Beam overlap", hint, value);
    }
    if let Some(fit) = calibration.fit {
        let offset = units.signed(fit.b_m, 2);
        let spread = units.spread(fit.spread_m, 2);
        fact(
            ui,
            "Line fit",
            &format!(
                "Line of recorded first-return range against recorded depth over the whole log; they scatter by ±{spread} {} about it.",
                units.symbol()
            ),
            format!("range = {:.3} × depth {offset}", fit.k),
        );
    }
}

/// Describes the correction of the ranges: factor or offset.
fn ranges(calibration: &Calibration, source: RangeSource, units: Units) -> String {
    let ranges = if source == RangeSource::Estimated { "estimated" } else { "recorded" };
    let factor = calibration.flat_spot.as_ref().and_then(place::stretch_factor);
    match (calibration.mode, factor, calibration.offset_note) {
        (ScaleMode::FlatSpot, Some(factor), _) => format!("{ranges} range {factor}"),
        (_, _, Some(note)) => format!("as {ranges}; offset: {}", units.sentence(note)),
        _ => format!("{ranges} {}", units.signed(-calibration.offset_m, 2)),
    }
}

fn range_hint(calibration: &Calibration, units: Units) -> String {
    let measured = calibration.measured_offset.map_or(String::new(), |found| {
        let differ = units.signed_within(found.offset_m, found.uncertainty_m, 2);
        format!(" First returns differ from the soundings by {differ}.")
    });
    format!("What is done to every recorded range before depths are made of it.{measured}")
}

/// Returns the pings of a stretch as text: `pings 400 to 499`.
fn pings(range: PingRange) -> String {
    format!("pings {} to {}", range.start, range.end.saturating_sub(1))
}

/// Draws the tool that proposes a stretch, and the button that restores the recorded range.
fn tools(ui: &mut Ui, context: &mut ViewContext<'_>, mode: ScaleMode) {
    let action = Action::Calibrate;
    let holds = context.app.logs.shown.reviewing.tool == Tool::Calibrate;
    ui.horizontal_wrapped(|ui| {
        let button = Button::new("Calibrate on a stretch").selected(holds);
        let response = controls::underline(ui, holds, button);
        // The tool is the control of the setting of the scale.
        find_setting::answer(ui, context, rows::SCALE.key, &response);
        context.keyed_button(response, action);
        if mode == ScaleMode::FlatSpot && context.app.logs.shown.proposed_stretch().is_none() {
            let keep = Action::KeepRecordedRange;
            context.button(ui.button(keep.label()), keep);
        }
    });
}

/// Draws the proposed stretch, if there is one; a new one is scrolled into view.
fn proposed(ui: &mut Ui, context: &mut ViewContext<'_>, products: &Products, is_new: bool) {
    let Some(range) = context.app.logs.shown.proposed_stretch() else {
        return;
    };
    let trial = context.app.logs.shown.scale_trial().cloned();
    let frame = Frame::group(ui.style()).show(ui, |ui| {
        ui.set_width(ui.available_width());
        let title = RichText::new(format!("Proposed: {}", pings(range)));
        ui.label(title.strong().color(theme::accent_colour(context.theme())));
        match &trial {
            Some(trial) => found(ui, context, products, trial),
            None => parts::remark(ui, "Measuring the scale."),
        }
        buttons(ui, context, trial.as_ref());
    });
    if is_new {
        frame.response.scroll_to_me(Some(Align::Center));
    }
}

fn found(ui: &mut Ui, context: &ViewContext<'_>, products: &Products, trial: &ScaleTrial) {
    let units = context.units();
    let spot = &trial.spot;
    let length = units.measure(spot.length_m, 1);
    let depth = units.measure(spot.depth_m, 2);
    let relief = place::stretch_relief(spot, units);
    let place = format!("{length} long, {depth} deep, relief {relief}");
    parts::remark(ui, place);
    for text in &trial.objections {
        parts::warning(ui, context, &units.sentence(text));
    }
    let (Some(factor), Some(spread)) = (place::stretch_factor(spot), place::stretch_spread(spot))
    else {
        return;
    };
    let hint = "What recorded ranges would be multiplied with: recorded depth over recorded range, median over the first returns of the stretch, with the spread of single pings.";
    fact(ui, "Scale", hint, format!("range {factor} {spread}"));
    draw_plot(ui, trial, products, context.options());
    match &trial.effect {
        Some(effect) => changes(ui, effect, units),
        None => parts::remark(ui, "The log has no side-scan depths that would change."),
    }
}

/// Draws the changes of the depths that the scale would cause.
fn changes(ui: &mut Ui, effect: &ScaleEffect, units: Units) {
    let change = &effect.change;
    let hint = "By how much side-scan depths that count for the map would change, in the median of the log; above 0 they become greater.";
    let value = format!("{} (median)", units.signed_difference(change.median_m));
    fact(ui, "Depth change", hint, value);
    let hint = "The largest change of a side-scan depth of the log.";
    let value = units.signed_difference(change.largest_m);
    fact(ui, "At most", hint, value);
    if let Some([now, then]) = &effect.residuals {
        let hint = "Side-scan minus sounding at the same ping, median over the log, with the scale in use and with this one: the nearer to 0 the better.";
        let now = units.signed_difference(now.median_m);
        let then = units.signed_difference(then.median_m);
        let value = format!("{now} now, {then} then");
        fact(ui, "To soundings", hint, value);
    }
}

fn buttons(ui: &mut Ui, context: &mut ViewContext<'_>, trial: Option<&Arc<ScaleTrial>>) {
    let gives_scale = trial.is_some_and(|trial| trial.spot.ppd.is_some());
    ui.horizontal_wrapped(|ui| {
        ui.add_enabled_ui(gives_scale, |ui| {
            let take = Action::UseScale;
            context.button(ui.button(take.label()), take);
        });
        let keep = Action::KeepRecordedRange;
        context.button(ui.button(keep.label()), keep);
        context.button(ui.button("Drop"), Action::DropProposal);
    });
}

/// Height of each of the two plots, points.
const HEIGHT: f32 = 96.0;
/// Greatest number of points that are drawn of a log, and of a stretch.
const MOST_POINTS: usize = 1500;
/// Share of the points at either end that does not affect the axes.
const TAIL: f64 = 0.02;
/// Least range of the lower plot, metres.
const LEAST_REACH_M: f64 = 0.1;

/// Draws both plots.
fn draw_plot(ui: &mut Ui, trial: &ScaleTrial, products: &Products, options: &ViewOptions) {
    let Some(factor) = trial.spot.factor else {
        return;
    };
    let size = vec2(ui.available_width(), 2.0 * HEIGHT);
    let (rect, response) = ui.allocate_exact_size(size, Sense::hover());
    let painter = ui.painter_at(rect);
    let (above, below) = rect.split_top_bottom_at_fraction(0.5);
    let points = Points::of(trial);
    points.ranges(&painter, above, (factor, &products.calibration), options);
    points.residuals(&painter, below, factor, options);
    let said = format!(
        "First-return range against sounding over {} first returns, {} of them on the stretch; the line is range = depth / {factor:.3}",
        trial.points.len(),
        points.stretch.len()
    );
    response.widget_info(|| WidgetInfo::labeled(Role::Image, true, &said));
    response.on_hover_text(
        "Above: recorded range of first returns over the recorded depth; grey all of the log, yellow those of the stretch. The yellow line is the proposed scale, the dashed one the scale in use.\nBelow: what is left between scaled range and depth.",
    );
}

/// Points of both plots.
struct Points<'a> {
    log: Vec<&'a RangeAtDepth>,
    stretch: Vec<&'a RangeAtDepth>,
    /// Ends of the depths of the log, metres.
    depths_m: [f64; 2],
}

impl<'a> Points<'a> {
    fn of(trial: &'a ScaleTrial) -> Self {
        let pings = &trial.spot.pings;
        let step = trial.points.len().div_ceil(MOST_POINTS).max(1);
        let on_stretch: Vec<&RangeAtDepth> =
            (trial.points.iter()).filter(|point| pings.contains(&point.ping)).collect();
        let every = on_stretch.len().div_ceil(MOST_POINTS).max(1);
        let depths = trial.points.iter().map(|point| point.depth_m);
        let [least_m, most_m] = ends(depths.collect());
        let margin_m = (0.05 * (most_m - least_m)).max(0.05);
        Self {
            log: trial.points.iter().step_by(step).collect(),
            stretch: on_stretch.into_iter().step_by(every).collect(),
            depths_m: [least_m - margin_m, most_m + margin_m],
        }
    }

    fn ranges(
        &self,
        painter: &Painter,
        rect: Rect,
        (factor, in_use): (f64, &Calibration),
        options: &ViewOptions,
    ) {
        let units = options.units;
        let ends = self.depths_m.map(|depth_m| units.in_unit(depth_m));
        let across = Axis::new(&format!("sounding, {}", units.symbol()), ends);
        let up = Axis::new(
            &format!("range, {}", units.symbol()),
            ends.map(|depth| depth / factor.min(1.0)),
        );
        let axes = PlotAxes::new(painter, rect, across, up);
        axes.draw(painter, theme::plot_ink(options));
        let at = |point: &RangeAtDepth| {
            axes.at(units.in_unit(point.depth_m), units.in_unit(point.range_m))
        };
        let inner = painter.with_clip_rect(axes.area);
        dots(&inner, self.log.iter().map(|point| at(point)), faint(options));
        let line = |range_m: &dyn Fn(f64) -> f64| {
            let of =
                |depth_m: f64| axes.at(units.in_unit(depth_m), units.in_unit(range_m(depth_m)));
            self.depths_m.map(of)
        };
        let used = line(&|depth_m| match (in_use.mode, in_use.factor()) {
            (ScaleMode::FlatSpot, Some(used)) => depth_m / used,
            _ => depth_m + in_use.offset_m,
        });
        let stroke = Stroke::new(1.0, theme::plot_ink(options));
        inner.extend(egui::Shape::dashed_line(&used, stroke, 4.0, 3.0));
        let colour = theme::proposal_ink(options);
        dots(&inner, self.stretch.iter().map(|point| at(point)), colour);
        let proposed = line(&|depth_m| depth_m / factor);
        inner.line_segment(proposed, Stroke::new(1.5, colour));
    }

    fn residuals(&self, painter: &Painter, rect: Rect, factor: f64, options: &ViewOptions) {
        let units = options.units;
        let left_m = |point: &RangeAtDepth| factor * point.range_m - point.depth_m;
        let all = self.log.iter().map(|point| left_m(point).abs());
        let [_, reach_m] = ends(all.collect());
        let reach_m = reach_m.max(LEAST_REACH_M);
        let ends = self.depths_m.map(|depth_m| units.in_unit(depth_m));
        let across = Axis::new(&format!("residual over sounding, {}", units.symbol()), ends);
        let up = Axis {
            // The numbers leave no space for a name.
            name: String::new(),
            ends: [-reach_m, reach_m],
            ticks: [-reach_m, 0.0, reach_m]
                .map(|metres| (metres, units.small_difference(metres)))
                .to_vec(),
        };
        let axes = PlotAxes::new(painter, rect, across, up);
        axes.draw(painter, theme::plot_ink(options));
        let at = |point: &RangeAtDepth| axes.at(units.in_unit(point.depth_m), left_m(point));
        let inner = painter.with_clip_rect(axes.area);
        dots(&inner, self.log.iter().map(|point| at(point)), faint(options));
        let colour = theme::proposal_ink(options);
        dots(&inner, self.stretch.iter().map(|point| at(point)), colour);
        let zero = ends.map(|depth| axes.at(depth, 0.0));
        inner.line_segment(zero, Stroke::new(1.0, colour));
    }
}

/// Returns the ends of the values, without the share [`TAIL`] at either end.
fn ends(mut values: Vec<f64>) -> [f64; 2] {
    values.sort_unstable_by(f64::total_cmp);
    let tail = (TAIL * values.len() as f64) as usize;
    let ends = values.get(tail).zip(values.iter().rev().nth(tail));
    ends.map_or([0.0, 1.0], |(least, most)| [*least, *most])
}

fn dots(painter: &Painter, places: impl Iterator<Item = egui::Pos2>, colour: Color32) {
    painter.extend(places.map(|at| egui::Shape::circle_filled(at, 1.2, colour)));
}

fn faint(options: &ViewOptions) -> Color32 {
    theme::plot_ink(options).gamma_multiply(0.45)
}

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
fn candidates(ui: &mut Ui, context: &mut ViewContext<'_>, survey: &Survey, products: &Products) {
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
    let factor = place::stretch_factor(spot);
    let cells = [
        rank.to_string(),
        range.start.to_string(),
        units.measure(spot.length_m, 0),
        place::stretch_relief(spot, units),
        factor.unwrap_or_else(|| "none".to_owned()),
        place::stretch_spread(spot).unwrap_or_default(),
    ];
    let is_proposed = context.app.logs.shown.proposed_stretch() == Some(range);
    let worse = objections.first().map(|why| units.sentence(why));
    let brief = || place::stretch_brief(spot, units);
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

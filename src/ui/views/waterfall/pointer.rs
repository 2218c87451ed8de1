//! Handles the pointer on the waterfall: the read-out, hover and selection, and the menu.

use super::lens::{Lens, LensPlace};
use super::{boxes, labels, stretches};
use crate::app::{AboveStretch, Action, App, Command, LogPlace, Tool};
use crate::ui::controls::option_checkbox;
use crate::ui::{ViewContext, place, text, theme};
use bathyscope_log::survey::{Side, Survey};
use egui::{Align2, Painter, Pos2, Rect, Response, Ui, pos2};

/// Returns the mark at a place; `None` before the first and after the last ping.
pub(super) fn mark_at(survey: &Survey, place: LensPlace) -> Option<LogPlace> {
    if place.ping < 0.0 {
        return None;
    }
    let ping = place.ping as usize;
    let side = place.side();
    let span = survey.side_scan.get(ping)?.side(side);
    let range_m = place.across_m.abs();
    let sample = span.and_then(|span| place::recorded_sample(span, span.sample_at(range_m)));
    Some(LogPlace { ping, side: sample.map(|_| side), sample, point: None })
}

/// Result of [`follow`].
pub(super) struct Followed {
    /// Place under the pointer; `None` if the pointer is not over the picture.
    pub place: Option<LensPlace>,
    /// Ping at which equal scales along and across were requested; `None` without a request.
    pub equal_scales_at: Option<usize>,
}

/// Pushes the commands of hover, selection and menu.
pub(super) fn follow(
    response: &Response,
    lens: &Lens,
    survey: &Survey,
    was_over: &mut Option<LogPlace>,
    context: &mut ViewContext<'_>,
) -> Followed {
    let pointer = response.hover_pos().filter(|at| lens.rect.contains(*at));
    let place = pointer.map(|at| lens.place_at(at));
    let mark = place.and_then(|place| mark_at(survey, place));
    if mark != *was_over {
        *was_over = mark;
        context.push(Command::Hover(mark));
    }
    let clicked = response.clicked() || response.secondary_clicked();
    // A click with a measuring tool belongs to that tool, and so do clicks with some of the other
    // tools.
    let measures = context.app.map.measuring.tool.is_some() && response.clicked();
    if clicked
        && !measures
        && let Some(at) = response.interact_pointer_pos()
    {
        let tool = context.app.logs.shown.reviewing.tool;
        let finds = matches!(tool, Tool::Look | Tool::Edit);
        match boxes::under(lens, context.app, at).filter(|_| finds) {
            Some(id) => context.push(Command::SelectBox(Some(id))),
            None if tool == Tool::Point && response.clicked() => {
                if let Some(mark) = mark_at(survey, lens.place_at(at)) {
                    context.push(Command::MarkTarget(mark));
                }
            }
            None if tool == Tool::Calibrate && response.clicked() => {
                propose(context, lens, at);
            }
            None if matches!(
                tool,
                Tool::Look | Tool::Bottom | Tool::Exclude | Tool::Calibrate | Tool::Accept
            ) =>
            {
                let mark = mark_at(survey, lens.place_at(at));
                context.push(Command::Select(mark));
                if let Some(mark) = mark.filter(|_| tool == Tool::Exclude && response.clicked()) {
                    let log = context.app.logs.shown.id;
                    place::include_again(context, log, mark.ping);
                }
            }
            None => {}
        }
    }
    Followed { place, equal_scales_at: menu(response, context) }
}

/// Shows the menu for the selection, which was set by the click that opened the menu; returns the
/// ping for which equal scales were requested.
fn menu(response: &Response, context: &mut ViewContext<'_>) -> Option<usize> {
    let mut equal_scales_at = None;
    response.context_menu(|ui| {
        theme::whole_words(ui);
        let Some(mark) = context.app.view.selection else {
            ui.label("no ping here");
            return;
        };
        let hint = "Proposes the stretch here for the scale; nothing changes yet.";
        let button = ui.button("Propose for the scale").on_hover_text(hint);
        if button.clicked() {
            if let Some(pings) = context.app.logs.shown.stretch_around(mark.ping) {
                context.push(Command::ProposeStretch(pings));
            }
            ui.close();
        }
        accept(ui, context, mark);
        let log = context.app.logs.shown.id;
        place::include_entry(ui, context, log, mark.ping);
        if ui.button("Show in map and 3D").clicked() {
            context.push(Command::Reveal(mark));
            ui.close();
        }
        ui.separator();
        let hint = "The same scale along and across the track, by the boat's speed here.";
        if ui.button("Equal scales").on_hover_text(hint).clicked() {
            equal_scales_at = Some(mark.ping);
            ui.close();
        }
        let mut options = context.options().clone();
        for action in [Action::FirstReturnLine, Action::DepthLine, Action::RangeLines] {
            option_checkbox(ui, &mut options, action);
        }
        ui.checkbox(&mut options.waterfall.flat_stretches, "Flat stretches");
        ui.checkbox(&mut options.waterfall.boxes, "Boxes");
        context.show(options);
    });
    equal_scales_at
}

/// Proposes the numbered stretch that was clicked, or a stretch around the clicked ping.
fn propose(context: &mut ViewContext<'_>, lens: &Lens, at: Pos2) {
    let here = lens.place_at(at).ping;
    let around = || context.app.logs.shown.stretch_around(here.max(0.0) as usize);
    if let Some(pings) = stretches::under_bar(lens, context.app, at).or_else(around) {
        context.push(Command::ProposeStretch(pings));
    }
}

/// Adds an entry that accepts as bottom the first returns above the recorded depth around a place,
/// if there are any.
fn accept(ui: &mut Ui, context: &mut ViewContext<'_>, mark: LogPlace) {
    let figures = context.app.logs.shown.figures.as_ref();
    let stretch = (mark.side.zip(figures))
        .and_then(|(side, figures)| figures.above_bottom.stretch_at(side, mark.ping));
    let Some(&AboveStretch { side, pings, .. }) = stretch else {
        return;
    };
    let [first, last] = pings;
    let hint = format!(
        "First returns of pings {first} to {last} to {} lie above the recorded depth; they then count as bottom.",
        side.name()
    );
    if ui.button("Accept as bottom").on_hover_text(hint).clicked() {
        context.push(Command::AcceptBottom { side, pings, accept: true });
        ui.close();
    }
}

/// Returns the metres that the boat moved from one ping to the next, averaged over a hundred pings
/// around this one; `None` if the speed is unknown.
pub(super) fn metres_per_ping(app: &App, survey: &Survey, ping: usize) -> Option<f64> {
    let pings = &app.logs.shown.products.as_ref()?.navigation.pings;
    let speed_mps = pings.get(ping)?.speed_mps;
    let first = ping.saturating_sub(50);
    let last = (ping + 50).min(survey.side_scan.len().checked_sub(1)?);
    let time_s = |ping: usize| survey.side_scan.get(ping).map(|ping| ping.time_s);
    let interval_s = (time_s(last)? - time_s(first)?) / (last - first) as f64;
    let metres = speed_mps * interval_s;
    (metres.is_finite() && metres > 0.0).then_some(metres)
}

/// Least distance between the read-out and the areas that it must not cover, points.
const APART: f32 = 10.0;

/// Writes the read-out in the corner of the view opposite to the pointer, or in another corner if
/// that one overlaps an area of `clear`: what the read-out describes stays visible.
pub(super) fn read_out(painter: &Painter, lens: &Lens, pointer: Pos2, text: &str, clear: &[Rect]) {
    let (at, anchor) = read_out_place(lens.rect, pointer, clear, |at, anchor| {
        labels::covered(painter, at, anchor, text)
    });
    labels::text(painter, at, anchor, text);
}

/// Returns the place of the read-out; `covered` returns its area at a place.
fn read_out_place(
    view: Rect,
    pointer: Pos2,
    clear: &[Rect],
    covered: impl Fn(Pos2, Align2) -> Rect,
) -> (Pos2, Align2) {
    let centre = view.center();
    let (right, below) = (pointer.x < centre.x, pointer.y < centre.y);
    let inner = view.shrink(8.0);
    // The corner opposite to the pointer is the first, because it is the farthest.
    let corners = [(right, below), (right, !below), (!right, below), (!right, !below)].map(
        |(right, below)| {
            let x = if right { inner.right() } else { inner.left() };
            let y = if below { inner.bottom() } else { inner.top() };
            (pos2(x, y), anchor(!right, !below))
        },
    );
    let is_free = |(at, anchor): &(Pos2, Align2)| {
        let area = covered(*at, *anchor);
        let hides_pointer = area.expand(4.0).contains(pointer);
        let is_clear = |plate: &Rect| !plate.expand(APART).intersects(area);
        view.contains_rect(area) && !hides_pointer && clear.iter().all(is_clear)
    };
    corners.into_iter().find(is_free).unwrap_or(corners[0])
}

/// Returns the anchor of a text that is right or left of a place, and below or above it.
fn anchor(right: bool, below: bool) -> Align2 {
    match (right, below) {
        (true, true) => Align2::LEFT_TOP,
        (true, false) => Align2::LEFT_BOTTOM,
        (false, true) => Align2::RIGHT_TOP,
        (false, false) => Align2::RIGHT_BOTTOM,
    }
}

/// Returns the reasons why lines are dashed at a ping.
fn doubts(app: &App, number: usize, side: Side) -> String {
    let shown = &app.view.options.waterfall;
    let mut lines = String::new();
    let judged = app.logs.shown.judged().and_then(|survey| survey.side_scan.get(number));
    let fault = judged.filter(|ping| ping.depth_m > 0.0).and_then(|ping| ping.depth_fault);
    if let Some(fault) = fault.filter(|_| shown.depth_line) {
        lines += &format!("\ndepth dashed: {}", fault.name());
    }
    let pick = app.logs.shown.bottom_line().and_then(|returns| returns.side(side).get(number));
    if shown.first_return && pick.is_some_and(|pick| pick.above_bottom) {
        lines += "\nfirst return above bottom";
    }
    lines
}

/// Describes a place. The range is that of the range lines and of the cloud, followed by the
/// recorded range.
pub(super) fn describe(app: &App, survey: &Survey, at: LensPlace) -> Option<String> {
    let mark = mark_at(survey, at)?;
    let ping = survey.side_scan.get(mark.ping)?;
    let side = at.side();
    let units = app.view.options.units;
    let mut lines = format!(
        "ping {}  {}\n{}, range {}",
        mark.ping,
        text::clock(survey.start_unix_s, ping.time_s),
        side.name(),
        units.measure(place::range_m(app, mark).unwrap_or(at.across_m.abs()), 2),
    );
    if app.logs.shown.products.is_some() {
        lines += &format!("\n{} as recorded", units.measure(at.across_m.abs(), 2));
    }
    if let Some(ground_m) = place::ground_m(app, mark) {
        lines += &format!("\n{} on the ground", units.measure(ground_m, 2));
    }
    if let Some((span, sample)) = ping.side(side).zip(mark.sample)
        && let Some(samples) = survey.samples(mark.ping, side)
    {
        let sample = (sample as usize).min(span.count.saturating_sub(1) as usize);
        let echo = if sample < samples.len() { samples.get(sample) } else { 0 };
        lines += &format!("\nsample {sample}, echo {echo}");
    }
    lines += &format!("\ndepth {}", place::depth(app, mark.ping));
    lines += &doubts(app, mark.ping, side);
    if let Some(why) = place::excluded_at(app, app.logs.shown.id, mark.ping) {
        lines += &format!("\n{why}");
    }
    if let Some(at) = place::lon_lat(app, mark) {
        lines += &format!("\n{}", place::written(app, at));
    }
    Some(lines)
}

#[cfg(test)]
mod tests {
    use super::*;
    use egui::vec2;

    #[test]
    fn the_read_out_keeps_off_the_pointer_and_what_is_edited() {
        let view = Rect::from_min_size(pos2(0.0, 0.0), vec2(800.0, 400.0));
        let size = vec2(160.0, 90.0);
        let covered = |at: Pos2, anchor: Align2| anchor.anchor_size(at, size);
        let place = |pointer: Pos2, clear: &[Rect]| {
            let (at, anchor) = read_out_place(view, pointer, clear, covered);
            covered(at, anchor)
        };
        let pointer = pos2(200.0, 100.0);
        assert_eq!(place(pointer, &[]).max, pos2(792.0, 392.0));
        let edited = Rect::from_min_size(pos2(700.0, 350.0), vec2(80.0, 60.0));
        let there = place(pointer, &[edited]);
        assert!(!there.intersects(edited.expand(APART)), "{there}");
        assert!(!there.contains(pointer), "{there}");
        // Even if everything is taken, the read-out is inside the view.
        assert!(view.contains_rect(place(pointer, &[view])));
    }
}

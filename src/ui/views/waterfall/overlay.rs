//! Draws everything over the picture, in the right order.

use super::drawing::WaterfallDrawing;
use super::labels::WaterfallLabels;
use super::lens::{Lens, LensPlace};
use super::scales::RangeLines;
use super::{bottom, boxes, flat_spots, lines, scales, stretch_tool};
use crate::app::{App, LogPlace};
use crate::ui::{place, theme};
use bathyscope_bottom::picture::PictureGeometry;
use bathyscope_bottom::presentation::units::Units;
use bathyscope_bottom::waterfall::LineStep;
use bathyscope_log::survey::{Side, SideScanState, Survey};
use egui::{Align2, Color32, Painter, Rect, Stroke, vec2};

/// Width of the line of the first return, points.
const FIRST_RETURN_WIDTH: f32 = 1.5;

/// Inputs of everything over the picture.
pub(super) struct ShownOverlay<'a> {
    pub app: &'a App,
    pub survey: &'a Survey,
    pub drawing: Option<&'a WaterfallDrawing>,
    /// Farthest slant range of the picture, metres.
    pub far_m: f64,
    pub hover: Option<LogPlace>,
    /// The visible boxes.
    pub boxes: &'a [boxes::ShownBox<'a>],
    /// The visible missed objects.
    pub missed: &'a [boxes::Missed<'a>],
    pub has_gpu: bool,
    /// Area of the banner of a tool; `None` without one.
    pub banner: Option<egui::Rect>,
    /// Length of a metre along the track divided by that of one across, as drawn; `None` if it is
    /// unknown.
    pub stretch: Option<f64>,
}

/// Draws everything over the picture.
pub(super) fn draw(painter: &Painter, lens: &Lens, shown: &ShownOverlay<'_>) {
    let options = &shown.app.view.options;
    let ink = theme::picture_ink(options);
    let wants_range_lines = options.waterfall.range_lines;
    let reduction = place::reduction(shown.app);
    let units = options.units;
    let range_lines = wants_range_lines
        .then(|| RangeLines::in_view(lens, shown.survey, reduction, shown.far_m, units));
    if let Some(lines) = &range_lines {
        lines.draw(painter, ink);
    }
    let stretches = flat_spots::in_view(lens, shown.app);
    for stretch in &stretches {
        stretch.draw(painter);
    }
    // Without the water column, the first return is at the middle of the picture.
    let shows_water = lens.geometry() == PictureGeometry::Slant;
    if let Some(drawing) = shown.drawing.filter(|_| shows_water) {
        draw_lines(painter, lens, shown, drawing);
    }
    let veiled = stretch_tool::in_view(lens, shown.app);
    for stretch in &veiled {
        stretch.draw(painter);
    }
    let marked =
        [(shown.app.view.selection, theme::SELECTION_COLOUR), (shown.hover, theme::HOVER_COLOUR)];
    for (mark, colour) in marked {
        if let Some(mark) = mark {
            cross_hair(painter, lens, shown.survey, &mark, colour);
        }
    }
    for missed in shown.missed {
        missed.draw(painter);
    }
    for shown_box in shown.boxes {
        shown_box.draw(painter, lens, &shown.app.logs.shown.reviewing);
    }
    if shown.app.view.options.waterfall.boxes {
        boxes::draw_shape(painter, lens, shown.app);
    }
    let mut labels = WaterfallLabels::new(painter);
    let mut below = lens.rect;
    if let Some(banner) = shown.banner {
        labels.keep_clear(banner);
        below.min.y = banner.bottom();
    }
    if let Some(text) = shown_warning(shown) {
        labels.keep_clear(banner(painter, below, &text));
    }
    // The geometry of the across direction is written first, because labels written later make way
    // for it.
    scales::geometry(&mut labels, lens, shown.stretch);
    if let Some(lines) = &range_lines {
        lines.label(&mut labels, lens);
    }
    for missed in shown.missed {
        missed.label(&mut labels);
    }
    for shown_box in shown.boxes.iter().rev() {
        shown_box.label(&mut labels, &shown.app.logs.shown.reviewing.review);
    }
    scales::sides(&mut labels, lens, options);
    let products = shown.app.logs.shown.products.as_ref();
    if let Some(change) = products.and_then(|products| products.calibration.range_change()) {
        scales::range_change(&mut labels, lens, &units.sentence(&change));
    }
    scales::ticks(painter, &mut labels, lens, shown.survey, ink);
    for stretch in &veiled {
        stretch.label(&mut labels);
    }
    for stretch in &stretches {
        stretch.label(&mut labels);
    }
}

/// Returns the reason why there is no picture of the bottom, if there is one.
fn shown_warning(shown: &ShownOverlay<'_>) -> Option<String> {
    let no_gpu = || "no picture: there is no graphics adapter that can draw it".to_owned();
    warning(shown.survey, shown.app.view.options.units).or_else(|| (!shown.has_gpu).then(no_gpu))
}

fn draw_lines(
    painter: &Painter,
    lens: &Lens,
    shown: &ShownOverlay<'_>,
    drawing: &WaterfallDrawing,
) {
    let options = &shown.app.view.options;
    if options.waterfall.depth_line {
        let pen = lines::WaterfallPen::new(theme::DEPTH_LINE_COLOUR, 1.0);
        let reduction = place::reduction(shown.app);
        let judged = shown.app.logs.shown.judged().map_or(shown.survey, |survey| &**survey);
        lines::depth(painter, lens, judged, drawing, reduction, pen);
    }
    let returns = shown.app.logs.shown.bottom_line();
    let Some(returns) = returns.filter(|_| options.waterfall.first_return) else {
        return;
    };
    for side in Side::BOTH {
        let pen = lines::WaterfallPen::new(theme::side_colour(options, side), FIRST_RETURN_WIDTH);
        let step = LineStep::Picks { returns, lines: drawing.picks.as_deref(), side };
        lines::first_return(painter, lens, shown.survey, step, side, pen);
    }
    bottom::drawn(painter, lens, shown.app);
}

/// Draws a thin line at the ping and, where the mark has a sample, one at its range.
fn cross_hair(painter: &Painter, lens: &Lens, survey: &Survey, mark: &LogPlace, colour: Color32) {
    let ping = mark.ping as f64 + 0.5;
    painter.line_segment(lens.line_at_ping(ping), Stroke::new(1.0, colour));
    let Some((side, sample)) = mark.side.zip(mark.sample) else {
        return;
    };
    let recorded = survey.side_scan.get(mark.ping);
    if let Some(span) = recorded.and_then(|recorded| recorded.side(side)) {
        let place = LensPlace::of(ping, side, span.range_m(f64::from(sample)));
        let faint = colour.gamma_multiply(0.6);
        let along = lens.line_at_range(place.across_m);
        painter.line(along, Stroke::new(1.0, faint));
        let at = lens.screen_at(place);
        painter.circle_stroke(at, 5.0, Stroke::new(1.5, colour));
    }
}

/// Writes on the picture a sentence that changes the meaning of the picture; returns the covered
/// area.
pub(super) fn banner(painter: &Painter, rect: Rect, text: &str) -> Rect {
    let (font, colour) = (egui::FontId::proportional(14.0), theme::OUTLIER_COLOUR);
    let width = (rect.width() - 40.0).max(60.0);
    let galley = painter.layout(text.to_owned(), font, colour, width);
    let area = Align2::CENTER_TOP.anchor_size(rect.center_top() + vec2(0.0, 14.0), galley.size());
    let ground = area.expand(8.0);
    painter.rect_filled(ground, 4.0, Color32::from_black_alpha(200));
    painter.galley(area.min, galley, Color32::PLACEHOLDER);
    ground
}

/// Returns the reason why the picture does not show the bottom; `None` if it does.
pub(super) fn warning(survey: &Survey, units: Units) -> Option<String> {
    match survey.side_scan_state {
        SideScanState::Usable => None,
        SideScanState::Absent => {
            Some("no side-scan: this log holds no side-scan frames".to_owned())
        }
        SideScanState::Noise { range_m } => Some(format!(
            "no side-scan: range stuck at ±{}, noise; was a transducer connected?",
            units.measure(f64::from(range_m), 1)
        )),
    }
}

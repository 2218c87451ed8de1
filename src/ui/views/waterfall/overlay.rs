//! Everything on top of the picture, in the order in which it is drawn.

use super::drawing::WaterfallDrawing;
use super::labels::WaterfallLabels;
use super::lens::Lens;
use super::scales::RangeLines;
use super::{bottom, boxes, exclusions, flat_spots, lines, marks, scales};
use crate::app::{App, LogPlace};
use crate::ui::{place, theme};
use bathyscope_bottom::picture::PictureGeometry;
use bathyscope_log::survey::{Side, Survey};
use egui::Painter;

/// Width of the first return, points.
const FIRST_RETURN_WIDTH: f32 = 1.5;

/// Overlay of the picture.
pub(super) struct ShownOverlay<'a> {
    pub app: &'a App,
    pub survey: &'a Survey,
    pub drawing: Option<&'a WaterfallDrawing>,
    /// Farthest slant range of the picture, metres.
    pub far_m: f64,
    pub hover: Option<LogPlace>,
    /// The boxes in view.
    pub boxes: &'a [boxes::ShownBox<'a>],
    /// The missed objects in view.
    pub missed: &'a [boxes::Missed<'a>],
    pub has_gpu: bool,
    /// Area of the banner of a tool.
    pub banner: Option<egui::Rect>,
    /// Length of a metre along the track over that of one across, as drawn; where that is known.
    pub stretch: Option<f64>,
}

/// Draws it.
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
    // Without the water column, the bottom lies in the middle.
    let shows_water = lens.geometry() == PictureGeometry::Slant;
    if let Some(drawing) = shown.drawing.filter(|_| shows_water) {
        draw_lines(painter, lens, shown, drawing);
    }
    let veiled = exclusions::in_view(lens, shown.app);
    for stretch in &veiled {
        stretch.draw(painter);
    }
    let marked =
        [(shown.app.view.selection, theme::SELECTION_COLOUR), (shown.hover, theme::HOVER_COLOUR)];
    for (mark, colour) in marked {
        if let Some(mark) = mark {
            marks::cross_hair(painter, lens, shown.survey, &mark, colour);
        }
    }
    for missed in shown.missed {
        missed.draw(painter);
    }
    for shown_box in shown.boxes {
        shown_box.draw(painter, lens, &shown.app.log.reviewing);
    }
    if shown.app.view.options.waterfall.boxes {
        boxes::shape::draw(painter, lens, shown.app);
    }
    let mut labels = WaterfallLabels::new(painter);
    let mut below = lens.rect;
    if let Some(banner) = shown.banner {
        labels.keep_clear(banner);
        below.min.y = banner.bottom();
    }
    if let Some(text) = warning(shown) {
        labels.keep_clear(marks::banner(painter, below, &text));
    }
    // What is across comes before the ranges themselves.
    scales::geometry(&mut labels, lens, shown.stretch);
    if let Some(lines) = &range_lines {
        lines.label(&mut labels, lens);
    }
    for missed in shown.missed {
        missed.label(&mut labels);
    }
    for shown_box in shown.boxes.iter().rev() {
        shown_box.label(&mut labels, &shown.app.log.reviewing.review);
    }
    scales::sides(&mut labels, lens, options);
    let products = shown.app.log.products.as_ref();
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

/// Reason why there is no picture of the bottom, if there is one.
fn warning(shown: &ShownOverlay<'_>) -> Option<String> {
    let no_gpu = || "no picture: there is no graphics adapter that can draw it".to_owned();
    marks::warning(shown.survey, shown.app.view.options.units)
        .or_else(|| (!shown.has_gpu).then(no_gpu))
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
        let judged = shown.app.log.judged().map_or(shown.survey, |survey| &**survey);
        lines::depth(painter, lens, judged, drawing, reduction, pen);
    }
    let returns = shown.app.bottom_line();
    let Some(returns) = returns.filter(|_| options.waterfall.first_return) else {
        return;
    };
    for side in Side::BOTH {
        let pen = lines::WaterfallPen::new(theme::side_colour(options, side), FIRST_RETURN_WIDTH);
        lines::first_return(painter, lens, shown.survey, drawing, returns, side, pen);
    }
    bottom::drawn(painter, lens, shown.app);
}

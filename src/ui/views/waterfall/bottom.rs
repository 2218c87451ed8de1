//! Draws first return and recorded depth over the picture; lets the user draw bottom edits with a
//! pen, and shows these edits.

use super::drawing::WaterfallDrawing;
use super::lens::{Lens, LensPlace};
use crate::app::{App, BottomStroke, Command, Ink, Orientation, Tool};
use crate::ui::views::tool;
use crate::ui::{ViewContext, theme};
use bathyscope_bottom::cloud::Reduction;
use bathyscope_bottom::first_return::BottomEdit;
use bathyscope_bottom::waterfall::{LineSpan, LineStep};
use bathyscope_log::survey::{Side, Survey};
use egui::{
    Color32, CursorIcon, Mesh, Modifiers, Painter, Pos2, Rect, Response, Shape, Stroke, Ui, vec2,
};

/// Width of a drawn line, points.
const WIDTH: f32 = 2.0;
/// Length of the dashes of a stroke that removes picks or edits, points.
const DASH: f32 = 5.0;

/// The pen for bottom edits; `None` while no stroke is being drawn.
#[derive(Default)]
pub(super) struct BottomPen {
    stroke: Option<BottomStroke>,
}

impl BottomPen {
    /// Handles a drag with the selected pen; returns true if the drag draws and must not move the
    /// picture. The middle button and Space move the picture with any tool.
    pub(super) fn follow(
        &mut self,
        ui: &Ui,
        response: &Response,
        lens: &Lens,
        context: &mut ViewContext<'_>,
    ) -> bool {
        if context.app.logs.shown.reviewing.tool != Tool::Bottom {
            self.stroke = None;
            return false;
        }
        if response.hovered() {
            ui.ctx().set_cursor_icon(CursorIcon::Crosshair);
        }
        let pointer = response.interact_pointer_pos().or(response.hover_pos());
        if let Some(at) = tool::begun(ui, response) {
            let modifiers = ui.input(|input| input.modifiers);
            self.stroke = Some(begun(lens, at, modifiers));
        }
        if tool::is_given_up(ui, response) {
            self.stroke = None;
        }
        let Some(stroke) = &mut self.stroke else {
            return false;
        };
        if let Some(at) = pointer {
            extend(stroke, lens.place_at(at));
        }
        if response.drag_stopped()
            && let Some(stroke) = self.stroke.take()
        {
            context.push(Command::DrawBottom(stroke));
        }
        true
    }

    /// Draws the stroke in progress.
    pub(super) fn draw(&self, painter: &Painter, lens: &Lens, app: &App) {
        let Some(stroke) = &self.stroke else {
            return;
        };
        for side in Side::BOTH {
            if side == stroke.side || app.view.options.waterfall.bottom_both_sides {
                let path = stroke.path.iter();
                let points = path.map(|&[ping, range_m]| at(lens, side, ping, range_m));
                let points: Vec<Pos2> = points.collect();
                let line = Stroke::new(WIDTH, theme::HAND_COLOUR);
                match stroke.ink {
                    Ink::Bottom => {
                        painter.line(points, line);
                    }
                    Ink::Silence | Ink::Search => {
                        painter.extend(Shape::dashed_line(&points, line, DASH, DASH));
                    }
                }
            }
        }
    }
}

fn begun(lens: &Lens, at: Pos2, modifiers: Modifiers) -> BottomStroke {
    let place = lens.place_at(at);
    BottomStroke {
        side: place.side(),
        path: vec![[place.ping, place.across_m.abs()]],
        ink: if modifiers.alt {
            Ink::Search
        } else if modifiers.command {
            Ink::Silence
        } else {
            Ink::Bottom
        },
    }
}

/// Extends a stroke. The stroke stays on its side: beyond the nadir, its points are at the nadir.
fn extend(stroke: &mut BottomStroke, to: LensPlace) {
    let point = [to.ping, to.outward_m(stroke.side).max(0.0)];
    if stroke.path.last() != Some(&point) {
        stroke.path.push(point);
    }
}

fn at(lens: &Lens, side: Side, ping: f64, range_m: f64) -> Pos2 {
    lens.screen_at(LensPlace::of(ping, side, range_m))
}

/// Draws the visible bottom edits over the first returns; edits are known before the results are.
pub(super) fn drawn(painter: &Painter, lens: &Lens, app: &App) {
    let seen = lens.pings();
    let pen = WaterfallPen::new(theme::HAND_COLOUR, WIDTH);
    for line in &app.logs.shown.settings.bottom.lines {
        let [first, last] = line.pings.map(|ping| ping as f64);
        if last + 1.0 < seen.start || first > seen.end {
            continue;
        }
        if line.accepted {
            hand(painter, lens, accepted(lens, app, line), pen);
            continue;
        }
        let corners = line.corners.iter().map(|[ping, _]| *ping);
        let between = corners.filter(|ping| (first..=last).contains(ping));
        let mut pings: Vec<f64> = [first].into_iter().chain(between).chain([last]).collect();
        pings.dedup();
        let points = pings.iter().filter_map(|&ping| {
            let range_m = line.range_m(ping as usize)?;
            Some(at(lens, line.side, ping + 0.5, range_m))
        });
        hand(painter, lens, points.collect(), pen);
    }
}

/// Returns the places of first returns that were accepted as bottom, at no more of the visible
/// pings than a line can show.
fn accepted(lens: &Lens, app: &App, line: &BottomEdit) -> Vec<Pos2> {
    const MOST_PLACES: usize = 512;
    let Some((returns, survey)) = app.logs.shown.bottom_line().zip(app.logs.shown.survey.as_ref())
    else {
        return Vec::new();
    };
    let seen = lens.pings();
    let first = line.pings[0].max(seen.start.max(0.0) as usize);
    let last = line.pings[1].min(seen.end.max(0.0) as usize);
    let step = (last.saturating_sub(first) / MOST_PLACES).max(1);
    let picks = (first..=last).step_by(step).filter_map(|ping| {
        let pick = returns.side(line.side).get(ping)?;
        let range_m = survey.span(ping, line.side)?.range_m(f64::from(pick.sample));
        range_m.is_finite().then(|| at(lens, line.side, ping as f64 + 0.5, range_m))
    });
    picks.collect()
}

/// Width of a ping above which each ping gets a dot, points.
const DOT_POINTS: f64 = 7.0;

/// Width of the dark rim of a line on each side, points: without a rim, red and blue are hard to
/// see on bright copper.
const RIM_POINTS: f32 = 1.25;

/// Colour and widths of a line.
#[derive(Clone, Copy)]
pub(super) struct WaterfallPen {
    colour: Color32,
    /// Width of the line, points.
    width: f32,
    /// Width of the rim on each side of the line, points; 0 except for the pen of the rim.
    rim: f32,
}

impl WaterfallPen {
    pub(super) fn new(colour: Color32, width: f32) -> Self {
        Self { colour, width, rim: 0.0 }
    }

    /// Returns the pen of the rim under the line, which makes it visible on any picture.
    fn rim(self) -> Self {
        Self { colour: Color32::from_black_alpha(170), rim: RIM_POINTS, ..self }
    }

    fn stroke_width(self) -> f32 {
        self.width + 2.0 * self.rim
    }

    fn dot_radius(self) -> f32 {
        self.width * 1.4 + self.rim
    }

    fn of(self, doubtful: bool) -> Color32 {
        if doubtful && self.colour.is_opaque() {
            self.colour.lerp_to_gamma(Color32::WHITE, 0.45)
        } else {
            self.colour
        }
    }
}

/// Draws first returns on a side of the picture; above-bottom returns are dashed and paler, and
/// pings without a pick are gaps.
pub(super) fn first_return(
    painter: &Painter,
    lens: &Lens,
    survey: &Survey,
    step: LineStep<'_>,
    shown_on: Side,
    pen: WaterfallPen,
) {
    draw(painter, &columns(lens, survey, step, shown_on), lens, pen);
}

/// Draws the recorded depth, at the slant range where a flat bottom would give the first return;
/// dashed and paler where the recorder had lost the bottom.
pub(super) fn depth(
    painter: &Painter,
    lens: &Lens,
    survey: &Survey,
    drawing: &WaterfallDrawing,
    reduction: Reduction<'_>,
    pen: WaterfallPen,
) {
    let step = LineStep::Depth(drawing.depth.as_ref());
    for side in Side::BOTH {
        let mut columns = columns(lens, survey, step, side);
        let (first, halvings) = (columns.first, columns.halvings);
        for (index, span) in columns.spans.iter_mut().enumerate() {
            // The scale of the column's first ping is used for the whole column.
            if let Some(recorded) = survey.span((first + index) << halvings, side) {
                *span = span.moved(|depth_m| {
                    let altitude_m = reduction.altitude_m(f64::from(depth_m));
                    reduction.recorded_range_m(recorded, altitude_m) as f32
                });
            }
        }
        draw(painter, &columns, lens, pen);
    }
}

fn draw(painter: &Painter, columns: &Columns, lens: &Lens, pen: WaterfallPen) {
    let pens = [pen.rim(), pen];
    if columns.halvings > 0 {
        painter.extend(pens.map(|pen| ribbon(columns, lens, pen).into()));
        return;
    }
    let runs = runs(columns, lens);
    for pen in pens {
        for run in &runs {
            draw_run(painter, run, lens, pen);
        }
    }
}

/// The line over the visible pings, with one value or pair of extremes for each screen point or
/// ping, whichever is wider.
struct Columns {
    /// Logarithm to base 2 of the number of pings in a column.
    halvings: u8,
    /// Number of the first column.
    first: usize,
    side: Side,
    spans: Vec<LineSpan>,
}

impl Columns {
    fn place(&self, index: usize, range_m: f32) -> LensPlace {
        let ping = ((self.first + index) as f64 + 0.5) * f64::from(1_u32 << self.halvings);
        LensPlace::of(ping, self.side, f64::from(range_m))
    }
}

fn columns(lens: &Lens, survey: &Survey, step: LineStep<'_>, side: Side) -> Columns {
    let halvings = lens.pings_per_point().max(1.0).log2().ceil().min(30.0) as u8;
    let block = 1_usize << halvings;
    let seen = lens.visible(survey.side_scan.len());
    // One more column at each end, so that the line reaches the edges of the picture.
    let first = (seen.start / block).saturating_sub(1);
    Columns {
        halvings,
        first,
        side,
        spans: (first..seen.end.div_ceil(block) + 1)
            .map(|index| step.span(survey, halvings, index))
            .collect(),
    }
}

/// Returns bars from extreme to extreme that touch their neighbours: quick to draw for any shape of
/// the line.
fn ribbon(columns: &Columns, lens: &Lens, pen: WaterfallPen) -> Mesh {
    let mut mesh = Mesh::default();
    let half = f64::from(1_u32 << columns.halvings) / lens.pings_per_point() / 2.0;
    let mut before = LineSpan::GAP;
    for (index, span) in columns.spans.iter().enumerate() {
        let is_dash_gap = span.doubtful && (columns.first + index) % 7 >= 4;
        if !span.is_gap() && !is_dash_gap {
            let [low, high] = span.reaching(&before);
            let [low, high] = [low, high].map(|range_m| columns.place(index, range_m));
            let ends = [low, high].map(|place| lens.screen_at(place));
            let bar = Rect::from_points(&ends);
            let across = pen.stroke_width() / 2.0;
            let bar = match lens.orientation {
                Orientation::Horizontal => bar.expand2(vec2(half as f32, across)),
                Orientation::Vertical => bar.expand2(vec2(across, half as f32)),
            };
            mesh.add_colored_rect(bar, pen.of(span.doubtful));
        }
        before = *span;
    }
    mesh
}

/// A piece of a line without gaps, either doubtful or not.
struct Run {
    doubtful: bool,
    points: Vec<Pos2>,
}

fn runs(columns: &Columns, lens: &Lens) -> Vec<Run> {
    let mut runs: Vec<Run> = Vec::new();
    let mut is_broken = true;
    for (index, span) in columns.spans.iter().enumerate() {
        if span.is_gap() {
            is_broken = true;
            continue;
        }
        let point = lens.screen_at(columns.place(index, span.min_m));
        let last = runs.last_mut().filter(|_| !is_broken);
        let joint = last.as_ref().and_then(|run| run.points.last().copied());
        match last.filter(|run| run.doubtful == span.doubtful) {
            Some(run) => run.points.push(point),
            None => runs.push(Run {
                doubtful: span.doubtful,
                points: joint.into_iter().chain([point]).collect(),
            }),
        }
        is_broken = false;
    }
    runs
}

/// Draws a bottom edit as a line; a single ping as a dot.
fn hand(painter: &Painter, lens: &Lens, points: Vec<Pos2>, pen: WaterfallPen) {
    let run = Run { doubtful: false, points };
    for pen in [pen.rim(), pen] {
        if !run.points.is_empty() {
            draw_run(painter, &run, lens, pen);
        }
    }
}

fn draw_run(painter: &Painter, run: &Run, lens: &Lens, pen: WaterfallPen) {
    let colour = pen.of(run.doubtful);
    let stroke = Stroke::new(pen.stroke_width(), colour);
    match (run.points.as_slice(), run.doubtful) {
        ([single], _) => {
            painter.circle_filled(*single, pen.width + pen.rim, colour);
        }
        (points, true) => {
            painter.extend(Shape::dashed_line(points, stroke, 4.0, 3.0));
        }
        (points, false) => {
            painter.line(points.to_vec(), stroke);
        }
    }
    if 1.0 / lens.pings_per_point() >= DOT_POINTS {
        for point in &run.points {
            painter.circle_filled(*point, pen.dot_radius(), colour);
        }
    }
}

//! Shows over the picture the boxes, the objects that no box has found, and the shape of the
//! selected object, and handles the pointer on boxes.
//!
//! Input: the boxes of a review, and the actions of the pointer. Output: outlines, labels, and
//! commands.

mod grab;
pub(crate) mod outline;

pub(super) use grab::{BoxGrab, under};

use super::labels::WaterfallLabels;
use super::lens::{Lens, LensPlace};
use crate::app::{App, BoxEdge, Reviewing, Tool, border_m};
use crate::ui::{text, theme};
use bathyscope_objects::review::{Review, Reviewed};
use bathyscope_objects::targets::ShapeOnPing;
use bathyscope_objects::truth::Mistake;
use bathyscope_objects::{Mark, ObjectExtent};
use egui::{Align2, Painter, Pos2, Rect, Shape, Stroke, vec2};
use outline::Style;

/// Least shorter side on the screen of a box that is labelled with its class and score, points.
const LABELLED: f32 = 24.0;
/// Width of the lines of an object's shape, width of the dark rim under them, and length of the
/// dashes of its shadow, points.
const SHAPE_WIDTH: f32 = 1.5;
const SHAPE_RIM: f32 = 3.0;
const SHAPE_DASH: f32 = 4.0;

/// A visible box.
pub(super) struct ShownBox<'a> {
    review_box: &'a Reviewed,
    rect: Rect,
    is_selected: bool,
}

/// Returns the visible boxes, the selected one last. The cost depends on the number of visible
/// boxes only.
pub(super) fn in_view<'a>(lens: &Lens, app: &'a App) -> Vec<ShownBox<'a>> {
    let reviewing = &app.logs.shown.reviewing;
    let pings = match &app.logs.shown.survey {
        Some(survey) if app.view.options.waterfall.boxes => lens.visible(survey.side_scan.len()),
        _ => return Vec::new(),
    };
    let shown = |review_box: &'a Reviewed| ShownBox {
        review_box,
        rect: on_screen(lens, &review_box.mark),
        is_selected: Some(review_box.id) == reviewing.selected,
    };
    let others = reviewing.between(pings).map(shown);
    let mut seen: Vec<ShownBox<'_>> =
        others.filter(|shown| !shown.is_selected && shown.rect.intersects(lens.rect)).collect();
    // The selected box is shown in spite of the filter, because keys act on it.
    seen.extend(reviewing.selected_box().map(shown));
    seen
}

/// Returns the area of a mark on the screen: the rectangle around its corners, which over an uneven
/// bottom do not form a rectangle themselves.
fn on_screen(lens: &Lens, mark: &Mark) -> Rect {
    let at = |ping: usize, range_m: f64| LensPlace::of(ping as f64, mark.side, range_m);
    let corner = |ping: usize, range_m: f64| lens.screen_at(at(ping, range_m));
    let pings = [mark.pings.start, mark.pings.end];
    let corners = pings.map(|ping| [mark.near_m, mark.far_m].map(|range_m| corner(ping, range_m)));
    Rect::from_points(corners.as_flattened())
}

impl ShownBox<'_> {
    /// Returns the area of the box on the screen if keys and drags act on the box; `None`
    /// otherwise.
    pub(super) fn edited(&self) -> Option<Rect> {
        self.is_selected.then_some(self.rect)
    }

    /// Draws the outline of the box, and the handles of the box that is edited.
    pub(super) fn draw(&self, painter: &Painter, lens: &Lens, reviewing: &Reviewing) {
        let style = Style::of(self.review_box.state);
        if self.review_box.extent == ObjectExtent::Point {
            return outline::point(painter, self.rect.center(), style, self.is_selected);
        }
        outline::draw(painter, self.rect, style, self.is_selected);
        let is_edited = self.is_selected && reviewing.tool == Tool::Edit;
        if is_edited || self.review_box.extent.border_m().is_some() {
            let border = self.border(lens, reviewing);
            let is_small = self.rect.size().min_elem() < LABELLED;
            if is_edited || !is_small {
                outline::border(painter, border, style.colour, is_edited);
            }
        }
        if is_edited {
            outline::handles(painter, self.rect, style.colour);
            if let Some(edge) = self.edge(lens, reviewing) {
                outline::held(painter, edge);
            }
        }
    }

    /// Returns the line between the echo and the shadow of the box.
    fn border(&self, lens: &Lens, reviewing: &Reviewing) -> [Pos2; 2] {
        self.line_at(lens, border_m(reviewing, self.review_box))
    }

    fn line_at(&self, lens: &Lens, range_m: f64) -> [Pos2; 2] {
        let Mark { side, pings, .. } = &self.review_box.mark;
        [pings.start, pings.end]
            .map(|ping| lens.screen_at(LensPlace::of(ping as f64, *side, range_m)))
    }

    /// Returns the edge that the arrow keys move; `None` where they move the whole box.
    fn edge(&self, lens: &Lens, reviewing: &Reviewing) -> Option<[Pos2; 2]> {
        let Mark { side, pings, near_m, far_m } = &self.review_box.mark;
        let at_ping = |ping: usize| {
            [*near_m, *far_m]
                .map(|range_m| lens.screen_at(LensPlace::of(ping as f64, *side, range_m)))
        };
        match reviewing.edge {
            BoxEdge::Whole => None,
            BoxEdge::Near => Some(self.line_at(lens, *near_m)),
            BoxEdge::Border => Some(self.border(lens, reviewing)),
            BoxEdge::Far => Some(self.line_at(lens, *far_m)),
            BoxEdge::Start => Some(at_ping(pings.start)),
            BoxEdge::End => Some(at_ping(pings.end)),
        }
    }

    /// Writes class and score above the box if the box is large enough or selected.
    pub(super) fn label(&self, labels: &mut WaterfallLabels<'_>, review: &Review) {
        if self.rect.size().min_elem() >= LABELLED || self.is_selected {
            let at = self.rect.left_top() - vec2(0.0, 2.0);
            let (caption, style) =
                (caption(self.review_box, review), Style::of(self.review_box.state));
            labels.write(at, Align2::LEFT_BOTTOM, &caption, style.colour);
        }
    }
}

/// A visible object of the truth that no box has found.
pub(super) struct Missed<'a> {
    class: &'a str,
    rect: Rect,
    is_selected: bool,
}

impl<'a> Missed<'a> {
    /// Returns the visible missed objects; none before the review has boxes, because they would
    /// reveal the truth.
    pub(super) fn in_view(lens: &Lens, app: &'a App) -> Vec<Self> {
        let judging = &app.logs.shown.reviewing.judging;
        let shown = app.view.options.waterfall.boxes && app.logs.shown.reviewing.has_boxes();
        let Some(comparison) = judging.comparison().filter(|_| shown) else {
            return Vec::new();
        };
        let truth = comparison.truth();
        let missed = judging.mistakes().iter().filter_map(|mistake| {
            let Mistake::Miss { object, .. } = mistake else {
                return None;
            };
            let known = truth.objects.get(*object)?;
            Some(Missed {
                class: truth.class_name(known.class),
                rect: on_screen(lens, &known.whole),
                is_selected: judging.missed == Some(*object),
            })
        });
        missed.filter(|missed| missed.rect.intersects(lens.rect)).collect()
    }

    /// Draws the outline of the missed object.
    pub(super) fn draw(&self, painter: &Painter) {
        let style = outline::Style::missed();
        outline::draw(painter, self.rect, style, self.is_selected);
    }

    /// Writes `missed rock` below the object, because the labels of boxes are above.
    pub(super) fn label(&self, labels: &mut WaterfallLabels<'_>) {
        let at = self.rect.left_bottom() + vec2(0.0, 2.0);
        let words = format!("missed {}", self.class);
        labels.write(at, Align2::LEFT_TOP, &words, theme::MISSED_COLOUR);
    }
}

/// Draws the shape of the selected object in each of its boxes of this log: a line around its echo,
/// and a dashed line around its shadow.
pub(super) fn draw_shape(painter: &Painter, lens: &Lens, app: &App) {
    let fitted = app.selected_object_shape();
    let (Some(Ok(fitted)), Some(object)) = (fitted, app.selected_object()) else {
        return;
    };
    let boxes = object.boxes.iter().zip(&fitted.on_pings);
    for (id, on_pings) in boxes.filter(|(id, _)| id.log == app.logs.shown.id) {
        let Some(review_box) = app.logs.log_box(*id) else {
            continue;
        };
        let echo = around(lens, &review_box.mark, on_pings, |on_ping| on_ping.echo_m);
        let shadow = around(lens, &review_box.mark, on_pings, |on_ping| {
            [on_ping.echo_m[1], on_ping.shadow_end_m]
        });
        let rim = Stroke::new(SHAPE_RIM, outline::RIM);
        let stroke = Stroke::new(SHAPE_WIDTH, theme::INFERRED_COLOUR);
        if echo.len() < 3 || !painter.clip_rect().intersects(egui::Rect::from_points(&shadow)) {
            continue;
        }
        painter.add(Shape::closed_line(echo.clone(), rim));
        painter.extend(Shape::dashed_line(&closed(shadow), stroke, SHAPE_DASH, SHAPE_DASH));
        painter.add(Shape::closed_line(echo, stroke));
    }
}

/// Returns the outline of the part between two slant ranges in each ping.
fn around(
    lens: &Lens,
    mark: &Mark,
    on_pings: &[ShapeOnPing],
    between_m: impl Fn(&ShapeOnPing) -> [f64; 2],
) -> Vec<Pos2> {
    let at = |on_ping: &ShapeOnPing, edge: usize| {
        let range_m = between_m(on_ping)[edge];
        lens.screen_at(LensPlace::of(on_ping.ping as f64 + 0.5, mark.side, range_m))
    };
    let there = on_pings.iter().map(|on_ping| at(on_ping, 0));
    let back = on_pings.iter().rev().map(|on_ping| at(on_ping, 1));
    there.chain(back).collect()
}

fn closed(mut line: Vec<Pos2>) -> Vec<Pos2> {
    line.extend(line.first().copied());
    line
}

/// Returns `rock 0.87`, or `Anna (wreck) 0.87` for a box with a name; the outline already shows the
/// decision.
fn caption(review_box: &Reviewed, review: &Review) -> String {
    let class = review.class_name(review_box.class);
    let class = if review_box.name.is_empty() {
        class.to_owned()
    } else {
        format!("{} ({class})", review_box.name)
    };
    match review_box.score {
        Some(score) => format!("{class} {score:.2}"),
        None => class,
    }
}

/// Describes the boxes of the view for screen readers and tests.
pub(super) fn words(seen: &[ShownBox<'_>], missed: &[Missed<'_>], app: &App) -> String {
    if !app.logs.shown.reviewing.has_boxes() {
        return tool_in_hand(app).to_owned();
    }
    let selected = app.logs.shown.reviewing.selected_box();
    let selected = selected.map_or_else(String::new, |review_box| {
        let caption = caption(review_box, &app.logs.shown.reviewing.review);
        let id = review_box.id.0;
        let state = review_box.state.name();
        format!(", box {id} selected: {caption}, {state}")
    });
    let missed = match missed.len() {
        0 => String::new(),
        count => format!(", {count} missed in view"),
    };
    let boxes = text::plural(seen.len(), "box", "boxes");
    let tool = tool_in_hand(app);
    format!(", {boxes} in view{missed}{selected}{tool}")
}

fn tool_in_hand(app: &App) -> &'static str {
    match app.logs.shown.reviewing.tool {
        Tool::Look => "",
        Tool::Edit => match app.logs.shown.reviewing.edge {
            BoxEdge::Whole => ", editing it",
            BoxEdge::Near => ", editing the near edge of its echo",
            BoxEdge::Border => ", editing its border of echo and shadow",
            BoxEdge::Far => ", editing the end of its shadow",
            BoxEdge::Start => ", editing its first ping",
            BoxEdge::End => ", editing its last ping",
        },
        Tool::Point => ", marking a target",
        Tool::Draw => ", drawing a box",
        Tool::Bottom => ", drawing the bottom",
        Tool::Exclude => ", excluding stretches",
        Tool::Calibrate => ", choosing a stretch for the scale",
        Tool::Accept => ", accepting first returns as bottom",
    }
}

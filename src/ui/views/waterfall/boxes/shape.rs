//! The shape of the selected object over the picture: where its echo and its shadow would lie.

use super::super::lens::{Lens, LensPlace};
use super::outline;
use crate::app::App;
use crate::ui::theme;
use bathyscope_objects::Mark;
use bathyscope_objects::targets::ShapeOnPing;
use egui::{Painter, Pos2, Shape, Stroke};

/// Width of its lines and of the dark rim under them, points; dashes of its shadow.
const WIDTH: f32 = 1.5;
const RIM: f32 = 3.0;
const DASH: f32 = 4.0;

/// Draws the shape of the selected object in each of its boxes of this log: a line around its echo,
/// a dashed one around its shadow.
pub(in crate::ui::views::waterfall) fn draw(painter: &Painter, lens: &Lens, app: &App) {
    let fitted = app.selected_object_shape();
    let (Some(Ok(fitted)), Some(object)) = (fitted, app.selected_object()) else {
        return;
    };
    let boxes = object.boxes.iter().zip(&fitted.on_pings);
    for (id, on_pings) in boxes.filter(|(id, _)| id.log == app.log.id) {
        let Some(one) = app.log_box(*id) else {
            continue;
        };
        let echo = around(lens, &one.mark, on_pings, |one| one.echo_m);
        let shadow = around(lens, &one.mark, on_pings, |one| [one.echo_m[1], one.shadow_end_m]);
        let rim = Stroke::new(RIM, outline::RIM);
        let stroke = Stroke::new(WIDTH, theme::INFERRED_COLOUR);
        if echo.len() < 3 || !painter.clip_rect().intersects(egui::Rect::from_points(&shadow)) {
            continue;
        }
        painter.add(Shape::closed_line(echo.clone(), rim));
        painter.extend(Shape::dashed_line(&closed(shadow), stroke, DASH, DASH));
        painter.add(Shape::closed_line(echo, stroke));
    }
}

/// The way around what lies between two slant ranges in each ping.
fn around(
    lens: &Lens,
    mark: &Mark,
    on_pings: &[ShapeOnPing],
    between_m: impl Fn(&ShapeOnPing) -> [f64; 2],
) -> Vec<Pos2> {
    let at = |one: &ShapeOnPing, edge: usize| {
        let range_m = between_m(one)[edge];
        lens.screen_at(LensPlace::of(one.ping as f64 + 0.5, mark.side, range_m))
    };
    let there = on_pings.iter().map(|one| at(one, 0));
    let back = on_pings.iter().rev().map(|one| at(one, 1));
    there.chain(back).collect()
}

fn closed(mut line: Vec<Pos2>) -> Vec<Pos2> {
    line.extend(line.first().copied());
    line
}

//! Lets the user draw bottom edits with a pen, and shows these edits.

use super::lens::{Lens, LensPlace};
use super::lines::WaterfallPen;
use crate::app::{App, BottomStroke, Command, Ink, Tool};
use crate::ui::views::tool;
use crate::ui::{ViewContext, theme};
use bathyscope_bottom::first_return::BottomEdit;
use bathyscope_log::survey::Side;
use egui::{CursorIcon, Modifiers, Painter, Pos2, Response, Shape, Stroke, Ui};

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
            super::lines::hand(painter, lens, accepted(lens, app, line), pen);
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
        super::lines::hand(painter, lens, points.collect(), pen);
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

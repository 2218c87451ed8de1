//! Provides what the views share of tools: the banner at the top of a view while a tool is
//! selected, with the name of the tool, the next action of the user, and the keys; and drags with a
//! tool.

use super::legend;
use crate::app::{Action, App, BoxEdge, Command, ExclusionEdit, LogId, Tool, View};
use crate::ui::{place, theme};
use bathyscope_bottom::calibration::PingRange;
use bathyscope_log::survey::{LogPart, Side};
use bathyscope_products::project::MeasurementKind;
use egui::text::LayoutJob;
use egui::{
    Color32, FontId, Galley, Key, Modifiers, PointerButton, Pos2, Rect, Response, Role, Sense,
    TextFormat, Ui, WidgetInfo, vec2,
};
use std::sync::Arc;

/// Room around the words, points.
const MARGIN: egui::Vec2 = vec2(7.0, 3.0);
/// Least height of a view whose banner shows all keys, points.
const ROOM_FOR_KEYS: f32 = 170.0;

/// Text of a banner.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Banner {
    name: &'static str,
    next: String,
    keys: String,
}

impl Banner {
    fn new(name: &'static str, next: impl Into<String>, keys: impl Into<String>) -> Self {
        Self { name, next: next.into(), keys: keys.into() }
    }

    /// Creates the banner of the selected tool, if the tool can be used in this view; `None`
    /// otherwise.
    pub(super) fn of(app: &App, view: View) -> Option<Self> {
        if let Some(kind) = app.map.measuring.tool {
            return measuring(app, kind, view);
        }
        match (app.logs.shown.reviewing.tool, view) {
            (Tool::Exclude, View::Waterfall | View::Map) => Some(Self::new(
                "Exclude stretches",
                "drag along the pings; a click includes a stretch again",
                format!(
                    "Ctrl: always include · Shift: trust soundings · Alt: reset · {} or Esc ends",
                    Action::Exclude.key()
                ),
            )),
            (Tool::Calibrate, View::Waterfall | View::Map) => Some(Self::new(
                "Calibrate on a stretch",
                "drag along level bottom, or click a numbered stretch",
                format!(
                    "then {} · {} or Esc ends",
                    Action::UseScale.label(),
                    Action::Calibrate.key()
                ),
            )),
            (tool, View::Waterfall) => of_picture(app, tool),
            _ => None,
        }
    }

    /// Returns the whole banner as one line.
    fn words(&self) -> String {
        format!("{}: {}. {}", self.name, self.next, self.keys)
    }

    /// Lays the banner out in the upper left corner of `room`.
    pub(super) fn place(&self, ui: &Ui, room: Rect) -> PlacedBanner {
        // All keys if they fit in two lines, else only the key that leaves the tool: a banner must
        // not cover a small view.
        let has_room = room.height() >= ROOM_FOR_KEYS;
        let whole = has_room.then(|| self.lay_out(ui, room, &self.keys));
        let whole = whole.filter(|galley| galley.rows.len() <= 2);
        let leave_key = self.keys.rsplit(" · ").next().unwrap_or_default();
        let galley = whole.unwrap_or_else(|| self.lay_out(ui, room, leave_key));
        PlacedBanner {
            plate: Rect::from_min_size(room.min, galley.size() + 2.0 * MARGIN),
            galley,
            words: self.words(),
        }
    }

    fn lay_out(&self, ui: &Ui, room: Rect, keys: &str) -> Arc<Galley> {
        let font = FontId::proportional(12.0);
        let mut job = LayoutJob::default();
        let mut add = |text: &str, colour: Color32| {
            job.append(text, 0.0, TextFormat::simple(font.clone(), colour));
        };
        // On a dark background in any theme, like all words on the picture.
        add(self.name, theme::MEASURE_COLOUR);
        add(&format!("  {}", self.next), Color32::from_gray(240));
        add(&format!("   {keys}"), Color32::from_gray(178));
        job.wrap.max_width = (room.width() - 2.0 * MARGIN.x).max(80.0);
        ui.painter().layout_job(job)
    }
}

/// A banner in its place.
pub(super) struct PlacedBanner {
    /// Area of the banner.
    pub plate: Rect,
    galley: Arc<Galley>,
    words: String,
}

impl PlacedBanner {
    /// Draws the banner.
    pub(super) fn draw(&self, ui: &Ui) {
        let plate = self.plate;
        let painter = ui.painter();
        painter.rect_filled(plate, 3.0, Color32::from_black_alpha(225));
        let edge = Rect::from_min_size(plate.min, vec2(3.0, plate.height()));
        painter.rect_filled(edge, 0.0, theme::MEASURE_COLOUR);
        let galley = self.galley.clone();
        painter.galley(plate.min + MARGIN, galley, Color32::PLACEHOLDER);
        let response = ui.interact(plate, ui.scope_id().with("tool banner"), Sense::hover());
        response.widget_info(|| WidgetInfo::labeled(Role::Label, true, &self.words));
    }
}

/// Returns the banner of a tool that is used in the waterfall only; `None` for other tools.
fn of_picture(app: &App, tool: Tool) -> Option<Banner> {
    Some(match tool {
        Tool::Look | Tool::Exclude | Tool::Calibrate => return None,
        Tool::Edit => {
            let edge = app.logs.shown.reviewing.edge;
            let next = match edge {
                BoxEdge::Whole => "drag the box or one of its edges".to_owned(),
                edge => format!("the arrow keys move the {}", edge.name()),
            };
            Banner::new(
                "Edit box",
                next,
                format!(
                    "Arrows move it, Ctrl+arrows its edges · {}: next edge · {} or Esc ends",
                    Action::NextEdge.key(),
                    Action::EditBox.key()
                ),
            )
        }
        Tool::Draw => Banner::new(
            "New box",
            "drag from one corner of echo and shadow to the other",
            format!(
                "Space or the middle button moves the picture · {} or Esc ends",
                Action::NewBox.key()
            ),
        ),
        Tool::Point => Banner::new(
            "Mark target",
            "click the target",
            format!(
                "Arrows move the cross, {} marks there or at the pointer · Esc ends",
                Action::MarkTarget.key()
            ),
        ),
        Tool::Accept => Banner::new(
            "Accept as bottom",
            "drag along first returns that follow the bottom",
            "Alt: no longer accepted · Esc ends",
        ),
        Tool::Bottom => Banner::new(
            "Draw the bottom",
            "drag along the first echo of the bottom",
            format!(
                "Ctrl: mark as missing · Alt: automatic pick · Up, Down: at the selected ping · {} or Esc ends",
                Action::DrawBottom.key()
            ),
        ),
    })
}

fn measuring(app: &App, kind: MeasurementKind, view: View) -> Option<Banner> {
    let is_drawing = app.map.measuring.is_drawing();
    let (name, next) = match (kind, view) {
        (_, View::Cloud | View::Objects | View::Profile) => return None,
        (MeasurementKind::Distance, _) => ("Measure distance", "click the corners of a line"),
        (MeasurementKind::Area, _) => ("Measure area", "click the corners around it"),
        (MeasurementKind::Profile, _) => ("Depth profile", "click the corners of a line"),
        (MeasurementKind::Height, View::Map) => {
            ("Height from shadow", "drag along the shadow in the waterfall")
        }
        (MeasurementKind::Height, View::Waterfall) => (
            "Height from shadow",
            if is_drawing {
                "now the end of the shadow"
            } else {
                "drag from the object's top, where its shadow begins, to the shadow's end"
            },
        ),
    };
    let [corner, back] = [Action::SetCorner, Action::TakeCornerBack].map(Action::key);
    let keys = match (kind, is_drawing) {
        (MeasurementKind::Height, _) => {
            let height = Action::HeightFromShadow.key();
            format!(
                "Arrows move the cross, {corner} sets an end · {back} removes it · {height} or Esc ends"
            )
        }
        (_, true) => {
            let end = Action::EndFigure.key();
            format!(
                "Arrows and {corner}: corner by key · {back}: remove it · {end} or double-click: finish · Esc ends"
            )
        }
        (_, false) => format!("Arrows move the cross, {corner} sets a corner · Esc ends"),
    };
    Some(Banner::new(name, next, keys))
}

/// Returns the banner of the selected tool at the top of a view; `None` without a tool, without
/// room, and in an exported picture.
pub(super) fn in_view(ui: &Ui, app: &App, view: View, rect: Rect) -> Option<PlacedBanner> {
    let banner = Banner::of(app, view).filter(|_| !app.view.is_picture)?;
    let room = rect.shrink2(vec2(4.0, 4.0));
    legend::has_width(room).then(|| banner.place(ui, room))
}

/// Effect of a drag along the pings of a log.
#[derive(Clone, Copy)]
pub(super) enum Does {
    Exclusion(ExclusionEdit),
    Propose,
    Accept(Side, bool),
}

impl Does {
    pub(super) fn command(self, log: LogId, pings: [usize; 2]) -> Command {
        let part = LogPart::Pings(pings);
        match self {
            Self::Exclusion(edit) => Command::Exclude { log, part, edit },
            Self::Propose => {
                Command::ProposeStretch(PingRange { start: pings[0], end: pings[1] + 1 })
            }
            Self::Accept(side, accept) => Command::AcceptBottom { side, pings, accept },
        }
    }

    /// Describes the effect, with the length that the drag covers; `None` if that length is
    /// unknown.
    pub(super) fn words(self, app: &App, log: LogId, pings: [usize; 2]) -> Option<String> {
        let units = app.view.options.units;
        let extent = app.logs.extent_of(log, LogPart::Pings(pings))?;
        let covered = place::stretch_extent(&extent, units);
        Some(match self {
            Self::Exclusion(edit) => place::drag_effect(edit, &extent, units),
            Self::Propose => format!("propose {covered}"),
            Self::Accept(side, true) => format!("accept as bottom, {}: {covered}", side.name()),
            Self::Accept(side, false) => format!("no longer accepted, {}: {covered}", side.name()),
        })
    }

    pub(super) fn colour(self) -> Color32 {
        match self {
            Self::Propose => theme::PROPOSAL_COLOUR,
            Self::Exclusion(_) | Self::Accept(..) => theme::HAND_COLOUR,
        }
    }
}

/// Returns the place where a drag with a tool began in this frame; `None` while Space is held,
/// which makes the drag move the picture instead.
pub(super) fn begun(ui: &Ui, response: &Response) -> Option<Pos2> {
    let (space, pressed) =
        ui.input(|input| (input.key_down(Key::Space), input.pointer.press_origin()));
    let begun = response.drag_started_by(PointerButton::Primary) && !space;
    let at = pressed.or(response.interact_pointer_pos());
    at.filter(|_| begun)
}

/// Returns true if a drag has ended while the button is still held: Escape has ended it, and it
/// must have no effect.
pub(super) fn is_given_up(ui: &Ui, response: &Response) -> bool {
    response.drag_stopped() && ui.input(|input| input.pointer.primary_down())
}

/// Returns the effect of the tool for excluded stretches with the modifier keys that are held.
pub(super) fn exclusion_edit(held: Modifiers) -> ExclusionEdit {
    if held.alt {
        ExclusionEdit::Reset
    } else if held.command {
        ExclusionEdit::Include
    } else if held.shift {
        ExclusionEdit::Trust
    } else {
        ExclusionEdit::Exclude
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::app::{Action, Command, Jobs};

    #[test]
    fn every_tool_says_what_to_do_and_how_to_leave_it() {
        let tools = [
            (Action::MeasureDistance, "Measure distance"),
            (Action::MeasureArea, "Measure area"),
            (Action::DepthProfile, "Depth profile"),
            (Action::HeightFromShadow, "Height from shadow"),
            (Action::NewBox, "New box"),
            (Action::MarkTarget, "Mark target"),
            (Action::DrawBottom, "Draw the bottom"),
            (Action::Exclude, "Exclude stretches"),
            (Action::AcceptBottom, "Accept as bottom"),
            (Action::Calibrate, "Calibrate on a stretch"),
        ];
        let mut app = App::new(Jobs::Inline);
        app.apply(Command::OpenDemo);
        for _ in 0..50 {
            app.poll();
        }
        assert_eq!(Banner::of(&app, View::Waterfall), None);
        for (action, name) in tools {
            app.apply(Command::Do(action));
            let banner = Banner::of(&app, View::Waterfall).expect(name);
            assert_eq!(banner.name, name);
            assert!(banner.keys.ends_with("Esc ends"), "{}", banner.keys);
            app.apply(Command::Do(Action::LeaveTool));
            assert_eq!(Banner::of(&app, View::Waterfall), None, "{name}");
        }
    }
}

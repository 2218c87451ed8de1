//! Plays along the survey: moves the selection with time.

use crate::app::{Action, App, Command, LogPlace};
use crate::ui::ViewContext;
use egui::Ui;
use std::time::Duration;

/// Speeds of playing: survey seconds per second.
const SPEEDS: [f64; 6] = [1.0, 2.0, 4.0, 10.0, 20.0, 30.0];
/// Index of the initial speed in [`SPEEDS`].
const FIRST_SPEED: usize = 2;

/// Playback of the selection: its state and its speed.
pub(super) struct Play {
    running: bool,
    /// Index into [`SPEEDS`].
    speed: usize,
    /// Survey time of the play head, seconds; it is finer than the pings.
    time_s: f64,
    /// The ping at the play head.
    ping: usize,
}

impl Default for Play {
    fn default() -> Self {
        Self { running: false, speed: FIRST_SPEED, time_s: 0.0, ping: 0 }
    }
}

impl Play {
    /// Starts playing at the selection, or stops. At the end of the log, playing starts at its
    /// beginning.
    pub(super) fn toggle(&mut self, app: &App) {
        let Some(pings) = app.logs.shown.survey.as_ref().map(|survey| &survey.side_scan) else {
            return;
        };
        let here = app.view.selection.map_or(0, |mark| mark.ping);
        let from = if here + 1 >= pings.len() { 0 } else { here };
        if let Some(ping) = pings.get(from) {
            self.time_s = ping.time_s;
            self.ping = here;
            self.running = !self.running;
        }
    }

    /// Changes the speed by a number of steps, between the slowest and the fastest.
    pub(super) fn change_speed(&mut self, steps: isize) {
        let next = self.speed.saturating_add_signed(steps);
        self.speed = next.min(SPEEDS.len() - 1);
    }

    /// Stops playing.
    pub(super) fn stop(&mut self) {
        self.running = false;
    }

    /// Moves the selection by the time since the last frame.
    pub(super) fn advance(&mut self, ui: &Ui, app: &App, commands: &mut Vec<Command>) {
        if !self.running {
            return;
        }
        let Some(survey) = &app.logs.shown.survey else {
            self.running = false;
            return;
        };
        let pings = &survey.side_scan;
        // If the analyst selects another ping meanwhile, playing continues from there.
        let moved = app.view.selection.filter(|mark| mark.ping != self.ping);
        if let Some(ping) = moved.and_then(|mark| pings.get(mark.ping)) {
            self.time_s = ping.time_s;
        }
        let frame_s = f64::from(ui.input(|input| input.stable_dt)).min(0.25);
        self.time_s += frame_s * SPEEDS[self.speed];
        let next = pings.partition_point(|ping| ping.time_s <= self.time_s);
        if next >= pings.len() {
            self.running = false;
        }
        let ping = next.saturating_sub(1);
        self.ping = ping;
        if app.view.selection.map(|mark| mark.ping) != Some(ping) {
            commands.push(Command::Reveal(LogPlace::ping(ping)));
        }
        ui.ctx().request_repaint_after(Duration::from_millis(16));
    }

    /// Draws the button and, while it runs, the speed at the left end of the time line.
    pub(super) fn ui(&mut self, ui: &mut Ui, context: &mut ViewContext<'_>) {
        if context.app.logs.shown.survey.is_none() {
            return;
        }
        let corner = ui.min_rect().left_top();
        let place = egui::Rect::from_min_size(corner, egui::vec2(34.0, 44.0));
        let mut ui = ui.new_child(egui::UiBuilder::new().max_rect(place));
        ui.spacing_mut().item_spacing.y = 3.0;
        let size = egui::vec2(30.0, 20.0);
        let button = ui
            .add_sized(size, egui::Button::new(""))
            .accessible_name(Action::Play.label())
            .on_hover_text("Runs along the survey (Space).");
        icon(&ui, button.rect, self.running);
        if button.clicked() {
            context.push(Command::Do(Action::Play));
        }
        if !self.running {
            return;
        }
        let text = egui::RichText::new(format!("{}×", SPEEDS[self.speed])).small();
        let hint = format!(
            "How much faster than the boat; click for the next speed. Faster: {}, slower: {}.",
            Action::PlayFaster.key(),
            Action::PlaySlower.key()
        );
        let speed = ui
            .add_sized(size, egui::Button::new(text))
            .accessible_name("Play speed")
            .on_hover_text(hint);
        if speed.clicked() {
            self.speed = (self.speed + 1) % SPEEDS.len();
        }
    }
}

/// Draws a triangle or two bars, because the font has neither.
fn icon(ui: &Ui, rect: egui::Rect, running: bool) {
    let at = rect.center();
    let colour = ui.visuals().strong_text_color();
    if running {
        for dx in [-3.0, 3.0] {
            let bar = egui::Rect::from_center_size(at + egui::vec2(dx, 0.0), egui::vec2(2.5, 9.0));
            ui.painter().rect_filled(bar, 0.0, colour);
        }
    } else {
        let corners = [[-3.5, -5.0], [5.0, 0.0], [-3.5, 5.0]];
        let points = corners.map(|[x, y]| at + egui::vec2(x, y)).to_vec();
        let triangle = egui::Shape::convex_polygon(points, colour, egui::Stroke::NONE);
        ui.painter().add(triangle);
    }
}

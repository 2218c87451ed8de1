//! Draws the list of all notices since the program was started: time, text, and offered action.

use crate::app::Notice;
use crate::ui::ViewContext;
use crate::ui::panels::parts;
use bathyscope_bottom::presentation::text;
use egui::{Align, Layout, RichText, ScrollArea, Ui, Window, vec2};
use std::time::UNIX_EPOCH;

const SIZE: [f32; 2] = [560.0, 420.0];

/// The list of notices; closed at the start.
#[derive(Default)]
pub(super) struct NoticeList {
    /// True if the list is shown.
    pub open: bool,
}

impl NoticeList {
    /// Draws the list while it is open.
    pub(super) fn ui(&mut self, ctx: &egui::Context, context: &mut ViewContext<'_>) {
        if !self.open {
            return;
        }
        let mut open = true;
        let room = ctx.content_rect().shrink(8.0);
        let size = vec2(SIZE[0], SIZE[1]).min(room.size());
        Window::new("Notices")
            .open(&mut open)
            .collapsible(false)
            .default_size(size)
            .max_size(room.size())
            .default_pos(room.center_bottom() - vec2(0.5 * size.x, size.y + 40.0))
            .show(ctx, |ui| list(ui, context));
        self.open &= open;
    }
}

fn list(ui: &mut Ui, context: &mut ViewContext<'_>) {
    let app = context.app;
    if app.notices.all().len() == 0 {
        parts::remark(ui, "There are no messages yet.");
    }
    ScrollArea::vertical().auto_shrink([false, false]).show(ui, |ui| {
        for notice in app.notices.all() {
            line(ui, context, notice);
        }
    });
}

fn line(ui: &mut Ui, context: &mut ViewContext<'_>, notice: &Notice) {
    let said = context.units().sentence(&notice.text);
    ui.horizontal_top(|ui| {
        parts::severity(ui, context.theme(), notice.is_error);
        let unix_s = notice.at.duration_since(UNIX_EPOCH).unwrap_or_default();
        let clock = text::clock(Some(0.0), unix_s.as_secs_f64());
        ui.label(RichText::new(clock).monospace().weak());
        ui.with_layout(Layout::right_to_left(Align::Min), |ui| {
            if let Some(action) = notice.offer {
                context.button(ui.small_button(action.label()), action);
            }
            ui.with_layout(Layout::top_down(Align::Min), |ui| {
                ui.add(egui::Label::new(said).wrap());
            });
        });
    });
    ui.add_space(2.0);
}

//! The track of another receiver in place of the recorder's, how far its clock is off, and how far
//! all positions are.

use super::parts::{self, fact, remark, setting};
use super::positions;
use super::section::{Section, section};
use crate::app::Action;
use crate::ui::ViewContext;
use bathyscope_products::pipeline::Stage;
use bathyscope_products::pipeline::settings::rows;
use egui::Ui;

/// Draws the section.
pub(crate) fn ui(ui: &mut Ui, context: &mut ViewContext<'_>) {
    section(ui, context, Section::new("Position").of(Stage::Navigation), |ui, context| {
        let path = context.app.log.settings.track.file.clone();
        let actions = [Action::OpenTrack, Action::RemoveTrack];
        parts::file(ui, context, &rows::TRACK_FILE, path.as_deref(), actions);
        match path {
            Some(_) => clock(ui, context),
            None => remark(ui, "Positions are those of the recorder."),
        }
        for row in [&rows::SHIFT_EAST, &rows::SHIFT_NORTH] {
            setting(ui, context, row);
        }
        // Of several logs they are compared where the logs are listed.
        if context.app.log_count() == 1 {
            positions::ui(ui, context);
        }
    });
}

/// The offset of the clock, and what it does to the distance between the tracks.
fn clock(ui: &mut Ui, context: &mut ViewContext<'_>) {
    setting(ui, context, &rows::TRACK_OFFSET);
    let apart = &context.app.log.external.apart;
    if !apart.pairs.is_empty() {
        let hint = "Median distance between the positions of recorder and receiver at the same times: \
                    smallest where their clocks agree.";
        let apart = context.units().measure(apart.median_m, 2);
        let text = format!("{apart} from the recorder's");
        fact(ui, "Lies", hint, text);
    }
    remark(
        ui,
        "The map shows the recorder's track as a thin line; short lines join positions of the same time.",
    );
}

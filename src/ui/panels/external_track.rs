//! The track of another receiver in place of the recorder's, and how far its clock is off.

use super::parts::{self, Section, fact, remark, row, section};
use crate::app::{Action, Command};
use crate::pipeline::Settings;
use crate::pipeline::Stage;
use crate::ui::ViewContext;
use egui::{DragValue, Ui};

/// Draws the section.
pub fn ui(ui: &mut Ui, context: &mut ViewContext<'_>) {
    let heading = Section {
        number: None,
        title: "Position",
        stage: Some(Stage::Navigation),
    };
    section(ui, context, &heading, |ui, context| {
        let path = context.app.log.settings.track.file.clone();
        parts::file(
            ui,
            context,
            "Track",
            "Places of another receiver, RTK or an autopilot, in place of the recorder's.",
            path.as_deref(),
            [Action::OpenTrack, Action::RemoveTrack],
        );
        match path {
            Some(_) => clock(ui, context),
            None => remark(ui, "Positions are those of the recorder."),
        }
    });
}

/// The offset of the clock, and what it does to the distance between the tracks.
fn clock(ui: &mut Ui, context: &mut ViewContext<'_>) {
    let mut offset_s = context.app.log.settings.track.offset_s;
    let hint = "Added to the times of the track: how far its clock is behind that of the recorder.";
    let response = row(ui, "Time offset", hint, |ui| {
        ui.add(
            DragValue::new(&mut offset_s)
                .speed(0.02)
                .fixed_decimals(2)
                .suffix(" s"),
        )
    });
    if response.changed() || response.drag_stopped() {
        let mut settings = Settings::clone(&context.app.log.settings);
        // Hundredths of a second stay hundredths.
        settings.track.offset_s = (offset_s * 100.0).round() / 100.0;
        context.push(Command::Change {
            settings: Box::new(settings),
            label: "time offset",
            live: response.dragged() && !response.drag_stopped(),
        });
    }
    let apart = &context.app.log.external.apart;
    if !apart.pairs.is_empty() {
        let hint = "Median distance between the places that recorder and receiver have at the same times: \
                    least where their clocks agree.";
        let text = format!("{:.2} m from the recorder's", apart.median_m);
        fact(ui, "Lies", hint, text);
    }
    remark(
        ui,
        "The recorder's track stays on the map as a thin line; short strokes join the two at the same times.",
    );
}

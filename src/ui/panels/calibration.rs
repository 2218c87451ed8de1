//! Step 2: from samples to metres. All scales side by side, and the stretch that the pixels per metre come from.

use super::parts::{self, fact, setting};
use super::section::{Section, section};
use crate::app::{Action, Command};
use crate::calibration::{Calibration, FlatSpot, PingRange, Scale, ScaleMode};
use crate::pipeline::Stage;
use crate::pipeline::settings::rows;
use crate::presentation::units::Units;
use crate::ui::{ViewContext, text};
use egui::Ui;
use std::ops::Range;

/// Draws the section.
pub fn ui(ui: &mut Ui, context: &mut ViewContext<'_>) {
    let heading = Section {
        number: Some(2),
        title: "Calibration",
        stage: Some(Stage::Calibration),
    };
    section(ui, context, &heading, |ui, context| {
        setting(ui, context, &rows::SCALE);
        setting(
            ui,
            context,
            match context.app.log.settings.calibration.mode {
                ScaleMode::FlatSpot => &rows::PPD_REACH,
                ScaleMode::Header => &rows::OFFSET,
            },
        );
        let Some(products) = context.app.log.products.clone() else {
            parts::remark(ui, "No result yet.");
            return;
        };
        scales(ui, &products.calibration, context.app.options.units);
        let survey = context.app.log.survey.as_ref();
        if survey.is_some_and(|survey| survey.soundings.is_empty()) {
            parts::remark(ui, "This log records no depth to measure a scale against.");
        }
        for text in &products.calibration.warnings {
            parts::warning(ui, context, &context.app.options.units.sentence(text));
        }
        spot_in_use(ui, context, &products.calibration);
        ranked_spots(ui, context, &products.flat_spots);
    });
}

fn scale(scale: Option<&Scale>) -> String {
    scale.map_or_else(
        || text::NONE.to_owned(),
        |scale| format!("{:.2} ±{:.2} px/m", scale.px_per_m, scale.spread_px_per_m),
    )
}

fn scales(ui: &mut Ui, calibration: &Calibration, units: Units) {
    fact(
        ui,
        "PPD",
        "Pixels per metre at the flat spot, PPD = p / d: median over its pings and robust spread.",
        scale(calibration.ppd().as_ref()),
    );
    fact(
        ui,
        "Header",
        "Pixels per metre that the recorder's own ranges imply.",
        scale(calibration.header.as_ref()),
    );
    let measured = calibration.measured_offset.map_or(String::new(), |found| {
        let added_m = -found.offset_m;
        format!(
            " This log asks for {}.",
            units.signed_within(added_m, found.uncertainty_m, 2)
        )
    });
    fact(
        ui,
        "Ranges",
        &format!(
            "What is added to every recorded range, so that first returns and recorded depths agree where the bottom is level.{measured}"
        ),
        match calibration.offset_note {
            Some(note) => format!("+0 {}: {}", units.symbol(), units.sentence(note)),
            None => units.signed(-calibration.offset_m, 2),
        },
    );
    let fit = calibration.fit.map_or_else(
        || text::NONE.to_owned(),
        |fit| {
            let b = units.signed_within(fit.b_m, fit.spread_m, 2);
            format!("k {:.3} b {b}", fit.k)
        },
    );
    fact(
        ui,
        "r = k d + b",
        "Robust line of first-return range r against recorded depth d over the whole log.",
        fit,
    );
}

fn spot_in_use(ui: &mut Ui, context: &mut ViewContext<'_>, calibration: &Calibration) {
    let picked = context.app.log.settings.calibration.pings;
    let shown = match (&calibration.flat_spot, picked) {
        (Some(spot), _) => pings(&spot.pings),
        (None, Some(range)) => pings(&(range.start..range.end)),
        (None, None) => "none found".to_owned(),
    };
    fact(
        ui,
        "Flat spot",
        "Pings that PPD is measured on. Click the map or the waterfall and press C to take another stretch.",
        format!("{shown}{}", if picked.is_some() { " (picked)" } else { "" }),
    );
    ui.horizontal(|ui| {
        let can = context.app.selection.is_some();
        for (action, label, enabled) in [
            (Action::CalibrateHere, "Calibrate here", can),
            (Action::CalibrationReset, "Reset", picked.is_some()),
        ] {
            let button = ui.add_enabled(enabled, egui::Button::new(label));
            let button = button
                .accessible_name(action.label())
                .on_hover_text(action.hint())
                .on_disabled_hover_text("Select a ping first.");
            if button.clicked() {
                context.push(Command::Do(action));
            }
        }
    });
}

fn pings(range: &Range<usize>) -> String {
    format!("{}..{}", range.start, range.end)
}

fn ranked_spots(ui: &mut Ui, context: &mut ViewContext<'_>, spots: &[FlatSpot]) {
    if spots.is_empty() {
        return;
    }
    let title = text::plural(spots.len(), "flat stretch", "flat stretches");
    egui::CollapsingHeader::new(title)
        .id_salt("ranked flat stretches")
        .show(ui, |ui| {
            for (rank, spot) in spots.iter().enumerate() {
                ranked_spot(ui, context, rank + 1, spot);
            }
        });
}

fn ranked_spot(ui: &mut Ui, context: &mut ViewContext<'_>, rank: usize, spot: &FlatSpot) {
    let picked = context.app.log.settings.calibration.pings;
    let range = PingRange {
        start: spot.pings.start,
        end: spot.pings.end,
    };
    ui.horizontal(|ui| {
        let units = context.app.options.units;
        let [port, starboard] = spot.picks;
        let label = match spot.ppd {
            Some(ppd) => format!(
                "{rank}  {}  {:.1} ±{:.1} px/m  {port}+{starboard}",
                units.measure(spot.depth_m, 1),
                ppd.px_per_m,
                ppd.spread_px_per_m
            ),
            None => format!(
                "{rank}  {}  {port}+{starboard} picks",
                units.measure(spot.depth_m, 1)
            ),
        };
        let row = ui
            .selectable_label(picked == Some(range), label)
            .accessible_name(format!(
                "Flat stretch {rank}, pings {}, {} deep",
                pings(&spot.pings),
                units.measure(spot.depth_m, 2)
            ));
        let row = row.on_hover_text(format!(
            "{}\nClick to calibrate on it and show it in all views.",
            units.sentence(&spot.summary())
        ));
        if row.clicked() {
            context.push(Command::CalibrateAt(range));
            let middle = (spot.pings.start + spot.pings.end) / 2;
            context.push(Command::Reveal(crate::app::Mark::ping(middle)));
        }
    });
}

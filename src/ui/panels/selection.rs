//! Shows the selected ping with all its facts, which can be copied.

use super::parts::{fact, remark};
use super::section::{Section, section};
use crate::app::{Command, LogPlace};
use crate::ui::{ViewContext, place, text, theme};
use bathyscope_bottom::cloud::{PointClass, PointSource};
use bathyscope_log::survey::{Side, arm_in_words};
use egui::{RichText, Ui};

/// Draws the section.
pub(crate) fn ui(ui: &mut Ui, context: &mut ViewContext<'_>) {
    section(ui, context, Section::new("Selection"), |ui, context| {
        match context.app.view.selection {
            Some(mark) => selected(ui, context, mark),
            None => remark(
                ui,
                "Nothing is selected: click the waterfall, the map, the cloud or the time line.",
            ),
        }
    });
}

fn selected(ui: &mut Ui, context: &mut ViewContext<'_>, mark: LogPlace) {
    let units = context.units();
    let Some(survey) = context.app.logs.shown.survey.clone() else {
        return;
    };
    let Some(ping) = survey.side_scan.get(mark.ping) else {
        return;
    };
    ui.horizontal(|ui| {
        let title = RichText::new(format!("Ping {}", mark.ping));
        ui.label(title.heading().strong());
        ui.label(text::clock(survey.start_unix_s, ping.time_s));
    });
    if let Some(at) = place::lon_lat(context.app, mark) {
        ui.label(RichText::new(place::written(context.app, at)).monospace());
    }
    let hint = "Corrected depth under the boat: the sounding, or the first return where the recorder lost the bottom.";
    fact(ui, "Depth", hint, place::depth(context.app, mark.ping));
    if let Some(range) = place::range_m(context.app, mark) {
        let side = mark.side.map_or("", Side::name);
        let hint = "Calibrated slant range of the selected place.";
        let value = format!("{} {side}", units.measure(range, 2));
        fact(ui, "Range here", hint, value);
    }
    if let Some(stretch) = context.app.logs.excluded_at(context.app.logs.shown.id, mark.ping) {
        let hint = "Why the ping is excluded: no point, depth, echo or box comes from it.";
        fact(ui, "Excluded", hint, stretch.reason.name());
    }
    for side in Side::BOTH {
        first_return(ui, context, mark.ping, side);
    }
    heading(ui, context, mark.ping);
    mounting(ui, context, mark.ping);
    point(ui, context, mark);
    ui.add_space(2.0);
    let show = ui.button("Show in all views");
    if show.on_hover_text("Brings this place into the waterfall, the map and the cloud.").clicked()
    {
        context.push(Command::Reveal(mark));
    }
}

fn first_return(ui: &mut Ui, context: &ViewContext<'_>, ping: usize, side: Side) {
    let returns = context.app.logs.shown.returns();
    let pick = returns.and_then(|returns| returns.side(side).get(ping).copied());
    let pick = pick.filter(|pick| pick.is_some());
    let value = match pick {
        None => "no return".to_owned(),
        Some(pick) => {
            let mark =
                LogPlace { side: Some(side), sample: Some(pick.sample), ..LogPlace::ping(ping) };
            let range = place::range_m(context.app, mark).unwrap_or(f64::NAN);
            let above_bottom = if pick.above_bottom { " · above bottom" } else { "" };
            let range = context.units().measure(range, 2);
            let confidence = pick.confidence;
            format!("{range} · conf. {confidence:.2}{above_bottom}")
        }
    };
    let name = match side {
        Side::Port => "Port",
        Side::Starboard => "Starboard",
    };
    let colour = theme::side_colour(context.options(), side);
    let hint = "First return on this side: calibrated slant range and confidence from 0 to 1.";
    fact(ui, name, hint, RichText::new(value).color(colour));
}

fn heading(ui: &mut Ui, context: &ViewContext<'_>, ping: usize) {
    let Some(products) = &context.app.logs.shown.products else {
        return;
    };
    let Some(here) = products.navigation.pings.get(ping) else {
        return;
    };
    let value = place::heading(context.app, ping);
    let hint = "Clockwise from north, and where it comes from.";
    fact(ui, "Heading", hint, value);
    let hint = "Over ground.";
    fact(ui, "Speed", hint, context.units().speed(here.speed_mps, 1));
}

/// Draws the position of the transducer relative to the antenna at the ping, and a mark of
/// exchanged sides, if these differ from the recording.
fn mounting(ui: &mut Ui, context: &ViewContext<'_>, ping: usize) {
    let Some(products) = &context.app.logs.shown.products else {
        return;
    };
    let mounting = &products.settings.mounting;
    let is_apart = products.navigation.antenna.get(ping).is_some();
    if let Some(arm_m) = mounting.lever_arm_m().filter(|_| is_apart) {
        let units = context.units();
        let arm = arm_in_words(arm_m, |metres| units.measure(metres, 2));
        let hint = "Position of the transducer, which positions refer to.";
        fact(ui, "Transducer", hint, format!("{arm} of the antenna"));
    }
    if mounting.swap_sides {
        let hint = "Port and starboard of the recorder are exchanged (Mounting).";
        fact(ui, "Sides", hint, "exchanged");
    }
}

fn point(ui: &mut Ui, context: &ViewContext<'_>, mark: LogPlace) {
    let Some(products) = &context.app.logs.shown.products else {
        return;
    };
    let Some(index) = mark.point else {
        return;
    };
    let Some(point) = products.cloud.points.get(index) else {
        return;
    };
    let source = match point.source {
        PointSource::DownScan => "down-scan",
        PointSource::Port => "port",
        PointSource::Starboard => "starboard",
        PointSource::Swath => "swath (StructureScan 3D)",
    };
    let level = if point.source.is_side_scan() {
        format!(" · level {}", point.level)
    } else {
        String::new()
    };
    let class = products.classes.get(index).filter(|class| !class.is_kept());
    let class = class.map_or(String::new(), |class| format!(" · {}", PointClass::name(*class)));
    let hint = "The selected point of the cloud: its source, depth and echo level (0 to 255).";
    let depth = context.units().measure(-point.z_m, 2);
    let value = format!("{source} · {depth} deep{level}{class}");
    fact(ui, "Point", hint, value);
}

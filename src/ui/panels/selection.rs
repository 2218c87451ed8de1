//! What is selected: one ping with everything known about it, to read and to copy.

use super::parts::{fact, remark};
use super::section::{Section, section};
use crate::app::{Command, Mark};
use crate::cloud::{PointClass, PointSource};
use crate::survey::{Side, Survey, arm_in_words, nearest_in_time};
use crate::ui::{ViewContext, place, text, theme};
use egui::{RichText, Ui};

/// Draws the section.
pub fn ui(ui: &mut Ui, context: &mut ViewContext<'_>) {
    let heading = Section {
        number: None,
        title: "Selection",
        stage: None,
    };
    section(ui, context, &heading, |ui, context| {
        match context.app.selection {
            Some(mark) => selected(ui, context, mark),
            None => remark(
                ui,
                "Nothing is selected: click the waterfall, the map, the cloud or the time line.",
            ),
        }
    });
}

fn selected(ui: &mut Ui, context: &mut ViewContext<'_>, mark: Mark) {
    let units = context.app.options.units;
    let Some(survey) = context.app.log.survey.clone() else {
        return;
    };
    let Some(ping) = survey.side_scan.get(mark.ping) else {
        return;
    };
    ui.horizontal(|ui| {
        ui.label(
            RichText::new(format!("Ping {}", mark.ping))
                .heading()
                .strong(),
        );
        ui.label(text::clock(survey.start_unix_s, ping.time_s));
    });
    if let Some(at) = place::lon_lat(context.app, mark) {
        ui.label(RichText::new(place::written(context.app, at)).monospace());
    }
    fact(
        ui,
        "Depth",
        "By the recorder's own bottom lock at the time of this ping, with the depth correction, as on the map.",
        format!(
            "{}{}",
            units.measure(place::depth_m(context.app, ping), 2),
            if had_bottom(&survey, ping.time_s) {
                ""
            } else {
                ", bottom lost"
            }
        ),
    );
    fact(
        ui,
        "Below",
        "What depths count from: the transducer, the water's surface where a draft is given, or the zero of the water level.",
        place::reduction(context.app).reference().noun(),
    );
    if let Some(range) = place::range_m(context.app, mark) {
        let side = mark.side.map_or("", Side::name);
        fact(
            ui,
            "Range here",
            "Slant range of the selected place by the calibration and the speed of sound in force.",
            format!("{} {side}", units.measure(range, 2)),
        );
    }
    if let Some(stretch) = context.app.left_out_at(context.app.log.id, mark.ping) {
        let hint = "Why the ping counts for nothing: no point, depth, echo or box comes from it.";
        fact(ui, "Left out", hint, stretch.reason.name());
    }
    for side in Side::BOTH {
        first_return(ui, context, mark.ping, side);
    }
    heading(ui, context, mark.ping);
    mounting(ui, context, mark.ping);
    point(ui, context, mark);
    ui.add_space(2.0);
    let show = ui.button("Show in all views");
    if show
        .on_hover_text("Brings this place into the waterfall, the map and the cloud.")
        .clicked()
    {
        context.push(Command::Reveal(mark));
    }
}

/// Whether the recorder had the bottom at its sounding nearest in time.
fn had_bottom(survey: &Survey, time_s: f64) -> bool {
    nearest_in_time(&survey.soundings, time_s, |sounding| sounding.time_s)
        .is_none_or(|nearest| survey.soundings[nearest].locked)
}

fn first_return(ui: &mut Ui, context: &ViewContext<'_>, ping: usize, side: Side) {
    let pick = context
        .app
        .returns()
        .and_then(|returns| returns.side(side).get(ping).copied())
        .filter(|pick| pick.is_some());
    let value = match pick {
        None => "no return".to_owned(),
        Some(pick) => {
            let mark = Mark {
                side: Some(side),
                sample: Some(pick.sample),
                ..Mark::ping(ping)
            };
            let range = place::range_m(context.app, mark).unwrap_or(f64::NAN);
            let above_bottom = if pick.above_bottom {
                " · above bottom"
            } else {
                ""
            };
            format!(
                "{} · conf. {:.2}{above_bottom}",
                context.app.options.units.measure(range, 2),
                pick.confidence
            )
        }
    };
    let (name, colour) = match side {
        Side::Port => ("Port", theme::side_colour(&context.app.options, side)),
        Side::Starboard => ("Starboard", theme::side_colour(&context.app.options, side)),
    };
    fact(
        ui,
        name,
        "First return on this side: calibrated slant range and confidence from 0 to 1.",
        RichText::new(value).color(colour),
    );
}

fn heading(ui: &mut Ui, context: &ViewContext<'_>, ping: usize) {
    let Some(products) = &context.app.log.products else {
        return;
    };
    let Some(here) = products.navigation.pings.get(ping) else {
        return;
    };
    let value = place::heading(context.app, ping);
    fact(
        ui,
        "Heading",
        "Clockwise from north, and where it comes from.",
        value,
    );
    fact(
        ui,
        "Speed",
        "Over ground.",
        context.app.options.units.speed(here.speed_mps, 1),
    );
}

/// How antenna and transducer lie to each other at the ping, and which sides these are, where that is not as recorded.
fn mounting(ui: &mut Ui, context: &ViewContext<'_>, ping: usize) {
    let Some(products) = &context.app.log.products else {
        return;
    };
    let mounting = &products.settings.mounting;
    let is_apart = products.navigation.antenna.get(ping).is_some();
    if let Some(arm_m) = mounting.lever_arm_m().filter(|_| is_apart) {
        let units = context.app.options.units;
        let arm = arm_in_words(arm_m, |metres| units.measure(metres, 2));
        let hint = "Where the transducer is, which positions are those of.";
        fact(ui, "Transducer", hint, format!("{arm} of the antenna"));
    }
    if mounting.swap_sides {
        let hint = "Port is what the recorder has as starboard (Mounting).";
        fact(ui, "Sides", hint, "exchanged");
    }
}

fn point(ui: &mut Ui, context: &ViewContext<'_>, mark: Mark) {
    let Some(products) = &context.app.log.products else {
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
    };
    let level = match point.source {
        PointSource::DownScan => String::new(),
        PointSource::Port | PointSource::Starboard => format!(" · level {}", point.level),
    };
    let class = products.classes.get(index).filter(|class| !class.is_kept());
    let class = class.map_or(String::new(), |class| {
        format!(" · {}", PointClass::name(*class))
    });
    fact(
        ui,
        "Point",
        "What measured the selected point of the cloud, its depth, and the level of its echo from 0 to 255.",
        format!(
            "{source} · {} deep{level}{class}",
            context.app.options.units.measure(-point.z_m, 2),
        ),
    );
}

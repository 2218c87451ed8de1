//! Draws the line that says what depths count from, what corrects them, and how large their error
//! is. Each part is a link to its control; what is not given, or does not agree, is amber.

use crate::app::{App, Command};
use crate::ui::{ViewContext, theme};
use bathyscope_bottom::calibration::{Calibration, CalibrationSettings, OffsetMode, ScaleMode};
use bathyscope_bottom::cloud::Correction;
use bathyscope_bottom::presentation::units::Units;
use bathyscope_products::pipeline::Settings;
use bathyscope_products::pipeline::settings::{SettingRow, rows};
use egui::{Align, Button, Layout, RichText, TextStyle, Ui};

/// Height of the line, points.
pub(crate) const HEIGHT: f32 = 19.0;
/// Text between two parts.
const BETWEEN: &str = "·";

/// Place in the panel of steps that a part leads to.
#[derive(Clone, Copy, Debug)]
enum Link {
    Setting(&'static SettingRow),
    Section(&'static str),
}

/// Part of the line: one fact about the depths.
#[derive(Clone, Debug)]
struct DepthFact {
    text: String,
    /// True if a value is missing, or values do not agree.
    is_open: bool,
    /// Text of the tooltip.
    hint: String,
    link: Link,
}

impl DepthFact {
    fn new(text: impl Into<String>, hint: impl Into<String>, link: Link) -> Self {
        Self { text: text.into(), is_open: false, hint: hint.into(), link }
    }

    fn open_if(self, is_open: bool) -> Self {
        Self { is_open, ..self }
    }
}

/// Draws the line; it is empty before there are depths.
pub(crate) fn ui(ui: &mut Ui, context: &mut ViewContext<'_>) {
    let font = TextStyle::Small.resolve(ui.style());
    let width = |text: &str| {
        let colour = ui.visuals().text_color();
        ui.painter().layout_no_wrap(text.to_owned(), font.clone(), colour).size().x
    };
    let between = width(BETWEEN) + 10.0;
    let shown = fitting(facts(context.app), ui.available_width(), |text| width(text) + between);
    let (plain, open) = (ui.visuals().text_color(), theme::stale_colour(context.theme()));
    ui.with_layout(Layout::left_to_right(Align::Center), |ui| {
        ui.spacing_mut().item_spacing.x = 5.0;
        ui.spacing_mut().button_padding.x = 0.0;
        for (index, fact) in shown.into_iter().enumerate() {
            if index > 0 {
                ui.label(RichText::new(BETWEEN).small().weak());
            }
            let text = RichText::new(fact.text).small();
            let text = text.color(if fact.is_open { open } else { plain });
            let button = ui.add(Button::new(text).frame(false).small());
            let button = button.on_hover_cursor(egui::CursorIcon::PointingHand);
            if button.on_hover_text(fact.hint).clicked() {
                follow(context, fact.link);
            }
        }
    });
}

/// Shows the place that a part leads to, and moves the keyboard there.
fn follow(context: &mut ViewContext<'_>, link: Link) {
    match link {
        Link::Setting(row) => context.push(Command::ShowSetting(row.key)),
        Link::Section(title) => context.push(Command::ShowSection(title)),
    }
}

/// Returns the facts that fit into `room` in their order; the last ones that are not open are left
/// out first. `width` returns the width of a text with what separates it from the next.
fn fitting(mut facts: Vec<DepthFact>, room: f32, width: impl Fn(&str) -> f32) -> Vec<DepthFact> {
    while facts.iter().map(|fact| width(&fact.text)).sum::<f32>() > room {
        let least = facts.iter().rposition(|fact| !fact.is_open);
        facts.remove(least.unwrap_or(facts.len() - 1));
    }
    facts
}

/// Returns the facts about the depths of the shown log and of the map.
fn facts(app: &App) -> Vec<DepthFact> {
    let log = &app.logs.shown;
    let Some(products) = &log.products else {
        return Vec::new();
    };
    let (units, correction) = (app.view.options.units, &*products.correction);
    let reference = format!("Depths {}", correction.reference().name());
    let hint = "The level that depths count from: the transducer, the water's surface with a draft, or a fixed level with a water level.";
    let mut facts = vec![
        DepthFact::new(reference, hint, Link::Section("Depth correction")),
        draft(correction, &log.settings, units),
        water_level(correction, &log.settings, units),
        sound_speed(&log.settings, units),
        ranges(&products.calibration, &log.settings.calibration, units),
    ];
    if let Some(sentence) = app.unlevelled() {
        let hint = units.sentence(&sentence);
        facts.push(
            DepthFact::new("logs differ in height", hint, Link::Section("Logs")).open_if(true),
        );
    }
    facts.extend(error(app, units));
    facts
}

fn draft(correction: &Correction, settings: &Settings, units: Units) -> DepthFact {
    let is_given = correction.knows_draft();
    let text = if is_given {
        format!("draft {}", units.measure(settings.draft_m, 2))
    } else {
        "draft not given".to_owned()
    };
    let hint = "Depth of the transducer below the water's surface; it is added to all depths.";
    DepthFact::new(text, hint, Link::Setting(&rows::DRAFT)).open_if(!is_given)
}

fn water_level(correction: &Correction, settings: &Settings, units: Units) -> DepthFact {
    let is_given = correction.knows_level();
    let text = match (is_given, correction.gauge().is_some()) {
        (false, _) => "water level not given".to_owned(),
        (true, true) => "water level by readings".to_owned(),
        (true, false) => format!("water level {}", units.signed(settings.water_level_m, 2)),
    };
    let hint = "Height of the water above the level that depths are to count from; it is taken off all depths.";
    DepthFact::new(text, hint, Link::Setting(&rows::WATER_LEVEL)).open_if(!is_given)
}

fn sound_speed(settings: &Settings, units: Units) -> DepthFact {
    let (unit_m_s, symbol) = units.sound_speed();
    let speed = &settings.sound_speed;
    let in_words = |m_s: f64| format!("sound speed {:.0} {symbol}", m_s / unit_m_s);
    let (text, is_given) = match speed.water_m_s() {
        Some(water_m_s) => (in_words(water_m_s), true),
        None => (format!("{} assumed", in_words(speed.recorder_m_s)), false),
    };
    let hint = "Speed of sound in the water. Where none is given, ranges and depths are the recorder's, which assumes one.";
    DepthFact::new(text, hint, Link::Section("Depth correction")).open_if(!is_given)
}

fn ranges(calibration: &Calibration, settings: &CalibrationSettings, units: Units) -> DepthFact {
    let is_fitted = settings.mode != ScaleMode::FlatSpot && settings.offset != OffsetMode::None;
    let text = match calibration.range_change() {
        None => "ranges as recorded".to_owned(),
        Some(change) if is_fitted => format!("{} automatic", units.sentence(&change)),
        Some(change) => units.sentence(&change),
    };
    let hint = "Scale and offset of the slant ranges.";
    DepthFact::new(text, hint, Link::Setting(&rows::SCALE))
}

/// Returns the error of the map; `None` where it is not known.
fn error(app: &App, units: Units) -> Option<DepthFact> {
    let [half_m, most_m] = app.depth_map().flatten()?.usual_error_m?;
    let [half, most] = [half_m, most_m].map(|error_m| units.measure(error_m, 2));
    let hint = format!(
        "Standard deviation of the depths of the map, from withheld soundings: the median. 90 % of the map do not exceed {most}."
    );
    Some(DepthFact::new(format!("error ±{half}"), hint, Link::Section("Depth map")))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_known_gives_way_to_what_is_missing() {
        let fact = |text: &str| DepthFact::new(text, "", Link::Section("Depth map"));
        let facts = [fact("depths"), fact("draft").open_if(true), fact("ranges"), fact("error")];
        let shown = |room: f32| {
            let facts = fitting(facts.to_vec(), room, |text| text.len() as f32);
            facts.iter().map(|fact| fact.text.clone()).collect::<Vec<_>>().join(" ")
        };
        assert_eq!(shown(22.0), "depths draft ranges error");
        assert_eq!(shown(21.0), "depths draft ranges");
        assert_eq!(shown(11.0), "depths draft");
        assert_eq!(shown(10.0), "draft");
        assert_eq!(shown(4.0), "");
    }
}

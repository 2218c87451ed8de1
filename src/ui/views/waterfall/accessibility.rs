//! Describes the waterfall for screen readers and tests, also while it shows no picture.

use super::overlay;
use crate::ui::views::empty;
use crate::ui::{ViewContext, stretch_text};
use bathyscope_bottom::first_return::BottomLine;
use bathyscope_log::survey::Survey;
use egui::{Rect, Response, Role, Ui, WidgetInfo};
use std::ops::Range;

/// Fills a view that has no picture, or not yet: shows the reason, and offers to open a log if none
/// is open.
pub(super) fn without_picture(
    ui: &mut Ui,
    context: &mut ViewContext<'_>,
    rect: Rect,
    response: &Response,
    is_reading: bool,
) {
    let survey = context.app.logs.shown.survey.clone();
    let said = match survey {
        None => {
            empty::first_steps(ui, context, rect);
            "open a survey to see its side-scan here".to_owned()
        }
        Some(_) if is_reading => {
            empty::say(ui, context, rect, "The side-scan is being read.");
            "reading the survey".to_owned()
        }
        Some(survey) => {
            let text = overlay::warning(&survey, context.units())
                .unwrap_or_else(|| "no side-scan: no ping has a usable range".to_owned());
            overlay::banner(&ui.painter_at(rect), rect, &text);
            text
        }
    };
    response.widget_info(|| {
        WidgetInfo::labeled(Role::Image, true, format!("Waterfall, empty: {said}"))
    });
}

/// Describes the picture for screen readers; the value of the view is the read-out under the
/// pointer.
pub(super) fn describe(
    response: &Response,
    visible: &Range<usize>,
    survey: &Survey,
    context: &ViewContext<'_>,
    boxes: &str,
    read_out: Option<&str>,
) {
    response.widget_info(|| WidgetInfo {
        current_text_value: read_out.map(str::to_owned),
        ..WidgetInfo::labeled(Role::Image, true, name(visible, survey, context) + boxes)
    });
}

fn name(visible: &Range<usize>, survey: &Survey, context: &ViewContext<'_>) -> String {
    let options = &context.options().waterfall;
    let source = context.app.logs.shown.settings.first_return.bottom_line;
    let first_return = match (context.app.logs.shown.bottom_line(), options.first_return, source) {
        (_, false, _) => "first return hidden",
        (None, true, _) => "first return not yet found",
        (Some(_), true, BottomLine::Search) => "first return shown",
        (Some(_), true, BottomLine::Recorded) => "bottom line at the recorded depth shown",
    };
    let units = context.units();
    let warning =
        overlay::warning(survey, units).map_or_else(String::new, |text| format!(", {text}"));
    let excluded = stretch_text::and_stretches(context.app);
    let products = context.app.logs.shown.products.as_ref();
    let ranges = products
        .and_then(|products| products.calibration.range_change())
        .map_or_else(String::new, |change| format!(", {}", units.sentence(&change)));
    format!(
        "Waterfall, pings {} to {} of {}, {first_return}{ranges}{excluded}{warning}",
        visible.start,
        visible.end.saturating_sub(1),
        survey.side_scan.len()
    )
}

//! Collects the values of the page and fills its templates.

use super::depth_plan::depth_plan;
use super::mosaic_plan::mosaic_plan;
use super::strip::strip;
use super::{ReportData, chart, logs, objects, summary, tables, targets};
use bathyscope_bottom::presentation::page::{Template, TemplateFault, Value, context, fill};
use bathyscope_log::support::progress::{Cancelled, Progress};

/// Makes a template of a file in the folder `templates`.
macro_rules! template {
    ($name:literal) => {
        ($name, include_str!(concat!("templates/", $name)))
    };
}

/// The page and what it includes.
const TEMPLATES: [Template<'static>; 13] = [
    template!("report.html"),
    template!("report.css"),
    template!("summary.html"),
    template!("logs.html"),
    template!("map.html"),
    template!("strips.html"),
    template!("strip.html"),
    template!("objects.html"),
    template!("targets.html"),
    template!("picture.html"),
    template!("trust.html"),
    template!("method.html"),
    template!("files.html"),
];

/// Largest number of logs that are drawn one by one: with more, the page would be too large to
/// send.
const MOST_STRIPS: usize = 12;

/// Returns the self-contained document: it loads no script, font or picture from elsewhere.
///
/// # Errors
/// When a template names a value that [`values`] does not give.
pub(crate) fn document(values: Value) -> Result<String, TemplateFault> {
    fill(&TEMPLATES, values)
}

/// Returns the values of the templates.
pub(crate) fn values(from: &ReportData<'_>, progress: &Progress) -> Result<Value, Cancelled> {
    let sections = context! {
        ..summary::values(from),
        ..tables::trust(from),
        ..tables::method(from),
        ..tables::files(from),
    };
    Ok(context! {
        title => &from.title,
        warnings => &from.report.warnings,
        logs => logs::values(from),
        depth_plan => depth_plan(from, progress)?,
        storage => chart::values(from),
        mosaic_plan => mosaic_plan(from, progress)?,
        strips => strips(from, progress)?,
        strips_left_out => from.logs.len().saturating_sub(MOST_STRIPS),
        objects => objects::values(from, progress)?,
        targets => targets::values(from, progress)?,
        ..sections
    })
}

/// Draws the pictures of the logs.
fn strips(from: &ReportData<'_>, progress: &Progress) -> Result<Vec<Value>, Cancelled> {
    let mut strips = Vec::new();
    for (log, name) in from.logs.iter().zip(from.names).take(MOST_STRIPS) {
        strips.extend(strip(log, name, progress)?);
    }
    Ok(strips)
}

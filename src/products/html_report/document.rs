//! Assembles the HTML document.

use super::depth_plan::depth_plan;
use super::mosaic_plan::mosaic_plan;
use super::strip::strip;
use super::{ReportData, chart, logs, objects, summary, tables, targets};
use bathyscope_log::support::printable::xml;
use bathyscope_log::support::progress::{Cancelled, Progress};

const STYLE: &str = "body{font:15px/1.45 system-ui,sans-serif;color:#1b1b1b;margin:0 auto;padding:28px;max-width:1100px}\
h1{font-size:26px;margin:0 0 6px}h3{font-size:15px;margin:18px 0 4px}h2{font-size:19px;margin:36px 0 8px;border-bottom:1px solid #cccccc;padding-bottom:4px}\
.lead{font-size:16px;max-width:860px}.figures{display:flex;flex-wrap:wrap;gap:10px;margin:18px 0}\
.figures div{background:#eef3f7;border-left:4px solid #0b5394;padding:8px 14px;min-width:120px}\
.figures b{display:block;font-size:18px}.figures span{font-size:12.5px;color:#444444}\
aside{background:#fff6e0;border-left:4px solid #d98e00;padding:8px 14px;margin:14px 0}aside ul{margin:4px 0;padding-left:20px}\
figure{margin:10px 0}figcaption{font-size:13px;color:#444444;max-width:900px}svg,img{max-width:100%;height:auto}\
table{border-collapse:collapse;font-size:13px;margin:8px 0}td,th{border:1px solid #d0d0d0;padding:3px 8px;text-align:right;font-weight:normal}\
th{background:#f1f1f1}td.text,th.text{text-align:left}pre{font-size:12.5px;background:#f4f4f4;padding:10px;overflow-x:auto}\
section.target>div{display:flex;flex-wrap:wrap;gap:18px;align-items:flex-start}section.target figure{margin:4px 0}\
section.target dl{display:grid;grid-template-columns:max-content 1fr;gap:2px 12px;font-size:13px;margin:4px 0;flex:1 1 420px}dt{color:#444444}dd{margin:0}\
code{font-size:11.5px;word-break:break-all}.made{color:#666666;font-size:13px}\
@media print{body{padding:0;max-width:none}figure,table tr,section.target{break-inside:avoid}h2{break-after:avoid}}";

/// Returns the self-contained document: it loads no script, font or picture from elsewhere.
pub(crate) fn document(from: &ReportData<'_>, progress: &Progress) -> Result<String, Cancelled> {
    let mut html = format!(
        "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><meta name=\"viewport\" content=\"width=device-width\"><title>Survey {}</title><style>{STYLE}</style></head><body>\n",
        xml(&from.title)
    );
    html += &summary::summary(from);
    html += &logs::section(from);
    html += &tables::warnings(from);
    html += &figure("Depths", depth_plan(from, progress)?, &depth_caption(from));
    html += &chart::storage_section(from);
    html += &figure(
        "Side-scan mosaic",
        mosaic_plan(from, progress)?,
        "Echoes at their place on the ground, gain-normalised; shadows stay dark. The lines are the way of the boat. \
         The ground to the side of the boat is taken as level.",
    );
    html += &strips(from, progress)?;
    html += &objects::section(from, progress)?;
    html += &targets::section(from, progress)?;
    html += &tables::trust(from);
    html += &tables::method(from);
    html += &tables::files(from);
    Ok(html + "</body></html>\n")
}

/// Largest number of logs that are drawn one by one: with more, the page would be too large to
/// send.
const MOST_STRIPS: usize = 12;

/// Returns the section with a picture of each log.
fn strips(from: &ReportData<'_>, progress: &Progress) -> Result<String, Cancelled> {
    const CAPTION: &str = "All pings from left to right, port above and starboard below, by slant range. The line is the first sonar return, \
         from which the side-scan depths follow.";
    if let [log] = from.logs {
        return Ok(figure("The log at a glance", strip(log, progress)?, CAPTION));
    }
    let mut figures = String::new();
    for (log, name) in from.logs.iter().zip(from.names).take(MOST_STRIPS) {
        if let Some(drawn) = strip(log, progress)? {
            figures += &format!("<h3>{}</h3>\n<figure>{drawn}</figure>\n", xml(name));
        }
    }
    if figures.is_empty() {
        return Ok(figures);
    }
    let rest = match from.logs.len().saturating_sub(MOST_STRIPS) {
        0 => String::new(),
        rest => format!(" The last {rest} logs are not drawn."),
    };
    Ok(format!("<h2>The logs at a glance</h2>\n<p>{CAPTION}{rest}</p>\n{figures}"))
}

fn figure(title: &str, drawn: Option<String>, caption: &str) -> String {
    drawn.map_or_else(String::new, |drawn| {
        format!("<h2>{title}</h2>\n<figure>{drawn}<figcaption>{caption}</figcaption></figure>\n")
    })
}

fn depth_caption(from: &ReportData<'_>) -> String {
    let Some(depth_map) = from.depth_map else {
        return String::new();
    };
    let settings = &from.products.settings;
    format!(
        "Cells of {:.2} m by {}, {}, graticule in WGS84. {} No cell is farther than {} m from a depth, none outside \
         their hull. The relief is lit from the north-west, {} times as high as it is. {}",
        depth_map.surface.grid.cell_m,
        depth_map.surface.method_in_words(),
        xml(&from.map.crs.to_string()),
        depth_map.surface.between_lines().unwrap_or_default(),
        settings.surface.max_gap_m,
        depth_map.light.exaggeration,
        xml(&logs::correction(from))
    )
}

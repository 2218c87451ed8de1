//! Makes the sections and tables on the trust in the depths, the method, the input files and the
//! written files.

use super::ReportData;
use crate::pipeline::{CalibrationReport, CommonUncertainty, Preset, Settings};
use bathyscope_bottom::calibration::ScaleMode;
use bathyscope_bottom::presentation::text::{bytes, typeset_count as count, typeset_signed};
use bathyscope_log::support::printable::xml;

/// Returns the warnings in a box; empty without warnings.
pub(super) fn warnings(from: &ReportData<'_>) -> String {
    let items: String =
        from.report.warnings.iter().map(|warning| format!("<li>{}</li>", xml(warning))).collect();
    if items.is_empty() {
        String::new()
    } else {
        format!("<aside><b>Warnings</b><ul>{items}</ul></aside>\n")
    }
}

/// Returns the section on the agreement of the depths and its limits.
pub(super) fn trust(from: &ReportData<'_>) -> String {
    let mut html = String::from("<h2>How far to trust it</h2>\n");
    html += &agreement(from);
    html += &latencies(from);
    html += &common(&from.report.uncertainty);
    html + &format!("<p>{}</p>\n", xml(&from.report.statement))
}

fn agreement(from: &ReportData<'_>) -> String {
    if from.comparisons.is_empty() {
        return "<p>There is nothing that these depths could be compared with.</p>\n".to_owned();
    }
    let mut html = String::from(
        "<p>Measured minus reference elevation, metres: positive is shallower than the reference. The last columns give the share of points within the vertical limit of each order of IHO S-44 (edition 6), of which an order asks for 95 %; agreement within one instrument is no proof of that order.</p>\n<table><tr><th class=\"text\">measured</th><th class=\"text\">reference</th><th class=\"text\">matched by</th><th>n</th><th>mean</th><th>median</th><th>st. dev.</th><th>RMS</th><th>95 %</th>",
    );
    let orders = from.comparisons.iter().map(|one| &one.comparison.orders);
    let names: Vec<&str> = orders
        .max_by_key(|orders| orders.len())
        .map(|orders| orders.iter().map(|share| share.order.order).collect())
        .unwrap_or_default();
    for name in &names {
        html += &format!("<th>{name}</th>");
    }
    html += "</tr>\n";
    for one in from.comparisons {
        let Some(residuals) = &one.comparison.residuals else {
            continue;
        };
        html += &format!(
            "<tr><td class=\"text\">{}</td><td class=\"text\">{}</td><td class=\"text\">{}</td><td>{}</td><td>{:+.3}</td><td>{:+.3}</td><td>{:.3}</td><td>{:.3}</td><td>{:.3}</td>",
            one.source,
            xml(&one.reference),
            xml(&one.matching),
            count(residuals.n),
            residuals.mean_m,
            residuals.median_m,
            residuals.sd_m,
            residuals.rms_m,
            residuals.p95_m,
        );
        for share in &one.comparison.orders {
            html += &format!("<td>{:.0} %</td>", 100.0 * share.share);
        }
        html += "</tr>\n";
    }
    html + "</table>\n"
}

/// Lists the uncertainties that all depths share: the parts that are not zero.
fn common(of: &CommonUncertainty) -> String {
    let metres =
        |sigma_m: f64, what: &str| (sigma_m > 0.0).then(|| format!("{what} {sigma_m:.3} m"));
    let share = of.sound_speed_share;
    let parts = [
        metres(of.range_offset_m, "side-scan against soundings"),
        (share > 0.0).then(|| format!("sound speed {:.1} % of the depth", 100.0 * share)),
        metres(of.draft_m, "draft"),
        metres(of.water_level_m, "water level"),
        metres(of.crossings.level_m, "crossings"),
        metres(of.crossings.per_slope_m, "crossings, times the slope of the bottom,"),
        metres(of.position_m, "positions, times the slope of the bottom,"),
    ];
    let parts: Vec<String> = parts.into_iter().flatten().collect();
    format!(
        "<p>The stated error of the map holds, besides what depths that were left out show, what all depths have in common (one standard deviation each; squares are added, as in the total vertical uncertainty of IHO S-44): {}. What is not corrected, below, is not in it.</p>\n",
        parts.join("; ")
    )
}

/// Reports the latency of positions for each log whose crossings determine it.
fn latencies(from: &ReportData<'_>) -> String {
    let mut html = String::new();
    for (name, latency) in from.names.iter().zip(from.latencies) {
        let Some(latency) = latency else { continue };
        let advice = if latency.contradicts() {
            format!("; set <code>mounting.latency_s</code> to {:.2}", latency.latency_s)
        } else {
            String::new()
        };
        html += &format!(
            "<p>{}: crossings over slopes show positions to be later than echoes by {}; in force is {} s{advice}.</p>\n",
            xml(name),
            latency.in_words(),
            latency.in_force_s,
        );
    }
    html
}

/// Returns the section with scale, method and settings.
pub(super) fn method(from: &ReportData<'_>) -> String {
    let mut html = String::from("<h2>How it was made</h2>\n");
    match &from.report.logs {
        None => html += &format!("<p>{}</p>\n", scale(&from.report.calibration)),
        Some(all) => {
            for log in &all.logs {
                let (name, scale) = (xml(&log.log), scale(&log.calibration));
                html += &format!("<p>{name}: {scale}</p>\n");
            }
        }
    }
    html += &corrections(from);
    html += &own_settings(from);
    let changed = changes(&from.products.settings);
    html += &if changed.is_empty() {
        "<p>All settings are those of the recommended preset.</p>\n".to_owned()
    } else {
        format!(
            "<p>Settings that differ from the recommended ones:</p>\n<pre>{}</pre>\n",
            xml(&changed.join("\n"))
        )
    };
    let all = toml::to_string(&from.products.settings).unwrap_or_default();
    html + &format!(
        "<details><summary>All settings</summary><pre>{}</pre></details>\n",
        xml(all.trim_end())
    )
}

/// Lists the results of the requested corrections of positions and heights; empty where none was
/// requested.
fn corrections(from: &ReportData<'_>) -> String {
    let corrections = from.report.corrections.iter();
    let items: String =
        corrections.map(|one| format!("<li>{}</li>\n", xml(&one.to_string()))).collect();
    if items.is_empty() {
        items
    } else {
        format!("<p>Corrections that were asked for:</p>\n<ul>\n{items}</ul>\n")
    }
}

/// Lists the settings of logs that differ from those of the first log; empty where none differs.
fn own_settings(from: &ReportData<'_>) -> String {
    let logs = from.report.logs.iter().flat_map(|all| &all.logs);
    let mut lines = String::new();
    for log in logs {
        for (key, value) in &log.own_settings {
            let value = value.as_ref().map_or("none".to_owned(), toml::Value::to_string);
            lines += &format!("{}: {key} = {value}\n", log.log);
        }
    }
    if lines.is_empty() {
        lines
    } else {
        format!(
            "<p>Settings of a log that differ from those of the first log:</p>\n<pre>{}</pre>\n",
            xml(lines.trim_end())
        )
    }
}

fn scale(scale: &CalibrationReport) -> String {
    let flat_spot = match (scale.ppd_px_per_m, scale.ppd_spread_px_per_m) {
        (Some(ppd), Some(spread)) => Some(format!(
            "{ppd:.2} \u{b1} {spread:.2} samples a metre over {} first returns{}",
            count(scale.ppd_picks),
            (scale.pings).map_or(String::new(), |pings| format!(
                " of pings {} to {}",
                pings.start, pings.end
            ))
        )),
        _ => None,
    };
    let header = scale.header_px_per_m.map(|header| format!("{header:.2} samples a metre"));
    let text = match (scale.mode, flat_spot, header) {
        (ScaleMode::FlatSpot, Some(flat_spot), Some(header)) => {
            format!("at a flat stretch of the bottom: {flat_spot}. The log itself states {header}")
        }
        (ScaleMode::FlatSpot, Some(flat_spot), None) => {
            format!("at a flat stretch of the bottom: {flat_spot}")
        }
        (_, Some(flat_spot), Some(header)) => format!(
            "as the log states it, {header}. A flat stretch of the bottom gives {flat_spot}"
        ),
        (_, _, Some(header)) => format!("as the log states it, {header}"),
        _ => "as the log states it".to_owned(),
    };
    let overlap = scale.overlap_deg.map_or(String::new(), |overlap_deg| {
        format!(
            " The beam of each side looks {overlap_deg:.1}\u{b0} past the nadir, as first returns over slopes show."
        )
    });
    format!("Slant ranges are scaled {text}.{}{overlap}", offset(scale))
}

/// Describes the offset that is subtracted from the ranges, or the reason why none is.
fn offset(scale: &CalibrationReport) -> String {
    match (scale.offset_m, scale.offset_measured_m, scale.offset_note) {
        (0.0, Some(measured_m), Some(note)) => format!(
            " First returns lie {} m from the recorded depths; no offset is taken off the ranges ({note}).",
            typeset_signed(measured_m, 2)
        ),
        (0.0, None, Some(note)) => format!(" No offset is taken off them ({note})."),
        (0.0, ..) => String::new(),
        (offset_m, ..) => format!(
            " {} m are added to every range: by so much first returns and recorded depths differ throughout the log.",
            typeset_signed(-offset_m, 2)
        ),
    }
}

/// Returns `key = value` of every setting that differs from the recommended preset.
fn changes(settings: &Settings) -> Vec<String> {
    let flat = |settings: &Settings| {
        let mut lines = Vec::new();
        if let Ok(table) = toml::Table::try_from(settings) {
            flatten("", &table, &mut lines);
        }
        lines
    };
    let recommended = flat(&Settings::preset(Preset::Recommended));
    let mut lines = flat(settings);
    lines.retain(|line| !recommended.contains(line));
    lines
}

fn flatten(prefix: &str, table: &toml::Table, lines: &mut Vec<String>) {
    for (key, value) in table {
        match value {
            toml::Value::Table(inner) => flatten(&format!("{prefix}{key}."), inner, lines),
            _ => lines.push(format!("{prefix}{key} = {value}")),
        }
    }
}

/// Returns the tables of the input files with their fingerprints, and of the written files.
pub(super) fn files(from: &ReportData<'_>) -> String {
    let mut html = String::from(
        "<h2>Files</h2>\n<table><tr><th class=\"text\">read</th><th>size</th><th class=\"text\">SHA-256</th></tr>\n",
    );
    for input in &from.report.inputs {
        html += &format!(
            "<tr><td class=\"text\">{}</td><td>{}</td><td class=\"text\"><code>{}</code></td></tr>\n",
            xml(file_name(&input.file)),
            bytes(input.bytes as u64),
            input.sha256
        );
    }
    html += "</table>\n<table><tr><th class=\"text\">written with this report</th><th class=\"text\">what it is</th></tr>\n";
    for (name, what) in from.files {
        html += &format!(
            "<tr><td class=\"text\">{}</td><td class=\"text\">{}</td></tr>\n",
            xml(name),
            xml(what)
        );
    }
    html + &format!(
        "</table>\n<p class=\"made\">Made with {}, run {}.</p>\n",
        xml(&from.report.program),
        from.report.run
    )
}

/// Returns the name of a file without its folder, which is private: the page is sent to others.
fn file_name(path: &str) -> &str {
    path.rsplit(['/', '\\']).next().unwrap_or(path)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_changed_settings_are_listed() {
        assert!(changes(&Settings::preset(Preset::Recommended)).is_empty());
        let changed = Settings::default().with_assignment("first_return.threshold=0.41").unwrap();
        assert_eq!(changes(&changed), ["first_return.threshold = 0.4099999964237213"]);
    }

    #[test]
    fn a_log_is_named_without_its_folder() {
        assert_eq!(file_name("a/b/river.DAT"), "river.DAT");
        assert_eq!(file_name("C:\\logs\\pond.sl2"), "pond.sl2");
    }
}

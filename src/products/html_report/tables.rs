//! Returns the values on the trust in the depths, the method, the input files and the written
//! files.

use super::ReportData;
use crate::pipeline::{CalibrationReport, CommonUncertainty, Preset, Settings};
use bathyscope_bottom::calibration::ScaleMode;
use bathyscope_bottom::presentation::page::{Value, context};
use bathyscope_bottom::presentation::text::{bytes, typeset_count as count, typeset_signed};

/// Returns the values on the agreement of the depths and its limits.
pub(super) fn trust(from: &ReportData<'_>) -> Value {
    let latencies = from.names.iter().zip(from.latencies).filter_map(|(name, latency)| {
        let latency = latency.as_ref()?;
        Some(context! {
            name,
            latency => latency.in_words(),
            in_force_s => latency.in_force_s.to_string(),
            advice_s => latency.contradicts().then(|| format!("{:.2}", latency.latency_s)),
        })
    });
    context! {
        comparisons => comparisons(from),
        latencies => latencies.collect::<Vec<Value>>(),
        common_errors => common_errors(&from.report.uncertainty),
        statement => &from.report.statement,
    }
}

fn comparisons(from: &ReportData<'_>) -> Option<Value> {
    let orders = from.comparisons.iter().map(|named| &named.comparison.orders);
    let orders = orders.max_by_key(|orders| orders.len())?.iter().map(|share| share.order.order);
    let rows = from.comparisons.iter().filter_map(|named| {
        let residuals = named.comparison.residuals.as_ref()?;
        let shares = named.comparison.orders.iter();
        Some(context! {
            source => named.source.to_string(),
            reference => &named.reference,
            matching => &named.matching,
            n => count(residuals.n),
            mean_m => format!("{:+.3}", residuals.mean_m),
            median_m => format!("{:+.3}", residuals.median_m),
            sd_m => format!("{:.3}", residuals.sd_m),
            rms_m => format!("{:.3}", residuals.rms_m),
            p95_m => format!("{:.3}", residuals.p95_m),
            shares => shares.map(|share| format!("{:.0}", 100.0 * share.share)).collect::<Vec<_>>(),
        })
    });
    let (orders, rows) = (orders.collect::<Vec<_>>(), rows.collect::<Vec<_>>());
    Some(context!(orders, rows))
}

/// Lists the uncertainties that all depths share: the parts that are not zero.
fn common_errors(of: &CommonUncertainty) -> String {
    let metres =
        |sigma_m: f64, what: &str| (sigma_m > 0.0).then(|| format!("{what} {sigma_m:.3} m"));
    let (share, beam_deg) = (of.sound_speed_share, of.sounder_beam_rad.to_degrees());
    let parts = [
        metres(of.range_offset_m, "side-scan against soundings"),
        (share > 0.0).then(|| format!("sound speed {:.1} % of the depth", 100.0 * share)),
        metres(of.draft_m, "draft"),
        metres(of.water_level_m, "water level"),
        metres(of.crossings.level_m, "crossings"),
        metres(of.crossings.per_slope_m, "crossings, times the slope of the bottom,"),
        metres(of.position_m, "positions, times the slope of the bottom,"),
        (beam_deg > 0.0).then(|| format!("wide beam of the sounder, on slopes, {beam_deg:.1}°")),
    ];
    parts.into_iter().flatten().collect::<Vec<String>>().join("; ")
}

/// Returns the values on scale, method and settings.
pub(super) fn method(from: &ReportData<'_>) -> Value {
    let scales: Vec<Value> = match &from.report.logs {
        None => vec![scale(None, &from.report.calibration)],
        Some(all) => all.logs.iter().map(|log| scale(Some(&log.log), &log.calibration)).collect(),
    };
    let corrections = from.report.corrections.iter().map(ToString::to_string);
    let all = toml::to_string(&from.products.settings).unwrap_or_default();
    context! {
        scales,
        corrections => corrections.collect::<Vec<String>>(),
        own_settings => own_settings(from),
        changed_settings => changes(&from.products.settings).join("\n"),
        all_settings => all.trim_end(),
    }
}

/// Lists the settings of logs that differ from those of the first log.
fn own_settings(from: &ReportData<'_>) -> String {
    let logs = from.report.logs.iter().flat_map(|all| &all.logs);
    let lines = logs.flat_map(|log| {
        log.own_settings.iter().map(|(key, value)| {
            let value = value.as_ref().map_or("none".to_owned(), toml::Value::to_string);
            format!("{}: {key} = {value}", log.log)
        })
    });
    lines.collect::<Vec<String>>().join("\n")
}

/// Returns the values on the scale of the slant ranges, of the log of this name or of the only one.
fn scale(log: Option<&String>, of: &CalibrationReport) -> Value {
    let flat_spot = of.ppd_px_per_m.zip(of.ppd_spread_px_per_m).map(|(scale, spread)| {
        context! {
            scale => format!("{scale:.2}"),
            spread => format!("{spread:.2}"),
            picks => count(of.ppd_picks),
            pings => of.pings.as_ref().map(|pings| [pings.start, pings.end]),
        }
    });
    let signed = |metres: f64| typeset_signed(metres, 2);
    context! {
        log,
        is_of_flat_spot => of.mode == ScaleMode::FlatSpot,
        flat_spot,
        header => of.header_px_per_m.map(|header| format!("{header:.2}")),
        overlap_deg => of.overlap_deg.map(|overlap_deg| format!("{overlap_deg:.1}")),
        added_m => (of.offset_m != 0.0).then(|| signed(-of.offset_m)),
        offset_m => of.offset_measured_m.map(signed),
        offset_note => of.offset_note,
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

/// Returns the values on the input files, with their fingerprints, and on the written files.
pub(super) fn files(from: &ReportData<'_>) -> Value {
    let inputs = from.report.inputs.iter().map(|input| {
        context! {
            name => file_name(&input.file),
            size => bytes(input.bytes),
            sha256 => &input.sha256,
        }
    });
    context! {
        inputs => inputs.collect::<Vec<Value>>(),
        files => from.files.to_vec(),
        program => &from.report.program,
        run => from.report.run.to_string(),
    }
}

/// Returns the name of a file without its folder, which is private: the page is sent to others.
fn file_name(path: &str) -> &str {
    path.rsplit(['/', '\\']).next().unwrap_or(path)
}

#[cfg(test)]
mod tests {
    use super::*;
    use bathyscope_bottom::presentation::page::fill;

    #[test]
    fn only_changed_settings_are_listed() {
        assert!(changes(&Settings::preset(Preset::Recommended)).is_empty());
        let changed = Settings::default().with_assignment("first_return.threshold=0.41").unwrap();
        assert_eq!(changes(&changed), ["first_return.threshold = 0.4099999964237213"]);
    }

    #[test]
    fn the_scale_is_said_as_it_is_known() {
        let said = |mode: ScaleMode, header: Option<f64>, ppd: Option<f64>, offset_m: f64| {
            let report = CalibrationReport {
                mode,
                header_px_per_m: header,
                ppd_px_per_m: ppd,
                ppd_spread_px_per_m: ppd.map(|_| 0.5),
                ppd_picks: 1200,
                ppd_factor: None,
                pings: None,
                flat_spot_depth_m: None,
                header_spread_px_per_m: None,
                k: None,
                b_m: None,
                offset_m,
                offset_measured_m: None,
                offset_uncertainty_m: None,
                offset_note: None,
                overlap_deg: None,
                fit_spread_m: None,
            };
            let template = ("method.html", include_str!("templates/method.html"));
            let page = fill(
                &[template],
                context! {
                    scales => vec![scale(None, &report)],
                    corrections => vec!["<b>"],
                    own_settings => "",
                    changed_settings => "a = 1",
                    all_settings => "a = 1",
                },
            );
            let page = page.unwrap();
            assert!(page.contains("<li>&lt;b&gt;</li>") && page.contains("<pre>a = 1</pre>"));
            let (_, text) = page.split_once("<p>Slant ranges are scaled ").unwrap();
            text.split_once("</p>").unwrap().0.to_owned()
        };
        use ScaleMode::{FlatSpot, Header};
        let flat = "12.00 ± 0.50 samples a metre over 1\u{202f}200 first returns";
        let header = "as the log states it, 10.00 samples a metre.";
        assert_eq!(said(Header, None, Some(12.0), 0.0), "as the log states it.");
        assert_eq!(said(FlatSpot, Some(10.0), None, 0.0), header);
        assert_eq!(
            said(Header, Some(10.0), Some(12.0), 0.0),
            format!("{header} A flat stretch of the bottom gives {flat}.")
        );
        assert_eq!(
            said(FlatSpot, None, Some(12.0), 0.0),
            format!("at a flat stretch of the bottom: {flat}.")
        );
        assert_eq!(
            said(FlatSpot, Some(10.0), Some(12.0), 0.25),
            format!(
                "at a flat stretch of the bottom: {flat}. The log itself states 10.00 samples a metre. \u{2212}0.25 m are added to every range: by so much first returns and recorded depths differ throughout the log."
            )
        );
    }

    #[test]
    fn a_log_is_named_without_its_folder() {
        assert_eq!(file_name("a/b/river.DAT"), "river.DAT");
        assert_eq!(file_name("C:\\logs\\pond.sl2"), "pond.sl2");
    }
}

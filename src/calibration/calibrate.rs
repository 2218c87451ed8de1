//! All scales side by side, the one in force, and what does not agree.

use super::offset::{RangeOffset, blocks};
use super::robust::robust_line;
use super::scale::{Usable, header_scale, picks_at_depths, range_changes, usable_picks};
use super::{
    Calibration, CalibrationSettings, DepthFit, FlatSpot, OffsetMode, PpdReach, ScaleMode,
    flat_spots,
};
use crate::first_return::FirstReturns;
use crate::progress::{Cancelled, Progress};
use crate::statistics::{median, spread_about};
use crate::survey::{Navigation, RangeSource, Side, Survey};

/// Picks that a fit over the log needs, at least.
const MIN_FIT_PICKS: usize = 50;

/// Measures all scales and picks the one that the settings ask for. `spots` are the ranked stretches.
///
/// Where the flat spot gives no scale the header's is in force, and a warning says so.
///
/// # Errors
/// When the work was cancelled.
pub fn calibrate(
    survey: &Survey,
    navigation: &Navigation,
    returns: &FirstReturns,
    spots: &[FlatSpot],
    settings: &CalibrationSettings,
    progress: &Progress,
) -> Result<Calibration, Cancelled> {
    progress.start(2);
    let picks = usable_picks(survey, returns);
    progress.advance(1);
    progress.check()?;
    let flat_spot = match settings.pings {
        Some(chosen) => flat_spots::describe(survey, navigation, &picks, chosen.start..chosen.end),
        None => spots.first().cloned(),
    };
    let measured = flat_spot.as_ref().is_some_and(|spot| spot.ppd.is_some());
    let fit = depth_fit(&picks);
    progress.advance(1);
    let mode = match settings.mode {
        ScaleMode::FlatSpot if !measured => ScaleMode::Header,
        mode => mode,
    };
    let header = header_scale(survey);
    let measured_offset = RangeOffset::of(&picks_at_depths(survey, returns));
    let mut warnings = Vec::new();
    let (offset_m, offset_note) = match (mode, settings.offset, survey.range_source) {
        (ScaleMode::FlatSpot, ..) => (0.0, Some("the flat spot's scale holds it")),
        (_, OffsetMode::None, _) => (0.0, Some("switched off")),
        (_, OffsetMode::Auto, RangeSource::SurveyRecorder) => {
            let sample_m = header.map(|header| 1.0 / header.px_per_m);
            let excess = measured_offset.zip(sample_m);
            warnings.extend(excess.and_then(|(found, sample_m)| found.excess(sample_m)));
            (0.0, Some("survey-grade ranges"))
        }
        _ => match (measured_offset, header) {
            (Some(measured), Some(header)) => match measured.objection(1.0 / header.px_per_m) {
                Some(objection) => {
                    warnings.push(objection);
                    (0.0, Some("refused"))
                }
                None => (measured.offset_m, None),
            },
            _ => (0.0, Some("no depths to measure it against")),
        },
    };
    if mode != settings.mode {
        warnings.push("There is no flat spot with usable first returns, so the scale of the log's headers is in force.".to_owned());
    }
    warnings.extend(flat_spot.as_ref().and_then(disagreement));
    if mode == ScaleMode::FlatSpot {
        warnings.extend(flat_spot.as_ref().and_then(|spot| selection(survey, spot)));
        warnings.extend(changing_range(survey, settings.ppd));
    }
    Ok(Calibration {
        mode,
        reach: settings.ppd,
        flat_spot,
        header,
        fit,
        offset_m,
        measured_offset,
        offset_note,
        warnings,
    })
}

/// Robust `r = k d + b` with the header's ranges; `None` where depths hardly vary or picks are few.
///
/// The line goes through medians over blocks of pings: the noise of a single recorded depth would flatten it.
fn depth_fit(picks: &[Usable]) -> Option<DepthFit> {
    if picks.len() < MIN_FIT_PICKS {
        return None;
    }
    let middle = |block: &[Usable], value: fn(&Usable) -> f64| {
        median(&mut block.iter().map(value).collect::<Vec<_>>())
    };
    let blocks: Vec<(f64, f64)> = blocks(picks)
        .map(|block| {
            (
                middle(block, |pick| pick.depth_m),
                middle(block, |pick| pick.range_m),
            )
        })
        .collect();
    let line = robust_line(&blocks)?;
    let about = |pick: &Usable| pick.range_m - line.slope * pick.depth_m - line.offset;
    Some(DepthFit {
        k: line.slope,
        b_m: line.offset,
        spread_m: spread_about(&mut picks.iter().map(about).collect::<Vec<_>>(), 0.0),
        picks: picks.len(),
    })
}

/// Against the header's scale at the same picks: over a log whose range was changed there is no other one to compare.
fn disagreement(spot: &FlatSpot) -> Option<String> {
    let (ppd, factor) = (spot.ppd?, spot.factor?);
    let spread = ppd.spread_px_per_m / ppd.px_per_m;
    let difference = 1.0 / factor - 1.0;
    (difference.abs() > spread).then(|| {
        format!(
            "The flat spot gives {:.2} samples a metre, the log's headers {:.2}: they differ by {:+.1} %, more than their spread of {:.1} %.",
            ppd.px_per_m,
            ppd.px_per_m * factor,
            100.0 * difference,
            100.0 * spread,
        )
    })
}

/// Where half the pings of a flat spot give no usable pick on a side that was recorded.
fn selection(survey: &Survey, spot: &FlatSpot) -> Option<String> {
    let recorded = survey.side_scan.get(spot.pings.start)?;
    let poorer = Side::BOTH
        .into_iter()
        .zip(spot.picks)
        .filter(|(side, _)| recorded.side(*side).is_some())
        .min_by_key(|(_, picks)| *picks);
    poorer
        .filter(|(_, picks)| 2 * picks < spot.pings.len())
        .map(|(side, picks)| {
            format!(
                "Only {picks} of {} pings of the flat spot have a usable first return to {}: its scale rests on a selection; choose another stretch.",
                spot.pings.len(),
                side.name(),
            )
        })
}

fn changing_range(survey: &Survey, reach: PpdReach) -> Option<String> {
    let changes = range_changes(survey);
    (reach == PpdReach::Constant && changes > 0).then(|| {
        format!("The recorded range changes {changes} times along the log: one constant from the flat spot is wrong outside its own range; use calibration.ppd = factor.")
    })
}

//! Computes all scales, chooses the one in force, and warns of disagreements.

use super::offset::{RangeOffset, TOLERANCE_M, blocks, robust_line};
use super::overlap::beam_widths;
use super::scale::{Usable, header_scale, picks_at_depths, range_changes, usable_picks};
use super::sounding_lag::SoundingLag;
use super::{
    Calibration, CalibrationSettings, DepthFit, FlatSpot, OffsetMode, PpdReach, ScaleMode,
    VERY_WIDE, flat_spots,
};
use crate::first_return::FirstReturns;
use bathyscope_log::support::progress::{Cancelled, Progress};
use bathyscope_log::support::statistics::{median_of, quantile, sorted, spread_about};
use bathyscope_log::survey::{Navigation, RangeSource, Side, Survey};

/// Least change of depths that is worth a warning, metres.
const LEAST_SAID_M: f64 = 0.02;
/// Largest difference of two ranges of a sample that count as the same recorded range, as a share.
const SAME_RANGE: f64 = 0.01;
/// Note on an offset that is not taken off because of an objection.
const REFUSED: &str = "refused";
/// Share of the differences of successive soundings that are smaller than the step of depths.
const FEW: f64 = 0.05;
/// Fewest picks for a fit over the log.
const MIN_FIT_PICKS: usize = 50;

/// Measures all scales and chooses the one that the settings name. `spots` are the ranked
/// stretches.
///
/// The header's scale is used, with a warning, where the flat spot gives none.
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
        Some(chosen) => {
            let pings = chosen.start..chosen.end;
            Some(flat_spots::describe(survey, navigation, &picks, pings))
        }
        None => spots.first().cloned(),
    };
    let measured = flat_spot.as_ref().is_some_and(|spot| spot.ppd.is_some());
    let fit = depth_fit(&picks);
    progress.advance(1);
    let mode = match settings.mode {
        ScaleMode::FlatSpot if !measured => ScaleMode::Header,
        mode => mode,
    };
    let mut made = Calibration {
        mode,
        reach: settings.ppd,
        flat_spot,
        header: header_scale(survey),
        fit,
        ..Calibration::default()
    };
    made.sounding_lag = SoundingLag::of(survey, returns, &made);
    let at_depths = picks_at_depths(survey, returns);
    let objection = take_off_offset(&mut made, survey, &at_depths, settings);
    if mode != settings.mode {
        made.warnings
            .push("No flat stretch gives a scale, so the recorded range is in use.".to_owned());
    }
    let spot = made.flat_spot.clone();
    let spot = spot.as_ref();
    // An offset with an objection may be no constant.
    let lead_m = match objection {
        None => spot.map_or(0.0, |spot| offset_at(spot, &made, survey, &at_depths)),
        Some(_) => 0.0,
    };
    let step_m = depth_step_m(survey);
    made.warnings.extend(spot.and_then(|spot| disagreement(spot, lead_m, step_m)));
    if settings.mode == ScaleMode::FlatSpot {
        let objections = spot.map(|spot| spot.objections(survey, spots.first()));
        made.warnings.extend(objections.unwrap_or_default());
    }
    if mode == ScaleMode::FlatSpot {
        made.warnings.extend(changing_range(survey, settings.ppd));
    }
    made.beams = beam_widths(survey, returns, &made);
    made.warnings.extend(made.beams.warning());
    made.warnings.extend(made.sounding_lag.map(|lag| lag.warning()));
    made.warnings.extend(remaining(&made));
    Ok(made)
}

/// Measures the constant between first returns and recorded depths, and takes it off the ranges of
/// a calibration where the settings and the log allow it. Returns the objection to the constant, if
/// there is one.
fn take_off_offset(
    made: &mut Calibration,
    survey: &Survey,
    picks: &[Usable],
    settings: &CalibrationSettings,
) -> Option<String> {
    let sample_m = made.header.map_or(f64::NAN, |header| 1.0 / header.px_per_m);
    let measured = RangeOffset::of(picks, sample_m, made.are_soundings_late(survey));
    made.measured_offset = measured;
    let measured = measured.filter(|_| made.header.is_some());
    let objection = measured.and_then(|measured| measured.objection(sample_m));
    let (offset_m, offset_note) = match (made.mode, settings.offset, survey.range_source) {
        (ScaleMode::FlatSpot, ..) => (0.0, Some("scaled on the flat stretch")),
        (_, OffsetMode::None, _) => (0.0, Some("switched off")),
        (_, OffsetMode::Auto, RangeSource::SurveyRecorder) => {
            made.warnings.extend(measured.and_then(|found| found.excess(sample_m)));
            (0.0, Some("survey-grade ranges"))
        }
        _ => match (measured, &objection) {
            (Some(_), Some(objection)) => {
                made.warnings.push(objection.clone());
                (0.0, Some(REFUSED))
            }
            (Some(measured), None) => (measured.offset_m, None),
            (None, _) => (0.0, Some("no depths to measure it against")),
        },
    };
    (made.offset_m, made.offset_note) = (offset_m, offset_note);
    objection
}

/// Returns the constant between first returns and recorded depths at the recorded range of a flat
/// spot, metres: a part of it is a number of samples, and these are longer at a longer range.
fn offset_at(spot: &FlatSpot, made: &Calibration, survey: &Survey, picks: &[Usable]) -> f64 {
    let of_log_m = made.measured_offset.map_or(0.0, |measured| measured.offset_m);
    let sample_m = |ping: usize| {
        let span = Side::BOTH.into_iter().find_map(|side| survey.span(ping, side));
        span.map_or(f64::NAN, |span| span.metres_per_sample())
    };
    if range_changes(survey) == 0 {
        return of_log_m;
    }
    let at_spot_m = sample_m(spot.pings.start);
    let is_alike = |pick: &&Usable| (sample_m(pick.ping) / at_spot_m - 1.0).abs() < SAME_RANGE;
    let picks: Vec<Usable> = picks.iter().filter(is_alike).copied().collect();
    let of_range = RangeOffset::of(&picks, at_spot_m, made.are_soundings_late(survey));
    of_range.map_or(of_log_m, |measured| measured.offset_m)
}

/// Returns the robust line `r = k d + b` with the header's ranges; `None` where depths hardly vary
/// or picks are few.
///
/// The line goes through medians over blocks of pings: the noise of a single recorded depth would
/// flatten it.
fn depth_fit(picks: &[Usable]) -> Option<DepthFit> {
    if picks.len() < MIN_FIT_PICKS {
        return None;
    }
    let middle = |block: &[Usable], value: fn(&Usable) -> f64| median_of(block.iter().map(value));
    let blocks: Vec<(f64, f64)> = blocks(picks)
        .map(|block| (middle(block, |pick| pick.depth_m), middle(block, |pick| pick.range_m)))
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

/// Returns a warning where the header's scale and the soundings disagree about the first returns at
/// the flat spot, after subtraction of the constant `lead_m` that ranges have over depths: an
/// offset of a few centimetres moves the flat spot's scale, and is no error of the header's. In a
/// log whose range was changed there are no other picks to compare. `None` where depths would
/// change by less than their scatter, of which at most [`VERY_WIDE`] of the depth counts, by less
/// than half the step that the recorder rounds depths to, or by less than [`LEAST_SAID_M`]. `None`
/// also for a stretch that slopes across the track: it determines no scale.
fn disagreement(spot: &FlatSpot, lead_m: f64, step_m: f64) -> Option<String> {
    let (spread, factor) = (spot.spread()?, spot.factor?);
    let change_m = spot.depth_m / factor - lead_m - spot.depth_m;
    let sigma_m = spot.depth_m * spread;
    let least_m = sigma_m.min(spot.depth_m * VERY_WIDE).max(0.5 * step_m).max(LEAST_SAID_M);
    (change_m.abs() > least_m && !spot.is_tilted()).then(|| {
        format!(
            "At the flat stretch, {:.2} m deep, recorded ranges give depths {:.1} cm {} than the soundings; single depths scatter by {:.1} cm. Compare the residuals with either scale.",
            spot.depth_m,
            100.0 * change_m.abs(),
            if change_m > 0.0 { "greater" } else { "less" },
            100.0 * sigma_m,
        )
    })
}

/// Returns the step that the recorder rounds depths to, metres: few differences of a sounding from
/// the one before it are smaller, those of 0 apart. Of a recorder that does not round it is a share
/// of the noise. 0 where depths do not differ.
fn depth_step_m(survey: &Survey) -> f64 {
    let good = survey.soundings.iter().filter(|sounding| sounding.is_good());
    let depths_m: Vec<f64> = good.map(|sounding| f64::from(sounding.depth_m)).collect();
    let steps = depths_m.windows(2).map(|pair| (pair[1] - pair[0]).abs());
    let steps_m = sorted(steps.filter(|step_m| *step_m > 0.0));
    if steps_m.is_empty() { 0.0 } else { quantile(&steps_m, FEW) }
}

/// Returns a warning where side-scan and soundings differ by more than the uncertainty of either,
/// and no other warning covers this: no offset was to be taken off.
fn remaining(made: &Calibration) -> Option<String> {
    let [left_m, two_sigma_m] = made.remaining_offset_m()?;
    let is_silent = matches!(made.offset_note, Some(note) if note != REFUSED);
    (is_silent && left_m.abs() > two_sigma_m.max(TOLERANCE_M)).then(|| {
        format!(
            "Side-scan depths are {:.1} cm {} than the soundings, more than the uncertainty of either. The stated error of the map includes this; calibration.offset = fit subtracts it where it is a constant.",
            100.0 * left_m.abs(),
            if left_m > 0.0 { "greater" } else { "less" },
        )
    })
}

fn changing_range(survey: &Survey, reach: PpdReach) -> Option<String> {
    let changes = range_changes(survey);
    (reach == PpdReach::Constant && changes > 0).then(|| {
        format!("The recorded range changes {changes} times along the log: one constant from the flat stretch is wrong outside its own range; use calibration.ppd = factor.")
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::calibration::tests::good;
    use bathyscope_log::survey::Sounding;

    #[test]
    fn half_a_step_of_the_recorded_depths_is_no_disagreement() {
        let survey = |round: fn(f32) -> f32| {
            let depths =
                (0..200).map(|index| 2.0 + 0.007 * index as f32 + 0.002 * (index % 3) as f32);
            let soundings = depths.map(|depth_m| Sounding::new(0.0, round(depth_m)));
            Survey { soundings: soundings.collect::<Vec<_>>().into(), ..Survey::default() }
        };
        let rounded_m = depth_step_m(&survey(|depth_m| (10.0 * depth_m).round() / 10.0));
        assert!((rounded_m - 0.1).abs() < 1e-4, "{rounded_m}");
        let exact_m = depth_step_m(&survey(|depth_m| depth_m));
        assert!(exact_m < 0.01, "{exact_m}");
        assert_eq!(depth_step_m(&Survey::default()), 0.0);

        let spot = FlatSpot { depth_m: 3.0, factor: Some(1.0127), ..good() };
        assert!(disagreement(&spot, 0.0, exact_m).is_some_and(|text| text.contains("3.8 cm less")));
        assert_eq!(disagreement(&spot, 0.0, rounded_m), None);
    }
}

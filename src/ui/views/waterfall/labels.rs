//! Words and numbers on the picture.

use crate::survey::Survey;
use egui::{Align2, Color32, FontId, Painter, Pos2, Rect};

/// Size of text on the picture, points.
const TEXT_POINTS: f32 = 11.0;

/// Text with a ground that keeps it readable on any picture. Returns the ground.
pub(super) fn text(painter: &Painter, at: Pos2, anchor: Align2, text: &str) -> Rect {
    let galley = painter.layout_no_wrap(
        text.to_owned(),
        FontId::proportional(TEXT_POINTS),
        Color32::from_gray(235),
    );
    let rect = anchor.anchor_size(at, galley.size());
    let ground = rect.expand2(egui::vec2(3.0, 1.0));
    painter.rect_filled(ground, 2.0, Color32::from_black_alpha(150));
    painter.galley(rect.min, galley, Color32::PLACEHOLDER);
    ground
}

/// Time of day (UTC) where the recorder knew it, else time since the log began. Tenths only when asked for.
pub(super) fn time(survey: &Survey, time_s: f64, tenths: bool) -> String {
    let (of_day_s, sign) = match survey.start_unix_s {
        Some(start_s) => ((start_s + time_s).rem_euclid(86_400.0), ""),
        None => (time_s.abs(), if time_s < 0.0 { "−" } else { "" }),
    };
    let whole = of_day_s as u64;
    let (hours, minutes, seconds) = (whole / 3600, whole / 60 % 60, whole % 60);
    let fraction = if tenths {
        format!(".{}", (of_day_s.fract() * 10.0) as u8)
    } else {
        String::new()
    };
    if hours > 0 || survey.start_unix_s.is_some() {
        format!("{sign}{hours:02}:{minutes:02}:{seconds:02}{fraction}")
    } else {
        format!("{sign}{minutes}:{seconds:02}{fraction}")
    }
}

/// The smallest of 1, 2, 5, 10, 20, 50 ... (times `unit`) that is at least `least`.
pub(super) fn round_step(least: f64, unit: f64) -> f64 {
    let decade = 10_f64.powf((least / unit).max(1e-9).log10().floor()) * unit;
    [1.0, 2.0, 5.0, 10.0]
        .into_iter()
        .map(|factor| factor * decade)
        .find(|step| *step >= least * (1.0 - 1e-9))
        .unwrap_or(10.0 * decade)
}

/// Metres with as many decimals as the step between neighbours needs.
pub(super) fn metres(value_m: f64, step_m: f64) -> String {
    let decimals = (-step_m.log10().floor()).clamp(0.0, 3.0) as usize;
    format!("{value_m:.decimals$} m")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_are_one_two_or_five() {
        for (least, step) in [
            (0.03, 0.05),
            (1.0, 1.0),
            (1.1, 2.0),
            (3.0, 5.0),
            (7.0, 10.0),
            (51.0, 100.0),
        ] {
            assert!((round_step(least, 1.0) - step).abs() < 1e-12, "{least}");
        }
    }

    #[test]
    fn metres_show_the_step() {
        assert_eq!(metres(5.0, 5.0), "5 m");
        assert_eq!(metres(2.5, 0.5), "2.5 m");
        assert_eq!(metres(0.25, 0.05), "0.25 m");
    }
}

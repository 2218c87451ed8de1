//! Fields that numbers are typed into.
//!
//! In: a number. Out: a field or a slider of egui, which changes it on Enter, when it is left, and
//! while it is dragged, never while digits are typed: a field that moves under the fingers would
//! leave the digits that follow to the keys of the views.

use egui::emath::Numeric;
use egui::{DragValue, Slider};
use std::ops::RangeInclusive;

/// Returns a field for a number.
pub(crate) fn number_field<N: Numeric>(value: &mut N) -> DragValue<'_> {
    DragValue::new(value).update_while_editing(false).custom_parser(parse)
}

/// Returns a slider for a number, with a field.
pub(crate) fn number_slider<N: Numeric>(value: &mut N, range: RangeInclusive<N>) -> Slider<'_> {
    Slider::new(value, range).update_while_editing(false).custom_parser(parse)
}

/// Returns the number of a text; half of the world writes a decimal comma, and figures are copied
/// with the minus sign of print.
pub(crate) fn parse(text: &str) -> Option<f64> {
    let sign = |letter: char| match letter {
        '\u{2212}' => '-',
        ',' => '.',
        other => other,
    };
    let is_kept = |letter: &char| !letter.is_whitespace();
    let number: f64 = text.chars().filter(is_kept).map(sign).collect::<String>().parse().ok()?;
    number.is_finite().then_some(number)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_read_with_comma_and_point() {
        assert_eq!(parse("0,45"), Some(0.45));
        assert_eq!(parse(" \u{2212}1 200.5 "), Some(-1200.5));
        assert_eq!([parse(""), parse("deep"), parse("nan")], [None; 3]);
    }
}

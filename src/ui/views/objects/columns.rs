//! What stands in each column, and how wide it is.

use crate::app::{App, ObjectColumn, ObjectState, SurveyObject};
use crate::ui::place;
use bathyscope_bottom::presentation::units::Units;
use bathyscope_objects::review::{Confidence, State};
use egui::{Rect, pos2, vec2};

/// Width of the picture of a row, points.
pub(super) const PICTURE_WIDTH: f32 = 72.0;
/// Room between the text of a cell and its edges, points.
pub(super) const ROOM: f32 = 6.0;

/// The columns behind the picture, each with its width.
pub(super) struct ColumnWidths {
    widths: Vec<(ObjectColumn, f32)>,
}

impl ColumnWidths {
    /// Those of a table as wide as there is room: what is left goes to the columns of text. One log
    /// needs no column of logs.
    pub(super) fn fit(room: f32, app: &App) -> Self {
        let is_shown = |column: &ObjectColumn| *column != ObjectColumn::Logs || app.log_count() > 1;
        let shown: Vec<ObjectColumn> = ObjectColumn::ALL.into_iter().filter(is_shown).collect();
        let least: f32 = shown.iter().map(|column| least_width(*column)).sum();
        let shares: f32 = shown.iter().map(|column| share(*column)).sum();
        let left = (room - PICTURE_WIDTH - least).max(0.0);
        let width = |column| least_width(column) + left * share(column) / shares;
        Self { widths: shown.into_iter().map(|one| (one, width(one))).collect() }
    }

    /// Width of a row.
    pub(super) fn width(&self) -> f32 {
        let columns: f32 = self.widths.iter().map(|(_, width)| width).sum();
        PICTURE_WIDTH + columns
    }

    /// Where the picture lies in a row, and where each cell does.
    pub(super) fn cells(&self, row: Rect) -> (Rect, impl Iterator<Item = (ObjectColumn, Rect)>) {
        let picture = Rect::from_min_size(row.min, vec2(PICTURE_WIDTH, row.height()));
        let mut left = picture.right();
        let cells = self.widths.iter().map(move |(column, width)| {
            let cell = Rect::from_min_size(pos2(left, row.top()), vec2(*width, row.height()));
            left += width;
            (*column, cell)
        });
        (picture, cells)
    }
}

/// Least width of a column, points.
fn least_width(column: ObjectColumn) -> f32 {
    match column {
        ObjectColumn::Number => 44.0,
        ObjectColumn::Name | ObjectColumn::Class => 84.0,
        ObjectColumn::State => 92.0,
        ObjectColumn::Confidence => 104.0,
        ObjectColumn::Length | ObjectColumn::Width | ObjectColumn::Depth => 72.0,
        ObjectColumn::Height => 98.0,
        ObjectColumn::Seen | ObjectColumn::Logs => 56.0,
        ObjectColumn::Position => 176.0,
        ObjectColumn::Remarks => 90.0,
    }
}

/// Share of a column in the room that is left.
fn share(column: ObjectColumn) -> f32 {
    match column {
        ObjectColumn::Name | ObjectColumn::Class => 1.0,
        ObjectColumn::Remarks => 3.0,
        _ => 0.0,
    }
}

/// Columns of numbers are aligned at their right.
pub(super) fn is_number(column: ObjectColumn) -> bool {
    matches!(
        column,
        ObjectColumn::Number
            | ObjectColumn::Length
            | ObjectColumn::Width
            | ObjectColumn::Height
            | ObjectColumn::Depth
            | ObjectColumn::Seen
    )
}

/// Whether its values have the unit of lengths.
fn is_length(column: ObjectColumn) -> bool {
    matches!(
        column,
        ObjectColumn::Length | ObjectColumn::Width | ObjectColumn::Height | ObjectColumn::Depth
    )
}

/// Its heading with the unit: `length, m`.
pub(super) fn heading(column: ObjectColumn, units: Units) -> String {
    match is_length(column) {
        true => format!("{}, {}", column.name(), units.symbol()),
        false => column.name().to_owned(),
    }
}

/// What a heading means.
pub(super) fn meaning(column: ObjectColumn) -> &'static str {
    match column {
        ObjectColumn::Number => "Number of the object.",
        ObjectColumn::Name => "Its name.",
        ObjectColumn::Class => "The class of most of its boxes.",
        ObjectColumn::State => "What was decided about it.",
        ObjectColumn::Confidence => {
            "Your own confidence, and the highest score of the detector (0 to 1)."
        }
        ObjectColumn::Length => "Length along the track.",
        ObjectColumn::Width => "Width across the track.",
        ObjectColumn::Height => {
            "Height above the bottom from its shadows, with the standard deviation."
        }
        ObjectColumn::Depth => "Depth of the bottom there.",
        ObjectColumn::Seen => "Passes of the boat that saw it.",
        ObjectColumn::Logs => "Logs that saw it.",
        ObjectColumn::Position => "Mean position of its boxes (WGS84).",
        ObjectColumn::Remarks => "Remarks on its boxes.",
    }
}

/// How far the decisions are, and the state whose colour that has: `3 undecided`.
pub(super) fn decisions(object: &SurveyObject) -> (String, State) {
    match object.summary.state {
        ObjectState::Open(open) if open == object.boxes.len() => {
            ("undecided".to_owned(), State::Proposed)
        }
        ObjectState::Open(open) => (format!("{open} undecided"), State::Proposed),
        ObjectState::Accepted => ("accepted".to_owned(), State::Accepted),
        ObjectState::Rejected => ("rejected".to_owned(), State::Rejected),
    }
}

/// The text of a cell; empty for what is not known.
pub(super) fn cell_text(app: &App, object: &SurveyObject, column: ObjectColumn) -> String {
    let (summary, units) = (&object.summary, app.view.options.units);
    let length = |value_m: f64| match value_m.is_finite() {
        true => units.number(value_m, 2),
        false => String::new(),
    };
    match column {
        ObjectColumn::Number => object.number.to_string(),
        ObjectColumn::Name => summary.name.clone(),
        ObjectColumn::Class => object.joint.class.clone(),
        ObjectColumn::State => decisions(object).0,
        ObjectColumn::Confidence => {
            let word = summary.confidence.map(|word| Confidence::name(word).to_owned());
            let score = summary.score.map(|score| format!("{score:.2}"));
            let both: Vec<String> = word.into_iter().chain(score).collect();
            both.join(" ")
        }
        ObjectColumn::Length => length(summary.length_m),
        ObjectColumn::Width => length(summary.width_m),
        ObjectColumn::Height => {
            let height = object.joint.height;
            match height.sigma_m.is_finite() {
                true => format!("{} ± {}", length(height.mean_m), length(height.sigma_m)),
                false => length(height.mean_m),
            }
        }
        ObjectColumn::Depth => length(summary.depth_m),
        ObjectColumn::Seen => object.sightings.to_string(),
        ObjectColumn::Logs => object.logs().len().to_string(),
        ObjectColumn::Position => place::written(app, object.position),
        ObjectColumn::Remarks => summary.notes.clone(),
    }
}

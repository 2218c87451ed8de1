//! Finds the control of a setting and moves the keyboard to it: the palette finds settings by their
//! names.

use crate::ui::{ViewContext, theme};
use bathyscope_products::pipeline::settings::{SettingRow, rows};
use egui::{Context, FocusDirection, Id, Response, Stroke, StrokeKind, Ui};

/// Place in the window where the controls of some settings are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum ControlPlace {
    /// A section of the panel of steps.
    Section(&'static str),
    /// The list Levels of the waterfall.
    Levels,
}

impl ControlPlace {
    /// Returns the text before the name of a setting in the palette.
    pub(crate) fn name(self) -> &'static str {
        match self {
            ControlPlace::Section(title) => title,
            ControlPlace::Levels => "Waterfall levels",
        }
    }
}

/// All settings that have a control in the window, by the place of the control.
pub(crate) static CONTROLS: &[(ControlPlace, &[&SettingRow])] = &[
    (
        ControlPlace::Section("First return"),
        &[
            &rows::METHOD,
            &rows::SAMPLES,
            &rows::THRESHOLD,
            &rows::DEAD_ZONE,
            &rows::ABOVE_BOTTOM_MARGIN,
            &rows::MIN_CONFIDENCE,
            &rows::BOTTOM_LINE,
        ],
    ),
    (ControlPlace::Section("Calibration"), &[&rows::SCALE, &rows::PPD_REACH, &rows::OFFSET]),
    (
        ControlPlace::Section("Cloud"),
        &[&rows::GEOMETRY, &rows::ALPHA2, &rows::HEADING, &rows::HEADING_WINDOW, &rows::PROJECTION],
    ),
    (ControlPlace::Section("Outliers"), &[&rows::RADIUS, &rows::MIN_NEIGHBOURS]),
    (
        ControlPlace::Section("Depth map"),
        &[
            &rows::SURFACE_METHOD,
            &rows::SWATH,
            &rows::SURFACE_CELL,
            &rows::MAX_GAP,
            &rows::SIDE_SCAN_WEIGHT,
        ],
    ),
    (
        ControlPlace::Section("Isobaths"),
        &[
            &rows::INTERVAL,
            &rows::ISOBATH_UNIT,
            &rows::SMOOTH,
            &rows::SHOAL_SAFE,
            &rows::SPOT_RADIUS,
            &rows::CLIP,
        ],
    ),
    (
        ControlPlace::Section("Mosaic"),
        &[
            &rows::RELIEF,
            &rows::OVERLAP,
            &rows::GAIN,
            &rows::MOSAIC_COLOURS,
            &rows::WATER_COLUMN,
            &rows::NADIR_GAP,
            &rows::MOST_TURN,
            &rows::MOSAIC_CELL,
        ],
    ),
    (ControlPlace::Section("Products"), &[&rows::CRS, &rows::POINTS_LAS, &rows::REPORT_PROPOSALS]),
    (
        ControlPlace::Section("Depth correction"),
        &[
            &rows::DRAFT,
            &rows::WATER_LEVEL,
            &rows::WATER_LEVEL_FILE,
            &rows::TEMPERATURE,
            &rows::SALINITY,
            &rows::RECORDER_SPEED,
        ],
    ),
    (
        ControlPlace::Section("Position"),
        &[&rows::TRACK_FILE, &rows::TRACK_OFFSET, &rows::SHIFT_EAST, &rows::SHIFT_NORTH],
    ),
    (
        ControlPlace::Section("Mounting"),
        &[
            &rows::SWAP_SIDES,
            &rows::ANTENNA_FORWARD,
            &rows::ANTENNA_RIGHT,
            &rows::HEADING_OFFSET,
            &rows::CLOCK_OFFSET,
            &rows::LATENCY,
            &rows::SOUNDING_LAG,
            &rows::SOURCE_CRS,
        ],
    ),
    (ControlPlace::Section("Excluded"), &[&rows::MAX_TURN, &rows::MIN_SPEED, &rows::MIN_DURATION]),
    (
        ControlPlace::Levels,
        &[
            &rows::PICTURE_GAIN,
            &rows::PICTURE_SPREADING,
            &rows::PICTURE_ABSORPTION,
            &rows::PICTURE_BALANCE,
            &rows::PICTURE_STRIPES,
            &rows::PICTURE_DESPECKLE,
            &rows::PICTURE_BLACK,
            &rows::PICTURE_WHITE,
            &rows::PICTURE_GAMMA,
            &rows::PICTURE_FLIP,
            &rows::PICTURE_FIRST,
        ],
    ),
];

/// Returns the settings whose controls are in a place.
pub(crate) fn rows_in(place: ControlPlace) -> impl Iterator<Item = &'static SettingRow> {
    let here = CONTROLS.iter().filter(move |(other, _)| *other == place);
    here.flat_map(|(_, rows)| rows.iter().copied())
}

/// Returns the place of the control of a setting; `None` if it has no control.
pub(crate) fn place_of(key: &str) -> Option<ControlPlace> {
    let holds = |(_, rows): &&(ControlPlace, &[&SettingRow])| rows.iter().any(|row| row.key == key);
    CONTROLS.iter().find(holds).map(|(place, _)| *place)
}

fn sought_id() -> Id {
    Id::unique("setting that gets the keyboard")
}

fn marked_id() -> Id {
    Id::unique("setting that is marked")
}

fn number_id() -> Id {
    Id::unique("setting whose number gets the keyboard")
}

/// Requests that the control of a setting takes the keyboard when it is drawn next.
pub(crate) fn seek(ctx: &Context, key: &'static str) {
    ctx.data_mut(|data| data.insert_temp(sought_id(), key));
}

/// Returns the setting whose control is requested and was not drawn since.
pub(crate) fn sought(ctx: &Context) -> Option<&'static str> {
    ctx.data(|data| data.get_temp(sought_id()))
}

/// Withdraws the request for a control.
pub(crate) fn give_up(ctx: &Context) {
    ctx.data_mut(|data| data.remove::<&'static str>(sought_id()));
}

/// Gives the keyboard to the control of a setting if it is requested, brings it into view, and
/// frames it while it has the keyboard.
pub(crate) fn answer(ui: &Ui, context: &ViewContext<'_>, key: &str, control: &Response) {
    let ctx = ui.ctx();
    // A list cannot scroll to a control before the size of the control is known.
    if sought(ctx) == Some(key) && !ui.is_sizing_pass() {
        ctx.data_mut(|data| data.insert_temp(marked_id(), key.to_owned()));
        give_up(ctx);
        control.request_focus();
        control.scroll_to_me(Some(egui::Align::Center));
        ctx.data_mut(|data| data.insert_temp(number_id(), key.to_owned()));
        ctx.request_repaint();
    }
    let is_marked = ctx.data(|data| data.get_temp(marked_id()) == Some(key.to_owned()));
    if is_marked && (control.has_focus() || control.gained_focus()) {
        let stroke = Stroke::new(1.5, theme::accent_colour(context.theme()));
        let frame = control.rect.expand(2.0);
        ui.painter().rect_stroke(frame, 3.0, stroke, StrokeKind::Outside);
    }
}

/// Moves the keyboard from a slider that got it in the last frame, because its setting was
/// requested, to the number beside it: digits that are typed then edit the number. Must be called
/// before the slider is drawn.
pub(crate) fn edit_number(ui: &Ui, key: &str) {
    let is_wanted = ui.data(|data| data.get_temp(number_id()) == Some(key.to_owned()));
    if is_wanted {
        ui.data_mut(|data| data.remove::<String>(number_id()));
        ui.memory_mut(|memory| memory.move_focus(FocusDirection::Next));
    }
}

/// Returns the setting whose control is framed while it has the keyboard.
#[cfg(test)]
pub(crate) fn marked(ctx: &Context) -> Option<String> {
    ctx.data(|data| data.get_temp(marked_id()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use bathyscope_products::pipeline::settings::rows::ROWS;

    /// Settings without a control: they are drawn in a view, edited in their own list, found by a
    /// search, or only set in files and by `--set`.
    const WITHOUT: [&str; 18] = [
        "height_offset_m",
        "sound_speed.m_s",
        "sound_speed.depth_m",
        "calibration.pings",
        "cloud.down_scan",
        "excluded.log",
        "excluded.stretches",
        "detector.model",
        "detector.score",
        "detector.iou",
        "detector.name_score",
        "surface.max_side",
        "surface.down_scan_weight",
        "surface.above_bottom",
        "surface.longest_above_bottom_m",
        "isobaths.depths_m",
        "review.classes",
        "source.frequency_khz",
    ];

    #[test]
    fn every_setting_has_one_place_or_no_control() {
        for row in ROWS {
            let places = CONTROLS.iter().flat_map(|(_, rows)| rows.iter());
            let count = places.filter(|other| other.key == row.key).count();
            let expected = usize::from(!WITHOUT.contains(&row.key));
            assert_eq!(count, expected, "{}", row.key);
        }
    }
}

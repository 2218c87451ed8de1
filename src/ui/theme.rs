//! All colours and sizes.

use crate::app::{SideColours, ThemeChoice, ViewOptions};
use crate::survey::Side;
use egui::Color32;

/// Colour of a side's first return and points.
pub fn side_colour(options: &ViewOptions, side: Side) -> Color32 {
    match (options.side_colours, side) {
        (SideColours::Paper, Side::Starboard) => Color32::from_rgb(235, 64, 52),
        (SideColours::Paper, Side::Port) => Color32::from_rgb(66, 135, 245),
        (SideColours::Maritime, Side::Starboard) => Color32::from_rgb(46, 176, 93),
        (SideColours::Maritime, Side::Port) => Color32::from_rgb(235, 64, 52),
    }
}

/// Colour of down-scan points: black as in the paper, white on dark.
pub fn down_scan_colour(options: &ViewOptions) -> Color32 {
    match options.theme {
        ThemeChoice::Dark => Color32::from_rgb(235, 235, 235),
        ThemeChoice::Light => Color32::from_rgb(20, 20, 20),
    }
}

/// Colour of points that the outlier filter would remove.
pub fn outlier_colour() -> Color32 {
    Color32::from_rgb(255, 190, 40)
}

/// Background of waterfall, map and cloud.
pub fn canvas_colour(options: &ViewOptions) -> Color32 {
    match options.theme {
        ThemeChoice::Dark => Color32::from_rgb(14, 17, 22),
        ThemeChoice::Light => Color32::from_rgb(247, 247, 245),
    }
}

/// Cross-hairs of the place under the pointer in another view.
pub fn hover_colour() -> Color32 {
    Color32::from_rgb(255, 221, 87)
}

/// Mark of the selection.
pub fn selection_colour() -> Color32 {
    Color32::from_rgb(90, 220, 220)
}

//! Computes the size of a printed view, and copies the state that it is drawn from.

use super::{App, Jobs};
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// Number of screen points in an inch: text is as large on paper as on a screen with this
/// resolution.
const POINTS_AN_INCH: f64 = 96.0;
/// Millimetres in an inch.
const INCH_MM: f64 = 25.4;

/// Medium that a picture is made for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Paper {
    /// 210 by 297 mm.
    #[default]
    A4,
    /// 297 by 420 mm.
    A3,
    /// A screen: as wide as requested, with the shape of the view.
    Pixels,
}

bathyscope_log::named! {
    /// All media in the order of the list.
    pub Paper {
        A4: "A4",
        A3: "A3",
        Pixels: "width in pixels",
    }
}

impl Paper {
    /// Returns the short and the long side, millimetres; `None` for a screen.
    fn sides_mm(self) -> Option<[f64; 2]> {
        match self {
            Paper::A4 => Some([210.0, 297.0]),
            Paper::A3 => Some([297.0, 420.0]),
            Paper::Pixels => None,
        }
    }
}

/// Print options of a view.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct PrintOptions {
    /// Medium that the picture is made for.
    pub paper: Paper,
    /// True for landscape format.
    pub landscape: bool,
    /// Resolution on paper, pixels per inch.
    pub dpi: u32,
    /// Width for a screen, pixels.
    pub width_px: u32,
    /// True to print on white instead of the background of the window.
    pub light: bool,
}

impl Default for PrintOptions {
    fn default() -> Self {
        Self { paper: Paper::default(), landscape: true, dpi: 300, width_px: 3000, light: true }
    }
}

/// Size and scale of a printed view.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Sheet {
    /// Width and height, pixels.
    pub size_px: [u32; 2],
    /// Pixels per screen point, which is the magnification of text and lines.
    pub pixels_per_point: f32,
}

impl PrintOptions {
    /// Size of a screen point on paper, metres.
    pub(crate) const POINT_M: f64 = INCH_MM / 1000.0 / POINTS_AN_INCH;
    /// Resolutions that can be chosen, pixels per inch.
    pub(crate) const DPI: std::ops::RangeInclusive<u32> = 72..=600;
    /// Widths that can be chosen, pixels.
    pub(crate) const WIDTHS_PX: std::ops::RangeInclusive<u32> = 400..=8192;

    /// Returns the size and scale of the print of a view with the size `view`, screen points.
    pub(crate) fn sheet(&self, view: [f32; 2]) -> Sheet {
        let Some([short_mm, long_mm]) = self.paper.sides_mm() else {
            let [width, height] = view.map(|side| f64::from(side.max(1.0)));
            let scale = f64::from(self.width_px) / width;
            return Sheet {
                size_px: [self.width_px, (height * scale).round().max(1.0) as u32],
                pixels_per_point: scale as f32,
            };
        };
        let sides_mm = if self.landscape { [long_mm, short_mm] } else { [short_mm, long_mm] };
        let dpi = f64::from(self.dpi);
        Sheet {
            size_px: sides_mm.map(|side_mm| (side_mm / INCH_MM * dpi).round() as u32),
            pixels_per_point: (dpi / POINTS_AN_INCH) as f32,
        }
    }
}

impl App {
    /// Returns a copy of the state for drawing the views elsewhere: without buttons, and without
    /// the selection of the pointer.
    pub(crate) fn for_picture(&self) -> App {
        let mut copy = App::new(Jobs::Threads(Arc::new(|| ())));
        copy.view.is_picture = true;
        copy.map.planning = self.map.planning.for_picture();
        copy.logs = self.logs.for_picture();
        copy.pipeline.deriving = self.pipeline.deriving.for_picture();
        copy.view.survey_serial = self.view.survey_serial;
        copy.view.plane_serial = self.view.plane_serial;
        copy.view.options = self.view.options.clone();
        copy.map.base_map = self.map.base_map.clone();
        copy.map.comparing = self.map.comparing.clone();
        copy.findings.reference_comparison = self.findings.reference_comparison.for_picture();
        copy.map.measuring = self.map.measuring.for_picture();
        copy
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paper_has_the_pixels_that_its_millimetres_take() {
        let a4 = PrintOptions::default().sheet([10.0, 10.0]);
        assert_eq!(a4.size_px, [3508, 2480]);
        assert_eq!(a4.pixels_per_point, 3.125);
        let upright = PrintOptions {
            paper: Paper::A3,
            landscape: false,
            dpi: 150,
            ..PrintOptions::default()
        };
        assert_eq!(upright.sheet([10.0, 10.0]).size_px, [1754, 2480]);
    }

    #[test]
    fn without_paper_the_view_keeps_its_shape() {
        let options =
            PrintOptions { paper: Paper::Pixels, width_px: 1600, ..PrintOptions::default() };
        let sheet = options.sheet([800.0, 500.0]);
        assert_eq!(sheet.size_px, [1600, 1000]);
        assert_eq!(sheet.pixels_per_point, 2.0);
    }
}

//! Writes the HTML page of a change: figures and a picture.

use super::record::ChangeRecord;
use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use bathyscope_bottom::presentation::colours::{difference_colour, difference_reach_m};
use bathyscope_bottom::presentation::page::{Template, TemplateFault, Value, context, fill};
use image::{ExtendedColorType, ImageEncoder as _, codecs::png::PngEncoder};

/// Longest side of the picture, pixels.
const MOST_PIXELS: usize = 900;
/// Approximate side of a picture with fewer cells, which is shown with larger squares, pixels.
const SHOWN_PIXELS: u32 = 640;

const TEMPLATE: Template<'static> = ("change.html", include_str!("templates/change.html"));

/// Picture for the page: the change of each pixel, metres, row by row.
pub(super) struct ChangeImage {
    rise_m: Vec<f32>,
    size: [usize; 2],
}

/// Makes a picture of the changes of the cells; joins cells where there are more than
/// [`MOST_PIXELS`].
pub(super) fn picture(rise_m: &[f32], [columns, rows]: [usize; 2]) -> Box<ChangeImage> {
    let joined = columns.max(rows).div_ceil(MOST_PIXELS).max(1);
    let size = [columns.div_ceil(joined), rows.div_ceil(joined)];
    let mean = |pixel: usize| {
        let (left, top) = (pixel % size[0] * joined, pixel / size[0] * joined);
        let cells = (top..(top + joined).min(rows)).flat_map(|row| {
            (left..(left + joined).min(columns)).map(move |column| row * columns + column)
        });
        let known = cells.map(|cell| rise_m[cell]).filter(|rise| !rise.is_nan());
        let (sum, count) =
            known.fold((0.0, 0.0), |(sum, count), rise| (sum + rise, count + 1.0_f32));
        // The mean of no cells is NaN.
        sum / count
    };
    Box::new(ChangeImage { rise_m: (0..size[0] * size[1]).map(mean).collect(), size })
}

/// Returns the page as HTML.
pub(super) fn of(
    record: &ChangeRecord,
    shown: Option<&ChangeImage>,
) -> Result<String, TemplateFault> {
    let reach_m = difference_reach_m(record.reach_m);
    let values = context! {
        newer => &record.newer,
        older => &record.older,
        rows => record.rows(),
        figure => shown.and_then(|shown| figure(shown, reach_m)),
    };
    fill(&[TEMPLATE], values)
}

/// Returns the picture with its colours; `None` where it cannot be encoded.
fn figure(shown: &ChangeImage, reach_m: f64) -> Option<Value> {
    let share = |rise_m: f32| (0.5 + 0.5 * f64::from(rise_m) / reach_m) as f32;
    let pixels = shown.rise_m.iter().flat_map(|&rise_m| {
        if rise_m.is_nan() {
            [0; 4]
        } else {
            let [red, green, blue] = difference_colour(share(rise_m));
            [red, green, blue, 255]
        }
    });
    let pixels: Vec<u8> = pixels.collect();
    let [width, height] = shown.size.map(|count| count as u32);
    let mut png = Vec::new();
    PngEncoder::new(&mut png).write_image(&pixels, width, height, ExtendedColorType::Rgba8).ok()?;
    let times = (SHOWN_PIXELS / width.max(height).max(1)).max(1);
    let colours = (0..=8).map(|step| {
        let [red, green, blue] = difference_colour(step as f32 / 8.0);
        format!("#{red:02x}{green:02x}{blue:02x}")
    });
    Some(context! {
        colours => colours.collect::<Vec<String>>().join(","),
        least_m => format!("{:+}", -reach_m),
        most_m => format!("{reach_m:+}"),
        width => width * times,
        height => height * times,
        png => STANDARD.encode(png),
    })
}

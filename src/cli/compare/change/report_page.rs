//! Writes the HTML page of a change: figures and a picture.

use super::record::ChangeRecord;
use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use bathyscope_bottom::presentation::colours::{difference_colour, difference_reach_m};
use bathyscope_log::support::printable::xml;
use image::{ExtendedColorType, ImageEncoder as _, codecs::png::PngEncoder};

/// Longest side of the picture, pixels.
const MOST_PIXELS: usize = 900;
/// Approximate side of a picture with fewer cells, which is shown with larger squares, pixels.
const SHOWN_PIXELS: u32 = 640;

const STYLE: &str = "body{font:15px/1.45 system-ui,sans-serif;color:#1b1b1b;margin:24px auto;max-width:960px;padding:0 16px}\
table{border-collapse:collapse}td,th{border:1px solid #d0d0d0;padding:3px 10px;text-align:left;font-weight:normal}\
img{max-width:100%;height:auto;image-rendering:pixelated;border:1px solid #d0d0d0}#bar{height:14px;max-width:480px;border:1px solid #888888}\
#ends{display:flex;justify-content:space-between;max-width:480px;font-size:13px}";

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
pub(super) fn of(record: &ChangeRecord, shown: Option<&ChangeImage>) -> String {
    let rows = record.rows().into_iter();
    let rows: String = rows
        .map(|(name, text)| format!("<tr><th>{name}</th><td>{}</td></tr>\n", xml(&text)))
        .collect();
    let reach_m = difference_reach_m(record.reach_m);
    let figure = shown.map_or_else(String::new, |shown| figure(shown, reach_m));
    format!(
        "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><meta name=\"viewport\" content=\"width=device-width\"><title>Change of the bottom</title><style>{STYLE}</style></head><body>\n\
         <h1>Change of the bottom</h1>\n<p>{} minus {}; positive where the bottom rose. Fill, cut and net are of the places where the change passes the level of \
         detection, each out to where it disappears in noise; the intervals hold the volume with 95 %.</p>\n<table>\n{rows}</table>\n{figure}</body></html>\n",
        xml(&record.newer),
        xml(&record.older),
    )
}

fn figure(shown: &ChangeImage, reach_m: f64) -> String {
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
    let drawn =
        PngEncoder::new(&mut png).write_image(&pixels, width, height, ExtendedColorType::Rgba8);
    if drawn.is_err() {
        return String::new();
    }
    let times = (SHOWN_PIXELS / width.max(height).max(1)).max(1);
    let (wide, tall) = (width * times, height * times);
    let steps = (0..=8).map(|step| {
        let [red, green, blue] = difference_colour(step as f32 / 8.0);
        format!("#{red:02x}{green:02x}{blue:02x}")
    });
    format!(
        "<h2>Where</h2>\n<div id=\"bar\" style=\"background:linear-gradient(90deg,{})\"></div><div id=\"ends\"><span>{:+} m</span><span>0</span><span>{:+} m</span></div>\n\
         <p><img alt=\"Map of the change: blue where the bottom sank, red where it rose\" width=\"{wide}\" height=\"{tall}\" src=\"data:image/png;base64,{}\"></p>\n",
        steps.collect::<Vec<String>>().join(","),
        -reach_m,
        reach_m,
        STANDARD.encode(png)
    )
}

//! Curves of shares, drawn as SVG.

use crate::export::xml;
use std::fmt::Write as _;

/// Side of the area that curves lie in, pixels.
const SIDE: f64 = 360.0;
/// Left and lower margin, pixels.
const MARGIN: f64 = 48.0;
/// Room for the key on the right, pixels.
const KEY: f64 = 150.0;
/// Points nearer to each other than this share are one.
const NEAR: f64 = 1e-3;
/// Colours by Okabe and Ito, which colour-blind readers tell apart; the first is for all classes together.
const COLOURS: [&str; 8] = [
    "#000000", "#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#8a8a00",
];

/// One curve.
pub struct Curve {
    /// What it is, for the key.
    pub name: String,
    /// Across and up, each a share; points that are not numbers are left out.
    pub points: Vec<[f64; 2]>,
}

/// A picture of curves over the unit square.
pub struct Plot<'a> {
    /// What grows to the right.
    pub across: &'a str,
    /// What grows upwards.
    pub up: &'a str,
    /// The curves; the first is drawn strongest.
    pub curves: Vec<Curve>,
    /// A place of interest, with its name.
    pub mark: Option<([f64; 2], String)>,
    /// An upright line at a share, with its name.
    pub limit: Option<(f64, String)>,
}

fn x(share: f64) -> f64 {
    MARGIN + share * SIDE
}

fn y(share: f64) -> f64 {
    10.0 + (1.0 - share) * SIDE
}

/// The plot as an `svg` element.
pub fn svg(plot: &Plot<'_>) -> String {
    let (width, height) = (MARGIN + SIDE + KEY, SIDE + 10.0 + MARGIN);
    let mut out = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" viewBox=\"0 0 {width} {height}\" font-family=\"sans-serif\" font-size=\"12\">\n<rect width=\"{width}\" height=\"{height}\" fill=\"#ffffff\"/>\n"
    );
    // Writing to a string cannot fail.
    axes(plot, &mut out).ok();
    for (index, curve) in plot.curves.iter().enumerate() {
        draw(curve, index, &mut out).ok();
    }
    marks(plot, &mut out).ok();
    out.push_str("</svg>\n");
    out
}

type Written = Result<(), std::fmt::Error>;

fn axes(plot: &Plot<'_>, out: &mut String) -> Written {
    for tick in 0..=5 {
        let share = f64::from(tick) / 5.0;
        let (at_x, at_y) = (x(share), y(share));
        let (left, right, top, bottom) = (x(0.0), x(1.0), y(1.0), y(0.0));
        writeln!(
            out,
            "<path d=\"M{at_x} {top}V{bottom}M{left} {at_y}H{right}\" stroke=\"#dddddd\" fill=\"none\"/>\n<text x=\"{at_x}\" y=\"{}\" text-anchor=\"middle\">{share}</text>\n<text x=\"{}\" y=\"{}\" text-anchor=\"end\">{share}</text>",
            bottom + 16.0,
            left - 6.0,
            at_y + 4.0,
        )?;
    }
    let middle = x(0.5);
    writeln!(
        out,
        "<text x=\"{middle}\" y=\"{}\" text-anchor=\"middle\">{}</text>\n<text transform=\"translate(14 {}) rotate(-90)\" text-anchor=\"middle\">{}</text>",
        y(0.0) + 36.0,
        xml(plot.across),
        y(0.5),
        xml(plot.up),
    )
}

/// The curve, and its line in the key.
fn draw(curve: &Curve, index: usize, out: &mut String) -> Written {
    let colour = COLOURS[index % COLOURS.len()];
    let width = if index == 0 { 2.5 } else { 1.25 };
    let dash = match index / COLOURS.len() {
        0 => "",
        _ => " stroke-dasharray=\"5 3\"",
    };
    let mut path = String::new();
    for [across, up] in thinned(&curve.points) {
        let letter = if path.is_empty() { 'M' } else { 'L' };
        write!(path, "{letter}{:.2} {:.2}", x(across), y(up))?;
    }
    let (key_x, key_y) = (x(1.0) + 12.0, 22.0 + 18.0 * index as f64);
    writeln!(
        out,
        "<path d=\"{path}\" stroke=\"{colour}\" stroke-width=\"{width}\" fill=\"none\"{dash}/>\n<path d=\"M{key_x} {key_y}h18\" stroke=\"{colour}\" stroke-width=\"{width}\"{dash}/>\n<text x=\"{}\" y=\"{}\">{}</text>",
        key_x + 24.0,
        key_y + 4.0,
        xml(&curve.name),
    )
}

fn marks(plot: &Plot<'_>, out: &mut String) -> Written {
    if let Some(([across, up], name)) = &plot.mark
        && across.is_finite()
        && up.is_finite()
    {
        let (at_x, at_y) = (x(*across), y(*up));
        writeln!(
            out,
            "<circle cx=\"{at_x:.2}\" cy=\"{at_y:.2}\" r=\"5\" fill=\"#ffffff\" stroke=\"#000000\" stroke-width=\"2\"><title>{0}</title></circle>\n<text x=\"{1:.2}\" y=\"{2:.2}\" text-anchor=\"end\">{0}</text>",
            xml(name),
            at_x - 9.0,
            at_y + 16.0,
        )?;
    }
    if let Some((share, name)) = &plot.limit {
        let at = x(*share);
        writeln!(
            out,
            "<path d=\"M{at:.2} {}V{}\" stroke=\"#555555\" stroke-dasharray=\"3 3\"/>\n<text x=\"{:.2}\" y=\"{}\">{}</text>",
            y(1.0),
            y(0.0),
            at + 4.0,
            y(0.0) - 6.0,
            xml(name),
        )?;
    }
    Ok(())
}

/// Without points that are no numbers or lie on the one before.
fn thinned(points: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let mut kept: Vec<[f64; 2]> = Vec::new();
    let sound = points
        .iter()
        .filter(|point| point.iter().all(|at| at.is_finite()));
    for (index, &[across, up]) in sound.clone().enumerate() {
        let is_near =
            |last: &[f64; 2]| (last[0] - across).abs() < NEAR && (last[1] - up).abs() < NEAR;
        let is_last = index + 1 == sound.clone().count();
        if is_last || !kept.last().is_some_and(is_near) {
            kept.push([across, up]);
        }
    }
    kept
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn curves_keep_their_ends_and_lose_what_cannot_be_seen() {
        let points: Vec<[f64; 2]> = (0..=100_000)
            .map(|index| [f64::from(index) * 1e-5, 0.5])
            .chain([[f64::NAN, 0.3]])
            .collect();
        let kept = thinned(&points);
        assert!((900..1100).contains(&kept.len()), "{}", kept.len());
        assert_eq!((kept[0], kept.last()), ([0.0, 0.5], Some(&[1.0, 0.5])));
    }

    #[test]
    fn names_from_outside_stay_text() {
        let plot = Plot {
            across: "recall",
            up: "precision",
            curves: vec![Curve {
                name: "<script>".into(),
                points: vec![[0.0, 1.0], [1.0, 0.0]],
            }],
            mark: None,
            limit: None,
        };
        let drawn = svg(&plot);
        assert!(drawn.contains("&lt;script&gt;") && !drawn.contains("<script>"));
        assert!(drawn.contains("M48.00 10.00L408.00 370.00"), "{drawn}");
    }
}

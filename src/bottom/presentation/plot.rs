//! Draws plots of curves over two axes as SVG for pages, and provides the axes for other ways of
//! drawing.

use super::ticks;
use bathyscope_log::support::printable::xml;
use std::fmt::Write as _;

/// Margins for numbers and names, pixels: left, below, above, and right without and with a key.
const LEFT: f64 = 48.0;
const BELOW: f64 = 48.0;
const ABOVE: f64 = 10.0;
const RIGHT: f64 = 36.0;
const KEY: f64 = 150.0;
/// Share of both axes within which points count as one.
const NEAR: f64 = 1e-3;
/// Colours of the curves, by Okabe and Ito, which colour-blind readers can distinguish; the first
/// is the strongest.
const COLOURS: [&str; 8] =
    ["#000000", "#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#8a8a00"];

/// Axis of a plot.
#[derive(Clone, Debug, PartialEq)]
pub struct Axis {
    /// Name of the quantity on the axis.
    pub name: String,
    /// Values at the beginning of the axis, on the left or below, and at its end.
    pub ends: [f64; 2],
    /// Values with a line and a label.
    pub ticks: Vec<(f64, String)>,
}

impl Axis {
    /// Creates an axis with round ticks.
    pub fn new(name: &str, ends: [f64; 2]) -> Self {
        let [from, to] = ends;
        Self { name: name.to_owned(), ends, ticks: ticks::ticks(from.min(to), from.max(to)) }
    }

    /// Returns the place of a value, from 0 at the beginning to 1 at the end; the middle on an axis
    /// without extent.
    pub fn share(&self, value: f64) -> f64 {
        let [from, to] = self.ends;
        if to == from { 0.5 } else { (value - from) / (to - from) }
    }
}

/// Curve of a plot.
#[derive(Clone, Debug, PartialEq)]
pub struct PlotCurve {
    /// Name of the curve in the key.
    pub name: String,
    /// Points, across and up; points that are not finite are left out.
    pub points: Vec<[f64; 2]>,
}

/// Plot of curves.
#[derive(Clone, Debug, PartialEq)]
pub struct Plot {
    /// Description of the plot, for readers who cannot see it.
    pub title: String,
    /// Axis that grows to the right.
    pub across: Axis,
    /// Axis that grows upwards.
    pub up: Axis,
    /// Curves; the first is drawn strongest. A single curve has no key.
    pub curves: Vec<PlotCurve>,
    /// Marked place, with its name.
    pub mark: Option<([f64; 2], String)>,
    /// Value on the across axis with a vertical line, and the name of the line.
    pub limit: Option<(f64, String)>,
}

type WriteResult = Result<(), std::fmt::Error>;

impl Plot {
    /// Returns the plot as an `svg` element whose curves lie in an area of this size, pixels.
    pub fn svg(&self, area: [f64; 2]) -> String {
        let drawing = Drawing { plot: self, area };
        let right = if self.curves.len() > 1 { KEY } else { RIGHT };
        let (width, height) = (LEFT + area[0] + right, ABOVE + area[1] + BELOW);
        let mut out = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" role=\"img\" aria-label=\"{}\" width=\"{width}\" height=\"{height}\" viewBox=\"0 0 {width} {height}\" font-family=\"sans-serif\" font-size=\"11\">\n<rect width=\"{width}\" height=\"{height}\" fill=\"#ffffff\"/>\n",
            xml(&self.title)
        );
        // Writing to a string cannot fail.
        drawing.axes(&mut out).ok();
        for (index, curve) in self.curves.iter().enumerate() {
            drawing.curve(curve, index, &mut out).ok();
        }
        drawing.marks(&mut out).ok();
        out.push_str("</svg>\n");
        out
    }
}

struct Drawing<'a> {
    plot: &'a Plot,
    area: [f64; 2],
}

impl Drawing<'_> {
    fn x(&self, value: f64) -> f64 {
        LEFT + self.plot.across.share(value) * self.area[0]
    }

    fn y(&self, value: f64) -> f64 {
        ABOVE + (1.0 - self.plot.up.share(value)) * self.area[1]
    }

    fn axes(&self, out: &mut String) -> WriteResult {
        let (right, bottom) = (LEFT + self.area[0], ABOVE + self.area[1]);
        for (value, label) in &self.plot.across.ticks {
            let at = self.x(*value);
            writeln!(
                out,
                "<path d=\"M{at:.1} {ABOVE}V{bottom}\" stroke=\"#dddddd\"/><text x=\"{at:.1}\" y=\"{}\" text-anchor=\"middle\">{label}</text>",
                bottom + 16.0
            )?;
        }
        for (value, label) in &self.plot.up.ticks {
            let at = self.y(*value);
            writeln!(
                out,
                "<path d=\"M{LEFT} {at:.1}H{right}\" stroke=\"#dddddd\"/><text x=\"{}\" y=\"{:.1}\" text-anchor=\"end\">{label}</text>",
                LEFT - 6.0,
                at + 4.0
            )?;
        }
        writeln!(
            out,
            "<text x=\"{}\" y=\"{}\" text-anchor=\"middle\">{}</text>\n<text transform=\"translate(14 {}) rotate(-90)\" text-anchor=\"middle\">{}</text>",
            LEFT + 0.5 * self.area[0],
            bottom + 36.0,
            xml(&self.plot.across.name),
            ABOVE + 0.5 * self.area[1],
            xml(&self.plot.up.name),
        )
    }

    /// Writes a curve, and its entry in the key.
    fn curve(&self, curve: &PlotCurve, index: usize, out: &mut String) -> WriteResult {
        let colour = COLOURS[index % COLOURS.len()];
        let width = if index == 0 { 2.5 } else { 1.25 };
        let dash = if index < COLOURS.len() { "" } else { " stroke-dasharray=\"5 3\"" };
        let mut path = String::new();
        for [across, up] in self.thinned(&curve.points) {
            let letter = if path.is_empty() { 'M' } else { 'L' };
            write!(path, "{letter}{:.2} {:.2}", self.x(across), self.y(up))?;
        }
        writeln!(
            out,
            "<path d=\"{path}\" stroke=\"{colour}\" stroke-width=\"{width}\" fill=\"none\"{dash}/>"
        )?;
        if self.plot.curves.len() < 2 {
            return Ok(());
        }
        let (key_x, key_y) = (LEFT + self.area[0] + 12.0, 22.0 + 18.0 * index as f64);
        writeln!(
            out,
            "<path d=\"M{key_x} {key_y}h18\" stroke=\"{colour}\" stroke-width=\"{width}\"{dash}/>\n<text x=\"{}\" y=\"{}\">{}</text>",
            key_x + 24.0,
            key_y + 4.0,
            xml(&curve.name),
        )
    }

    fn marks(&self, out: &mut String) -> WriteResult {
        if let Some(([across, up], name)) = &self.plot.mark
            && across.is_finite()
            && up.is_finite()
        {
            let (x, y) = (self.x(*across), self.y(*up));
            writeln!(
                out,
                "<circle cx=\"{x:.2}\" cy=\"{y:.2}\" r=\"5\" fill=\"#ffffff\" stroke=\"#000000\" stroke-width=\"2\"><title>{0}</title></circle>\n<text x=\"{1:.2}\" y=\"{2:.2}\" text-anchor=\"end\">{0}</text>",
                xml(name),
                x - 9.0,
                y + 16.0,
            )?;
        }
        if let Some((value, name)) = &self.plot.limit {
            let (x, bottom) = (self.x(*value), ABOVE + self.area[1]);
            writeln!(
                out,
                "<path d=\"M{x:.2} {ABOVE}V{bottom}\" stroke=\"#555555\" stroke-dasharray=\"3 3\"/>\n<text x=\"{:.2}\" y=\"{}\">{}</text>",
                x + 4.0,
                bottom - 6.0,
                xml(name),
            )?;
        }
        Ok(())
    }

    /// Returns the points without those that are not finite or are at the same place as the one
    /// before; the last finite point is kept.
    fn thinned(&self, points: &[[f64; 2]]) -> Vec<[f64; 2]> {
        let Plot { across, up, .. } = self.plot;
        let mut kept: Vec<[f64; 2]> = Vec::new();
        let mut sound =
            points.iter().filter(|point| point.iter().all(|at| at.is_finite())).peekable();
        while let Some(&[x, y]) = sound.next() {
            let is_near = |last: &[f64; 2]| {
                (across.share(last[0]) - across.share(x)).abs() < NEAR
                    && (up.share(last[1]) - up.share(y)).abs() < NEAR
            };
            if sound.peek().is_none() || !kept.last().is_some_and(is_near) {
                kept.push([x, y]);
            }
        }
        kept
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plot(up: [f64; 2], curves: Vec<PlotCurve>) -> Plot {
        Plot {
            title: "a plot".to_owned(),
            across: Axis::new("recall", [0.0, 1.0]),
            up: Axis::new("precision", up),
            curves,
            mark: None,
            limit: None,
        }
    }

    fn curve(name: &str, points: &[[f64; 2]]) -> PlotCurve {
        PlotCurve { name: name.to_owned(), points: points.to_vec() }
    }

    #[test]
    fn curves_keep_their_ends_and_lose_what_cannot_be_seen() {
        let points: Vec<[f64; 2]> = (0..=100_000)
            .map(|index| [f64::from(index) * 1e-5, 0.5])
            .chain([[f64::NAN, 0.3]])
            .collect();
        let plot = plot([0.0, 1.0], vec![]);
        let drawing = Drawing { plot: &plot, area: [360.0, 360.0] };
        let kept = drawing.thinned(&points);
        assert!((900..1100).contains(&kept.len()), "{}", kept.len());
        assert_eq!((kept[0], kept.last()), ([0.0, 0.5], Some(&[1.0, 0.5])));
    }

    #[test]
    fn names_from_outside_stay_text_and_a_single_curve_has_no_key() {
        let falling = [[0.0, 1.0], [1.0, 0.0]];
        let two = vec![curve("<script>", &falling), curve("other", &falling)];
        let drawn = plot([0.0, 1.0], two).svg([360.0, 360.0]);
        assert!(drawn.contains("&lt;script&gt;") && !drawn.contains("<script>"));
        assert!(drawn.contains("M48.00 10.00L408.00 370.00"), "{drawn}");
        let single = plot([0.0, 1.0], vec![curve("<script>", &falling)]);
        assert!(!single.svg([360.0, 360.0]).contains("script"));
    }

    #[test]
    fn an_axis_may_run_downwards() {
        let deeper = plot([8.0, 2.0], vec![curve("depth", &[[0.0, 2.0], [1.0, 8.0]])]);
        let drawn = deeper.svg([100.0, 60.0]);
        assert!(drawn.contains("M48.00 10.00L148.00 70.00"), "{drawn}");
        // The grid line of depth 2 is at the top.
        assert!(drawn.contains("M48 10.0H148"), "{drawn}");
        assert_eq!(Axis::new("level", [3.0, 3.0]).share(3.0), 0.5);
    }
}

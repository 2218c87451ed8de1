//! Step 3: the point cloud.

use super::parts::{self, Choice, Knob, Section, choice, fact, knob, section};
use crate::app::Figures;
use crate::cloud::{Geometry, Residuals};
use crate::pipeline::{Products, Stage};
use crate::survey::{HeadingSource, Projection};
use crate::ui::{ViewContext, text};
use egui::Ui;

const GEOMETRIES: &[Choice<Geometry>] = &[
    (
        Geometry::Slope,
        "slope",
        "The first return lies where the bottom is square to the beam.",
    ),
    (
        Geometry::Nadir,
        "nadir",
        "z = r, y = 0: the first return is straight below.",
    ),
    (
        Geometry::SelfConsistent,
        "self-consistent",
        "As published, with PPD measured so that the depth at the flat spot is reproduced.",
    ),
    (
        Geometry::Published,
        "published",
        "z = r cos(α2), y = r sin(α2), as printed in the paper.",
    ),
];

const HEADINGS: &[Choice<HeadingSource>] = &[
    (
        HeadingSource::TrackFit,
        "track fit",
        "A line fitted to the fixes in a time window around the ping.",
    ),
    (
        HeadingSource::Cog,
        "recorded course",
        "Course over ground as the recorder stored it.",
    ),
    (
        HeadingSource::Compass,
        "compass",
        "The recorded compass heading, where the boat had one.",
    ),
    (
        HeadingSource::Steps,
        "fix to fix (published)",
        "h = p(i+1) − p(i): most steps are zero, and those pings give no point.",
    ),
];

const PROJECTIONS: &[Choice<Projection>] = &[
    (
        Projection::Enu,
        "local metres",
        "Metres on the ground, east and north of the first fix.",
    ),
    (
        Projection::Mercator,
        "Mercator (published)",
        "Pseudo-Mercator metres: stretched by 1 / cos(latitude).",
    ),
];

/// How the side-scan points lie over the soundings of their own pings: named alike wherever it stands.
pub(super) const SAME_PING: &str = "At same ping";
/// What it is.
pub(super) const SAME_PING_HINT: &str = "Elevation of side-scan points minus that of the sounding at the same ping, over all points that are kept: median, where above 0 is shallower than the sounding, and 95th percentile of the absolute difference. On a slope part of it is real.";

/// Its figures.
pub(super) fn same_ping(residuals: &Residuals) -> String {
    format!(
        "{} · p95 {}",
        text::signed_difference(residuals.median_m),
        text::difference(residuals.p95_m)
    )
}

/// Draws the section.
pub fn ui(ui: &mut Ui, context: &mut ViewContext<'_>) {
    let heading = Section {
        number: Some(3),
        title: "Cloud",
        stage: Some(Stage::Cloud),
    };
    section(ui, context, &heading, |ui, context| {
        if let (Some(products), Some(figures)) =
            (&context.app.log.products, &context.app.log.figures)
        {
            found(ui, products, figures);
        }
        controls(ui, context);
    });
}

fn found(ui: &mut Ui, products: &Products, figures: &Figures) {
    fact(
        ui,
        "Points",
        "All points of the cloud, and how many of them are first returns beside the track; the rest are soundings under the boat.",
        format!(
            "{} · {} beside",
            text::count(figures.points),
            text::count(figures.outliers.side_scan)
        ),
    );
    let zero = products.navigation.zero_heading;
    let share = 100.0 * zero as f64 / products.navigation.pings.len().max(1) as f64;
    fact(
        ui,
        "No heading",
        "Pings without a heading give no side-scan point.",
        format!("{} ({share:.1} %)", text::plural(zero, "ping", "pings")),
    );
    if let Some(residuals) = figures.residuals {
        fact(ui, SAME_PING, SAME_PING_HINT, same_ping(&residuals));
    }
}

fn controls(ui: &mut Ui, context: &mut ViewContext<'_>) {
    let settings = context.app.log.settings.clone();
    choice(
        ui,
        context,
        "Geometry",
        "Where a first return is placed.",
        GEOMETRIES,
        settings.cloud.geometry,
        |settings, geometry| settings.cloud.geometry = geometry,
    );
    if matches!(
        settings.cloud.geometry,
        Geometry::Published | Geometry::SelfConsistent
    ) {
        let angle = Knob {
            name: "Angle α2",
            undo: "angle",
            hint: "α2 of the paper: angle of the first return from the vertical; 16 degrees in the published code.",
            range: 0.0..=60.0,
            step: 0.5,
            decimals: 1,
            suffix: "°",
        };
        knob(
            ui,
            context,
            angle,
            settings.cloud.alpha2_deg,
            |settings, value| {
                settings.cloud.alpha2_deg = value;
            },
        );
    }
    if settings.cloud.geometry == Geometry::Published {
        parts::warning(ui, context, &published_depth(settings.cloud.alpha2_deg));
    }
    choice(
        ui,
        context,
        "Heading",
        "Where the heading of a ping comes from.",
        HEADINGS,
        settings.heading.source,
        |settings, source| settings.heading.source = source,
    );
    if settings.heading.source == HeadingSource::TrackFit {
        let window = Knob {
            name: "Window",
            undo: "heading window",
            hint: "Width of the time window that the heading line is fitted over.",
            range: 0.5..=30.0,
            step: 0.5,
            decimals: 1,
            suffix: " s",
        };
        knob(
            ui,
            context,
            window,
            settings.heading.window_s,
            |settings, value| {
                settings.heading.window_s = value;
            },
        );
    }
    choice(
        ui,
        context,
        "Plane",
        "The plane that the cloud is built in.",
        PROJECTIONS,
        settings.projection,
        |settings, projection| settings.projection = projection,
    );
    if settings.projection == Projection::Mercator {
        parts::remark(ui, "Mercator metres are longer than ground metres.");
    }
}

/// What the printed equations make of the depth that they were calibrated on: at the calibration spot r = d, and z = r cos(α2).
fn published_depth(alpha2_deg: f64) -> String {
    let percent = 100.0 * (alpha2_deg.to_radians().cos() - 1.0);
    format!(
        "Published formula: the depth d at the calibration spot comes out as d cos(α2), {percent:+.2} %."
    )
}

//! Paints the points of the cloud from above: the places on the bottom where depths were measured.

use super::dots::{Dot, Dots};
use super::tiles::TilePainter;
use crate::app::{SideColours, SwathShown, ThemeChoice, ViewOptions, VisibleLog};
use crate::ui::theme;
use bathyscope_bottom::cloud::{CloudPoint, PointClass, PointCloud, PointSource};
use bathyscope_log::support::progress::Progress;
use bathyscope_log::survey::Side;
use bathyscope_products::pipeline::Same;
use std::sync::Arc;

/// Number of points between two checks for cancellation.
const CHECK: usize = 1 << 14;

/// Inputs of the point layer: the points and their colours.
#[derive(Clone, PartialEq)]
pub(super) struct PointKey {
    logs: Vec<(Same<PointCloud>, Same<Vec<PointClass>>)>,
    side_colours: SideColours,
    theme: ThemeChoice,
    swath: SwathShown,
}

impl PointKey {
    /// Creates the key of the points of these logs with their colours.
    pub(super) fn of(logs: &[VisibleLog], options: &ViewOptions) -> Self {
        let key = |shown: &VisibleLog| {
            let products = &shown.log.products;
            (Same(products.cloud.clone()), Same(products.classes.clone()))
        };
        Self {
            logs: logs.iter().map(key).collect(),
            side_colours: options.side_colours,
            theme: options.theme,
            swath: options.swath,
        }
    }
}

/// Returns a note for the legend; `has_swath` is true if there are points of a swath.
pub(super) fn note(options: &ViewOptions, has_swath: bool) -> String {
    let sides = match options.side_colours {
        SideColours::Paper => "points: blue port,\nred starboard",
        SideColours::Maritime => "points: red port,\ngreen starboard",
    };
    if has_swath && options.swath.0 { format!("{sides},\nviolet swath") } else { sides.to_owned() }
}

/// Returns the tiles of all kept points; inner `None` if there is no point, outer `None` when
/// cancelled.
pub(super) fn source(
    logs: &[VisibleLog],
    options: &ViewOptions,
    progress: &Progress,
) -> Option<Option<Arc<dyn TilePainter>>> {
    let kept = logs.iter().flat_map(|shown| shown.log.kept_points());
    let is_shown = |point: &&CloudPoint| options.swath.0 || point.source != PointSource::Swath;
    let kept = kept.filter(is_shown);
    let mut dots = Vec::new();
    for (index, point) in kept.enumerate() {
        if index % CHECK == 0 {
            progress.check().ok()?;
        }
        dots.push(Dot { east_m: point.east_m, north_m: point.north_m, colour: source_slot(point) });
    }
    let colours = vec![
        theme::down_scan_colour(options),
        theme::side_colour(options, Side::Port),
        theme::side_colour(options, Side::Starboard),
        theme::SWATH_COLOUR,
    ];
    let dots = Dots::new(dots, colours);
    Some(dots.map(|dots| Arc::new(dots) as Arc<dyn TilePainter>))
}

/// Returns the index of a point's colour.
fn source_slot(point: &CloudPoint) -> u8 {
    match point.source {
        PointSource::DownScan => 0,
        PointSource::Port => 1,
        PointSource::Starboard => 2,
        PointSource::Swath => 3,
    }
}

//! Fits shapes to objects: a solid on the bottom, whose kind, size and pose are chosen so that its
//! predicted echo and shadow match what all passes recorded of the object.
//!
//! In: the levels that passes recorded around an object. Out: a solid with its pose, and the share
//! of the picture that it explains.
//!
//! A shape is a hypothesis: its far side was never insonified. If no kind explains enough of the
//! picture, there is no shape, and the reason is returned.

mod fit;
mod levels;
mod predict;
mod problem;
mod ray;
mod solid;

pub use levels::BoxLevels;
pub use predict::{PosedSolid, ShapeOnPing};
pub use solid::{ShapeKind, Solid};

use super::Target;
use fit::{InitialGuess, ShapeFit, fits};

/// A solid that explains the recorded levels of an object.
#[derive(Clone, Debug, PartialEq)]
pub struct FittedShape {
    /// The solid as placed in the look that shows it best.
    pub posed: PosedSolid,
    /// Elevation of the bottom at the box of that look, metres: its depth, with the sign of an
    /// elevation.
    pub bottom_z_m: f64,
    /// Place of the solid on the pings of each box, in the order of the boxes; empty for a box
    /// without a look.
    pub on_pings: Vec<Vec<ShapeOnPing>>,
    /// Share of the difference between the looks and bare bottom, beyond speckle, that the solid
    /// explains; at 1, only speckle is left.
    pub explained: f64,
    /// Other kinds that explain nearly as much, the best first.
    pub rivals: Vec<ShapeKind>,
}

/// Reason why an object has no shape.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum ShapeError {
    /// No box has a look to fit a shape to.
    #[error("no shape: no picture of it with a place and bare bottom beside it")]
    NoLook,
    /// The looks differ too little from bare bottom.
    #[error("no shape: its picture differs too little from the bottom beside it")]
    Faint,
    /// No kind explains enough of the looks.
    #[error("no shape: the best, a {}, explains {:.0} % of its picture", kind.name(), 100.0 * explained)]
    Unexplained {
        /// The kind that explains most.
        kind: ShapeKind,
        /// Share that it explains, as [`FittedShape::explained`].
        explained: f64,
    },
    /// The best solid is larger than its picture, so part of it was not compared with any level.
    #[error("no shape: the best, a {} of {length_m:.1} m, is larger than its picture", kind.name())]
    LargerThanPicture {
        /// The kind that explains most.
        kind: ShapeKind,
        /// Length of the solid, metres.
        length_m: f64,
    },
}

/// Least share that a shape must explain ([`FittedShape::explained`]).
const LEAST_EXPLAINED: f64 = 0.35;
/// Least excess of the squares of a look over those of speckle, as a share of the latter; with
/// less, the look is too faint to distinguish shapes.
const LEAST_CONTRAST: f64 = 0.15;
/// Greatest difference between the gain of the best kind and that of a rival, as a share of the
/// former.
const RIVAL: f64 = 0.07;

/// Greatest number of looks that are fitted together, those that show the object best: more would
/// take time and give no more information.
const MOST_LOOKS: usize = 4;

/// Fits a shape to an object, from its boxes: each with its position and its look, if it has one.
///
/// # Errors
/// When no shape fits: see [`ShapeError`].
pub fn fit_shape(sightings: &[(&Target, Option<BoxLevels>)]) -> Result<FittedShape, ShapeError> {
    let mut best: Vec<(usize, &Target, &BoxLevels)> = (sightings.iter().enumerate())
        .filter_map(|(index, (target, look))| Some((index, *target, look.as_ref()?)))
        .collect();
    best.sort_by(|(.., a), (.., b)| b.contrast().total_cmp(&a.contrast()));
    best.truncate(MOST_LOOKS);
    if best.is_empty() {
        return Err(ShapeError::NoLook);
    }
    best.retain(|(.., look)| look.contrast() >= LEAST_CONTRAST);
    let Some((_, target, _)) = best.first() else {
        return Err(ShapeError::Faint);
    };
    let starts = best.iter().map(|(_, target, look)| InitialGuess::of(target, look));
    let starts: Vec<InitialGuess> = starts.collect();
    let looks: Vec<BoxLevels> = best.iter().map(|(.., look)| (*look).clone()).collect();
    let fits = fits(&looks, &starts);
    let bare: f64 = looks.iter().map(BoxLevels::squares).sum();
    let speckle: f64 = looks.iter().map(BoxLevels::speckle_squares).sum();
    let gained = |fit: &ShapeFit| bare - fit.cost;
    let Some(fitted) = fits.first() else {
        return Err(ShapeError::Faint);
    };
    let explained = gained(fitted) / (bare - speckle);
    if explained < LEAST_EXPLAINED {
        return Err(ShapeError::Unexplained { kind: fitted.kind, explained: explained.max(0.0) });
    }
    if !is_within(&fitted.posed[0], &looks[0]) {
        let length_m = fitted.posed[0].solid.length_m;
        return Err(ShapeError::LargerThanPicture { kind: fitted.kind, length_m });
    }
    let is_rival = |other: &&ShapeFit| gained(other) > (1.0 - RIVAL) * gained(fitted);
    let rivals = fits.iter().skip(1).take_while(is_rival);
    let on_pings = |(index, (target, look)): (usize, &(&Target, Option<BoxLevels>))| {
        let Some(look) = look else {
            return Vec::new();
        };
        let fitted_to = best.iter().position(|(fitted_to, ..)| *fitted_to == index);
        let posed = match fitted_to {
            Some(at) => fitted.posed[at],
            None => fitted.placed_in(look, &InitialGuess::of(target, look)),
        };
        predict::on_pings(look, &posed)
    };
    Ok(FittedShape {
        posed: fitted.posed[0],
        bottom_z_m: -target.depth_m,
        on_pings: sightings.iter().enumerate().map(on_pings).collect(),
        explained: explained.min(1.0),
        rivals: rivals.map(|rival| rival.kind).collect(),
    })
}

/// Returns true if a solid is no larger than the picture along the track and across it. The outline
/// is approximated by an ellipse.
fn is_within(posed: &PosedSolid, look: &BoxLevels) -> bool {
    let outward = look.pings.first().map_or([0.0; 2], |ping| ping.outward);
    let (sin, cos) = posed.heading_rad.sin_cos();
    let across = sin * outward[0] + cos * outward[1];
    let along = cos * outward[0] - sin * outward[1];
    let Solid { length_m, width_m, .. } = posed.solid;
    let extent_m = |by_length: f64, by_width: f64| (by_length * length_m).hypot(by_width * width_m);
    extent_m(along, across) <= look.along_m() && extent_m(across, along) <= look.across_m()
}

#[cfg(test)]
mod tests {
    use super::levels::PingLevels;
    use super::*;

    #[test]
    fn a_solid_that_reaches_beyond_its_picture_is_none_of_it() {
        // The picture covers 2 m along a track to the north, and 4 to 7.4 m to the east of it.
        let ping = |ping: usize| PingLevels {
            ping,
            boat_m: [0.0, 0.1 * ping as f64],
            outward: [1.0, 0.0],
            levels: vec![0.0; 60],
        };
        let look = BoxLevels::of_pings((0..20).map(ping).collect(), 0.1, [5.0, 0.05]);
        let is_within = |[length_m, width_m]: [f64; 2], heading_deg: f64| {
            let solid =
                Solid { kind: ShapeKind::Hull, length_m, width_m, height_m: 0.5, list: 0.0 };
            let heading_rad = f64::to_radians(heading_deg);
            super::is_within(&PosedSolid { solid, east_m: 5.5, north_m: 1.0, heading_rad }, &look)
        };
        assert!(is_within([1.8, 0.8], 0.0) && is_within([1.8, 0.8], 60.0));
        // Across the track there is more room than along it.
        assert!(is_within([3.2, 0.8], 90.0) && !is_within([3.2, 0.8], 0.0));
        // A boulder of the river that was once fitted as a hull.
        for heading_deg in [0.0, 45.0, 90.0, 200.0] {
            assert!(!is_within([8.38, 1.87], heading_deg));
        }
    }
}

//! Shapes of objects: a solid on the bottom, fitted in kind, size and pose so that its predicted
//! echo and shadow lie over what all passes recorded of the object.
//!
//! In: the levels that passes recorded about an object. Out: a solid with its pose, and how much of
//! the picture it explains.
//!
//! A shape is a hypothesis: what it says of the far side was never insonified. Where no kind
//! explains most of what the picture shows, there is none, and the reason is said.

mod fit;
mod initial_guess;
mod levels;
mod predict;
mod problem;
mod ray;
mod search;
mod solid;

pub use levels::BoxLevels;
pub use predict::{PosedSolid, ShapeOnPing};
pub use solid::ShapeKind;
pub use solid::Solid;

use super::Target;
use fit::{ShapeFit, fits};
use initial_guess::InitialGuess;

/// A solid that explains what was recorded of an object.
#[derive(Clone, Debug, PartialEq)]
pub struct FittedShape {
    /// The solid as the pass places it that shows it best.
    pub posed: PosedSolid,
    /// Elevation of the bottom there, metres: the depth of that box, upward.
    pub bottom_z_m: f64,
    /// Place of the solid on the pings of each box, in their order; empty for a box without a look.
    pub on_pings: Vec<Vec<ShapeOnPing>>,
    /// Share of what the looks differ from bare bottom, beyond speckle, that it explains; 1 leaves
    /// nothing but speckle.
    pub explained: f64,
    /// Kinds that explain nearly as much, the better first.
    pub rivals: Vec<ShapeKind>,
}

/// Reason why an object has no shape.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum ShapeError {
    /// There is no picture to fit it to.
    #[error("no shape: no picture of it with a place and bare bottom beside it")]
    NoLook,
    /// The box has no more in it than the bottom beside it.
    #[error("no shape: its picture differs too little from the bottom beside it")]
    Faint,
    /// No kind explains enough.
    #[error("no shape: the best, a {}, explains {:.0} % of its picture", kind.name(), 100.0 * explained)]
    Unexplained {
        /// The kind that explains most.
        kind: ShapeKind,
        /// Share that it explains, as [`FittedShape::explained`].
        explained: f64,
    },
    /// The best reaches beyond the picture, where it was compared with nothing.
    #[error("no shape: the best, a {} of {length_m:.1} m, is larger than its picture", kind.name())]
    LargerThanPicture {
        /// The kind that explains most.
        kind: ShapeKind,
        /// Its length, metres.
        length_m: f64,
    },
}

/// Share that a shape has to explain.
const LEAST_EXPLAINED: f64 = 0.35;
/// Least excess of the squares of a look over those of speckle, as a share of the latter; with less
/// it is too faint to distinguish shapes.
const LEAST_CONTRAST: f64 = 0.15;
/// A kind that leaves no more than so much of what the best explains is a rival.
const RIVAL: f64 = 0.07;

/// Looks that are fitted together at most, those that show the object best: more cost time and tell
/// no more.
const MOST_LOOKS: usize = 4;

/// The shape of an object by the boxes that show it: each with its place and its look, where it has
/// one.
///
/// # Errors
/// Why it has none.
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

/// True where a solid is no larger than the picture along the track and across it. Its outline is
/// taken for an ellipse.
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
        // 2 m along a track to the north, and 4 to 7.4 m to the east of it.
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
        // Outward there is more room than along the track.
        assert!(is_within([3.2, 0.8], 90.0) && !is_within([3.2, 0.8], 0.0));
        // The boulder of the river that was called a hull.
        for heading_deg in [0.0, 45.0, 90.0, 200.0] {
            assert!(!is_within([8.38, 1.87], heading_deg));
        }
    }
}

//! Finds the reference of each measured point.

use crate::bathymetry::{Between, Node, Tin};
use crate::nearest::Nearest;
use bathyscope_log::support::progress::{Cancelled, Progress};
use rayon::prelude::*;

/// Method that finds the reference of a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Matching {
    /// The nearest reference point, seen from above, within a radius in metres.
    Nearest {
        /// The radius, inclusive, metres.
        radius_m: f64,
    },
    /// The triangulated surface of the reference points at the place of the point.
    Surface {
        /// The surface has no triangles between points farther apart than twice this
        /// ([`Tin::with_max_gap`]), metres.
        max_gap_m: f64,
    },
}

impl Matching {
    /// Returns the method in words.
    pub fn in_words(self) -> String {
        match self {
            Self::Nearest { radius_m } => format!("nearest point within {radius_m} m"),
            Self::Surface { max_gap_m } => format!("triangulated surface, gap {max_gap_m} m"),
        }
    }
}

/// A measured point and its reference.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Match {
    /// Index of the measured point.
    pub measured: usize,
    /// Elevation of the reference there, metres.
    pub reference_z_m: f64,
    /// Measured minus reference elevation, metres: up is positive.
    pub difference_m: f64,
}

/// Number of points that a worker processes between two checks for cancellation.
const CHUNK: usize = 1024;

/// Finds the reference of each measured point, in the order of the points; points without a
/// reference and points that are not finite are left out. Points are east, north and elevation in
/// metres, all in one plane.
pub fn match_points(
    measured: &[[f64; 3]],
    reference: &[[f64; 3]],
    matching: Matching,
    progress: &Progress,
) -> Result<Vec<Match>, Cancelled> {
    ReferencePoints::new(reference.iter().copied(), matching).matches(
        measured,
        |point| *point,
        progress,
    )
}

/// Reference points, prepared for comparison with several measurements.
pub struct ReferencePoints(Prepared);

enum Prepared {
    Nearest(NearPoints),
    Surface(Tin),
    /// No points, or points that span no surface.
    Nothing,
}

impl ReferencePoints {
    /// Prepares reference points as east, north, elevation, metres; points that are not finite are
    /// ignored.
    pub fn new(points: impl Iterator<Item = [f64; 3]> + Clone, matching: Matching) -> Self {
        let points = points.filter(|point| point.iter().all(|value| value.is_finite()));
        let prepared = match matching {
            Matching::Nearest { radius_m } => {
                NearPoints::new(points.collect(), radius_m).map(Prepared::Nearest)
            }
            Matching::Surface { max_gap_m } => {
                triangulated(points, max_gap_m).map(Prepared::Surface)
            }
        };
        Self(prepared.unwrap_or(Prepared::Nothing))
    }

    /// Finds the reference of each measured item as [`match_points`] does; `place` returns its
    /// east, north and elevation.
    pub fn matches<T: Sync>(
        &self,
        measured: &[T],
        place: impl Fn(&T) -> [f64; 3] + Sync,
        progress: &Progress,
    ) -> Result<Vec<Match>, Cancelled> {
        match &self.0 {
            Prepared::Nearest(nearest) => each(measured, place, || |at| nearest.at(at), progress),
            Prepared::Surface(tin) => {
                let sampler = || {
                    let mut sampler = tin.sampler(Between::Linear);
                    move |place| {
                        let nodes = sampler.nodes_at(place)?;
                        Some(-nodes.map(|(node, share)| share * node.depth_m).sum::<f64>())
                    }
                };
                each(measured, place, sampler, progress)
            }
            Prepared::Nothing => Ok(Vec::new()),
        }
    }
}

/// Finds the reference elevation at every measured place; each chunk of places has its own sampler.
fn each<T: Sync, R: FnMut([f64; 2]) -> Option<f64>>(
    measured: &[T],
    place: impl Fn(&T) -> [f64; 3] + Sync,
    reference: impl Fn() -> R + Sync,
    progress: &Progress,
) -> Result<Vec<Match>, Cancelled> {
    progress.start(measured.len() as u64);
    // One number per point, not a list per chunk: a log has more than a million points.
    let mut references_z_m = vec![f64::NAN; measured.len()];
    references_z_m.par_chunks_mut(CHUNK).zip(measured.par_chunks(CHUNK)).try_for_each(
        |(found, points)| {
            progress.check()?;
            let mut reference = reference();
            for (found, point) in found.iter_mut().zip(points) {
                let [east_m, north_m, z_m] = place(point);
                if [east_m, north_m, z_m].iter().all(|value| value.is_finite()) {
                    *found = reference([east_m, north_m]).unwrap_or(f64::NAN);
                }
            }
            progress.advance(points.len() as u64);
            Ok(())
        },
    )?;
    let known = || {
        let found = references_z_m.iter().enumerate();
        found.filter(|(_, z_m)| !z_m.is_nan())
    };
    let mut matches = Vec::with_capacity(known().count());
    matches.extend(known().map(|(measured_index, &reference_z_m)| Match {
        measured: measured_index,
        reference_z_m,
        difference_m: place(&measured[measured_index])[2] - reference_z_m,
    }));
    Ok(matches)
}

struct NearPoints {
    points: Vec<[f64; 3]>,
    nearest: Nearest,
    radius_m: f64,
}

impl NearPoints {
    fn new(points: Vec<[f64; 3]>, radius_m: f64) -> Option<Self> {
        let places: Vec<[f64; 2]> = points.iter().map(|[x, y, _]| [*x, *y]).collect();
        Some(Self { nearest: Nearest::of(&places)?, points, radius_m })
    }

    fn at(&self, place: [f64; 2]) -> Option<f64> {
        let (found, _) = self.nearest.at(place);
        let [x, y, z_m] = self.points[found];
        // Computed from coordinates, not from the index's squared distance: only then is a radius
        // exact to its last bit.
        let distance_m = (x - place[0]).hypot(y - place[1]);
        (distance_m <= self.radius_m).then_some(z_m)
    }
}

fn triangulated(points: impl Iterator<Item = [f64; 3]> + Clone, max_gap_m: f64) -> Option<Tin> {
    let node = |[east_m, north_m, z_m]: [f64; 3]| Node {
        east_m,
        north_m,
        depth_m: -z_m,
        spread_m: 0.0,
        has_side_scan: false,
    };
    let mut nodes = Vec::with_capacity(points.clone().count());
    nodes.extend(points.map(node));
    Some(Tin::new(nodes)?.with_max_gap(max_gap_m))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bathymetry::testing::{GOLDEN, golden_points};

    fn reference() -> Vec<[f64; 3]> {
        let points = golden_points();
        points.iter().map(|p| [p.east_m, p.north_m, -p.depth_m]).collect()
    }

    #[test]
    fn the_nearest_is_that_of_a_search_through_all() {
        let reference = reference();
        let measured: Vec<[f64; 3]> = (0..3000)
            .map(|i| [0.37 * f64::from(i % 32) - 1.0, 0.11 * f64::from(i / 32), -3.0])
            .collect();
        let radius_m = 0.6;
        let found =
            match_points(&measured, &reference, Matching::Nearest { radius_m }, &Progress::new());
        let brute = measured.iter().enumerate().filter_map(|(index, [x, y, _])| {
            let off = |point: &&[f64; 3]| (point[0] - x).hypot(point[1] - y);
            let nearest = reference.iter().min_by(|a, b| off(a).total_cmp(&off(b)))?;
            (off(&nearest) <= radius_m).then_some((index, nearest[2]))
        });
        let brute: Vec<(usize, f64)> = brute.collect();
        let found: Vec<(usize, f64)> =
            found.unwrap().iter().map(|m| (m.measured, m.reference_z_m)).collect();
        assert!(brute.len() > 500 && brute.len() < 2500, "{}", brute.len());
        assert_eq!(found, brute);
    }

    #[test]
    fn the_surface_is_that_of_scipy_and_up_is_positive() {
        let measured = GOLDEN.map(|golden| [golden.place[0], golden.place[1], -3.0]);
        let matching = Matching::Surface { max_gap_m: 20.0 };
        let found = match_points(&measured, &reference(), matching, &Progress::new()).unwrap();
        for (matched, golden) in found.iter().zip(&GOLDEN) {
            assert!((matched.difference_m - (golden.linear - 3.0)).abs() < 1e-9, "{matched:?}");
        }
        assert_eq!(found.len(), GOLDEN.len());
    }

    #[test]
    fn what_is_no_number_has_no_reference() {
        let nearest = Matching::Nearest { radius_m: 5.0 };
        let find = |measured: &[[f64; 3]], reference: &[[f64; 3]], matching| {
            match_points(measured, reference, matching, &Progress::new()).unwrap().len()
        };
        assert_eq!(
            find(
                &[[f64::NAN, 0.0, 1.0], [0.0, 0.0, 1.0]],
                &[[f64::NAN; 3], [1.0, 1.0, 1.0]],
                nearest
            ),
            1
        );
        assert_eq!(find(&[[0.0; 3]], &[], nearest), 0);
        assert_eq!(find(&[[0.0; 3]], &[], Matching::Surface { max_gap_m: 1.0 }), 0);
    }
}

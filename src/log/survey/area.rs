//! An area of water, as somebody drew it.

use crate::support::geo::LonLat;
use crate::support::outline::is_crossed;
use std::path::PathBuf;

/// The rings of an area: a place is in it where an odd number of them go around it, so that islands
/// are rings too.
#[derive(Clone, Debug, Default)]
pub struct WaterArea {
    /// The file that it was read from.
    pub path: PathBuf,
    /// Its size.
    pub bytes: usize,
    /// Its SHA-256, hexadecimal.
    pub sha256: String,
    /// Corners of each ring, the first of them once.
    pub rings: Vec<Vec<LonLat>>,
}

impl WaterArea {
    /// Returns true if a place is in it.
    pub fn contains(&self, at: LonLat) -> bool {
        let corner = |at: &LonLat| [at.lon_deg, at.lat_deg];
        let crossed = self.rings.iter().map(|ring| {
            let next = ring.iter().cycle().skip(1);
            let edges = ring.iter().zip(next).map(|(from, to)| [corner(from), corner(to)]);
            edges.filter(|edge| is_crossed(*edge, corner(&at))).count()
        });
        crossed.sum::<usize>() % 2 == 1
    }
}

/// Compares path, size and hash of the file that was read: the rings follow from it, and there may
/// be many.
impl PartialEq for WaterArea {
    fn eq(&self, other: &Self) -> bool {
        (&self.path, self.bytes, &self.sha256) == (&other.path, other.bytes, &other.sha256)
    }
}

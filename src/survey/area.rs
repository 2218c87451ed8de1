//! An area of water, as somebody drew it.

use crate::support::geo::LonLat;
use std::path::PathBuf;

/// The rings of an area: a place is in it where an odd number of them go around it, so that islands are rings too.
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

/// By what was read: the rings follow from it, and there may be many.
impl PartialEq for WaterArea {
    fn eq(&self, other: &Self) -> bool {
        (&self.path, self.bytes, &self.sha256) == (&other.path, other.bytes, &other.sha256)
    }
}

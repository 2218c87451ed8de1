//! Needs of the files of a run: inputs without which a file cannot be made.

/// Input without which a file cannot be made.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Need {
    /// A point that the outlier filter keeps.
    KeptPoints,
    /// `points.las`.
    PlainLas,
    /// A boat that moves, with positions.
    Track,
    /// Ground that the side-scan covers.
    Footprint,
    /// Depths that span a surface.
    Surface,
    /// Depths from echo levels, which tell how bright the bed is.
    Hardness,
    /// Levels for isobaths that are not too many.
    Levels,
    /// A line of equal depth.
    Isobaths,
    /// The area that isobaths end at, where one is named: their own files say what is wrong with
    /// it.
    Area,
    /// Side-scan points over soundings, or a track that crosses itself.
    Agreement,
    /// Side-scan.
    SideScan,
    /// Side-scan with a place, in a map of a size that can be drawn.
    Mosaic,
    /// A box that an analyst accepted or added.
    Targets,
    /// A reference that the depths are compared with.
    Reference,
}

/// Reason why a file cannot be made, in a sentence; `None` where nobody needs to know it.
pub(super) struct Missing(pub Option<String>);

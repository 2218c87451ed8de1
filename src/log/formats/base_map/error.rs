//! Errors of base maps.

use crate::support::file_error::FileError;
use crate::support::progress::Cancelled;
use std::io;
use tiff::{ColorType, TiffError};

/// Reason why a file is not opened as a base map.
#[derive(Debug, thiserror::Error)]
pub enum BaseMapError {
    /// The file cannot be read or shown.
    #[error(transparent)]
    Unusable(#[from] FileError<BaseMapFault>),
    /// The user stopped it.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

/// Fault of a base map, as a sentence without the path.
#[derive(Debug, thiserror::Error)]
pub enum BaseMapFault {
    /// The system does not give it.
    #[error("the base map cannot be read: {0}")]
    Io(#[from] io::Error),
    /// It is no TIFF, or one of a kind that is not known.
    #[error("the base map cannot be read: {0}")]
    Tiff(#[from] TiffError),
    /// It contradicts itself, or has no pixels.
    #[error("the base map cannot be read: {0}")]
    Damaged(&'static str),
    /// Its pixels have colours of another kind.
    #[error(
        "the base map is no picture of 8 bits a colour (RGB, grey or paletted); make one with gdal_translate"
    )]
    Colours(ColorType),
    /// It holds all reds before all greens.
    #[error("the base map keeps its colours apart; write it with INTERLEAVE=PIXEL")]
    ColoursApart,
    /// It has no system or no transform.
    #[error("the picture does not say where on Earth it lies; {0}")]
    Nowhere(&'static str),
    /// It names a system that is not known.
    #[error(
        "the base map is in EPSG:{0}, which is not known here; turn it into WGS84, web Mercator or a UTM zone with gdalwarp"
    )]
    UnknownSystem(u16),
    /// Its rows do not run from west to east, north first.
    #[error("the base map is not north up; turn it with gdalwarp")]
    Turned,
    /// Its blocks, of so many bytes, are too large.
    #[error(
        "the base map holds blocks of {} MB, more than is read at once; write it with TILED=YES",
        .0 >> 20
    )]
    LargeBlocks(u64),
    /// It is too large to make an overview of.
    #[error(
        "the base map has {columns} by {rows} pixels and no overviews of them; add some with gdaladdo"
    )]
    NoOverviews {
        /// Pixels from west to east.
        columns: u32,
        /// Pixels from north to south.
        rows: u32,
    },
}

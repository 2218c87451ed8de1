//! Place of the pixels of a base map.

use super::BaseMapFault;
use crate::formats::geotiff::{GeoKeys, GeoTransform};
use crate::support::geo::{Crs, LonLat};
use std::io::{Read, Seek};
use tiff::decoder::Decoder;

/// Degrees of WGS84, ETRS89 and NAD83.
const WGS84: u16 = 4326;
const DEGREES: [u16; 3] = [WGS84, 4258, 4269];

/// Place of the pixels of a picture, north up.
#[derive(Clone, Debug, PartialEq)]
pub struct Georeference {
    /// The system that the numbers are in.
    pub crs: Crs,
    /// x and y of the upper left corner of the upper left pixel.
    pub corner: [f64; 2],
    /// Width and height of a pixel.
    pub pixel: [f64; 2],
}

impl Georeference {
    /// Column and row of a position, counted from the upper left corner of the picture, fractions
    /// within a pixel.
    pub fn to_pixels(&self, at: LonLat) -> [f64; 2] {
        let [x, y] = self.crs.place(at);
        [(x - self.corner[0]) / self.pixel[0], (self.corner[1] - y) / self.pixel[1]]
    }

    /// Inverse of [`Georeference::to_pixels`].
    pub fn to_position(&self, [column, row]: [f64; 2]) -> LonLat {
        let x = self.corner[0] + column * self.pixel[0];
        let y = self.corner[1] - row * self.pixel[1];
        self.crs.to_lon_lat([x, y])
    }

    /// Reads keys and transform of the picture that the decoder is at.
    ///
    /// # Errors
    /// When it has none, or such as are not known or not north up.
    pub(crate) fn read<R: Read + Seek>(decoder: &mut Decoder<R>) -> Result<Self, BaseMapFault> {
        let keys = GeoKeys::read(decoder);
        let code = if keys.is_geographic() { keys.geographic() } else { keys.projected() };
        let Some(epsg) = code else {
            return Err(BaseMapFault::Nowhere("a GeoTIFF with an EPSG number does"));
        };
        // Degrees of NAD83 and ETRS89 lie within 2 m of those of WGS84.
        let known = if DEGREES.contains(&epsg) { WGS84 } else { epsg };
        let crs = Crs::from_epsg(known).map_err(|_| BaseMapFault::UnknownSystem(epsg))?;
        let Some(transform) = GeoTransform::read(decoder, &keys) else {
            return Err(BaseMapFault::Nowhere("it has no transform"));
        };
        let ([width, down], [across, height]) = (transform.per_column, transform.per_row);
        let is_turned = down != 0.0 || across != 0.0;
        let pixel = [width, -height];
        let place = Self { crs, corner: transform.of_corners().origin, pixel };
        let numbers = [place.corner, place.pixel].concat();
        let usable =
            numbers.iter().all(|number| number.is_finite()) && pixel.iter().all(|side| *side > 0.0);
        if usable && !is_turned { Ok(place) } else { Err(BaseMapFault::Turned) }
    }
}

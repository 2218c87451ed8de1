//! Maps pixels of a base map to positions and back.

use super::BaseMapFault;
use crate::formats::geotiff::{GeoKeys, GeoTransform};
use crate::support::geo::{Crs, LonLat};
use std::io::{Read, Seek};
use tiff::decoder::Decoder;

/// EPSG code of WGS84, and the codes in degrees that are read as WGS84: WGS84, ETRS89 and NAD83.
const WGS84: u16 = 4326;
const DEGREES: [u16; 3] = [WGS84, 4258, 4269];

/// Place of the pixels of a picture, north up.
#[derive(Clone, Debug, PartialEq)]
pub struct Georeference {
    /// Coordinate system of the corner and the pixel size.
    pub crs: Crs,
    /// x and y of the upper left corner of the upper left pixel, in units of the system.
    pub corner: [f64; 2],
    /// Width and height of a pixel, in units of the system.
    pub pixel: [f64; 2],
}

impl Georeference {
    /// Returns the column and row of a position, counted from the upper left corner of the picture,
    /// with fractions of a pixel.
    pub fn to_pixels(&self, at: LonLat) -> [f64; 2] {
        let [x, y] = self.crs.place(at);
        [(x - self.corner[0]) / self.pixel[0], (self.corner[1] - y) / self.pixel[1]]
    }

    /// Returns the position of a column and row; the inverse of [`Georeference::to_pixels`].
    pub fn to_position(&self, [column, row]: [f64; 2]) -> LonLat {
        let x = self.corner[0] + column * self.pixel[0];
        let y = self.corner[1] - row * self.pixel[1];
        self.crs.to_lon_lat([x, y])
    }

    /// Reads the GeoTIFF keys and the transform of the current picture of the decoder.
    ///
    /// # Errors
    /// When the picture has no EPSG number or no transform, its system is not supported, or it is
    /// not north up.
    pub(crate) fn read<R: Read + Seek>(decoder: &mut Decoder<R>) -> Result<Self, BaseMapFault> {
        let keys = GeoKeys::read(decoder);
        let code = if keys.is_geographic() { keys.geographic() } else { keys.projected() };
        let nowhere = |what: &str| {
            let what = format!("the picture does not say where on Earth it lies; {what}");
            BaseMapFault::unsuitable(what)
        };
        let epsg = code.ok_or_else(|| nowhere("a GeoTIFF with an EPSG number does"))?;
        // Coordinates in NAD83 and ETRS89 differ from WGS84 by less than 2 m.
        let known = if DEGREES.contains(&epsg) { WGS84 } else { epsg };
        let crs = Crs::from_epsg(known).map_err(|_| {
            BaseMapFault::unsuitable(format!(
                "the base map is in EPSG:{epsg}, which is not known here; turn it into WGS84, web Mercator or a UTM zone with gdalwarp"
            ))
        })?;
        let transform = GeoTransform::read(decoder, &keys);
        let transform = transform.ok_or_else(|| nowhere("it has no transform"))?;
        let ([width, down], [across, height]) = (transform.per_column, transform.per_row);
        let is_turned = down != 0.0 || across != 0.0;
        let pixel = [width, -height];
        let place = Self { crs, corner: transform.of_corners().origin, pixel };
        let numbers = [place.corner, place.pixel].concat();
        let usable =
            numbers.iter().all(|number| number.is_finite()) && pixel.iter().all(|side| *side > 0.0);
        if usable && !is_turned {
            return Ok(place);
        }
        Err(BaseMapFault::unsuitable("the base map is not north up; turn it with gdalwarp"))
    }
}

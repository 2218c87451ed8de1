//! Where the pixels of a GeoTIFF lie: its geo keys and its transform, as OGC 19-008 defines them.

use crate::geo::{Crs, LonLat};
use std::io::{Read, Seek};
use tiff::decoder::Decoder;
use tiff::tags::Tag;

const MODEL_TYPE: u16 = 1024;
const RASTER_TYPE: u16 = 1025;
const GEOGRAPHIC: u16 = 2048;
const PROJECTED: u16 = 3072;
/// Degrees of WGS84, ETRS89 and NAD83.
const WGS84: u16 = 4326;
const DEGREES: [u16; 3] = [WGS84, 4258, 4269];
/// Values of the two types.
const IS_GEOGRAPHIC: u16 = 2;
const IS_POINT: u16 = 2;

/// Where the pixels of a picture lie, north up.
#[derive(Clone, Debug, PartialEq)]
pub struct Place {
    /// The system that the numbers are in.
    pub crs: Crs,
    /// x and y of the upper left corner of the upper left pixel.
    pub corner: [f64; 2],
    /// Width and height of a pixel.
    pub pixel: [f64; 2],
}

impl Place {
    /// Column and row of a position, counted from the upper left corner of the picture, fractions within a pixel.
    pub fn to_pixels(&self, at: LonLat) -> [f64; 2] {
        let [x, y] = self.crs.place(at);
        [
            (x - self.corner[0]) / self.pixel[0],
            (self.corner[1] - y) / self.pixel[1],
        ]
    }

    /// Inverse of [`Place::to_pixels`].
    pub fn to_position(&self, [column, row]: [f64; 2]) -> LonLat {
        let x = self.corner[0] + column * self.pixel[0];
        let y = self.corner[1] - row * self.pixel[1];
        self.crs.to_lon_lat([x, y])
    }

    /// Reads keys and transform of the picture that the decoder is at. The error is a sentence without the path.
    pub fn read<R: Read + Seek>(decoder: &mut Decoder<R>) -> Result<Self, String> {
        let keys = decoder
            .get_tag_u16_vec(Tag::GeoKeyDirectoryTag)
            .unwrap_or_default();
        // Entries are a key, where its value lies (0: here), how many, and the value; the first is a header.
        let key = |wanted: u16| {
            let mut entries = keys.chunks_exact(4).skip(1);
            entries
                .find(|entry| entry[0] == wanted && entry[1] == 0)
                .map(|entry| entry[3])
        };
        let code = match key(MODEL_TYPE) {
            Some(IS_GEOGRAPHIC) => key(GEOGRAPHIC),
            _ => key(PROJECTED).or(key(GEOGRAPHIC)),
        };
        let Some(epsg) = code else {
            return Err("the picture does not say where on Earth it lies; a GeoTIFF with an EPSG number does".to_owned());
        };
        // Degrees of NAD83 and ETRS89 lie within 2 m of those of WGS84.
        let known = if DEGREES.contains(&epsg) { WGS84 } else { epsg };
        let crs = Crs::from_epsg(known).map_err(|_| {
            format!("the base map is in EPSG:{epsg}, which is not known here; turn it into WGS84, web Mercator or a UTM zone with gdalwarp")
        })?;
        let (corner, pixel) = transform(decoder)?;
        let half = match key(RASTER_TYPE) {
            Some(IS_POINT) => 0.5,
            _ => 0.0,
        };
        let place = Self {
            crs,
            corner: [corner[0] - half * pixel[0], corner[1] + half * pixel[1]],
            pixel,
        };
        let numbers = [place.corner, place.pixel].concat();
        let usable =
            numbers.iter().all(|number| number.is_finite()) && pixel.iter().all(|side| *side > 0.0);
        match usable {
            true => Ok(place),
            false => Err("the base map is not north up; turn it with gdalwarp".to_owned()),
        }
    }
}

/// Upper left corner and size of a pixel, from a tie point and a scale or from a matrix without rotation.
fn transform<R: Read + Seek>(decoder: &mut Decoder<R>) -> Result<([f64; 2], [f64; 2]), String> {
    let mut numbers = |tag| decoder.get_tag_f64_vec(tag).unwrap_or_default();
    let (scale, tie) = (
        numbers(Tag::ModelPixelScaleTag),
        numbers(Tag::ModelTiepointTag),
    );
    if let ([width, height, ..], [column, row, _, x, y, ..]) = (&scale[..], &tie[..]) {
        let corner = [x - column * width, y + row * height];
        return Ok((corner, [*width, *height]));
    }
    let matrix = numbers(Tag::ModelTransformationTag);
    match matrix[..] {
        [width, across, _, x, down, height, _, y, ..] if across == 0.0 && down == 0.0 => {
            Ok(([x, y], [width, -height]))
        }
        [] => {
            Err("the picture does not say where on Earth it lies; it has no transform".to_owned())
        }
        _ => Err("the base map is not north up; turn it with gdalwarp".to_owned()),
    }
}

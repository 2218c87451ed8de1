//! Draws all zooms of a map, from the finest pixels to the coarsest.

use super::chart::draw_isobaths;
use super::{Pixels, TILE_PIXELS, WebTile, ZoomRange};
use bathyscope_bottom::bathymetry::isobaths::{Isobath, IsobathSettings, evenly_apart_m, joined};
use bathyscope_log::support::progress::Progress;
use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use image::{ExtendedColorType, ImageEncoder as _, ImageResult};
use rayon::prelude::*;
use std::io;
use std::sync::{Mutex, PoisonError};

bathyscope_log::listed! {
    /// All styles, in the order of their declaration.
    const ALL;

    /// Content of a picture of a tile.
    #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
    pub enum TileStyle {
        /// Lit colours of depth, without the isobaths, which the web map draws itself.
        Colours,
        /// Lit colours of depth with isobaths and their depths.
        Chart,
        /// The depths themselves ([`Pixels::elevations`]).
        Elevations,
    }
}

/// Extent of a map and scales of its drawing.
#[derive(Clone, Debug)]
pub struct MapScales {
    /// Zooms and extent of the map.
    pub zooms: ZoomRange,
    /// Ends of the colour scale, metres.
    pub range_m: [f32; 2],
    /// Depths of the isobaths, rising, metres.
    pub levels_m: Vec<f64>,
    /// Settings of the isobaths, with the unit of the numbers along them.
    pub isobaths: IsobathSettings,
}

impl MapScales {
    /// Returns the interval of the isobaths, metres; `None` where they are not evenly spaced.
    pub fn interval_m(&self) -> Option<f64> {
        evenly_apart_m(&self.levels_m).map(|[interval_m, _]| interval_m)
    }
}

/// Source of the tiles of a map.
pub trait PyramidSource: Sync {
    /// Returns the extent of the map and the scales of its drawing.
    fn scales(&self) -> &MapScales;
    /// Returns true if anything may be known in a tile of any zoom.
    fn reaches(&self, tile: WebTile) -> bool;
    /// Returns the pixels of a tile of the finest zoom; `None` where none is known.
    ///
    /// # Errors
    /// When the map cannot be read.
    fn pixels(&self, tile: WebTile) -> io::Result<Option<Pixels>>;
    /// Returns the isobaths in a tile of the finest zoom, cut at its edges, in pixels of that zoom
    /// from the north-west of the whole earth.
    ///
    /// # Errors
    /// When the isobaths cannot be read.
    fn isobaths(&self, tile: WebTile) -> io::Result<Vec<Isobath>>;
    /// Returns a part of the map that was drawn before, if drawing again would give the same;
    /// `None` for a source that keeps no parts.
    fn kept(&self, _tile: WebTile) -> Option<MapPart> {
        None
    }
    /// Stores a part of the map that was drawn.
    ///
    /// # Errors
    /// When the part cannot be stored.
    fn keep(&self, _tile: WebTile, _part: &MapPart) -> io::Result<()> {
        Ok(())
    }
}

/// Pixels and isobaths of a tile, from which the next coarser tile is made.
#[derive(Clone, Debug, PartialEq)]
pub struct KnownTile {
    /// Pixels of the tile.
    pub pixels: Pixels,
    /// Isobaths in the tile, in pixels of the finest zoom from the north-west of the whole earth.
    pub lines: Vec<Isobath>,
}

/// A part of a map: a tile a few zooms coarser than the finest zoom, with all finer tiles in it.
#[derive(Clone, Debug, PartialEq)]
pub struct MapPart {
    /// Pixels and isobaths of the tile; `None` where nothing is known.
    pub known: Option<KnownTile>,
    /// Pictures of the tile and of the finer tiles, PNG, in order.
    pub pictures: Vec<(TileStyle, WebTile, Vec<u8>)>,
}

impl MapPart {
    /// Returns the number of tiles of a zoom that the part has pictures of.
    fn count(&self, zoom: u8) -> u64 {
        let tiles = self.pictures.iter();
        let of_zoom =
            tiles.filter(|(picture, tile, _)| *picture == TileStyle::Colours && tile.zoom == zoom);
        of_zoom.count() as u64
    }
}

/// Number of zooms between a part of a map and its finest tiles. A part is some 250 to 500 m long
/// where cells are 0.5 m, about as long as a tile of an archive: smaller parts would be too many
/// files, and of larger parts too much would be drawn again when a tile changes.
const PART_ZOOMS: u8 = 2;

/// Interval between the isobaths that are drawn, in intervals of the map, by the number of zooms
/// that a tile is coarser than the finest: every isobath, every second, every fifth.
const EVERY: [i64; 9] = [1, 1, 2, 2, 5, 5, 10, 10, 20];
/// Least distance between points of a line, and least length of a line, in pixels of its zoom.
const LEAST_STEP: f64 = 0.5;
const LEAST_LENGTH: f64 = 4.0;

/// Draws the pictures of all tiles in which anything is known and passes each as PNG to `keep`,
/// from several threads and in no order.
///
/// # Errors
/// When the source or `keep` fails, or the work was cancelled.
pub fn pyramid(
    source: &impl PyramidSource,
    progress: &Progress,
    keep: &(impl Fn(TileStyle, WebTile, Vec<u8>) -> io::Result<()> + Sync),
) -> io::Result<()> {
    let zooms = source.scales().zooms;
    progress.start(zooms.tiles(zooms.finest).len() as u64);
    let pyramid =
        Pyramid { source, zooms, interval_m: source.scales().interval_m(), progress, keep };
    let tops = zooms.tiles(zooms.coarsest);
    tops.par_iter().try_for_each(|tile| pyramid.tile(*tile).map(drop))
}

type Keep<'a> = &'a (dyn Fn(TileStyle, WebTile, Vec<u8>) -> io::Result<()> + Sync);

struct Pyramid<'a, S> {
    source: &'a S,
    zooms: ZoomRange,
    interval_m: Option<f64>,
    progress: &'a Progress,
    keep: Keep<'a>,
}

impl<S: PyramidSource> Pyramid<'_, S> {
    /// Draws a tile and all finer tiles in it; a tile at the zoom of the parts is drawn or read as
    /// a part.
    fn tile(&self, tile: WebTile) -> io::Result<Option<KnownTile>> {
        self.progress.check().map_err(io::Error::other)?;
        let part_zoom = self.zooms.finest.saturating_sub(PART_ZOOMS);
        match self.source.reaches(tile) {
            false => Ok(None),
            true if tile.zoom == part_zoom.max(self.zooms.coarsest) => self.part(tile),
            true => self.drawn(tile),
        }
    }

    /// Reads a part of the map from the source, or draws it and gives it to the source to store.
    fn part(&self, tile: WebTile) -> io::Result<Option<KnownTile>> {
        let part = match self.source.kept(tile) {
            Some(part) => {
                self.progress.advance(part.count(self.zooms.finest));
                part
            }
            None => {
                let part = self.drawn_part(tile)?;
                self.source.keep(tile, &part)?;
                part
            }
        };
        for (picture, tile, bytes) in part.pictures {
            (self.keep)(picture, tile, bytes)?;
        }
        Ok(part.known)
    }

    fn drawn_part(&self, tile: WebTile) -> io::Result<MapPart> {
        let pictures: Mutex<Vec<(TileStyle, WebTile, Vec<u8>)>> = Mutex::default();
        let keep = |picture, tile, bytes| {
            let mut pictures = pictures.lock().unwrap_or_else(PoisonError::into_inner);
            pictures.push((picture, tile, bytes));
            Ok(())
        };
        let inner = Pyramid { keep: &keep, ..*self };
        let known = inner.drawn(tile)?;
        let mut pictures = pictures.into_inner().unwrap_or_else(PoisonError::into_inner);
        // Threads add the pictures in any order.
        pictures.sort_unstable_by_key(|(picture, tile, _)| (*picture, *tile));
        Ok(MapPart { known, pictures })
    }

    fn drawn(&self, tile: WebTile) -> io::Result<Option<KnownTile>> {
        let known =
            if tile.zoom == self.zooms.finest { self.finest(tile)? } else { self.coarser(tile)? };
        if let Some(known) = &known {
            self.pictures(tile, known)?;
        }
        Ok(known)
    }

    fn finest(&self, tile: WebTile) -> io::Result<Option<KnownTile>> {
        self.progress.advance(1);
        let Some(pixels) = self.source.pixels(tile)? else {
            return Ok(None);
        };
        let lines = self.source.isobaths(tile)?;
        Ok(Some(KnownTile { pixels, lines }))
    }

    fn coarser(&self, tile: WebTile) -> io::Result<Option<KnownTile>> {
        let children = tile.children();
        let known = children.par_iter().map(|child| self.tile(*child));
        let known: Vec<Option<KnownTile>> = known.collect::<io::Result<_>>()?;
        let pixels =
            [0, 1, 2, 3].map(|child| known[child].as_ref().map(|known_tile| &known_tile.pixels));
        let Some(pixels) = Pixels::of_children(pixels) else {
            return Ok(None);
        };
        let coarser = self.zooms.finest - tile.zoom;
        let lines = known.into_iter().flatten().flat_map(|known_tile| known_tile.lines);
        let lines = joined(lines.filter(|line| self.is_shown(line.depth_m, coarser)).collect());
        let pixel = f64::from(1_u32 << coarser);
        let thinned = lines.into_iter().map(|line| thinned(line, LEAST_STEP * pixel));
        let lines = thinned.filter(|line| line.length_m() >= LEAST_LENGTH * pixel).collect();
        Ok(Some(KnownTile { pixels, lines }))
    }

    /// Returns true if an isobath is drawn at a coarser zoom: only depths that are a multiple of
    /// some intervals are; all where the isobaths are not evenly spaced.
    fn is_shown(&self, depth_m: f64, coarser: u8) -> bool {
        let every = EVERY[usize::from(coarser).min(EVERY.len() - 1)];
        self.interval_m.is_none_or(|interval_m| (depth_m / interval_m).round() as i64 % every == 0)
    }

    fn pictures(&self, tile: WebTile, known: &KnownTile) -> io::Result<()> {
        let mut picture = known.pixels.colours(self.source.scales().range_m);
        let keep = |style: TileStyle, pixels: &[u8]| {
            let png = png(pixels, style).map_err(io::Error::other)?;
            (self.keep)(style, tile, png)
        };
        keep(TileStyle::Colours, &picture)?;
        let ([west, north], side) = tile.corner_at(self.zooms.finest);
        let scale = TILE_PIXELS as f64 / side;
        let in_tile = |line: &Isobath| Isobath {
            points: (line.points.iter().map(|[x, y]| [scale * (x - west), scale * (y - north)]))
                .collect(),
            ..*line
        };
        let lines: Vec<Isobath> = known.lines.iter().map(in_tile).collect();
        draw_isobaths(&mut picture, &lines, &self.source.scales().isobaths);
        keep(TileStyle::Chart, &picture)?;
        keep(TileStyle::Elevations, &known.pixels.elevations())
    }
}

/// Removes the points of a line that are nearer than `least` to the point before; the ends are
/// kept.
fn thinned(line: Isobath, least: f64) -> Isobath {
    let last = line.points.len().saturating_sub(1);
    let mut points: Vec<[f64; 2]> = Vec::new();
    for (index, point) in line.points.into_iter().enumerate() {
        let far = |before: &[f64; 2]| (point[0] - before[0]).hypot(point[1] - before[1]) >= least;
        if index == last || points.last().is_none_or(far) {
            points.push(point);
        }
    }
    Isobath { depth_m: line.depth_m, points }
}

/// Encodes the picture of a tile as PNG. The default compression took as long as all other work on
/// a map. The settings here take a tenth of that time for colours and a third for elevations, and
/// files are an eighth to a quarter longer; the fastest compression would make elevations twice as
/// long.
fn png(rgba: &[u8], style: TileStyle) -> ImageResult<Vec<u8>> {
    let (compression, filter) = match style {
        TileStyle::Colours | TileStyle::Chart => (CompressionType::Fast, FilterType::Adaptive),
        TileStyle::Elevations => (CompressionType::Level(3), FilterType::Up),
    };
    let mut bytes = Vec::new();
    let side = TILE_PIXELS as u32;
    PngEncoder::new_with_quality(&mut bytes, compression, filter).write_image(
        rgba,
        side,
        side,
        ExtendedColorType::Rgba8,
    )?;
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::map_tiles::{Pixel, web_pixel};
    use bathyscope_bottom::bathymetry::isobaths::clipped;
    use bathyscope_log::support::geo::{LonLat, boxes_meet};
    use std::collections::BTreeMap;
    use std::sync::Mutex;

    /// A bottom that sinks eastwards by a metre from one edge of a box to the other, with an
    /// isobath in the middle; stores the parts of the map.
    struct Slope {
        scales: MapScales,
        parts: Mutex<BTreeMap<WebTile, MapPart>>,
        /// Tiles of the finest zoom that were requested.
        asked: Mutex<Vec<WebTile>>,
    }

    const BOX: [f64; 4] = [9.0, 47.0, 9.004, 47.003];

    fn depth_m(at: LonLat) -> f32 {
        (2.0 + (at.lon_deg - BOX[0]) / (BOX[2] - BOX[0])) as f32
    }

    impl PyramidSource for Slope {
        fn scales(&self) -> &MapScales {
            &self.scales
        }

        fn reaches(&self, tile: WebTile) -> bool {
            boxes_meet(tile.bounds_deg(), BOX)
        }

        fn pixels(&self, tile: WebTile) -> io::Result<Option<Pixels>> {
            self.asked.lock().unwrap().push(tile);
            let inside = |at: &LonLat| {
                (BOX[0]..BOX[2]).contains(&at.lon_deg) && (BOX[1]..BOX[3]).contains(&at.lat_deg)
            };
            Ok(Pixels::draw(|pixel| {
                let at = tile.place(pixel.map(|number| number as f64 + 0.5));
                inside(&at).then(|| Pixel { depth_m: depth_m(at), light: 1.0 })
            }))
        }

        fn isobaths(&self, tile: WebTile) -> io::Result<Vec<Isobath>> {
            let middle_deg = 0.5 * (BOX[0] + BOX[2]);
            let points = [BOX[1], BOX[3]].map(|lat_deg| {
                let at = LonLat { lon_deg: middle_deg, lat_deg };
                web_pixel(at, self.scales.zooms.finest)
            });
            let line = Isobath { depth_m: 2.5, points: points.to_vec() };
            Ok(clipped(&line, tile.pixel_bounds(self.scales.zooms.finest)))
        }

        fn kept(&self, tile: WebTile) -> Option<MapPart> {
            self.parts.lock().unwrap().get(&tile).cloned()
        }

        fn keep(&self, tile: WebTile, part: &MapPart) -> io::Result<()> {
            self.parts.lock().unwrap().insert(tile, part.clone());
            Ok(())
        }
    }

    fn slope() -> Slope {
        Slope {
            scales: MapScales {
                zooms: ZoomRange::of_map(BOX, 0.6),
                range_m: [2.0, 3.0],
                levels_m: vec![2.5],
                isobaths: IsobathSettings::default(),
            },
            parts: Mutex::default(),
            asked: Mutex::default(),
        }
    }

    type Pictures = BTreeMap<(TileStyle, WebTile), Vec<u8>>;

    fn drawn(source: &Slope) -> Pictures {
        let kept = Mutex::new(Pictures::new());
        let keep = |picture, tile, bytes| {
            kept.lock().unwrap().insert((picture, tile), bytes);
            Ok(())
        };
        pyramid(source, &Progress::new(), &keep).unwrap();
        kept.into_inner().unwrap()
    }

    #[test]
    fn every_zoom_shows_the_same_bed_and_its_isobath() {
        let pictures = drawn(&slope());
        let zooms = slope().scales.zooms;
        assert!(zooms.finest >= zooms.coarsest + 3);
        for zoom in zooms.coarsest..=zooms.finest {
            let mut lined = 0;
            for tile in zooms.tiles(zoom) {
                let of = |picture| {
                    image::load_from_memory(&pictures[&(picture, tile)]).unwrap().to_rgba8()
                };
                let [colours, chart, elevations] =
                    [TileStyle::Colours, TileStyle::Chart, TileStyle::Elevations].map(of);
                for (x, y, pixel) in elevations.enumerate_pixels() {
                    let at = [x, y].map(|number| f64::from(number) + 0.5);
                    let (at, [red, green, blue, opacity]) = (tile.place(at), pixel.0);
                    assert_eq!(colours.get_pixel(x, y).0[3], opacity);
                    // Half a coarse pixel beyond the edge only a part of the pixel is known.
                    let pixel_deg = 360.0 / 256.0 / f64::from(1_u32 << zoom);
                    if opacity > 0
                        && at.lon_deg > BOX[0] + pixel_deg
                        && at.lon_deg < BOX[2] - pixel_deg
                    {
                        let elevation_m =
                            f32::from(red) * 256.0 + f32::from(green) + f32::from(blue) / 256.0
                                - 32_768.0;
                        assert!((elevation_m + depth_m(at)).abs() < 0.01, "{tile:?} {x} {y}");
                    }
                    let middle_deg = 0.5 * (BOX[0] + BOX[2]);
                    let near = (at.lon_deg - middle_deg).abs() < pixel_deg;
                    lined += usize::from(near && chart.get_pixel(x, y) != colours.get_pixel(x, y));
                }
            }
            assert!(lined > 5, "zoom {zoom}");
        }
    }

    #[test]
    fn the_same_map_gives_the_same_pictures_and_a_cancelled_one_none() {
        assert!(drawn(&slope()) == drawn(&slope()));
        let cancelled = Progress::new();
        cancelled.cancel();
        assert!(pyramid(&slope(), &cancelled, &|_, _, _| Ok(())).is_err());
    }

    #[test]
    fn parts_that_are_kept_are_not_drawn_again() {
        let source = slope();
        let pictures = drawn(&source);
        let part = *source.parts.lock().unwrap().keys().next().unwrap();
        assert!(source.parts.lock().unwrap().len() > 1);
        source.asked.lock().unwrap().clear();
        assert!(drawn(&source) == pictures);
        assert!(source.asked.lock().unwrap().is_empty());
        source.parts.lock().unwrap().remove(&part);
        assert!(drawn(&source) == pictures);
        let asked = source.asked.lock().unwrap();
        let part_place = |tile: &WebTile| (tile.x >> PART_ZOOMS, tile.y >> PART_ZOOMS);
        assert!(!asked.is_empty());
        assert!(asked.iter().all(|tile| part_place(tile) == (part.x, part.y)));
    }

    #[test]
    fn lines_thin_out_where_the_map_is_small() {
        let keep = |_, _, _| Ok(());
        let pyramid = Pyramid {
            source: &slope(),
            zooms: slope().scales.zooms,
            interval_m: Some(0.5),
            progress: &Progress::new(),
            keep: &keep,
        };
        let shown = |coarser: u8| {
            (0..40).filter(|step| pyramid.is_shown(0.5 * f64::from(*step), coarser)).count()
        };
        assert_eq!([shown(0), shown(2), shown(4), shown(7), shown(30)], [40, 20, 8, 4, 2]);
        let line =
            Isobath { depth_m: 1.0, points: vec![[0.0, 0.0], [0.1, 0.0], [0.6, 0.0], [0.7, 0.0]] };
        assert_eq!(thinned(line, 0.5).points, [[0.0, 0.0], [0.6, 0.0], [0.7, 0.0]]);
    }
}

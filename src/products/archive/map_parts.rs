//! Stores parts of the web map that were drawn before: `map_parts/ZOOM_X_Y_HASH.parquet`. The hash
//! in the name covers all inputs of the part, so that a file is used only where drawing again would
//! give the same part.

use super::tile::TileId;
use super::{names_in, remove};
use crate::Error;
use crate::export::{make_folder, write_atomically};
use crate::map_tiles::{KnownTile, MapPart, Pixels, TileStyle, WebTile};
use crate::pipeline::{Fingerprint, in_hexadecimal};
use bathyscope_bottom::bathymetry::isobaths::{Isobath, IsobathSettings};
use bathyscope_log::formats::parquet_table::{Column, Values, read_parquet, write_parquet};
use flate2::Compression;
use flate2::read::ZlibDecoder;
use flate2::write::ZlibEncoder;
use serde::Serialize;
use sha2::{Digest as _, Sha256};
use std::collections::{BTreeMap, BTreeSet};
use std::io::{self, Read as _, Write as _};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

const ENDING: &str = ".parquet";
/// Number of bytes of the hash in a name.
const HASH: usize = 12;
/// Names of the columns: the kind of content of a row, the tile of a picture, and the bytes.
const COLUMNS: [&str; 5] = ["content", "zoom", "x", "y", "bytes"];
/// Content of a row: a picture, by its index in [`TileStyle::ALL`], or, by these numbers, the known
/// pixels or an isobath of the tile itself.
const PIXELS: i32 = 3;
const LINE: i32 = 4;
/// Largest number of bytes of a tile's pixels; a damaged file may unpack to more.
const MOST_PIXELS: u64 = 1 << 20;

/// Settings that all parts of a map are drawn with.
#[derive(Clone, Debug, Serialize)]
pub(super) struct DrawnWith {
    /// The program and its version.
    pub program: String,
    /// The finest zoom of the map.
    pub finest_zoom: u8,
    /// Ends of the scale of colours, metres.
    pub range_m: [f32; 2],
    /// Factor of the hill-shade on the relief.
    pub exaggeration: f64,
    /// Interval between isobaths, metres.
    pub interval_m: Option<f32>,
    /// Settings of the isobaths.
    pub isobaths: IsobathSettings,
}

/// The stored parts of the map of an archive.
pub(super) struct MapParts {
    folder: PathBuf,
    drawn_with: DrawnWith,
    /// Files of the maps of the archive's tiles.
    maps: BTreeMap<TileId, Vec<Fingerprint>>,
    /// Names of the files that are parts of the present map.
    used: Mutex<BTreeSet<String>>,
}

impl MapParts {
    /// Creates the parts of a map in a folder, which may not exist yet.
    pub(super) fn new(
        folder: PathBuf,
        drawn_with: DrawnWith,
        maps: BTreeMap<TileId, Vec<Fingerprint>>,
    ) -> Self {
        Self { folder, drawn_with, maps, used: Mutex::default() }
    }

    /// Returns the part drawn for a web tile, if the tiles of the archive under it and all other
    /// inputs are unchanged; `None` without such a file or where it is damaged.
    pub(super) fn read(&self, tile: WebTile, under: &[TileId]) -> Option<MapPart> {
        let name = self.name(tile, under);
        let part = read(&self.folder.join(&name))?;
        self.use_file(name);
        Some(part)
    }

    /// Writes a part to its file.
    pub(super) fn write(&self, tile: WebTile, under: &[TileId], part: &MapPart) -> io::Result<()> {
        make_folder(&self.folder).map_err(io::Error::other)?;
        let name = self.name(tile, under);
        let columns = columns(part)?;
        write_atomically(&self.folder.join(&name), |file| write_parquet(file, &columns, &[]))
            .map_err(io::Error::other)?;
        self.use_file(name);
        Ok(())
    }

    /// Removes the files that are not parts of the present map.
    ///
    /// # Errors
    /// When a file cannot be removed.
    pub(super) fn remove_others(&self) -> Result<(), Error> {
        let used = self.used.lock().unwrap_or_else(PoisonError::into_inner);
        remove_parts(&self.folder, |name| !used.contains(name))
    }

    fn use_file(&self, name: String) {
        let mut used = self.used.lock().unwrap_or_else(PoisonError::into_inner);
        used.insert(name);
    }

    fn name(&self, tile: WebTile, under: &[TileId]) -> String {
        let maps: BTreeMap<String, Option<&Vec<Fingerprint>>> =
            (under.iter()).map(|id| (id.to_string(), self.maps.get(id))).collect();
        let from = serde_json::json!({ "with": self.drawn_with, "maps": maps }).to_string();
        let hash = in_hexadecimal(&Sha256::digest(from.as_bytes())[..HASH]);
        format!("{}_{}_{}_{hash}{ENDING}", tile.zoom, tile.x, tile.y)
    }
}

/// Removes the parts of a map for whose names `goes` is true.
///
/// # Errors
/// When a file cannot be removed.
pub(super) fn remove_parts(folder: &Path, goes: impl Fn(&str) -> bool) -> Result<(), Error> {
    for name in names_in(folder)? {
        if name.ends_with(ENDING) && goes(&name) {
            remove(&folder.join(&name))?;
        }
    }
    Ok(())
}

fn columns(part: &MapPart) -> io::Result<Vec<Column>> {
    let mut rows: Vec<(i32, Option<WebTile>, Vec<u8>)> = Vec::new();
    if let Some(known) = &part.known {
        let mut packed = ZlibEncoder::new(Vec::new(), Compression::fast());
        packed.write_all(&known.pixels.to_bytes())?;
        rows.push((PIXELS, None, packed.finish()?));
        rows.extend((known.lines.iter()).map(|line| (LINE, None, line_bytes(line))));
    }
    rows.extend((part.pictures.iter()).map(|(picture, tile, bytes)| {
        let content = *picture as i32;
        (content, Some(*tile), bytes.clone())
    }));
    let of_tiles = |value: fn(WebTile) -> u32| {
        let values = rows.iter().map(|row| row.1.map(|tile| value(tile) as i32));
        Values::Whole(values.collect())
    };
    let [zoom, x, y] =
        [of_tiles(|tile| tile.zoom.into()), of_tiles(|tile| tile.x), of_tiles(|tile| tile.y)];
    let content = Values::Whole(rows.iter().map(|row| Some(row.0)).collect());
    let bytes = Values::Bytes(rows.into_iter().map(|row| row.2).collect());
    let values = [content, zoom, x, y, bytes];
    Ok(COLUMNS.into_iter().zip(values).map(|(name, values)| Column::new(name, values)).collect())
}

fn read(path: &Path) -> Option<MapPart> {
    let columns = path.exists().then(|| read_parquet(path, &COLUMNS).ok())??;
    let Ok(
        [
            Values::Whole(content),
            Values::Whole(zoom),
            Values::Whole(x),
            Values::Whole(y),
            Values::Bytes(bytes),
        ],
    ) = <[Values; 5]>::try_from(columns)
    else {
        return None;
    };
    let (mut pixels, mut lines, mut pictures) = (None, Vec::new(), Vec::new());
    for (row, bytes) in bytes.into_iter().enumerate() {
        match content[row]? {
            PIXELS => pixels = Some(unpacked(&bytes)?),
            LINE => lines.push(line_of(&bytes)?),
            other => {
                let picture = *TileStyle::ALL.get(usize::try_from(other).ok()?)?;
                let tile = WebTile {
                    zoom: u8::try_from(zoom[row]?).ok()?,
                    x: u32::try_from(x[row]?).ok()?,
                    y: u32::try_from(y[row]?).ok()?,
                };
                pictures.push((picture, tile, bytes));
            }
        }
    }
    let known = pixels.map(|pixels| KnownTile { pixels, lines });
    Some(MapPart { known, pictures })
}

fn unpacked(bytes: &[u8]) -> Option<Pixels> {
    let mut values = Vec::new();
    let mut from = ZlibDecoder::new(bytes).take(MOST_PIXELS);
    from.read_to_end(&mut values).ok()?;
    Pixels::of_bytes(&values)
}

/// Packs the depth and the places of a line in 8 bytes each, the lowest first: as text they would
/// not come back to the bit.
fn line_bytes(line: &Isobath) -> Vec<u8> {
    let values = std::iter::once(line.depth_m).chain(line.points.iter().flatten().copied());
    values.flat_map(f64::to_le_bytes).collect()
}

fn line_of(bytes: &[u8]) -> Option<Isobath> {
    let (values, rest) = bytes.as_chunks::<8>();
    let values: Vec<f64> = values.iter().copied().map(f64::from_le_bytes).collect();
    let (depth_m, places) = values.split_first()?;
    let (points, odd) = places.as_chunks::<2>();
    (rest.is_empty() && odd.is_empty())
        .then(|| Isobath { depth_m: *depth_m, points: points.to_vec() })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::map_tiles::Pixel;
    use bathyscope_log::support::geo::UtmZone;
    use std::fs;

    const TILE: WebTile = WebTile { zoom: 16, x: 34_567, y: 22_222 };

    fn parts(folder: &Path, range_m: [f32; 2], sha256: &str) -> (MapParts, TileId) {
        let zone = UtmZone { number: 17, north: true };
        let under = TileId::at(zone, [393_000.0, 3_254_000.0]);
        let file =
            Fingerprint { file: "depth.tif".to_owned(), bytes: 7, sha256: sha256.to_owned() };
        let with = DrawnWith {
            program: "bathyscope".to_owned(),
            finest_zoom: 18,
            range_m,
            exaggeration: 5.0,
            interval_m: Some(0.5),
            isobaths: IsobathSettings::default(),
        };
        let maps = BTreeMap::from([(under, vec![file])]);
        (MapParts::new(folder.join("map_parts"), with, maps), under)
    }

    fn part() -> MapPart {
        let pixels = Pixels::draw(|[column, row]| {
            let depth_m = (1.0 / 3.0 + 1e-2 * (column + row) as f64) as f32;
            (depth_m < 2.0).then_some(Pixel { depth_m, light: 0.7 / depth_m })
        });
        let line =
            Isobath { depth_m: 0.1 + 0.2, points: vec![[1.0 / 3.0, 2e7 / 7.0], [0.1, 1e7 / 3.0]] };
        let pictures = TileStyle::ALL.map(|picture| (picture, TILE, vec![picture as u8; 9]));
        MapPart {
            known: pixels.map(|pixels| KnownTile { pixels, lines: vec![line] }),
            pictures: pictures.to_vec(),
        }
    }

    #[test]
    fn a_part_comes_back_to_the_bit_where_nothing_is_another() {
        let folder = tempfile::tempdir().unwrap();
        let empty = MapPart { known: None, pictures: Vec::new() };
        for part in [part(), empty] {
            let (parts, under) = parts(folder.path(), [1.0, 3.0], "a");
            parts.write(TILE, &[under], &part).unwrap();
            let found = parts.read(TILE, &[under]).expect("it was kept");
            assert_eq!(found.pictures, part.pictures);
            let bytes = |part: &MapPart| {
                let known = part.known.as_ref();
                known.map(|tile| (tile.pixels.to_bytes(), tile.lines.clone()))
            };
            assert!(bytes(&found) == bytes(&part));
        }
        for (range_m, sha256) in [([1.0, 3.5], "a"), ([1.0, 3.0], "b")] {
            let (other, under) = parts(folder.path(), range_m, sha256);
            assert!(other.read(TILE, &[under]).is_none());
        }
        let (same, under) = parts(folder.path(), [1.0, 3.0], "a");
        assert!(same.read(TILE, &[]).is_none());
        let other_tile = WebTile { x: 1, ..TILE };
        assert!(same.read(other_tile, &[under]).is_none());
    }

    #[test]
    fn a_damaged_file_is_none_and_those_of_another_map_go() {
        let folder = tempfile::tempdir().unwrap();
        let (first, under) = parts(folder.path(), [1.0, 3.0], "a");
        first.write(TILE, &[under], &part()).unwrap();
        let names = || names_in(&folder.path().join("map_parts")).unwrap();
        let path = folder.path().join("map_parts").join(&names()[0]);
        let whole = fs::read(&path).unwrap();
        for length in [0, 5, whole.len() / 2, whole.len() - 1] {
            fs::write(&path, &whole[..length]).unwrap();
            assert!(first.read(TILE, &[under]).is_none(), "{length}");
        }
        fs::write(&path, &whole).unwrap();
        let (second, under) = parts(folder.path(), [1.0, 3.0], "b");
        second.write(TILE, &[under], &part()).unwrap();
        assert_eq!(names().len(), 2);
        second.remove_others().unwrap();
        assert_eq!(names().len(), 1);
        assert!(second.read(TILE, &[under]).is_some());
    }
}

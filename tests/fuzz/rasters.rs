//! GeoTIFFs: heights, the rasters of archives, and pictures that lie under the map.

use super::{say, scratch};
use bathyscope_log::formats::base_map;
use bathyscope_log::formats::geotiff::{
    self, Band, CellFormat, RASTER_TILE, RasterSpec, RasterTiles,
};
use bathyscope_log::formats::geotiff::{read_cells, read_values};
use bathyscope_log::support::catch_panic::catch_panic;
use bathyscope_log::support::geo::Crs;
use bathyscope_log::support::progress::Progress;
use std::io::Cursor;
use tiff::decoder::Decoder;

/// Cells of an image, and of a block of it, that the fuzzer unpacks. A few bytes may ask for a
/// million times as many as they are, within the limits of the readers: what that takes is a matter
/// for other tests (`tests/suite/hostile`).
const MOST_CELLS: u64 = 1 << 18;
/// Images of one file that are looked at for that.
const MOST_IMAGES: usize = 8;

/// Returns true if no image of a file is large.
pub(super) fn is_small(bytes: &[u8]) -> bool {
    let sizes = || -> Option<bool> {
        let mut bytes = Cursor::new(bytes);
        geotiff::check_claims(&mut bytes).ok()?;
        let mut decoder = Decoder::new(bytes).ok()?;
        for _ in 0..MOST_IMAGES {
            let (columns, rows) = decoder.dimensions().ok()?;
            let (across, down) = decoder.chunk_dimensions();
            let largest =
                |width: u32, height: u32| u64::from(width.max(1)) * u64::from(height.max(1));
            if largest(columns, rows).max(largest(across, down.min(rows))) > MOST_CELLS {
                return Some(false);
            }
            if !decoder.more_images() || decoder.next_image().is_err() {
                break;
            }
        }
        Some(true)
    };
    // What the decoder does not take is refused at once.
    catch_panic(sizes).flatten().unwrap_or(true)
}

pub(super) fn cells(bytes: &[u8]) {
    if !is_small(bytes) {
        return;
    }
    scratch::with_file("raster.tif", bytes, |path| {
        if let Err(error) = read_cells(path) {
            say(&error);
        }
        match read_values(path) {
            Ok(raster) => assert_eq!(raster.values.len(), raster.columns * raster.rows),
            Err(error) => say(&error),
        }
    });
}

/// Tiles that are read of one input: each takes as long as all the rest.
const MOST_TILES: usize = 4;

pub(super) fn tiles(bytes: &[u8]) {
    if !is_small(bytes) {
        return;
    }
    scratch::with_file("tiles.tif", bytes, |path| match RasterTiles::open(path) {
        Ok(tiles) => {
            for tile in tiles.tiles().take(MOST_TILES) {
                let cells = RASTER_TILE * RASTER_TILE;
                match (tiles.levels(tile), tiles.values(tile)) {
                    (Ok(levels), _) => assert_eq!(levels.len(), cells),
                    (_, Ok(values)) => assert_eq!(values.len(), cells),
                    (Err(error), _) => say(&error),
                }
            }
            for halvings in 0..2 {
                if let Err(error) = tiles.overview(halvings) {
                    say(&error);
                }
            }
        }
        Err(error) => say(&error),
    });
}

pub(super) fn cells_seeds() -> Vec<Vec<u8>> {
    let of = |cells: CellFormat, columns: usize| {
        let spec = RasterSpec {
            columns,
            rows: 40,
            west: 500_000.0,
            north: 4_000_000.0,
            cell: [0.5, 0.5],
            crs: Crs::from_epsg(32_612).expect("a system"),
            cells,
            band: (cells == CellFormat::Metres).then_some(Band {
                name: "depth",
                unit: "metre",
                positive_down: true,
            }),
            description: "depth".into(),
        };
        let cell: &[u8] = match cells {
            CellFormat::Metres => &2.5_f32.to_le_bytes(),
            CellFormat::Rgba => &[9, 8, 7, 255],
            CellFormat::Level | CellFormat::Class => &[7],
        };
        let beside = scratch::folder().join("scratch");
        let mut options = std::fs::File::options();
        options.read(true).write(true).create(true).truncate(true);
        let beside = options.open(beside).expect("a file to write");
        let tile = cell.repeat(RASTER_TILE * RASTER_TILE);
        scratch::written("seed.tif", |file| {
            let draw = |_| Ok(tile.clone());
            let written = geotiff::write(file, beside, &spec, &[[0, 0]], draw, &Progress::new());
            written.expect("a raster");
        })
    };
    vec![
        of(CellFormat::Metres, 60),
        of(CellFormat::Level, 300),
        include_bytes!("../support/base_map/heights.tif").to_vec(),
    ]
}

pub(super) fn base_map(bytes: &[u8]) {
    if !is_small(bytes) {
        return;
    }
    let progress = Progress::new();
    scratch::with_file("map.tif", bytes, |path| match base_map::open(path, &progress) {
        Ok(map) => {
            assert!(map.pixel_m() >= 0.0 || map.pixel_m().is_nan());
            for pixels in [1.0, 8.0] {
                let window = map.window([0.0; 2], [64.0; 2], pixels, &progress);
                if let Some(window) = window {
                    assert_eq!(window.pixels.len(), (window.size[0] * window.size[1]) as usize);
                    window.at([3.0, 3.0]);
                }
            }
        }
        Err(error) => say(&error),
    });
}

pub(super) fn base_map_seeds() -> Vec<Vec<u8>> {
    vec![
        include_bytes!("../support/base_map/degrees_grey.tif").to_vec(),
        include_bytes!("../support/base_map/british.tif").to_vec(),
        include_bytes!("../support/base_map/jpeg.tif").to_vec(),
        include_bytes!("../support/base_map/late_palette.tif").to_vec(),
        include_bytes!("../support/base_map/masked_grey.tif").to_vec(),
    ]
}

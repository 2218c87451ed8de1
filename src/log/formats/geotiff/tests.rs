use super::*;
use crate::formats::points;
use std::path::Path;

fn geotiff(
    path: &Path,
    spec: &RasterSpec,
    tiles: &[[usize; 2]],
    draw: impl Fn([usize; 2]) -> Vec<u8> + Sync,
) {
    let file = File::create(path).unwrap();
    let scratch = tempfile::tempfile().unwrap();
    let draw = |tile| Ok(draw(tile));
    write(file, scratch, spec, tiles, draw, &Progress::new()).unwrap();
}

fn spec(columns: usize, rows: usize, cells: CellFormat) -> RasterSpec {
    RasterSpec {
        columns,
        rows,
        west: 500_000.0,
        north: 4_000_000.0,
        cell: [0.5, 0.5],
        crs: Crs::from_epsg(32_612).unwrap(),
        cells,
        band: (cells == CellFormat::Metres).then_some(Band {
            name: "depth",
            unit: "metre",
            positive_down: true,
        }),
        description: "depth".into(),
    }
}

/// A directory of a file: its offset, and the values of its tags as 64-bit numbers.
struct Directory {
    at: usize,
    tags: Vec<(u32, Vec<u64>)>,
}

impl Directory {
    fn get(&self, number: u32) -> &[u64] {
        let found = self.tags.iter().find(|tag| tag.0 == number);
        found.map(|tag| tag.1.as_slice()).unwrap_or_default()
    }

    fn text(&self, number: u32) -> String {
        let bytes = self.get(number).iter().map(|&byte| byte as u8);
        String::from_utf8(bytes.collect()).unwrap()
    }
}

fn directories(bytes: &[u8]) -> Vec<Directory> {
    let number = |at: usize, size: usize| {
        let bytes = bytes[at..at + size].iter().rev();
        bytes.fold(0_u64, |number, &byte| number << 8 | u64::from(byte))
    };
    let (mut at, mut found) = (number(4, 4) as usize, Vec::new());
    while at != 0 {
        let count = number(at, 2) as usize;
        let tag = |index: usize| {
            let entry = at + 2 + 12 * index;
            let size = match number(entry + 2, 2) {
                2 => 1,
                3 => 2,
                4 => 4,
                kind => {
                    assert_eq!(kind, 12, "a type that is not written");
                    8
                }
            };
            let values = number(entry + 4, 4) as usize;
            let first = if values * size <= 4 { entry + 8 } else { number(entry + 8, 4) as usize };
            let values = (0..values).map(|index| number(first + index * size, size));
            (number(entry, 2) as u32, values.collect())
        };
        let tags: Vec<(u32, Vec<u64>)> = (0..count).map(tag).collect();
        assert!(tags.is_sorted_by_key(|tag| tag.0));
        found.push(Directory { at, tags });
        at = number(at + 2 + 12 * count, 4) as usize;
    }
    found
}

/// Asserts the rules of a validator of Cloud-Optimized GeoTIFF: directories first and in order,
/// tiles from the coarsest level to the full picture, row by row.
fn assert_cloud_optimized(bytes: &[u8], found: &[Directory]) {
    assert_eq!(found[0].at, 8);
    assert!(found.is_sorted_by_key(|directory| directory.at));
    let last_directory = found.last().unwrap().at as u64;
    let mut levels: Vec<(u64, &Directory)> = Vec::new();
    for directory in found {
        let [places, lengths] = [324, 325].map(|tag| directory.get(tag));
        assert_eq!([places.len(), directory.get(322)[0] as usize], [lengths.len(), RASTER_TILE]);
        for (place, length) in places.iter().zip(lengths) {
            assert!(*place > last_directory && place + length <= bytes.len() as u64);
        }
        // Empty tiles share one place; the others follow each other.
        let mut own = places.to_vec();
        own.dedup();
        let mut once = own.clone();
        once.sort_unstable();
        once.dedup();
        let shared = own.len() - once.len();
        let ascending = own.windows(2).filter(|pair| pair[0] < pair[1]).count();
        assert!(ascending + 2 * shared + 1 >= own.len(), "{places:?}");
        levels.push((*places.iter().min().unwrap(), directory));
    }
    for pair in levels.windows(2) {
        let is_mask_of = pair[1].1.get(254)[0] & 4 != 0;
        if is_mask_of {
            assert_eq!(pair[0].1.get(256), pair[1].1.get(256))
        } else {
            assert!(pair[0].0 > pair[1].0, "coarser tiles lie before finer ones")
        }
    }
}

#[test]
fn directories_come_first_and_coarse_tiles_before_fine_ones() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.tif");
    let spec = spec(1000, 300, CellFormat::Metres);
    let draw = |[row, column]: [usize; 2]| {
        let metres = (10 * row + column) as f32;
        metres.to_le_bytes().repeat(RASTER_TILE * RASTER_TILE)
    };
    geotiff(&path, &spec, &[[0, 0], [1, 2]], draw);
    let bytes = std::fs::read(&path).unwrap();
    let found = directories(&bytes);
    assert_cloud_optimized(&bytes, &found);
    let size = |directory: &Directory| [254, 256, 257].map(|tag| directory.get(tag)[0]);
    let sizes: Vec<_> = found.iter().map(size).collect();
    assert_eq!(sizes, [[0, 1000, 300], [1, 500, 150], [1, 250, 75]]);
}

#[test]
fn a_band_has_a_name_a_unit_and_figures() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.tif");
    let mut tile = CellFormat::Metres.empty_tile();
    for (cell, metres) in [(0, 2.0_f32), (5, 3.0), (300, 7.0)] {
        tile[4 * cell..4 * cell + 4].copy_from_slice(&metres.to_le_bytes());
    }
    let spec = spec(100, 60, CellFormat::Metres);
    geotiff(&path, &spec, &[[0, 0]], |_| tile.clone());
    let found = directories(&std::fs::read(&path).unwrap());
    let text = found[0].text(42_112);
    for item in [
        "name=\"DESCRIPTION\" sample=\"0\" role=\"description\">depth<",
        "name=\"UNITTYPE\" sample=\"0\" role=\"unittype\">metre<",
        "name=\"positive\" sample=\"0\">down<",
        "name=\"STATISTICS_MINIMUM\" sample=\"0\">2<",
        "name=\"STATISTICS_MAXIMUM\" sample=\"0\">7<",
        "name=\"STATISTICS_MEAN\" sample=\"0\">4<",
        "name=\"STATISTICS_STDDEV\" sample=\"0\">2.1602",
        "name=\"STATISTICS_VALID_PERCENT\" sample=\"0\">0.05<",
    ] {
        assert!(text.contains(item), "{item} in {text}");
    }
    assert!(metadata::counts_downwards(&text));
}

#[test]
fn the_tag_and_not_the_sentence_says_which_way_depths_count() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.tif");
    let mut tile = CellFormat::Metres.empty_tile();
    tile[..4].copy_from_slice(&2.5_f32.to_le_bytes());
    for (positive_down, sentence) in
        [(true, "Surface"), (false, "Surface"), (false, "Depth in metres, positive down")]
    {
        let mut spec = spec(100, 60, CellFormat::Metres);
        spec.description = sentence.to_owned();
        spec.band = spec.band.map(|band| Band { positive_down, ..band });
        geotiff(&path, &spec, &[[0, 0]], |_| tile.clone());
        let found = points::read_elevations(path.as_os_str()).unwrap();
        let expected = if positive_down { -2.5 } else { 2.5 };
        assert_eq!(found.points[0][2], expected);
    }
}

#[test]
fn levels_have_one_band_and_a_mask_at_every_resolution() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.tif");
    let mut spec = spec(700, 700, CellFormat::Level);
    spec.band = Some(Band { name: "echo level", unit: "", positive_down: false });
    let draw = |[row, column]: [usize; 2]| {
        let level = |cell: usize| (cell % 7 * (row + column)) as u8;
        (0..RASTER_TILE * RASTER_TILE).map(level).collect()
    };
    geotiff(&path, &spec, &[[0, 1], [1, 0], [1, 1]], draw);
    let bytes = std::fs::read(&path).unwrap();
    let found = directories(&bytes);
    assert_cloud_optimized(&bytes, &found);
    // Kind of directory, columns, samples, bits, and photometric interpretation.
    let what = |directory: &Directory| [254, 256, 277, 258, 262].map(|tag| directory.get(tag)[0]);
    let whats: Vec<_> = found.iter().map(what).collect();
    let expected = [
        [0, 700, 1, 8, 1],
        [4, 700, 1, 1, 4],
        [1, 350, 1, 8, 1],
        [5, 350, 1, 1, 4],
        [1, 175, 1, 8, 1],
        [5, 175, 1, 1, 4],
    ];
    assert_eq!(whats, expected);
    // The mask of the middle tile: six of seven cells of a level are known.
    let mask = &found[1];
    let index = 4;
    let place = mask.get(324)[index] as usize;
    let packed = &bytes[place..place + mask.get(325)[index] as usize];
    let mask = pack::unpack(CellFormat::Level, packed).unwrap();
    assert_eq!(mask.len(), RASTER_TILE * RASTER_TILE / 8);
    assert_eq!(mask[..2], [0b0111_1110, 0b1111_1101]);
}

#[test]
fn halves_are_means_of_what_is_known() {
    let mut finer = CellFormat::Metres.empty_tile();
    let mut set = |row: usize, column: usize, metres: f32| {
        let at = 4 * (row * RASTER_TILE + column);
        finer[at..at + 4].copy_from_slice(&metres.to_le_bytes());
    };
    set(0, 0, 1.0);
    set(0, 1, 2.0);
    set(3, 2, 7.0);
    let mut coarser = CellFormat::Metres.empty_tile();
    pack::halve_into(CellFormat::Metres, &finer, [1, 0], &mut coarser);
    let at = |row: usize, column: usize| {
        let at = 4 * (row * RASTER_TILE + column);
        f32::from_le_bytes(coarser[at..at + 4].try_into().unwrap())
    };
    assert_eq!([at(128, 0), at(129, 1), at(128, 1), at(0, 0)], [1.5, 7.0, NODATA, NODATA]);
}

#[test]
fn tiles_come_back_as_they_were_drawn() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.tif");
    let level = |tile: [usize; 2], cell: usize| (1 + tile[0] + 3 * tile[1] + cell % 200) as u8;
    let inside = |tile: [usize; 2], cell: usize| {
        let [row, column] = [cell / RASTER_TILE, cell % RASTER_TILE];
        tile[0] * RASTER_TILE + row < 300 && tile[1] * RASTER_TILE + column < 700
    };
    let draw = |tile: [usize; 2]| -> Vec<u8> {
        let cells = 0..RASTER_TILE * RASTER_TILE;
        cells.map(|cell| u8::from(inside(tile, cell)) * level(tile, cell)).collect()
    };
    let drawn = [[0, 1], [1, 2]];
    geotiff(&path, &spec(700, 300, CellFormat::Level), &drawn, draw);
    let raster = RasterTiles::open(&path).unwrap();
    assert_eq!(raster.size(), [700, 300]);
    assert_eq!(raster.tiles().collect::<Vec<_>>(), drawn);
    for tile in drawn {
        assert!(raster.may_hold(tile));
        assert!(raster.levels(tile).unwrap() == draw(tile), "{tile:?}");
    }
    assert!(!raster.may_hold([0, 0]) && !raster.may_hold([0, 3]));
    assert!(raster.levels([0, 0]).unwrap().iter().all(|level| *level == 0));
    assert!(raster.values([0, 1]).is_err(), "levels are no numbers");
    let coarse = raster.overview(1).unwrap();
    assert_eq!(coarse.len(), 350 * 150);
    let four = [0, 1, 256, 257].map(|cell| u16::from(draw([0, 1])[cell]));
    let mean = (four.iter().sum::<u16>() + 2) / 4;
    assert_eq!(u16::from(coarse[128]), mean);
    assert_eq!(coarse[127], 0);
    assert!(raster.overview(3).is_err(), "the coarsest has one tile");
    std::fs::write(&path, b"II\x2a\0\x08\0\0\0").unwrap();
    assert!(RasterTiles::open(&path).is_err());
    assert!(raster.levels([0, 1]).is_err());
}

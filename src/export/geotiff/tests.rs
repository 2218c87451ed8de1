use super::*;

fn spec(columns: usize, rows: usize, cells: Cells) -> RasterSpec {
    RasterSpec {
        columns,
        rows,
        west: 500_000.0,
        north: 4_000_000.0,
        cell: [0.5, 0.5],
        crs: Crs::from_epsg(32_612).unwrap(),
        cells,
        description: "depth".into(),
    }
}

/// Reads the tags of the directory at a place, and the place of the next: number, type, count, value or offset.
fn read_directory(bytes: &[u8], at: usize) -> (Vec<[u32; 4]>, usize) {
    let short = |at: usize| u32::from(u16::from_le_bytes([bytes[at], bytes[at + 1]]));
    let long = |at: usize| u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap());
    let count = short(at) as usize;
    let tags = (0..count).map(|index| at + 2 + 12 * index);
    let tags = tags.map(|at| [short(at), short(at + 2), long(at + 4), long(at + 8)]);
    (tags.collect(), long(at + 2 + 12 * count) as usize)
}

#[test]
fn levels_halve_down_to_one_tile_and_tags_ascend() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.tif");
    let spec = spec(1000, 300, Cells::Metres);
    let draw = |[row, column]: [usize; 2]| {
        let metres = (10 * row + column) as f32;
        metres.to_le_bytes().repeat(RASTER_TILE * RASTER_TILE)
    };
    geotiff(&path, &spec, &[[0, 0], [1, 3]], draw, &Progress::new()).unwrap();
    let bytes = std::fs::read(&path).unwrap();
    let (mut at, mut sizes) = (
        u32::from_le_bytes(bytes[4..8].try_into().unwrap()) as usize,
        Vec::new(),
    );
    while at != 0 {
        let (tags, next) = read_directory(&bytes, at);
        assert!(tags.is_sorted_by_key(|tag| tag[0]));
        let value = |number: u32| tags.iter().find(|tag| tag[0] == number).unwrap()[3];
        sizes.push([value(254), value(256), value(257)]);
        at = next;
    }
    assert_eq!(sizes, [[0, 1000, 300], [1, 500, 150], [1, 250, 75]]);
}

#[test]
fn halves_are_means_of_what_is_known() {
    let mut finer = Cells::Metres.empty().repeat(RASTER_TILE * RASTER_TILE);
    let mut set = |row: usize, column: usize, metres: f32| {
        let at = 4 * (row * RASTER_TILE + column);
        finer[at..at + 4].copy_from_slice(&metres.to_le_bytes());
    };
    set(0, 0, 1.0);
    set(0, 1, 2.0);
    set(3, 2, 7.0);
    let mut coarser = Cells::Metres.empty().repeat(RASTER_TILE * RASTER_TILE);
    overview::halve_into(Cells::Metres, &finer, [1, 0], &mut coarser);
    let at = |row: usize, column: usize| {
        let at = 4 * (row * RASTER_TILE + column);
        f32::from_le_bytes(coarser[at..at + 4].try_into().unwrap())
    };
    assert_eq!(
        [at(128, 0), at(129, 1), at(128, 1), at(0, 0)],
        [1.5, 7.0, NODATA, NODATA]
    );
}

#[test]
fn packing_can_be_undone() {
    let bytes: Vec<u8> = (0..4 * RASTER_TILE * RASTER_TILE)
        .map(|index| (index * index / 7) as u8)
        .collect();
    for cells in [Cells::Rgba, Cells::Metres] {
        assert_eq!(
            unpack(cells, &pack(cells, bytes.clone()).unwrap()).unwrap(),
            bytes
        );
    }
}

#[test]
fn a_cancelled_raster_leaves_no_file() {
    let folder = tempfile::tempdir().unwrap();
    let progress = Progress::new();
    progress.cancel();
    let path = folder.path().join("a.tif");
    let empty = |_| vec![0; 4 * RASTER_TILE * RASTER_TILE];
    let stopped = geotiff(
        &path,
        &spec(300, 300, Cells::Rgba),
        &[[0, 0]],
        empty,
        &progress,
    );
    assert!(matches!(stopped, Err(RasterError::Cancelled(_))));
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
}

use super::*;
use crate::map_tiles::{TileStyle, WebTile, ZoomRange, web_pixel};
use bathyscope_log::support::geo::LonLat;
use flate2::read::GzDecoder;
use std::fs;

fn set(folder: &std::path::Path, bounds_deg: [f64; 4], cell_m: f64) -> TileSet {
    let zooms = ZoomRange::of_map(bounds_deg, cell_m);
    TileSet {
        name: "pond".to_owned(),
        description: "Depth in metres".to_owned(),
        scales: MapScales {
            zooms,
            range_m: [1.0, 3.0],
            levels_m: Vec::new(),
            isobaths: Default::default(),
        },
        store: store(folder, zooms),
    }
}

/// Creates a store with different pictures for all tiles, added in another order than they are
/// read.
fn store(folder: &std::path::Path, zooms: ZoomRange) -> TileStore {
    let store = TileStore::in_folder(folder).unwrap();
    for zoom in (zooms.coarsest..=zooms.finest).rev() {
        for tile in zooms.tiles(zoom) {
            // Lengths have no pattern, so that a directory does not compress well.
            let mixed = tile.hilbert_id().wrapping_mul(0x9e37_79b9_7f4a_7c15);
            let length = (mixed ^ mixed >> 29).wrapping_mul(0xbf58_476d_1ce4_e5b9) >> 56;
            let bytes = [&tile.x.to_le_bytes()[..], &vec![7; length as usize]].concat();
            store.keep(TileStyle::Colours, tile, &bytes).unwrap();
        }
    }
    store
}

/// A reader of PMTiles written after the specification.
struct Reader(Vec<u8>);

impl Reader {
    fn number(&self, at: usize) -> usize {
        u64::from_le_bytes(self.0[at..at + 8].try_into().unwrap()) as usize
    }

    fn part(&self, at: usize) -> &[u8] {
        &self.0[self.number(at)..][..self.number(at + 8)]
    }

    fn unpacked(packed: &[u8]) -> Vec<u8> {
        let mut bytes = Vec::new();
        GzDecoder::new(packed).read_to_end(&mut bytes).unwrap();
        bytes
    }

    /// Returns the number of the tile, run, length and place of every entry.
    fn entries(packed: &[u8]) -> Vec<[usize; 4]> {
        let bytes = Self::unpacked(packed);
        let (mut at, mut numbers) = (0, Vec::new());
        while at < bytes.len() {
            let (mut number, mut shift) = (0, 0);
            loop {
                number |= usize::from(bytes[at] & 0x7f) << shift;
                (at, shift) = (at + 1, shift + 7);
                if bytes[at - 1] < 0x80 {
                    break;
                }
            }
            numbers.push(number);
        }
        let count = numbers[0];
        let (mut id, mut end, mut entries) = (0, 0, Vec::new());
        for entry in 0..count {
            let column = |part: usize| numbers[1 + part * count + entry];
            id += column(0);
            let at = match column(3) {
                0 => end,
                more => more - 1,
            };
            end = at + column(2);
            entries.push([id, column(1), column(2), at]);
        }
        entries
    }

    fn tile(&self, id: usize) -> Option<&[u8]> {
        let mut directory = self.part(8);
        loop {
            let entries = Self::entries(directory);
            let found = entries.iter().rfind(|entry| entry[0] <= id)?;
            let [first, run, length, at] = *found;
            if run > 0 {
                return (first == id).then(|| &self.part(56)[at..at + length]);
            }
            directory = &self.part(40)[at..at + length];
        }
    }
}

#[test]
fn every_tile_of_a_pmtiles_file_is_found_whether_it_has_one_directory_or_many() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("depth.pmtiles");
    for (cell_m, wide, has_leaves) in [(0.5, 0.01, false), (0.08, 0.025, true)] {
        let bounds_deg = [-111.49, 36.85, -111.49 + wide, 36.85 + wide];
        let set = set(folder.path(), bounds_deg, cell_m);
        pmtiles(&path, &set, TileStyle::Colours).unwrap();
        let reader = Reader(fs::read(&path).unwrap());
        assert_eq!(&reader.0[..8], b"PMTiles\x03");
        assert_eq!(!reader.part(40).is_empty(), has_leaves);
        assert!(reader.number(8) + reader.number(16) <= 16_384);
        assert_eq!(reader.number(56) + reader.number(64), reader.0.len());
        let metadata: serde_json::Value =
            serde_json::from_slice(&Reader::unpacked(reader.part(24))).unwrap();
        assert_eq!(metadata["name"], "pond");
        let tiles = set.store.tiles(TileStyle::Colours);
        assert_eq!(reader.number(72), tiles.len());
        for (id, stored) in tiles.iter().step_by(37) {
            let expected = set.store.read(*stored).unwrap();
            assert_eq!(reader.tile(*id as usize), Some(expected.as_slice()));
        }
        let at = LonLat { lon_deg: 0.0, lat_deg: 0.0 };
        let elsewhere =
            WebTile::at_pixel(web_pixel(at, set.scales.zooms.finest), set.scales.zooms.finest);
        assert_eq!(reader.tile(elsewhere.hilbert_id() as usize), None);
    }
}

#[test]
fn the_same_tiles_give_the_same_bytes_in_whatever_order_they_come() {
    let folder = tempfile::tempdir().unwrap();
    let first = set(folder.path(), [-111.49, 36.85, -111.48, 36.86], 0.5);
    let turned = TileSet {
        name: first.name.clone(),
        description: first.description.clone(),
        scales: first.scales.clone(),
        store: TileStore::in_folder(folder.path()).unwrap(),
    };
    for (_, stored) in first.store.tiles(TileStyle::Colours) {
        let bytes = first.store.read(stored).unwrap();
        turned.store.keep(TileStyle::Colours, stored.tile, &bytes).unwrap();
    }
    let files =
        ["a.pmtiles", "b.pmtiles", "a.mbtiles", "b.mbtiles"].map(|name| folder.path().join(name));
    for (path, set) in files.iter().zip([&first, &turned, &first, &turned]) {
        if path.extension().is_some_and(|ending| ending == "pmtiles") {
            pmtiles(path, set, TileStyle::Colours).unwrap()
        } else {
            mbtiles(path, set, TileStyle::Colours).unwrap()
        }
    }
    let [a, b, c, d] = files.map(|path| fs::read(path).unwrap());
    assert!(a == b && c == d);
    assert_eq!(&c[68..72], b"MPBX");
    // Only the written files remain.
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 4);
}

#[test]
fn a_small_map_lies_in_its_page_and_a_large_one_beside_it() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("index.html");
    for name in PMTILES {
        fs::write(folder.path().join(name), b"tiles").unwrap();
    }
    let set = TileSet {
        name: "pond & </script>".to_owned(),
        description: "Depth".to_owned(),
        scales: MapScales {
            zooms: ZoomRange::of_map([9.0, 47.0, 9.01, 47.01], 0.5),
            range_m: [1.0, 3.0],
            levels_m: vec![1.0, 1.2],
            isobaths: Default::default(),
        },
        store: TileStore::in_folder(folder.path()).unwrap(),
    };
    let written = || {
        map_page(&path, &set).unwrap();
        fs::read_to_string(&path).unwrap()
    };
    let small = written();
    assert!(small.contains("id=\"depth.pmtiles\">dGlsZXM=</script>"));
    assert!(small.contains("<h1>pond &amp; &lt;/script&gt;</h1>") && !small.contains("{{"));
    assert!(!small.contains("http://") && small.matches("https://").count() == 1, "one remark");
    fs::write(folder.path().join(PMTILES[1]), vec![0; MOST_INSIDE as usize]).unwrap();
    let large = written();
    assert!(!large.contains("octet-stream") && large.contains("\"finest\":"));
    fs::remove_file(folder.path().join(PMTILES[1])).unwrap();
    assert!(map_page(&path, &set).is_err());
}

//! Base maps that GDAL wrote (`make.py`), read as GDAL reads them.

use bathyscope_log::formats::base_map::{BaseMap, open};
use bathyscope_log::support::geo::LonLat;
use bathyscope_log::support::progress::Progress;
use bathyscope_test_support::base_map;
use std::collections::HashMap;

fn opened(name: &str) -> BaseMap {
    open(&base_map(name), &Progress::new()).expect("a base map")
}

/// Longitude, latitude and colour of some pixels of each picture.
type Goldens = HashMap<String, Vec<(f64, f64, [u8; 4])>>;

fn goldens() -> Goldens {
    let text = std::fs::read_to_string(base_map("colours.json")).expect("the goldens");
    serde_json::from_str(&text).expect("positions and colours")
}

fn differs(a: [u8; 4], b: [u8; 4]) -> u8 {
    let off = a.into_iter().zip(b).map(|(a, b)| a.abs_diff(b));
    off.max().unwrap_or_default()
}

#[test]
fn pixels_lie_where_gdal_puts_them_in_the_colours_that_it_reads() {
    for (name, pixels) in goldens() {
        let map = opened(&name);
        // Decoders of JPEG round differently.
        let allowed = if name == "jpeg.tif" { 6 } else { 0 };
        for (lon_deg, lat_deg, colour) in pixels {
            let at = LonLat { lon_deg, lat_deg };
            assert!(map.covers(at));
            let place = map.place.to_pixels(at);
            for side in place {
                let off = (side.fract() - 0.5).abs();
                assert!(off < 1e-3, "{name}: the middle of a pixel is at {place:?}");
            }
            let window = map.window(place, place, 1.0, &Progress::new()).expect("pixels");
            let found = window.at(place);
            assert!(
                differs(found, colour) <= allowed,
                "{name} {place:?}: {found:?} is not {colour:?}"
            );
            let back = map.place.to_position(place);
            assert!(
                (back.lon_deg - lon_deg).abs() < 1e-10 && (back.lat_deg - lat_deg).abs() < 1e-10
            );
        }
    }
}

#[test]
fn a_far_look_takes_an_overview_and_an_overview_is_made_where_there_is_none() {
    let whole = |map: &BaseMap, pixels: f64| {
        let high = map.size.map(f64::from);
        map.window([0.0; 2], high, pixels, &Progress::new()).expect("pixels")
    };
    let map = opened("utm_rgb.tif");
    assert_eq!(map.size, [200, 150]);
    assert_eq!(whole(&map, 1.0).size, [200, 150]);
    assert_eq!(whole(&map, 2.5).size, [100, 75]);
    assert_eq!(whole(&map, 40.0).size, [50, 38]);
    assert!((map.pixel_m() - 0.3).abs() < 1e-3, "{}", map.pixel_m());

    let wide = opened("wide.tif");
    assert_eq!(wide.size, [5200, 640]);
    let far = whole(&wide, 3.0);
    assert_eq!(far.size, [1734, 214], "a third of it");
    // Blocks of 40 pixels: within one the mean is its colour.
    for (column, row) in [(60.0, 20.0), (2460.0, 340.0), (5180.0, 620.0)] {
        let near = wide.window([column, row], [column, row], 1.0, &Progress::new());
        assert_eq!(far.at([column, row]), near.expect("pixels").at([column, row]));
        assert_eq!(far.at([column, row])[3], 255);
    }
    assert_eq!(far.at([-1.0, 5.0]), [0; 4]);
    assert_eq!(far.at([5199.0, 639.0])[3], 255, "its last cells hold fewer pixels");
}

#[test]
fn what_cannot_lie_under_a_map_is_refused_in_a_sentence() {
    for (name, why) in [
        ("heights.tif", "8 bits a colour"),
        ("nowhere.tif", "where on Earth"),
        ("british.tif", "EPSG:27700"),
        ("turned.tif", "not north up"),
        ("colours.json", "cannot be read"),
        ("absent.tif", "cannot be read"),
    ] {
        let refused = open(&base_map(name), &Progress::new()).err();
        let text = refused.expect("refused").to_string();
        assert!(text.contains(why) && text.ends_with(name), "{text}");
        assert!(!text.contains('\n') && text.len() < 400, "{text}");
    }
}

#[test]
fn a_damaged_picture_is_refused_or_shows_less() {
    let whole = std::fs::read(base_map("utm_rgb.tif")).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("damaged.tif");
    let mut read = 0;
    for seed in 0..400usize {
        let mut bytes = whole.clone();
        if seed % 4 == 0 {
            bytes.truncate(whole.len() * seed / 400);
        }
        for step in 0..1 + seed % 7 {
            // Most of what decides lies in the first hundreds of bytes.
            let at = (seed * 7919 + step * 104_729) % if seed % 2 == 0 { 600 } else { whole.len() };
            if let Some(byte) = bytes.get_mut(at) {
                *byte = byte.wrapping_add((seed * 31 + step * 17) as u8 | 1);
            }
        }
        std::fs::write(&path, &bytes).unwrap();
        if let Ok(map) = open(&path, &Progress::new()) {
            read += 1;
            let high = map.size.map(f64::from);
            if let Some(window) = map.window([0.0; 2], high, 1.0, &Progress::new()) {
                assert_eq!(window.pixels.len(), (window.size[0] * window.size[1]) as usize);
            }
        }
    }
    assert!(read > 20, "some damage does not hurt: {read}");
}

//! Logs, base maps and coordinate systems as the crate reads them: real recordings, small logs
//! written byte by byte, and damaged ones.

#![allow(
    clippy::expect_used,
    clippy::unwrap_used,
    reason = "their failure is the failure of the test"
)]

mod base_map;
mod damage;
mod formats;

use bathyscope_log::support::geo::{Crs, CrsChoice, LonLat};
use std::path::Path;

/// Returns system, position and place of each line that `crs/make.py` wrote with PROJ.
fn goldens() -> Vec<(u16, LonLat, [f64; 2])> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/suite/crs/epsg.csv");
    let mut table = csv::Reader::from_path(path).expect("the goldens");
    let rows = table.deserialize().map(|row| {
        let (epsg, lon_deg, lat_deg, x, y) = row.expect("a row");
        (epsg, LonLat { lon_deg, lat_deg }, [x, y])
    });
    rows.collect()
}

#[test]
fn places_are_those_of_proj_to_a_millimetre_and_come_back() {
    let (mut held, mut refused) = (0, Vec::new());
    for (epsg, position, [x, y]) in goldens() {
        let Ok(crs) = Crs::from_epsg(epsg) else {
            refused.push(epsg);
            continue;
        };
        let place = crs.place(position);
        assert!((place[0] - x).hypot(place[1] - y) < 1e-3, "{crs}: {place:?}, not {x}, {y}");
        let back = crs.to_lon_lat(place);
        let off_deg = (back.lon_deg - position.lon_deg).hypot(back.lat_deg - position.lat_deg);
        assert!(off_deg < 1e-8, "{crs}: {back:?}");
        held += 1;
    }
    eprintln!("{held} systems agree, {} are not known: {refused:?}", refused.len());
    assert!(held > 150, "{held}");
    for named in [2154, 2193, 3006, 3035, 3857, 6350, 25832, 26912, 28355, 32612, 32756] {
        assert!(!refused.contains(&named), "{named}");
    }
}

#[test]
fn what_cannot_be_exact_is_refused_in_a_sentence() {
    let refusal = |epsg| Crs::from_epsg(epsg).expect_err("a refusal").to_string();
    assert!(refusal(27_700).contains("OSGB 1936 / British National Grid"));
    for (epsg, why) in [
        (27_700, "another datum"),
        (26_961, "another datum"),
        (2225, "in metres"),
        (4269, "in metres"),
        (9, "not known"),
    ] {
        let sentence = refusal(epsg);
        assert!(sentence.contains(why) && sentence.lines().count() == 1, "{sentence}");
    }
    let river = LonLat { lon_deg: -111.48, lat_deg: 36.86 };
    let elsewhere = CrsChoice::Epsg(32_733).at(river).expect_err("a refusal");
    assert!(elsewhere.to_string().contains("outside"), "{elsewhere}");
    assert_eq!(CrsChoice::Utm.at(river).map(|crs| crs.epsg()), Ok(32_612));
}

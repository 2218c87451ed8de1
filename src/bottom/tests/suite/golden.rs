//! Numbers that we did not compute: projections (pyproj 3.7.2 / PROJ 9.5.1) and the published
//! geometry.

use bathyscope_bottom::cloud::{Geometry, across_track, fixed_bottom_point};
use bathyscope_log::support::geo::{
    LocalFrame, LonLat, UtmZone, humminbird_mercator_inverse, lowrance_mercator,
    lowrance_mercator_inverse, web_mercator, web_mercator_inverse,
};
use bathyscope_log::survey::{PingNav, Side};

fn at(lon_deg: f64, lat_deg: f64) -> LonLat {
    LonLat { lon_deg, lat_deg }
}

fn assert_close(got: f64, expected: f64, tolerance: f64, what: &str) {
    assert!((got - expected).abs() <= tolerance, "{what}: got {got}, expected {expected}");
}

/// Name, lon, lat, EPSG:3857 x and y, Lowrance x and y.
type Mercator = (&'static str, f64, f64, [f64; 2], Option<[f64; 2]>);

const MERCATORS: [Mercator; 6] = [
    ("Citra", -82.110, 29.410, [-9140443.3890, 3427934.0649], Some([-9109797.213, 3416440.851])),
    ("paper origin", -82.170207413, 29.407394338, [-9147145.6475, 3427601.0975], None),
    (
        "Gainesville",
        -82.3248,
        29.6516,
        [-9164354.8157, 3458844.4248],
        Some([-9133628.469, 3447247.574]),
    ),
    ("lat 45", 10.0, 45.0, [1113194.9079, 5621521.4862], Some([1109462.576, 5602673.589])),
    ("Trondheim", 10.3951, 63.4305, [1157177.2387, 9206597.5329], Some([1153297.443, 9175729.554])),
    (
        "Sydney",
        151.2093,
        -33.8688,
        [16832542.2792, -4011198.6473],
        Some([16776105.952, -3997749.858]),
    ),
];

#[test]
fn mercators_agree_with_proj() {
    for (name, lon, lat, web, lowrance) in MERCATORS {
        let [x, y] = web_mercator(at(lon, lat));
        // The paper's origin is printed to 1e-9 degrees, which is 1e-4 m.
        let tolerance = if lowrance.is_none() { 2e-4 } else { 5.1e-5 };
        assert_close(x, web[0], tolerance, name);
        assert_close(y, web[1], tolerance, name);
        let back = web_mercator_inverse(x, y);
        assert_close(back.lon_deg, lon, 1e-12, name);
        assert_close(back.lat_deg, lat, 1e-12, name);
        let Some(lowrance) = lowrance else { continue };
        let [x, y] = lowrance_mercator(at(lon, lat));
        assert_close(x, lowrance[0], 5.1e-4, name);
        assert_close(y, lowrance[1], 5.1e-4, name);
        let back = lowrance_mercator_inverse(x, y);
        assert_close(back.lon_deg, lon, 1e-12, name);
        assert_close(back.lat_deg, lat, 1e-12, name);
    }
}

/// Targets by `Geod.fwd` from -82.110, 29.410; east and north by PROJ's cart + topocentric. The
/// targets are printed to 1e-9 degrees, 0.1 mm.
const ENU: [(f64, f64, f64, f64); 6] = [
    (-82.110000000, 29.410451090, 0.0, 50.0),
    (-82.109484812, 29.409999999, 50.0, 0.0),
    (-82.109271409, 29.410637936, 70.71068, 70.71068),
    (-82.111821437, 29.408405142, -176.77670, -176.77670),
    (-82.099696235, 29.409999602, 1000.0, 0.0),
    (-82.110000000, 29.419021799, 0.0, 1000.0),
];

#[test]
fn local_metres_agree_with_proj_and_come_back() {
    let frame = LocalFrame::new(at(-82.110, 29.410));
    for (lon, lat, east, north) in ENU {
        let what = format!("{lon} {lat}");
        let [e, n] = frame.to_enu(at(lon, lat));
        assert_close(e, east, 1.2e-4, &what);
        assert_close(n, north, 1.2e-4, &what);
        let back = frame.to_lon_lat(e, n);
        assert_close(back.lon_deg, lon, 1e-12, &what);
        assert_close(back.lat_deg, lat, 1e-12, &what);
    }
}

#[test]
fn local_metres_come_back_far_away_in_both_hemispheres() {
    for origin in [at(-82.11, 29.41), at(151.2, -33.9), at(10.4, 63.4), at(179.99, 0.0)] {
        let frame = LocalFrame::new(origin);
        for (east, north) in [(0.0, 0.0), (25_000.0, -40_000.0), (-300_000.0, 100_000.0)] {
            let [e, n] = frame.to_enu(frame.to_lon_lat(east, north));
            assert_close(e, east, 1e-6, "east");
            assert_close(n, north, 1e-6, "north");
        }
    }
}

/// First fix of the Humminbird recording of Glen Canyon, and the same fix in the Lowrance file that
/// was made from it.
#[test]
fn humminbird_and_lowrance_metres_name_the_same_place() {
    let humminbird = humminbird_mercator_inverse(-12_414_199.0, 4_396_652.0);
    assert_close(humminbird.lon_deg, -111.514_258_577, 1e-9, "lon");
    assert_close(humminbird.lat_deg, 36.878_808_302, 1e-9, "lat");
    let lowrance = lowrance_mercator_inverse(-12_372_090.0, 4_407_401.0);
    let [east_m, north_m] = LocalFrame::new(humminbird).to_enu(lowrance);
    // Lowrance rounds to a metre of its Mercator.
    assert_close(east_m, 0.0, 0.45, "east");
    assert_close(north_m, 0.0, 0.45, "north");
}

/// Section 2.4: p_i = (100, 200), p_(i+1) = (103, 204), p = 75 pixels of 0.0339774609375 m, alpha_2
/// = 16 degrees.
#[test]
fn the_published_point_is_exact() {
    let range_m = 75.0 * 0.0339774609375;
    assert_eq!(range_m, 2.5483095703125);
    let bottom_point = fixed_bottom_point(Geometry::Published, range_m, 16.0);
    assert_close(bottom_point.depth_m, 2.4495923793344425, 1e-15, "z");
    assert_close(bottom_point.across_m, 0.7024093117640908, 1e-15, "y");
    let place = PingNav {
        east_m: 100.0,
        north_m: 200.0,
        heading_rad: f64::atan2(3.0, 4.0),
        speed_mps: 1.0,
    };
    for (side, expected) in [
        (Side::Starboard, [100.56192744941127, 199.57855441294154]),
        (Side::Port, [99.43807255058873, 200.42144558705846]),
    ] {
        let got = across_track(&place, side, bottom_point.across_m).expect("a heading");
        assert_close(got[0], expected[0], 3e-14, side.name());
        assert_close(got[1], expected[1], 3e-14, side.name());
    }
}

/// pyproj 3.7.2, EPSG:4326 to EPSG:326xx and 327xx.
#[test]
fn utm_agrees_with_proj() {
    let table = [
        (-82.110, 29.410, 32617, [392311.9646, 3253923.7680]),
        (-111.516, 36.877, 32612, [454014.3267, 4081351.9874]),
        (151.2093, -33.8688, 32756, [334368.6336, 6250948.3454]),
        (10.3951, 63.4305, 32632, [569618.6286, 7034313.8490]),
        (2.9999, 0.0, 32631, [499988.8725, 0.0]),
        (-179.5, -60.25, 32701, [361631.4944, 3318124.8671]),
    ];
    for (lon, lat, epsg, expected) in table {
        let zone = UtmZone::of(at(lon, lat));
        assert_eq!(zone.epsg(), epsg);
        let [east_m, north_m] = zone.to_metres(at(lon, lat));
        assert_close(east_m, expected[0], 5.1e-5, "easting");
        assert_close(north_m, expected[1], 5.1e-5, "northing");
    }
}

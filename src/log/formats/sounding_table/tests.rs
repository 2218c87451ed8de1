//! Tests that tables are read correctly with all separators and names of columns, and that files
//! that are no recordings are refused.

use crate::formats::test_logs::{beginnings, garbled, held, says};
use crate::formats::{self, OpenError, open_growing};
use crate::support::progress::Progress;
use crate::survey::{SideScanState, Survey};

fn open(text: &str) -> Result<Survey, OpenError> {
    formats::open_bytes("pond.csv", text.into(), &Progress::new())
}

fn read(text: &str) -> Survey {
    open(text).unwrap_or_else(|error| panic!("{error}\n{text}"))
}

/// Returns time, longitude, latitude and depth of each row; every row must have all of them.
fn rows(survey: &Survey) -> Vec<[f64; 4]> {
    assert_eq!(survey.soundings.len(), survey.track.fixes.len());
    let fixes = survey.track.fixes.iter().zip(survey.soundings.iter());
    let rounded = |value: f64| (value * 1e6).round() / 1e6;
    let row = fixes.map(|(fix, sounding)| {
        assert_eq!(fix.time_s, sounding.time_s);
        let depth_m = f64::from(sounding.depth_m);
        [fix.time_s, fix.position.lon_deg, fix.position.lat_deg, depth_m].map(rounded)
    });
    row.collect()
}

const EXPECTED: [[f64; 4]; 3] =
    [[0.0, 11.5, 48.1, 2.5], [1.5, 11.6, 48.2, 3.0], [3.0, 11.7, 48.3, 3.5]];

#[test]
fn columns_are_found_by_their_names_whatever_separates_them() {
    for text in [
        "lon,lat,depth_m,time\n11.5,48.1,2.5,2021-10-12T00:53:20Z\n11.6,48.2,3,2021-10-12T00:53:21.5Z\n11.7,48.3,3.5,2021-10-12 00:53:23\n",
        "# exported\nDepth (m);Longitude;Latitude;Unix_s\n2,5;11,5;48,1;1634000000\n3;11,6;48,2;1634000001,5\n3,5;11,7;48,3;1634000003\n",
        "\u{feff}Timestamp\tLatitude\tLongitude\tWaterDepth(m)\tnote\r\n1634000000000\t48.1\t11.5\t2.5\tx\r\n1634000001500\t48.2\t11.6\t3\t\r\n1634000003000\t48.3\t11.7\t3.5\t\r\n",
        "\"Date\",\"Time\",\"Lat\",\"Lon\",\"Depth [m]\"\n\"2021-10-12\",\"00:53:20\",\"48.1\",\"11.5\",\"2.5\"\n2021-10-12,00:53:21.5,48.2,11.6,3\n2021-10-12,00:53:23,48.3,11.7,3.5\n",
    ] {
        let survey = read(text);
        assert_eq!(rows(&survey), EXPECTED, "{text}");
        assert_eq!(survey.start_unix_s, Some(1_634_000_000.0));
        assert_eq!(survey.side_scan_state, SideScanState::Absent);
        assert!(!says(&survey, "unit") && !says(&survey, "one second apart"));
    }
}

#[test]
fn feet_headings_and_depths_below_zero_are_read() {
    let survey =
        read("time_s,lon,lat,depth_ft,heading_deg\n0,11.5,48.1,-10,90\n1,11.5,48.1,-20,180\n");
    let depths: Vec<f32> = survey.soundings.iter().map(|sounding| sounding.depth_m).collect();
    assert_eq!(depths, [3.048, 6.096]);
    assert!(says(&survey, "negative in most rows"));
    assert_eq!(survey.start_unix_s, None);
    assert!((survey.track.fixes[1].compass_rad.to_degrees() - 180.0).abs() < 1e-4);
}

#[test]
fn rows_without_times_are_a_second_apart() {
    // A track as ReefMaster writes it.
    let survey = read("Latitude,Longitude,Depth\n48.1,11.5,2.5\n48.2,11.6,3\n48.3,11.7,3.5\n");
    let times: Vec<f64> = rows(&survey).iter().map(|row| row[0]).collect();
    assert_eq!(times, [0.0, 1.0, 2.0]);
    assert!(says(&survey, "one second apart") && says(&survey, "names no unit"));
    let survey = read("lat,lon,depth_m,time\n48.1,11.5,2.5,noon\n48.2,11.6,3,later\n");
    assert!(says(&survey, "one second apart"));
}

#[test]
fn deepers_table_has_depths_between_positions() {
    let text = "0.0,0.0,1.25,1634000000000,14.5\n48.1,11.5,1.5,1634000000066,14.5\n0.0,0.0,1.75,1634000000133,14.5\n48.2,11.6,2.0,1634000001000,14.5\n";
    let survey = read(text);
    assert_eq!(survey.source.recorder(), "CSV of soundings, Deeper");
    assert_eq!((survey.soundings.len(), survey.track.fixes.len()), (4, 2));
    assert_eq!(survey.soundings[1].time_s, 0.066);
    assert_eq!(survey.track.fixes[1].position.lat_deg, 48.2);
    assert_eq!(survey.start_unix_s, Some(1_634_000_000.0));
    let without = text.replace(",14.5", "");
    assert_eq!(read(&without).soundings.len(), 4);
}

#[test]
fn metres_wait_for_their_system() {
    let survey = read("Easting,Northing,Depth_m\n500000,5300000,2\n500003,5300004,3\n");
    let projected = survey.track.projected.as_ref().expect("metres");
    assert_eq!(projected.origin_m, [500_000.0, 5_300_000.0]);
    let [x, y] = survey.track.frame.to_enu(survey.track.fixes[1].position);
    assert!((x - 3.0).abs() < 1e-6 && (y - 4.0).abs() < 1e-6, "{x} {y}");
    assert!(says(&survey, "source.crs"));
    // Names as in exports of a GIS.
    let survey = read("x,y,depth_m\n11.5,48.1,2\n11.6,48.2,3\n");
    assert!(survey.track.projected.is_none());
    assert_eq!(survey.track.fixes[0].position.lat_deg, 48.1);
}

#[test]
fn damage_costs_its_row_and_is_said_with_its_place() {
    let text = "time_s,lon,lat,depth_m\n0,11.5,48.1,2.5\n1,x,y,z\n2,11.5,48.1,nan\n3,,,4\nnoon,11.5,48.1,5\n900000,11.5,48.1,6\n4,11.5,48.1,0\n5,11.5,191,7\n";
    let survey = read(text);
    let depths: Vec<f32> = survey.soundings.iter().map(|sounding| sounding.depth_m).collect();
    assert_eq!(depths, [2.5, 4.0, 7.0]);
    assert_eq!(survey.track.fixes.len(), 3);
    let places: Vec<u64> =
        survey.warnings.iter().filter_map(|warning| Some(warning.place?.1)).collect();
    let at = |row: &str| text.find(row).expect("a row") as u64;
    assert_eq!(places, [at("1,x"), at("noon"), at("900000")]);
}

#[test]
fn other_tables_are_no_recordings() {
    for text in [
        "time,level_m\n1634000000,1.5\n1634003600,2.5\n",
        "time,lon,lat\n1634000000,11.5,48.1\n1634000001,11.5,48.2\n",
        "x,y,z\n1,2,-3\n",
        "lon,lat,depth\n",
        "1,2,3\n4,5,6\n7,8,9\n",
        "48.1,11.5,2.5,5\n48.1,11.5,2.5,6\n48.1,11.5,2.5,7\n",
        "depth_m,area_m2,volume_m3\n1.000,5,6\n",
    ] {
        let error = open(text).expect_err(text);
        assert!(matches!(error, OpenError::NotRecognised { .. }), "{error}");
    }
    for own in [
        "ping,time_s,lon,lat,east_m,north_m,heading_deg,depth_m,port_sample\n0,0.0,11.5,48.1,0,0,90,2.5,100\n",
        "log,source,ping,lon,lat,east_m,north_m,z_m,kept\na,port,0,11.5,48.1,0,0,-2.5,1\n",
    ] {
        let error = open(own).expect_err(own);
        assert!(matches!(error, OpenError::Unsupported { .. }), "{error}");
        assert!(error.to_string().contains("that Bathyscope wrote"), "{error}");
    }
    let empty = open("lon,lat,depth_m\n1,2,99999\n").expect_err("no depth");
    assert!(matches!(empty, OpenError::Broken { .. }), "{empty}");
}

#[test]
fn a_folder_is_not_searched_for_tables() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("pond.csv");
    std::fs::write(&path, "lon,lat,depth_m\n11.5,48.1,2.5\n").expect("a table");
    assert!(formats::logs_in(folder.path()).is_empty());
    assert!(formats::unusable_in(folder.path()).is_empty());
    assert!(formats::open(&path, &Progress::new()).is_ok());
}

fn assert_bounded(bytes: Vec<u8>) {
    if let Ok(survey) = formats::open_bytes("pond.csv", bytes, &Progress::new()) {
        assert!(survey.soundings.len() <= 8 && survey.track.fixes.len() <= 8);
        let fixes = survey.track.fixes.iter();
        assert!(fixes.clone().all(|fix| fix.time_s.is_finite() && fix.position.is_on_earth()));
        assert!(
            survey
                .soundings
                .iter()
                .all(|sounding| sounding.time_s.is_finite() && sounding.depth_m > 0.0)
        );
    }
}

#[test]
fn hostile_bytes_neither_end_the_program_nor_make_up_depths() {
    let texts = [
        "date,time,lon,lat,depth_ft,cog\n2021-10-12,00:53:20,11.5,48.1,2.5,90\n2021-10-12,00:53:21,11.6,48.2,3,80\n",
        "easting;northing;depth_m;unix_s\n500000,5;5300000;2;1634000000\n500003;5300004;3;1634000001\n",
        "0.0,0.0,1.25,1634000000000,14.5\n48.1,11.5,1.5,1634000000066,14.5\n0.0,0.0,1.75,1634000000133,14.5\n",
    ];
    for text in texts {
        let garbled = garbled(text.as_bytes(), 88_172_645_463_325_252, 2000);
        beginnings(text.as_bytes()).chain(garbled).for_each(assert_bounded);
        for number in ["1e308", "-1e308", "inf", "nan", "99999999999999999999", "0", "-0", "é"] {
            for (at, _) in text.match_indices(|letter: char| letter.is_ascii_digit()) {
                assert_bounded([&text[..at], number, &text[at + 1..]].concat().into_bytes());
            }
        }
        // One row without an end.
        assert_bounded([text.as_bytes(), &vec![b','; 1 << 22]].concat());
    }
}

#[test]
fn a_growing_table_is_read_to_its_last_whole_row() {
    let row = |index: usize| format!("{index},11.5,48.1,{}.25\n", index + 2);
    let text = "time_s,lon,lat,depth_m\n".to_owned() + &(0..20).map(row).collect::<String>();
    for length in 100..text.len() {
        let files = held("pond.csv", &text.as_bytes()[..length]);
        let survey = open_growing(files, &Progress::new()).expect("a table");
        assert!(
            survey.soundings.iter().all(|sounding| sounding.depth_m.fract() == 0.25),
            "{length}"
        );
        assert!(!survey.warnings.iter().any(|warning| warning.place.is_some()));
    }
}

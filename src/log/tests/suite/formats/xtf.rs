//! Small XTF files: both sample widths, both kinds of positions.

use super::*;
use bathyscope_log::survey::RangeSource;

#[test]
fn eight_and_sixteen_bits_show_the_same_picture() {
    let narrow = read(handmade::xtf(20, 1, 3, (-73.6, 42.7), 0.0));
    assert_eq!(outward(&narrow, 4, Side::Starboard)[..3], [0, 1, 2]);
    assert_eq!(outward(&narrow, 4, Side::Port)[..3], [199, 198, 197]);
    // 12 bits are in use (199 * 20 = 3980): four are dropped.
    let wide = read(handmade::xtf(20, 2, 3, (-73.6, 42.7), 0.0));
    let expected: Vec<u8> = (0..200).map(|sample| (sample * 20 / 16) as u8).collect();
    assert_eq!(outward(&wide, 4, Side::Starboard), expected);
}

#[test]
fn altitude_is_depth_and_metres_are_local() {
    let survey = read(handmade::xtf(20, 1, 0, (412_000.0, 4_730_000.0), 7.5));
    assert_eq!(survey.soundings.len(), 20);
    assert_eq!(survey.side_scan[3].depth_m, 7.5);
    assert_eq!(survey.range_source, RangeSource::SurveyRecorder);
    assert!(says(&survey, "set source.crs to its EPSG number"));
    let [_, north_m] = survey.track.frame.to_enu(survey.track.fixes[19].position);
    assert!((north_m - 19.0 * 0.5).abs() < 0.01, "{north_m}");
    assert!((survey.side_scan[19].time_s - 1.9).abs() < 1e-6);
}

#[test]
fn a_recording_from_before_2000_has_its_date() {
    let mut bytes = handmade::xtf(20, 1, 3, (-73.6, 42.7), 0.0);
    let step = (bytes.len() - 1024) / 20;
    // In full, and as recorders with two digits wrote it.
    for year in [1997_u16, 97] {
        for ping in 0..20 {
            let at = 1024 + ping * step + 14;
            bytes[at..at + 2].copy_from_slice(&year.to_le_bytes());
        }
        let survey = read(bytes.clone());
        // `date -u -d "1997-06-01 12:00:00" +%s`
        assert_eq!(survey.start_unix_s, Some(865_166_400.0));
        assert_eq!(survey.side_scan.len(), 20);
    }
}

#[test]
fn bathymetry_without_side_scan_is_no_damage() {
    let bytes = handmade::xtf_bathymetry(40);
    let error = formats::open_bytes("lines.xtf", bytes, &Progress::new()).unwrap_err();
    assert!(matches!(error, OpenError::Unsupported { .. }), "{error}");
    let text = error.to_string();
    for words in [
        "40 bathymetry (type 2) and 20 attitude (type 3) packets",
        "no side-scan in it",
        "open the file that the side-scan was recorded into",
        "lines.xtf",
    ] {
        assert!(text.contains(words), "{text}");
    }
    assert!(!text.contains("damaged"), "{text}");
}

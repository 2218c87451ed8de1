//! Tests that depths of a multibeam sonar are read.

use super::super::read_multibeam;
use super::*;
use crate::formats::points::PointPlane;
use crate::support::geo::LocalFrame;

/// Number of beams in the datagram.
const BEAMS: usize = 101;
/// Depth of a flat bottom below the sonar, metres.
const DEPTH_M: f64 = 12.0;

/// Returns a datagram 0x13 of a flat bottom: 1.5 degrees a beam, 15 000 samples a second, 1500 m/s.
/// The first beam is bad.
fn datagram(roll_deg: f64) -> Vec<u8> {
    let mut bytes = vec![0; 36];
    let mut put = |at: usize, value: &[u8]| bytes[at..at + value.len()].copy_from_slice(value);
    put(0, &[0xFF, 0xFF, 0, 0, 0x13]);
    put(16, &1500_u16.to_be_bytes());
    put(18, &15_000_u16.to_be_bytes());
    put(33, &[15]);
    put(34, &(BEAMS as u16).to_be_bytes());
    for beam in 0..BEAMS {
        let angle_rad = ((beam as f64 - 50.0) * 1.5 - roll_deg).to_radians();
        let range_m = DEPTH_M / angle_rad.cos();
        bytes.extend(((range_m * 80.0).round() as u16).to_be_bytes());
    }
    bytes.push(0xF0);
    bytes.extend([0xFF; BEAMS / 2]);
    bytes
}

fn bathymetry(index: usize) -> Vec<u8> {
    let datagram = datagram(2.0);
    let (time, hundredths) = time(index);
    let header = PingHeader {
        packet: packet(2, size_of::<PingHeader>() + datagram.len()),
        time,
        hundredths,
        sensor_x: START.lon_deg,
        sensor_y: latitude(index),
        sensor_heading_deg: 90.0,
        sensor_roll_deg: 2.0,
        ..PingHeader::zeroed()
    };
    [bytes_of(&header), &datagram].concat()
}

#[test]
fn beams_become_depths_across_the_track() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("line.xtf");
    let file = Xtf { before: bathymetry, ..Xtf::default() };
    std::fs::write(&path, written(&file)).expect("a file");
    let read = read_multibeam(&path, &Progress::new()).expect("points");
    assert_eq!((read.plane, read.blank), (PointPlane::Degrees, 0));
    assert_eq!(read.points.len(), 40 * (BEAMS - 1));
    let frame = LocalFrame::new(START);
    for (index, &[lon_deg, lat_deg, z_m]) in read.points[..BEAMS - 1].iter().enumerate() {
        assert!((z_m + DEPTH_M).abs() < 0.04, "{index}: {z_m}");
        let angle_rad = ((index as f64 - 49.0) * 1.5 - 2.0).to_radians();
        // The heading is east, so starboard is south.
        let [east_m, north_m] = frame.to_enu(LonLat::new(lon_deg, lat_deg));
        let right_m = DEPTH_M * angle_rad.tan();
        assert!(east_m.abs() < 1e-6 && (north_m + right_m).abs() < 0.12, "{index}");
    }
    // The same file opens as side-scan; a file without beams has no points.
    let survey = read_survey(&written(&file));
    assert!(says(&survey, "40 bathymetry (type 2) packets that are no side-scan pings"));
    std::fs::write(&path, written(&Xtf::default())).expect("a file");
    let error = read_multibeam(&path, &Progress::new()).expect_err("no beams");
    assert!(error.to_string().contains("no beams of a Reson SeaBat"), "{error}");
}

fn read_survey(bytes: &[u8]) -> Survey {
    open(bytes.to_vec()).unwrap_or_else(|error| panic!("{error}"))
}

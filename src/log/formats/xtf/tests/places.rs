//! Tests the positions of the sonar: its own, those of a ship that tows it, and those of packets;
//! and the depths of a multibeam sonar.

use super::super::raw::{AttitudePacket, GyroPacket, NavigationPacket, RawNavigationPacket};
use super::super::read_multibeam;
use super::*;
use crate::formats::points::PointPlane;
use crate::support::geo::LocalFrame;

/// Returns the position of the fix of a ping relative to the ship, metres east and north.
fn from_ship(survey: &Survey, ping: usize) -> [f64; 2] {
    let ship = LocalFrame::new(LonLat::new(START.lon_deg, latitude(ping)));
    ship.to_enu(survey.track.fixes[ping].position)
}

fn assert_near(place: [f64; 2], expected: [f64; 2]) {
    let off_m = (place[0] - expected[0]).hypot(place[1] - expected[1]);
    assert!(off_m < 1e-3, "{place:?} for {expected:?}");
}

#[test]
fn the_ships_position_is_moved_back_by_the_layback() {
    fn ship_at(ping: &mut PingHeader, index: usize) {
        (ping.ship_x, ping.ship_y) = (START.lon_deg, latitude(index));
        ping.layback_m = 12.0;
    }
    // The heading is east.
    for ping in [
        |index: usize, ping: &mut PingHeader| ship_at(ping, index),
        |index: usize, ping: &mut PingHeader| {
            ship_at(ping, index);
            (ping.sensor_x, ping.sensor_y) = (ping.ship_x, ping.ship_y);
        },
        |index: usize, ping: &mut PingHeader| {
            ship_at(ping, index);
            (ping.sensor_heading_deg, ping.ship_gyro_deg) = (0.0, 90.0);
        },
    ] {
        let survey = read(&Xtf { ping, ..Xtf::default() });
        assert_near(from_ship(&survey, 5), [-12.0, 0.0]);
        assert!(says(&survey, "40 positions are the ship's and were moved to the sonar"));
        assert!(says(&survey, "by the stated layback of 12.0 m; mounting"));
    }
    // The antenna is 3 m forward and 1 m to port of the reference point.
    let survey = read(&Xtf {
        header: |header| (header.nav_offset_y_m, header.nav_offset_x_m) = (3.0, -1.0),
        ping: |index, ping| ship_at(ping, index),
        ..Xtf::default()
    });
    assert_near(from_ship(&survey, 5), [-15.0, -1.0]);
    // Without a heading, the direction from the ship to the sonar is unknown.
    let survey = read(&Xtf {
        ping: |index, ping| {
            ship_at(ping, index);
            ping.sensor_heading_deg = 0.0;
        },
        ..Xtf::default()
    });
    assert_near(from_ship(&survey, 5), [0.0, 0.0]);
    assert!(says(&survey, "no heading is known there"));
    // The length of cable alone gives no layback.
    let survey = read(&Xtf {
        ping: |index, ping| {
            ship_at(ping, index);
            (ping.layback_m, ping.cable_out_m) = (0.0, 40);
        },
        ..Xtf::default()
    });
    assert_near(from_ship(&survey, 5), [0.0, 0.0]);
    assert!(says(&survey, "up to 40 m of cable but no layback"));
}

#[test]
fn a_position_of_the_sonars_own_stays() {
    // The sonar is 12 m west of the ship.
    let survey = read(&Xtf {
        ping: |index, ping| {
            let ship = LonLat::new(START.lon_deg, latitude(index));
            let sonar = LocalFrame::new(ship).to_lon_lat(-12.0, 0.0);
            (ping.ship_x, ping.ship_y) = (ship.lon_deg, ship.lat_deg);
            (ping.sensor_x, ping.sensor_y) = (sonar.lon_deg, sonar.lat_deg);
            ping.layback_m = 12.0;
        },
        ..Xtf::default()
    });
    assert_near(from_ship(&survey, 5), [-12.0, 0.0]);
    assert!(says(&survey, "40 pings state a layback that was not applied"));
}

#[test]
fn a_position_that_repeats_is_moved_alike() {
    let survey = read(&Xtf {
        ping: |index, ping| {
            (ping.ship_x, ping.ship_y) = (START.lon_deg, latitude(index / 10));
            ping.sensor_heading_deg = 90.0 + index as f32 / 10.0;
            ping.layback_m = 50.0;
        },
        ..Xtf::default()
    });
    let places: Vec<LonLat> = survey.track.fixes.iter().map(|fix| fix.position).collect();
    assert_eq!(places.len(), 40);
    for ten in places.chunks(10) {
        assert!(ten.iter().all(|place| *place == ten[0]));
    }
    assert_ne!(places[0], places[10]);
}

/// Returns a packet with a position, for ten packets a second, a metre east of the ship of the
/// pings.
pub(super) fn raw_navigation(index: usize) -> Vec<u8> {
    let (time, hundredths) = time(index);
    let place = LocalFrame::new(LonLat::new(START.lon_deg, latitude(index))).to_lon_lat(1.0, 0.0);
    bytes_of(&RawNavigationPacket {
        packet: packet(107, 64),
        time,
        tenths_ms: u16::from(hundredths) * 100,
        x: place.lon_deg,
        y: place.lat_deg,
        heading_deg: 45.0,
        ..RawNavigationPacket::zeroed()
    })
    .to_vec()
}

#[test]
fn navigation_packets_stand_in_for_pings_without_positions() {
    let survey = read(&Xtf {
        ping: |_, ping| ping.sensor_heading_deg = 0.0,
        before: raw_navigation,
        ..Xtf::default()
    });
    assert_eq!(survey.track.fixes.len(), 40);
    assert_near(from_ship(&survey, 7), [1.0, 0.0]);
    let fix = survey.track.fixes[7];
    assert!((fix.time_s - 0.7).abs() < 1e-6);
    assert!((fix.compass_rad.to_degrees() - 45.0).abs() < 1e-4);
    assert!(says(&survey, "40 positions of navigation packets stand in"));
    // Positions of pings are preferred where they are good.
    let survey = read(&Xtf { before: raw_navigation, ..Xtf::default() });
    assert_eq!(survey.track.fixes.len(), 40);
    assert_near(from_ship(&survey, 7), [0.0, 0.0]);
    assert!(!says(&survey, "stand in") && !says(&survey, "skipped"));
    // The other kind of position packet, to which the layback of the pings applies.
    let survey = read(&Xtf {
        ping: |_, ping| ping.layback_m = 12.0,
        before: |index| {
            let (time, hundredths) = time(index);
            bytes_of(&NavigationPacket {
                packet: packet(42, 64),
                time,
                microseconds: u32::from(hundredths) * 10_000,
                x: START.lon_deg,
                y: latitude(index),
                ..NavigationPacket::zeroed()
            })
            .to_vec()
        },
        ..Xtf::default()
    });
    assert_near(from_ship(&survey, 7), [-12.0, 0.0]);
    assert!(says(&survey, "40 positions are the ship's and were moved"));
}

#[test]
fn old_positions_of_pings_give_way_to_those_of_packets() {
    let survey = read(&Xtf {
        pings: 300,
        // The receiver fails after ten seconds.
        ping: |index, ping| {
            (ping.sensor_x, ping.sensor_y) = (START.lon_deg, latitude(index.min(100)));
        },
        before: raw_navigation,
        ..Xtf::default()
    });
    let fixes = &survey.track.fixes;
    let frame = LocalFrame::new(START);
    let norths = fixes.iter().map(|fix| (fix.time_s, frame.to_enu(fix.position)[1]));
    let per_second_m = frame.to_enu(LonLat::new(START.lon_deg, latitude(10)))[1];
    for (time_s, north_m) in norths {
        let off_m = (north_m - per_second_m * time_s).abs();
        assert!(off_m < 5.1 * per_second_m, "{time_s}: {off_m}");
    }
    let late = fixes.iter().filter(|fix| fix.time_s > 15.1);
    assert_eq!(late.count(), 148);
    assert!(says(&survey, "positions of navigation packets stand in"));
}

#[test]
fn headings_come_from_other_packets_where_pings_have_none() {
    fn nothing_but_position(index: usize, ping: &mut PingHeader) {
        (ping.sensor_x, ping.sensor_y) = (START.lon_deg, latitude(index));
        ping.sensor_heading_deg = 0.0;
    }
    let gyro = |index: usize| {
        let (time, hundredths) = time(index);
        bytes_of(&GyroPacket {
            packet: packet(84, 64),
            time,
            microseconds: u32::from(hundredths) * 10_000,
            heading_deg: 30.0 + index as f32,
            ..GyroPacket::zeroed()
        })
        .to_vec()
    };
    let attitude = |index: usize| {
        let (time, hundredths) = time(index);
        bytes_of(&AttitudePacket {
            packet: packet(3, 64),
            time,
            milliseconds: u16::from(hundredths) * 10,
            heading_deg: 30.0 + index as f32,
            ..AttitudePacket::zeroed()
        })
        .to_vec()
    };
    for before in [gyro as fn(usize) -> Vec<u8>, attitude] {
        let survey = read(&Xtf { ping: nothing_but_position, before, ..Xtf::default() });
        let heading_deg = survey.track.fixes[12].compass_rad.to_degrees();
        assert!((heading_deg - 42.0).abs() < 1e-4, "{heading_deg}");
        assert!(says(&survey, "40 pings have the heading of other packets"));
        let is_attitude = before(0)[2] == 3;
        assert_eq!(says(&survey, "pitch, roll and heave"), is_attitude);
    }
}

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
    let found = read_multibeam(&path, &Progress::new()).expect("points");
    assert_eq!((found.plane, found.blank), (PointPlane::Degrees, 0));
    assert_eq!(found.points.len(), 40 * (BEAMS - 1));
    let frame = LocalFrame::new(START);
    for (index, &[lon_deg, lat_deg, z_m]) in found.points[..BEAMS - 1].iter().enumerate() {
        assert!((z_m + DEPTH_M).abs() < 0.04, "{index}: {z_m}");
        let angle_rad = ((index as f64 - 49.0) * 1.5 - 2.0).to_radians();
        // The heading is east, so starboard is south.
        let [east_m, north_m] = frame.to_enu(LonLat::new(lon_deg, lat_deg));
        let right_m = DEPTH_M * angle_rad.tan();
        assert!(east_m.abs() < 1e-6 && (north_m + right_m).abs() < 0.12, "{index}");
    }
    // The same file opens as side-scan; a file without beams has no points.
    let survey = read(&file);
    assert!(says(&survey, "40 bathymetry (type 2) packets that are no side-scan pings"));
    std::fs::write(&path, written(&Xtf::default())).expect("a file");
    let error = read_multibeam(&path, &Progress::new()).expect_err("no beams");
    assert!(error.to_string().contains("no beams of a Reson SeaBat"), "{error}");
}

//! Boxes that an analyst draws around a hull: the object is what was drawn, and its picture shows
//! all of it.

use bathyscope_bottom::calibration::{Calibration, CalibrationSettings, calibrate};
use bathyscope_bottom::first_return::{FirstReturns, Pick};
use bathyscope_log::support::progress::Progress;
use bathyscope_log::survey::{
    Bytes, Encoding, Navigation, PingNav, Relief, SampleOrder, Side, SidePing, SideSpan, Survey,
};
use bathyscope_objects::targets::{Placer, Target, TopShape};
use bathyscope_objects::{Mark, ObjectExtent, Raster};
use bathyscope_products::export;
use std::sync::Arc;

const PINGS: usize = 700;
const SAMPLES: usize = 600;
/// Height of the transducer above the bottom.
const ALTITUDE_M: f64 = 8.0;
/// Pings of the hull: 100 m at the spacings of [`north_m`].
const HULL: std::ops::Range<usize> = 100..500;

/// The boat goes north, 0.2 m a ping, and half as fast again from ping 300 on.
fn north_m(ping: usize) -> f64 {
    0.2 * ping as f64 + 0.1 * ping.saturating_sub(300) as f64
}

/// Returns a survey of an even bottom with speckle that is the same on every run, and with `level`
/// where that gives a value. Samples are 0.1 m of slant range to starboard.
fn survey(level: impl Fn(usize, f64) -> Option<u8>) -> (Survey, Navigation) {
    let mut bytes = Vec::with_capacity(PINGS * SAMPLES);
    let mut random = 1_u32;
    for ping in 0..PINGS {
        for sample in 0..SAMPLES {
            random = random.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            let speckle = (random >> 27) as u8;
            let quiet = level(ping, 0.1 * (sample as f64 + 0.5)).unwrap_or(70);
            bytes.push(quiet.saturating_add(speckle));
        }
    }
    let span = |ping: usize| SideSpan {
        file: 0,
        encoding: Encoding::U8,
        order: SampleOrder::NearToFar,
        offset: (ping * SAMPLES) as u64,
        count: SAMPLES as u32,
        near_m: 0.0,
        far_m: 0.1 * SAMPLES as f32,
    };
    let pings = (0..PINGS).map(|ping| SidePing {
        starboard: Some(span(ping)),
        ..SidePing::with_depth(ping as f64 * 0.1, ALTITUDE_M as f32)
    });
    let survey = Survey { bytes: vec![Bytes::Held(Arc::new(bytes))], ..Survey::of_pings(pings) };
    let places = (0..PINGS).map(|ping| PingNav {
        east_m: 0.0,
        north_m: north_m(ping),
        heading_rad: 0.0,
        speed_mps: if ping < 300 { 2.0 } else { 3.0 },
    });
    (survey, Navigation::of_pings(places))
}

fn place(survey: &Survey, navigation: &Navigation, mark: &Mark) -> Target {
    let returns = FirstReturns {
        port: vec![Pick::NONE; PINGS].into(),
        starboard: vec![Pick::NONE; PINGS].into(),
        ..FirstReturns::default()
    };
    let (settings, progress) = (CalibrationSettings::default(), Progress::new());
    let calibration: Calibration =
        calibrate(survey, navigation, &returns, &[], &settings, &progress).expect("not cancelled");
    let level = Relief::default();
    let placer = Placer::new(survey, navigation, &returns, &calibration, 1.0, &level);
    placer.place(mark, ObjectExtent::Found, None, TopShape::Unknown).expect("a place")
}

fn drawn(near_m: f64, far_m: f64) -> Mark {
    Mark { side: Side::Starboard, pings: HULL, near_m, far_m }
}

/// Distance from the track of what lies on the bottom at a slant range.
fn ground_m(slant_m: f64) -> f64 {
    (slant_m * slant_m - ALTITUDE_M * ALTITUDE_M).sqrt()
}

/// A hull from 20 to 44 m: two bright walls, and between them a hold darker than the bottom.
fn hull(ping: usize, range_m: f64) -> Option<u8> {
    let is_wall = (20.0..24.0).contains(&range_m) || (41.0..44.0).contains(&range_m);
    let is_hold = (24.0..41.0).contains(&range_m);
    match HULL.contains(&ping) {
        true if is_wall => Some(170),
        true if is_hold => Some(10),
        _ => None,
    }
}

#[test]
fn a_hull_lies_in_the_middle_of_its_box_and_is_as_large() {
    let (survey, navigation) = survey(hull);
    let target = place(&survey, &navigation, &drawn(20.0, 44.0));
    let middle_m = 0.5 * (ground_m(20.0) + ground_m(44.0));
    println!(
        "{:.2} m off across, {:.2} m along, {:.1} x {:.1} m",
        target.east_m - middle_m,
        target.north_m - 70.0,
        target.length_m,
        target.width_m
    );
    // Walls 24 m apart with a dark hold between: none of it is shadow.
    assert!((target.east_m - middle_m).abs() < 0.2, "{target:?}");
    assert!((target.width_m - (ground_m(44.0) - ground_m(20.0))).abs() < 0.4);
    assert!(target.height_m.is_nan(), "there is no shadow");
    // Half of the way, not half of the pings: 20 m to ping 100, 100 m over the hull.
    assert!((target.north_m - 70.0).abs() < 0.3, "{}", target.north_m);
    assert!((target.length_m - 100.0).abs() < 1.0);
}

#[test]
fn the_shadow_of_a_hull_that_lies_askew_is_no_part_of_it() {
    // From 20 m at its first ping to 30 m at its last, 6 m thick, with a shadow 4 m long behind.
    let near_m = |ping: usize| 20.0 + 10.0 * (ping - HULL.start) as f64 / HULL.len() as f64;
    let (survey, navigation) = survey(|ping, range_m| {
        let behind_m = HULL.contains(&ping).then(|| range_m - near_m(ping))?;
        match behind_m {
            0.0..6.0 => Some(170),
            6.0..10.0 => Some(10),
            _ => None,
        }
    });
    let target = place(&survey, &navigation, &drawn(20.0, 40.0));
    // The echo reaches to 36 m, where the last slice of a fifth of the box tells it within a metre.
    let middle_m = 0.5 * (ground_m(20.0) + ground_m(36.0));
    println!("{:.2} m off across", target.east_m - middle_m);
    // The shadow tells a height, and of what stands high the place is nearer by half of what it
    // leans.
    assert!((target.east_m - middle_m).abs() < 1.0, "{target:?}");
    assert!((0.5..1.5).contains(&target.height_m), "{target:?}");
}

#[test]
fn the_picture_of_a_hull_shows_all_of_it() {
    let (survey, navigation) = survey(hull);
    let raster = Raster::new(&survey, &navigation, 0.04);
    let chip = export::chip(&survey, &raster, &drawn(20.0, 44.0));
    // 100 by 24 m and what lies around, in pixels of one size.
    assert!(chip.width > 100 && chip.height > 380, "{} x {}", chip.width, chip.height);
    let row = &chip.levels[chip.width * (chip.height / 2)..][..chip.width];
    let (least, most) = (row.iter().min(), row.iter().max());
    assert!(most > Some(&150) && least < Some(&60), "walls and hold: {row:?}");
    let column = |x: usize| (0..chip.height).map(move |y| y * chip.width + x);
    let wall = (0..chip.width)
        .max_by_key(|&x| column(x).map(|at| u32::from(chip.levels[at])).sum::<u32>());
    let bright = column(wall.expect("columns")).filter(|&at| chip.levels[at] > 120);
    let share = bright.count() as f64 / chip.height as f64;
    assert!((0.75..0.97).contains(&share), "{share:.2} of the rows show the wall");
}

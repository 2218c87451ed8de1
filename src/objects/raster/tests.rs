use super::*;
use crate::testing::survey;
use std::sync::Arc;

#[test]
fn a_mark_and_its_box_are_the_same_place() {
    let (survey, navigation) = survey(200, |_, _| 0);
    let raster = Raster::new(&survey, &navigation, 0.04);
    assert_eq!(raster.columns(), 250);
    let mark = Mark::new(Side::Port, 40..52, [3.2, 4.8]);
    let rect = raster.rect_of(&mark);
    // Twelve pings of 0.2 m are 60 rows of 0.04 m.
    assert!((rect.y1 - rect.y0 - 60.0).abs() < 0.01, "{rect:?}");
    assert!((rect.x0 - 80.0).abs() < 1e-3 && (rect.x1 - 120.0).abs() < 1e-3);
    let back = raster.mark_of(Side::Port, &rect);
    assert_eq!((back.side, back.pings.clone()), (mark.side, mark.pings));
    assert!((back.near_m - 3.2).abs() < 1e-5 && (back.far_m - 4.8).abs() < 1e-5);
    assert_eq!(back.samples(&survey), 32..48);
}

#[test]
fn a_bright_patch_lands_in_its_box() {
    let (survey, navigation) = survey(200, |ping, sample| {
        u8::from((40..52).contains(&ping) && (32..48).contains(&sample)) * 200
    });
    let raster = Raster::new(&survey, &navigation, 0.04);
    let tile = raster.tile(&survey, Side::Port, 100, 50);
    let mark = Mark::new(Side::Port, 40..52, [3.2, 4.8]);
    let rect = raster.rect_of(&mark).shifted(-50.0, -100.0);
    for (index, &pixel) in tile.pixels.iter().enumerate() {
        let (x, y) = ((index % TILE_PX) as f32 + 0.5, (index / TILE_PX) as f32 + 0.5);
        // Interpolation blurs the edges by a ping (5 rows) along the track, and by a pixel in
        // range.
        let inside = |grow_x: f32, grow_y: f32| {
            (rect.x0 - grow_x..rect.x1 + grow_x).contains(&x)
                && (rect.y0 - grow_y..rect.y1 + grow_y).contains(&y)
        };
        if inside(-1.5, -3.0) {
            assert_eq!(pixel, 200, "dark inside at {x}, {y}");
        }
        if !inside(1.5, 3.0) {
            assert_eq!(pixel, 0, "bright outside at {x}, {y}");
        }
    }
}

#[test]
fn a_side_that_was_not_recorded_is_dark_and_an_empty_survey_has_no_rows() {
    let (some, navigation) = survey(20, |_, _| 90);
    let raster = Raster::new(&some, &navigation, 0.04);
    let tile = raster.tile(&some, Side::Starboard, 0, 0);
    assert!(tile.pixels.iter().all(|&pixel| pixel == 0));
    let (none, navigation) = survey(0, |_, _| 0);
    let raster = Raster::new(&none, &navigation, 0.04);
    assert_eq!((raster.rows(), raster.columns()), (0, 0));
    assert_eq!(raster.tile(&none, Side::Port, 0, 0).pixels.len(), TILE_PX * TILE_PX);
}

#[test]
fn positions_that_jump_do_not_stretch_the_picture() {
    let (some, mut navigation) = survey(200, |_, _| 90);
    let sound = Raster::new(&some, &navigation, 0.04).rows();
    for (ping, place) in Arc::make_mut(&mut navigation.pings).iter_mut().enumerate() {
        place.speed_mps = 10f64.powi(ping as i32 % 8 + 1);
    }
    let rows = Raster::new(&some, &navigation, 0.04).rows();
    assert!(rows <= sound, "{rows} rows instead of {sound}");
}

#[test]
fn what_few_pings_were_recorded_to_is_not_searched() {
    let (mut some, navigation) = survey(400, |_, _| 90);
    for ping in Arc::make_mut(&mut some.side_scan).iter_mut().step_by(5) {
        ping.port.as_mut().unwrap().far_m = 400.0;
    }
    let raster = Raster::new(&some, &navigation, 0.04);
    assert_eq!(raster.columns(), 10_000);
    let is_recorded = |column| raster.is_recorded(&some, Side::Port, 300, column);
    assert!(is_recorded(0));
    assert!(!is_recorded(208) && !is_recorded(9_000));
    // A survey that is narrower than a tile is recorded everywhere.
    let (narrow, navigation) = survey(400, |_, _| 90);
    let raster = Raster::new(&narrow, &navigation, 0.04);
    assert!(raster.is_recorded(&narrow, Side::Port, 300, 0));
}

//! Measuring in the waterfall: by mouse and by keys, against the known objects of the demo.

use crate::bottom::draw;
use crate::review::mouse::at;
use crate::window::{Window, app, demo_window, press};
use crate::{map_tools, support};
use bathyscope_products::project::MeasurementKind;
use egui::{Key, Modifiers};
use egui_kittest::kittest::Queryable as _;

/// A sighting of an object of the demo, from the simulator's own table.
struct Sighting {
    ping: f64,
    height_m: f64,
    echo_m: f64,
    shadow_m: [f64; 2],
}

/// The sightings of an object on starboard whose shadow ends within the range.
fn sightings(object: &str) -> Vec<Sighting> {
    let path = support::demo_log().with_file_name("demo.objects.csv");
    let mut table = csv::Reader::from_path(path).expect("the table");
    let headers = table.headers().expect("a header").clone();
    let column = |name: &str| headers.iter().position(|heading| heading == name).expect("a column");
    let names = ["first_ping", "last_ping", "height_m", "near_m", "shadow_start_m", "shadow_end_m"];
    let numbers = names.map(column);
    let (of, side) = (column("object"), column("side"));
    let rows = table.records().map(|row| row.expect("a row"));
    let wanted = rows.filter(|row| &row[of] == object && &row[side] == "starboard");
    wanted
        .filter_map(|row| {
            let [first, last, height_m, echo_m, start_m, end_m] =
                numbers.map(|at| row[at].parse::<f64>());
            Some(Sighting {
                ping: 0.5 * (first.ok()? + last.ok()?) + 0.5,
                height_m: height_m.ok()?,
                echo_m: echo_m.ok()?,
                shadow_m: [start_m.ok()?, end_m.ok()?],
            })
        })
        .collect()
}

fn click(window: &mut Window, ping: f64, across_m: f64) {
    let pos = at(window, ping, across_m);
    map_tools::click(window, pos);
}

#[test]
fn a_drag_along_a_shadow_gives_the_height_of_a_known_block() {
    let mut window = demo_window();
    press(&mut window, Modifiers::NONE, Key::F);
    let seen = &sightings("0")[0];
    press(&mut window, Modifiers::NONE, Key::H);
    assert_eq!(app(&window).map.measuring.tool, Some(MeasurementKind::Height));
    let [start_m, end_m] = seen.shadow_m;
    draw(&mut window, Modifiers::NONE, (seen.ping, start_m), (seen.ping + 8.0, end_m));
    let found = app(&window).measured_height().expect("results").expect("a height");
    let off = found.height_m() / seen.height_m - 1.0;
    println!(
        "a block of {:.2} m: {:.3} m ± {:.3} m, off by {:.1} %",
        seen.height_m,
        found.height_m(),
        found.sigma_m(),
        100.0 * off
    );
    assert!(off.abs() < 0.1, "{found:?}");
    assert!(!found.is_least);
    // The end lies on the ping of the top, wherever the hand let go.
    let figure = app(&window).map.measuring.figure.clone().expect("a figure");
    assert!(figure.done);
    assert_eq!(figure.measurement.picks[&0].ping, figure.measurement.picks[&1].ping);
    window.get_by_label_contains("Construction: height");
    window.get_by_label("Altitude H");

    press(&mut window, Modifiers::NONE, Key::Escape);
    press(&mut window, Modifiers::COMMAND, Key::Z);
    assert!(app(&window).measured_height().is_none(), "one end is left");
    press(&mut window, Modifiers::COMMAND | Modifiers::SHIFT, Key::Z);
    assert_eq!(app(&window).measured_height(), Some(Ok(found)));
    // The water column holds no shadow's end.
    press(&mut window, Modifiers::NONE, Key::H);
    draw(&mut window, Modifiers::NONE, (seen.ping, 0.8), (seen.ping, 1.2));
    let refused = app(&window).measured_height().expect("results");
    assert!(refused.is_err(), "{refused:?}");
    // On the picture and in the panel.
    let said = window.query_all_by_label_contains("the shadow ends in the water column");
    assert!(said.count() > 0);
}

#[test]
fn a_block_on_two_passes_is_no_farther_apart_than_it_is_large() {
    let mut window = demo_window();
    press(&mut window, Modifiers::NONE, Key::F);
    let seen = sightings("0");
    press(&mut window, Modifiers::NONE, Key::D);
    for sighting in &seen[..2] {
        click(&mut window, sighting.ping, sighting.echo_m);
    }
    press(&mut window, Modifiers::NONE, Key::Enter);
    let figure = app(&window).map.measuring.figure.clone().expect("a figure");
    let apart_m = figure.measurement.length_m();
    println!("one block on two passes: {apart_m:.2} m apart");
    assert_eq!(figure.measurement.picks.len(), 2);
    // What is clicked are the near edges of a block of 1 m by 0.7 m, which are others from other
    // lines.
    assert!(apart_m < 1.5, "{apart_m}");
    // On the slant range it would be more than that from the water column to the bottom.
    press(&mut window, Modifiers::NONE, Key::Escape);
    press(&mut window, Modifiers::NONE, Key::D);
    let ping = seen[0].ping;
    for across_m in [-5.0, 5.0] {
        click(&mut window, ping, across_m);
    }
    press(&mut window, Modifiers::NONE, Key::Enter);
    let figure = app(&window).map.measuring.figure.clone().expect("a figure");
    let across_m = figure.measurement.length_m();
    println!("10 m of slant range across the boat: {across_m:.2} m on the ground");
    assert!((8.5..9.5).contains(&across_m), "{across_m}");
}

#[test]
fn a_shadow_is_measured_by_keys_alone() {
    let mut window = demo_window();
    press(&mut window, Modifiers::NONE, Key::F);
    press(&mut window, Modifiers::NONE, Key::Num1);
    press(&mut window, Modifiers::NONE, Key::H);
    // The cross starts in the middle, on the nadir.
    for key in [
        Key::ArrowDown,
        Key::ArrowDown,
        Key::ArrowDown,
        Key::ArrowDown,
        Key::ArrowDown,
        Key::ArrowDown,
    ] {
        press(&mut window, Modifiers::NONE, key);
    }
    press(&mut window, Modifiers::NONE, Key::X);
    for _ in 0..3 {
        press(&mut window, Modifiers::NONE, Key::ArrowDown);
    }
    press(&mut window, Modifiers::NONE, Key::X);
    let figure = app(&window).map.measuring.figure.clone().expect("a figure");
    assert!(figure.done && figure.measurement.picks.len() == 2, "{figure:?}");
    assert!(app(&window).measured_height().is_some());
}

//! The passes that saw a place: as the map's menu lists them, and one after the other from a
//! selected place.

use crate::window::{Window, app, demo_window, press, settle};
use bathyscope::app::{Action, Command, LogPass, LogPlace, PassesFound, mark_of};
use bathyscope_log::support::geo::LonLat;
use bathyscope_log::support::progress::Progress;
use bathyscope_products::pipeline::{Derived, Pass, ProcessedLog, place_of};
use bathyscope_test_support::Moments;
use egui::{Key, Modifiers};
use egui_kittest::kittest::Queryable as _;

/// Least distance from the boat at which a slant range shows well how far a place is, metres.
const LEAST_OUT_M: f64 = 2.0;
/// Distance that a place may have from the samples of the ping that begins its strip, besides the
/// way to the next ping, metres: the boat turns.
const BESIDE_M: f64 = 0.3;

fn passes_at(window: &mut Window, at: LonLat) -> Vec<LogPass> {
    let app = &mut window.state_mut().app;
    app.apply(Command::FindPasses(at));
    assert_eq!(app.passes_at(at), PassesFound::Searching);
    app.poll();
    match app.passes_at(at) {
        PassesFound::Found(passes) => passes.to_vec(),
        other => panic!("{other:?}"),
    }
}

#[test]
fn every_pass_has_the_place_where_it_says_and_the_selection_goes_from_one_to_the_next() {
    let mut window = demo_window();
    let log = ProcessedLog {
        survey: app(&window).logs.shown.survey.clone().expect("a survey"),
        products: app(&window).logs.shown.products.clone().expect("results"),
    };
    let layout = Derived::default().layout(&log, &Progress::new());
    let layout = layout.expect("nobody cancels");
    let navigation = &log.products.navigation;
    let plane = |at: LonLat| navigation.to_plane(&log.survey.track, at);
    let boats = &navigation.pings;
    let mut moments = Moments(3);
    let out_m = |pass: &Pass, [east_m, north_m]: [f64; 2]| {
        let boat = &boats[pass.middle.0];
        (boat.east_m - east_m).hypot(boat.north_m - north_m)
    };
    let mut looked = 0;
    let mut of_several = None;
    for _ in 0..200 {
        let boat = &boats[(moments.share() * boats.len() as f64) as usize];
        let [east_m, north_m] =
            [boat.east_m, boat.north_m].map(|m| m + 10.0 * (moments.share() - 0.5));
        let at = navigation.to_lon_lat(&log.survey.track, east_m, north_m);
        let passes = passes_at(&mut window, at);
        for (_, pass) in &passes {
            let (ping, sample) = pass.middle;
            let [first, last] = pass.pings;
            assert!(first <= ping && ping <= last);
            let place = place_of(&layout, ping, pass.side, sample).expect("a place");
            let off_m = (place[0] - east_m).hypot(place[1] - north_m);
            let is_far = out_m(pass, [east_m, north_m]) > LEAST_OUT_M;
            // The strip reaches to the next ping, which is farther where some were lost.
            let next = boats.get(ping + 1).unwrap_or(&boats[ping]);
            let [from, to] = [&boats[ping], next];
            let step_m = (to.east_m - from.east_m).hypot(to.north_m - from.north_m);
            assert!(!is_far || off_m < BESIDE_M + 2.0 * step_m, "{off_m} m: {pass:?}");
            looked += usize::from(is_far);
        }
        let are_far = passes.iter().all(|(_, pass)| out_m(pass, [east_m, north_m]) > LEAST_OUT_M);
        if passes.len() > 2 && are_far {
            of_several = Some((at, passes));
        }
    }
    assert!(looked > 100, "{looked}");
    let (at, passes) = of_several.expect("lines of the demo overlap");
    press(&mut window, Modifiers::SHIFT, Key::T);
    let asked = "select a place to port or starboard first";
    assert!(window.query_by_label_contains(asked).is_some());
    let (id, first) = passes[0];
    let reveal = Command::RevealIn(id, mark_of(&first));
    window.state_mut().app.apply(reveal);
    settle(&mut window);
    let mut pings = vec![first.middle.0];
    for _ in 0..passes.len() {
        press(&mut window, Modifiers::SHIFT, Key::T);
        settle(&mut window);
        let mark = app(&window).view.selection.expect("a selection");
        let (side, sample) = mark.side.zip(mark.sample).expect("a place");
        let place = place_of(&layout, mark.ping, side, f64::from(sample)).expect("a place");
        let wanted = plane(at);
        let off_m = (place[0] - wanted[0]).hypot(place[1] - wanted[1]);
        // From look to look, for each begins where the one before it ended.
        assert!(off_m < 4.0 * BESIDE_M, "{off_m} m");
        pings.push(mark.ping);
    }
    let away = pings.windows(2).filter(|two| two[0].abs_diff(two[1]) > 5);
    assert!(away.count() >= passes.len() - 1, "{pings:?}");
    let back = pings[0].abs_diff(pings[passes.len()]);
    assert!(back < 10, "after the last pass the first again: {pings:?}");
}

#[test]
fn an_answer_that_nobody_waits_for_any_more_is_dropped() {
    let mut window = demo_window();
    let log = &app(&window).logs.shown;
    let (survey, products) = log.survey.clone().zip(log.products.clone()).expect("results");
    let places = [100, 900].map(|ping| {
        let boat = &products.navigation.pings[ping];
        let frame = &products.navigation;
        frame.to_lon_lat(&survey.track, boat.east_m + 3.0, boat.north_m)
    });
    let app = &mut window.state_mut().app;
    for at in places {
        app.apply(Command::FindPasses(at));
    }
    app.poll();
    assert_eq!(app.passes_at(places[0]), PassesFound::Unasked);
    let found = app.passes_at(places[1]);
    assert!(matches!(found, PassesFound::Found([_, ..])), "{found:?}");
    app.apply(Command::FindPasses(places[0]));
    app.apply(Command::Do(Action::Cancel));
    assert_eq!(app.passes_at(places[0]), PassesFound::Stopped);
    // From a selected place the way leads to its next pass, unless another place is selected
    // meanwhile.
    app.apply(Command::FindPasses(places[1]));
    app.poll();
    let PassesFound::Found([(id, pass), ..]) = app.passes_at(places[1]) else {
        panic!("it was found before");
    };
    let there = Command::RevealIn(*id, mark_of(pass));
    app.apply(there);
    app.apply(Command::Do(Action::NextPass));
    assert!(!app.is_idle());
    app.apply(Command::Select(Some(LogPlace::ping(7))));
    app.poll();
    assert_eq!(app.view.selection, Some(LogPlace::ping(7)));
    assert!(app.is_idle());
    // A place alone is shown in the first pass that saw it; one that none saw leaves the selection.
    app.apply(Command::ShowPlace(places[1]));
    app.poll();
    let PassesFound::Found([(_, pass), ..]) = app.passes_at(places[1]) else {
        panic!("it was found before");
    };
    let first = mark_of(pass);
    assert_eq!(app.view.selection, Some(first));
    app.apply(Command::ShowPlace(LonLat { lat_deg: 0.0, ..places[1] }));
    app.poll();
    assert_eq!(app.view.selection, Some(first));
    let said = app.notices.shown().last().map(|notice| notice.text.clone());
    assert_eq!(said.as_deref(), Some("no pass of the visible logs saw this place"));
}

//! The passes that saw a place: as the map's menu lists them, and one after the other from a selected place.

use crate::support::Moments;
use crate::window::{app, demo_window, press, settle};
use bathyscope::app::{Command, mark_of};
use bathyscope::geo::LonLat;
use bathyscope::pipeline::{Pass, ProcessedLog, place_of};
use egui::{Key, Modifiers};
use egui_kittest::kittest::Queryable as _;

/// Nearer to the boat a slant range hardly tells how far a place is.
const LEAST_OUT_M: f64 = 2.0;
/// How far a place may lie beside the samples of the ping that begins its strip, besides the way to the next ping: the boat turns.
const BESIDE_M: f64 = 0.3;

#[test]
fn every_pass_has_the_place_where_it_says_and_the_selection_goes_from_one_to_the_next() {
    let mut window = demo_window();
    let log = ProcessedLog {
        survey: app(&window).log.survey.clone().expect("a survey"),
        products: app(&window).log.products.clone().expect("results"),
    };
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
        let passes = app(&window).passes_at(at);
        for (_, pass) in &passes {
            let (ping, sample) = pass.middle;
            let [first, last] = pass.pings;
            assert!(first <= ping && ping <= last);
            let place = place_of(&log, ping, pass.side, sample).expect("a place");
            let off_m = (place[0] - east_m).hypot(place[1] - north_m);
            let is_far = out_m(pass, [east_m, north_m]) > LEAST_OUT_M;
            // The strip reaches to the next ping, which is farther where some were lost.
            let next = boats.get(ping + 1).unwrap_or(&boats[ping]);
            let [from, to] = [&boats[ping], next];
            let step_m = (to.east_m - from.east_m).hypot(to.north_m - from.north_m);
            assert!(
                !is_far || off_m < BESIDE_M + 2.0 * step_m,
                "{off_m} m: {pass:?}"
            );
            looked += usize::from(is_far);
        }
        let are_far = passes
            .iter()
            .all(|(_, pass)| out_m(pass, [east_m, north_m]) > LEAST_OUT_M);
        if passes.len() > 2 && are_far {
            of_several = Some((at, passes));
        }
    }
    assert!(looked > 100, "{looked}");
    let (at, passes) = of_several.expect("lines of the demo overlap");
    press(&mut window, Modifiers::SHIFT, Key::T);
    let asked = "select a place beside the track first";
    assert!(window.query_by_label_contains(asked).is_some());
    let (id, first) = passes[0];
    let reveal = Command::RevealIn(id, mark_of(&first));
    window.state_mut().app.apply(reveal);
    settle(&mut window);
    let mut pings = vec![first.middle.0];
    for _ in 0..passes.len() {
        press(&mut window, Modifiers::SHIFT, Key::T);
        settle(&mut window);
        let mark = app(&window).selection.expect("a selection");
        let (side, sample) = mark.side.zip(mark.sample).expect("a place");
        let place = place_of(&log, mark.ping, side, f64::from(sample)).expect("a place");
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

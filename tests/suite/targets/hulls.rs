//! Sunken boats of 30 m, upright or keel up, with a list, by edges drawn by hand.

use super::{edit, level_scene, only_box, opened, see_far, settle, target, written};
use bathyscope::app::{Action, App, Command, Measure};
use bathyscope_log::survey::Identity;
use bathyscope_objects::review::{Edit, Review};
use bathyscope_objects::{Mark, MeasuredShadow};
use bathyscope_products::project::Pick;
use bathyscope_simulation::{ObjectKind, ObjectPass, ObjectSettings, Scene};

const LENGTH_M: f64 = 30.0;
const WIDTH_M: f64 = 6.0;
const HEIGHT_M: f64 = 2.5;
const DEPTH_M: f64 = 8.0;
const HULLS: usize = 6;
const APART_M: f64 = 60.0;

fn scene() -> Scene {
    let hulls = (0..HULLS).map(|index| ObjectSettings {
        kind: ObjectKind::Boat,
        east_m: (index as f64 + 0.5 - 0.5 * HULLS as f64) * APART_M,
        north_m: if index % 2 == 0 { -16.0 } else { 14.0 },
        length_m: LENGTH_M,
        width_m: WIDTH_M,
        height_m: HEIGHT_M,
        heading_deg: if index < 3 { 90.0 } else { 270.0 },
        buried_m: 0.0,
        strength_db: None,
    });
    let hulls = hulls.collect();
    let mut scene = level_scene(DEPTH_M, HULLS as f64 * APART_M + 30.0, hulls);
    see_far(&mut scene, 40.0);
    scene
}

/// Returns the box and shadow that an analyst draws who sees all of the hull: pings and edges of
/// the echo, the end of the longest shadow, and that shadow.
fn edges(seen: &ObjectPass) -> (Mark, f64, MeasuredShadow) {
    let [top_m, end_m] = seen.shadow_m;
    let mark = Mark {
        side: seen.side,
        pings: seen.first_ping..seen.last_ping + 1,
        near_m: seen.near_m,
        far_m: end_m,
    };
    let ping = seen.shadow_ping;
    let shadow = MeasuredShadow { ping, top_m, end_m };
    (mark, seen.far_m.min(end_m), shadow)
}

#[test]
fn hulls_of_thirty_metres_are_measured_by_hand_drawn_edges_and_a_measured_shadow() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let (log, truth) = written(folder.path(), "hulls.sl2", &scene(), 4);
    let mut app = opened(&log);
    for object in &truth.objects {
        let [seen] = &object.sightings[..] else { panic!("one pass: {:?}", object.sightings) };
        let (mark, border_m, shadow) = edges(seen);
        let id = app.logs.shown.reviewing.review.next_id();
        let added = Edit::Add { mark: mark.clone(), class: 0 };
        for change in
            [added, Edit::SetEdges { id, mark, border_m }, Edit::SetShadow(id, Some(shadow))]
        {
            edit(&mut app, change);
        }
        let found = target(&app, id);
        let off_m = f64::hypot(found.east_m - object.east_m, found.north_m - object.north_m);
        println!(
            "{:.2} m long, {:.2} m wide, {:.2} +- {:.2} m high of {:.2} where the shadow begins, {off_m:.2} m off, within {:.2} m",
            found.length_m,
            found.width_m,
            found.height_m,
            found.height_sigma_m,
            seen.top_height_m,
            found.sigma_m
        );
        assert!((found.length_m / LENGTH_M - 1.0).abs() < 0.05, "length");
        assert!((found.height_m / seen.top_height_m - 1.0).abs() < 0.10, "height");
        assert!(off_m < 1.0, "position");
        // A normal error lies within three standard deviations.
        assert!(off_m < 3.0 * found.sigma_m);
        assert!((found.height_m - seen.top_height_m).abs() < 3.0 * found.height_sigma_m);
    }
}

/// Measures a shadow with the tool for it.
fn measure(app: &mut App, mark: &Mark, shadow: MeasuredShadow) {
    let survey = app.logs.shown.survey.clone().expect("a survey");
    app.apply(Command::Do(Action::HeightFromShadow));
    for slant_m in [shadow.top_m, shadow.end_m] {
        app.apply(Command::Measure(Measure::Pick(Pick {
            log: Identity::of(&survey),
            side: mark.side,
            ping: shadow.ping,
            slant_m,
        })));
    }
    app.apply(Command::Do(Action::LeaveTool));
    settle(app);
}

fn press(app: &mut App, action: Action) {
    app.apply(Command::Do(action));
    settle(app);
}

#[test]
fn a_measured_shadow_tells_the_height_of_its_box_until_that_is_taken_back() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let (log, truth) = written(folder.path(), "hulls.sl2", &scene(), 4);
    let mut app = opened(&log);
    let (mark, _, shadow) = edges(&truth.objects[0].sightings[0]);
    press(&mut app, Action::UseShadow);
    assert!(
        app.notices.shown().last().is_some_and(|notice| notice.is_error),
        "there is neither a shadow nor a box"
    );
    let added = Edit::Add { mark: mark.clone(), class: 0 };
    edit(&mut app, added);
    let id = only_box(&app).id;
    let found = target(&app, id);
    measure(&mut app, &mark, shadow);
    let height_m = app.measured_height().expect("measured").expect("a height").height_m();
    press(&mut app, Action::UseShadow);
    let review_box = only_box(&app);
    assert_eq!(review_box.shadow, Some(shadow));
    let measured = target(&app, id);
    // The altitude is that over the box there, and that over a few pings here.
    assert!((measured.height_m / height_m - 1.0).abs() < 0.02, "{} {height_m}", measured.height_m);
    assert!((measured.height_m / found.height_m - 1.0).abs() > 1e-6);

    // The file of the review keeps it, and refuses one that cannot be.
    let review = app.logs.shown.reviewing.review.clone();
    let identity = review.identity().clone();
    let text = review.to_json();
    assert_eq!(Review::from_json(&text, &identity).expect("our own file"), *review);
    let broken = text.replace(&format!("\"ping\": {}", shadow.ping), "\"ping\": 0");
    assert_ne!(broken, text);
    assert!(Review::from_json(&broken, &identity).is_err());

    // Once more takes it back, in one step as the first time.
    press(&mut app, Action::UseShadow);
    assert_eq!(target(&app, id), found);
    press(&mut app, Action::Undo);
    assert_eq!(target(&app, id), measured);
    // On the other side it is none of its own.
    edit(&mut app, Edit::SwapSide(id));
    assert_eq!(only_box(&app).shadow, None);
}

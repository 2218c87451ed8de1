//! A sunken barge of 30 m on a level bed, from the picture to the report.

use super::{edit, level_scene, log_box, only_box, opened, see_far, settle, target, written};
use bathyscope::app::{Action, App, Command, FileToWrite};
use bathyscope_log::survey::{Identity, Side};
use bathyscope_objects::review::{Certainty, Edit, Review, State};
use bathyscope_objects::{Mark, ObjectExtent};
use bathyscope_simulation::{ObjectKind, ObjectSettings, Scene, Simulated};
use std::path::Path;

const LENGTH_M: f64 = 30.0;
const WIDTH_M: f64 = 6.0;
const HEIGHT_M: f64 = 2.5;
const DEPTH_M: f64 = 8.0;

/// A hull with steep sides and a flat deck along the line, 16 m to starboard of it. Of an open hull
/// with a list the higher gunwale may be the near one, whose shadow falls on the rest of it: one
/// shadow then does not tell the height.
fn scene() -> Scene {
    let hull = ObjectSettings {
        kind: ObjectKind::Block,
        east_m: 0.0,
        north_m: -16.0,
        length_m: LENGTH_M,
        width_m: WIDTH_M,
        height_m: HEIGHT_M,
        heading_deg: 90.0,
        buried_m: 0.0,
        strength_db: None,
    };
    let mut scene = level_scene(DEPTH_M, 80.0, vec![hull]);
    see_far(&mut scene, 40.0);
    scene
}

/// Returns the box and border that an analyst draws who sees all of the wreck: pings of the echo,
/// its near edge, the border to the shadow, and the end of the shadow.
fn edges(truth: &Simulated) -> (Mark, f64) {
    let [seen] = &truth.objects[0].sightings[..] else {
        panic!("one pass: {:?}", truth.objects[0].sightings)
    };
    let [border_m, end_m] = seen.shadow_m;
    println!(
        "pings {} to {}, echo {:.2} to {:.2} m, shadow {border_m:.2} to {end_m:.2} m",
        seen.first_ping, seen.last_ping, seen.near_m, seen.far_m
    );
    let mark = Mark {
        side: seen.side,
        pings: seen.first_ping..seen.last_ping + 1,
        near_m: seen.near_m,
        far_m: end_m,
    };
    (mark, border_m)
}

/// Draws a box roughly around the hull, and then its edges.
fn draw(app: &mut App, truth: &Simulated) -> Mark {
    let (mark, border_m) = edges(truth);
    assert_eq!(mark.side, Side::Starboard);
    let rough = Mark {
        pings: mark.pings.start - 12..mark.pings.end + 9,
        near_m: mark.near_m - 0.8,
        far_m: mark.far_m + 1.1,
        ..mark.clone()
    };
    edit(app, Edit::Add { mark: rough, class: 0 });
    let id = only_box(app).id;
    edit(app, Edit::SetEdges { id, mark: mark.clone(), border_m });
    mark
}

#[test]
fn a_hull_of_thirty_metres_is_measured_by_hand_drawn_edges() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let (log, truth) = written(folder.path(), "wreck.sl2", &scene(), 4);
    let mut app = opened(&log);
    let mark = draw(&mut app, &truth);
    let review_box = only_box(&app);
    assert_eq!((&review_box.mark, review_box.state), (&mark, State::Added));
    let found = target(&app, review_box.id);
    let object = &truth.objects[0];
    let off_m = f64::hypot(found.east_m - object.east_m, found.north_m - object.north_m);
    println!(
        "length {:.2} m, width {:.2} m, height {:.2} +- {:.2} m, altitude {:.2} m, {off_m:.2} m off, position within {:.2} m",
        found.length_m,
        found.width_m,
        found.height_m,
        found.height_sigma_m,
        found.altitude_m,
        found.sigma_m
    );
    assert!((found.length_m / LENGTH_M - 1.0).abs() < 0.05, "length");
    assert!(off_m < 1.0, "position");
    assert!((found.height_m / HEIGHT_M - 1.0).abs() < 0.10, "height");
    assert!((found.width_m / WIDTH_M - 1.0).abs() < 0.05, "width");
    // A normal error lies within three standard deviations.
    assert!(off_m < 3.0 * found.sigma_m);
    assert!((found.height_m - HEIGHT_M).abs() < 3.0 * found.height_sigma_m);
    // The height is what its inputs say.
    let [start_m, end_m] = found.shadow_m;
    let by_hand_m = found.altitude_m * (end_m - start_m) / end_m;
    assert!((found.height_m - by_hand_m).abs() < 1e-9);

    // One step each; and the program finds the edges again when it is asked to.
    app.apply(Command::Do(Action::Undo));
    settle(&mut app);
    assert_eq!(only_box(&app).extent, ObjectExtent::Found);
    app.apply(Command::Do(Action::Redo));
    settle(&mut app);
    assert_eq!(target(&app, review_box.id), found);
    edit(&mut app, Edit::FindEdges(review_box.id));
    assert_eq!(only_box(&app).extent, ObjectExtent::Found);
}

/// Draws, names and judges the hull.
fn described(app: &mut App, truth: &Simulated) {
    draw(app, truth);
    let id = only_box(app).id;
    for change in [
        Edit::Rename(id, "Anna <Maria>".to_owned()),
        Edit::Classify(id, "steam tug".to_owned()),
        Edit::Rate(id, Some(Certainty::Probable)),
        Edit::Note(id, "boiler amidships".to_owned()),
    ] {
        edit(app, change);
    }
}

#[test]
fn a_wreck_is_named_kept_exported_and_has_its_page_in_the_report() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let (log, truth) = written(folder.path(), "wreck.sl2", &scene(), 4);
    let mut app = opened(&log);
    described(&mut app, &truth);
    let review = app.logs.shown.reviewing.review.clone();
    let review_box = only_box(&app);
    assert_eq!(review.class_name(review_box.class), "steam tug");
    assert_eq!(
        (review_box.name.as_str(), review_box.certainty, review_box.note.as_str()),
        ("Anna <Maria>", Some(Certainty::Probable), "boiler amidships")
    );
    // The file of the review keeps all of it.
    let survey = app.logs.shown.survey.clone().expect("a survey");
    let kept = Review::from_json(&review.to_json(), &Identity::of(&survey)).expect("our own file");
    assert_eq!(kept, *review);

    let boxes = folder.path().join("boxes");
    app.apply(Command::Write(FileToWrite::Boxes(boxes.clone())));
    settle(&mut app);
    check_tables(&boxes);
    let products = folder.path().join("products");
    app.apply(Command::Write(FileToWrite::Products(products.clone())));
    settle(&mut app);
    let targets = std::fs::read_to_string(products.join("objects/targets.gpx")).expect("waypoints");
    for text in
        ["<name>Anna &lt;Maria&gt;</name><cmt>boiler amidships</cmt>", "<type>steam tug</type>"]
    {
        assert!(targets.contains(text), "{text}: {targets}");
    }
    assert_eq!(targets.matches("<wpt ").count(), 1);
    let page = std::fs::read_to_string(products.join("report.html")).expect("a report");
    for text in ["Anna &lt;Maria&gt;", "steam tug", "boiler amidships", "probable"] {
        assert!(page.contains(text), "{text}");
    }

    // Its picture: an image of its own.
    let section = page.split("<section class=\"target\">").nth(1).expect("its section");
    let section = section.split("</section>").next().unwrap_or(section);
    assert!(section.contains("Anna &lt;Maria&gt;"));
    assert!(section.contains("<img "), "no picture");

    // All views enlarge it: about a third of each is hull.
    let id = log_box(&app, review_box.id);
    app.apply(Command::FlyTo(id));
    let close_up = app.view.reveal.and_then(|reveal| reveal.close_up);
    let close_up = close_up.expect("a close-up");
    assert!((close_up.size_m / LENGTH_M - 1.0).abs() < 0.05);
    assert_eq!(close_up.pings, [review_box.mark.pings.start, review_box.mark.pings.end]);
    let edges_m = [review_box.mark.near_m, review_box.mark.far_m];
    for (shown_m, edge_m) in close_up.across_m.iter().zip(edges_m) {
        assert!((shown_m - edge_m).abs() < 1e-9);
    }
    assert!(close_up.place_m.is_some());
}

fn check_tables(folder: &Path) {
    let read = |name: &str| std::fs::read_to_string(folder.join(name)).expect(name);
    let mut table = csv::Reader::from_path(folder.join("objects.csv")).expect("a table");
    let header = table.headers().expect("a header").clone();
    let line = table.records().next().expect("a line").expect("fields");
    let field = |name: &str| {
        let column = header.iter().position(|heading| heading == name).expect(name);
        line[column].to_owned()
    };
    assert_eq!(field("name"), "Anna <Maria>");
    assert_eq!(field("class"), "steam tug");
    assert_eq!(field("certainty"), "probable");
    let length_m: f64 = field("length_m").parse().expect("a number");
    assert!((length_m / LENGTH_M - 1.0).abs() < 0.05);
    let features: serde_json::Value =
        serde_json::from_str(&read("objects.geojson")).expect("GeoJSON");
    let properties = &features["features"][0]["properties"];
    assert_eq!(properties["name"], "Anna <Maria>");
    assert_eq!(properties["certainty"], "probable");
    for name in ["objects.kml", "objects.gpx"] {
        let text = read(name);
        assert!(text.contains("<name>Anna &lt;Maria&gt;</name>"), "{name}");
        assert!(text.contains("steam tug; "), "{name}");
        assert!(text.contains("probable"), "{name}");
    }
}

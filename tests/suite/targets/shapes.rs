//! Shapes fitted to simulated objects of known kind and size.

use super::{edit, level_scene, log_box, opened, see_far, target, written};
use bathyscope::app::{App, Command};
use bathyscope_objects::Mark;
use bathyscope_objects::review::Edit;
use bathyscope_objects::targets::{FittedShape, ShapeError, ShapeKind};
use bathyscope_simulation::{ObjectKind, ObjectPass, ObjectSettings, Scene};
use bathyscope_test_support::Moments;
use std::path::Path;

const OBJECTS: usize = 60;
const APART_M: f64 = 12.0;
const DEPTH_M: f64 = 3.0;

/// The five shapes.
const KINDS: [ObjectKind; 5] =
    [ObjectKind::Block, ObjectKind::Cylinder, ObjectKind::Tyre, ObjectKind::Rock, ObjectKind::Boat];

/// Returns true if a shape is that of a kind.
fn is_of(kind: ObjectKind, shape: ShapeKind) -> bool {
    match kind {
        ObjectKind::Block => shape == ShapeKind::Block,
        ObjectKind::Cylinder => shape == ShapeKind::Cylinder,
        ObjectKind::Tyre => shape == ShapeKind::Tyre,
        ObjectKind::Rock => shape == ShapeKind::Boulder,
        _ => shape.is_boat(),
    }
}

/// Length, width and height of an object of a kind.
fn size_m(kind: ObjectKind, between: &mut impl FnMut(f64, f64) -> f64) -> [f64; 3] {
    match kind {
        ObjectKind::Block => {
            let length_m = between(0.6, 1.5);
            [length_m, length_m * between(0.5, 1.0), between(0.4, 0.8)]
        }
        ObjectKind::Cylinder => {
            let width_m = between(0.3, 0.6);
            [between(1.5, 4.0), width_m, width_m]
        }
        ObjectKind::Tyre => {
            let width_m = between(0.6, 1.1);
            [width_m, width_m, width_m * between(0.27, 0.38)]
        }
        ObjectKind::Rock => {
            let length_m = between(0.6, 1.6);
            [length_m, length_m * between(0.7, 1.0), length_m * between(0.4, 0.6)]
        }
        _ => {
            let length_m = between(3.0, 8.0);
            [length_m, length_m / between(2.5, 3.8), between(0.5, 0.9)]
        }
    }
}

/// Passes that show the objects.
#[derive(Clone, Copy, PartialEq)]
enum Looks {
    /// One line past all of them.
    One,
    /// A line on each side.
    FromBothSides,
}

/// Half of the distance between two lines, metres.
const BESIDE_M: f64 = 5.5;

/// Sixty objects along one line or between two, of the five kinds in turn, 3 to 8 m off a line to
/// either side, in any direction.
fn scene(seed: u64, looks: Looks) -> Scene {
    let mut moments = Moments(seed);
    let mut between = |from: f64, to: f64| from + (to - from) * moments.share();
    let objects = (0..OBJECTS).map(|index| {
        let kind = KINDS[index % KINDS.len()];
        let [length_m, width_m, height_m] = size_m(kind, &mut between);
        let side = if between(0.0, 1.0) < 0.5 { -1.0 } else { 1.0 };
        ObjectSettings {
            kind,
            east_m: (index as f64 + 0.5 - 0.5 * OBJECTS as f64) * APART_M,
            north_m: match looks {
                Looks::One => side * between(3.0, 8.0),
                Looks::FromBothSides => side * (between(3.0, 8.0) - BESIDE_M),
            },
            length_m,
            width_m,
            height_m,
            heading_deg: between(0.0, 360.0),
            buried_m: 0.0,
            strength_db: None,
        }
    });
    let objects = objects.collect();
    let mut scene = level_scene(DEPTH_M, OBJECTS as f64 * APART_M + 20.0, objects);
    if looks == Looks::FromBothSides {
        scene.track.lines = 2;
        scene.track.spacing_m = 2.0 * BESIDE_M;
    }
    scene
}

/// A box as an analyst draws it around what the picture shows; `None` where it shows nothing.
fn drawn(seen: &ObjectPass) -> Option<Mark> {
    let shown = seen.shown.as_ref()?;
    Some(Mark {
        side: seen.side,
        pings: shown.first_ping..shown.last_ping + 1,
        near_m: shown.near_m,
        far_m: shown.far_m,
    })
}

/// Draws boxes, and gives back the shape of their object.
fn shape_of(app: &mut App, boxes: Vec<Mark>) -> Result<FittedShape, ShapeError> {
    let mut last = None;
    for mark in boxes {
        last = Some(app.logs.shown.reviewing.review.next_id());
        edit(app, Edit::Add { mark, class: 0 });
    }
    let id = last.expect("a box");
    let log_box = log_box(app, id);
    app.apply(Command::SelectLogBox(log_box));
    super::settle(app);
    let shape = app.selected_object_shape().expect("it is selected");
    shape.clone()
}

/// Results for the objects of a survey.
#[derive(Default)]
struct Found {
    right: usize,
    wrong: usize,
    without: usize,
    /// Heights of shapes, and of shadows alone, over true ones less 1, without their sign.
    heights: Vec<f64>,
    by_shadow: Vec<f64>,
}

impl Found {
    fn of(scene: &Scene, seed: u64, looks: Looks, folder: &Path) -> Self {
        let (log, truth) = written(folder, "shapes.sl2", scene, seed);
        let mut app = opened(&log);
        let mut found = Self::default();
        for object in &truth.objects {
            let mut marks: Vec<Mark> = object.sightings.iter().filter_map(drawn).collect();
            // The other times the beam swings over it in a turn.
            marks.sort_by_key(|mark| std::cmp::Reverse(mark.pings.len()));
            marks.truncate(match looks {
                Looks::One => 1,
                Looks::FromBothSides => 2,
            });
            if marks.is_empty() {
                found.without += 1;
                continue;
            }
            let id = app.logs.shown.reviewing.review.next_id();
            match shape_of(&mut app, marks) {
                Err(_) => found.without += 1,
                Ok(shape) => {
                    let solid = shape.posed.solid;
                    if is_of(object.kind, solid.kind) {
                        found.right += 1
                    } else {
                        found.wrong += 1
                    }
                    let error = |height_m: f64| (height_m / object.height_m - 1.0).abs();
                    found.heights.push(error(solid.height_m));
                    found.by_shadow.push(error(target(&app, id).height_m));
                }
            }
        }
        found
    }
}

/// The middle one; NaN counts as the largest.
fn median(errors: &mut [f64]) -> f64 {
    errors.sort_by(f64::total_cmp);
    errors[errors.len() / 2]
}

/// Name, seed, which nothing was chosen on, passes, and whether the recorder sees as far as the
/// objects lie.
type Case = (&'static str, u64, Looks, bool);

#[test]
fn shapes_of_sixty_objects_are_right_in_four_of_five_and_their_heights_within_a_seventh() {
    check(("usual noise", 31, Looks::One, false));
}

#[test]
#[ignore = "minutes: two surveys of sixty objects"]
fn shapes_are_as_right_from_both_sides_and_far_away() {
    check(("usual noise, both sides", 33, Looks::FromBothSides, false));
    check(("far-seeing", 32, Looks::One, true));
}

fn check((name, seed, looks, sees_far): Case) {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let mut scene = scene(seed, looks);
    if sees_far {
        see_far(&mut scene, 20.0);
    }
    let mut found = Found::of(&scene, seed, looks, folder.path());
    let [height, by_shadow] =
        [&mut found.heights, &mut found.by_shadow].map(|errors| median(errors));
    println!(
        "{name}: {} right, {} wrong, {} without; height off by {:.1} % (median), by the shadow alone {:.1} %",
        found.right,
        found.wrong,
        found.without,
        100.0 * height,
        100.0 * by_shadow
    );
    assert!(5 * found.right >= 4 * OBJECTS, "{name}: {}", found.right);
    assert!(height < 0.15, "{name}: {height}");
}

#[test]
fn a_hull_of_twelve_metres_that_two_lines_saw_is_one_object_with_its_length() {
    const LENGTH_M: f64 = 12.0;
    let hull = ObjectSettings {
        kind: ObjectKind::Boat,
        east_m: 0.0,
        north_m: 2.0,
        length_m: LENGTH_M,
        width_m: 3.6,
        height_m: 1.4,
        heading_deg: 70.0,
        buried_m: 0.0,
        strength_db: None,
    };
    // The seed draws which way up it lies, its list, its thwarts and how much mud is in it.
    let seeds = 41..47;
    let count = seeds.clone().count();
    let mut known = 0;
    for seed in seeds {
        let mut scene = level_scene(5.0, 60.0, vec![hull.clone()]);
        see_far(&mut scene, 30.0);
        scene.track.lines = 2;
        scene.track.spacing_m = 26.0;
        let folder = tempfile::tempdir().expect("a temporary folder");
        let (log, truth) = written(folder.path(), "hull.sl2", &scene, seed);
        let mut app = opened(&log);
        let marks = truth.objects[0].sightings.iter().filter_map(drawn);
        let mut marks: Vec<Mark> = marks.collect();
        // The other times the beam swings over it in a turn.
        marks.sort_by_key(|mark| std::cmp::Reverse(mark.pings.len()));
        marks.truncate(2);
        let shape = shape_of(&mut app, marks);
        assert_eq!(app.objects.all().len(), 1, "one object");
        let shape = match shape {
            Ok(shape) => shape,
            Err(why) => {
                println!("{seed}: {why}");
                continue;
            }
        };
        let solid = shape.posed.solid;
        println!(
            "{seed}: {}, {:.2} x {:.2} x {:.2} m, heading {:.0}, explains {:.0} %",
            solid.kind.name(),
            solid.length_m,
            solid.width_m,
            solid.height_m,
            shape.posed.heading_rad.to_degrees(),
            100.0 * shape.explained
        );
        assert!(solid.kind.is_boat());
        assert!((solid.length_m / LENGTH_M - 1.0).abs() < 0.10, "length");
        known += 1;
    }
    assert!(known + 1 >= count, "{known} of {count} have a shape");
}

//! Heights of many objects, by the edges of the shadows that the program finds.

use super::{edit, level_scene, opened, see_far, target, written};
use crate::support::Moments;
use bathyscope::detection::Mark;
use bathyscope::detection::review::Edit;
use bathyscope::simulation::{ObjectKind, ObjectSettings, Scene, Simulated};

const DEPTH_M: f64 = 4.0;
const OBJECTS: usize = 50;
/// From one object to the next along the line, metres.
const APART_M: f64 = 6.0;
const KINDS: [ObjectKind; 5] = [
    ObjectKind::Rock,
    ObjectKind::Block,
    ObjectKind::Cylinder,
    ObjectKind::Boat,
    ObjectKind::Effigy,
];

/// Fifty objects along one line: of random kinds, 0.3 to 1.5 m high, 5 to 13 m off to either side.
fn scene() -> Scene {
    let mut moments = Moments(7);
    let mut between = |from: f64, to: f64| from + (to - from) * moments.share();
    let line_m = OBJECTS as f64 * APART_M + 20.0;
    let objects = (0..OBJECTS).map(|index| {
        let kind = KINDS[(between(0.0, KINDS.len() as f64) as usize).min(KINDS.len() - 1)];
        let side = if between(0.0, 1.0) < 0.5 { -1.0 } else { 1.0 };
        let height_m = between(0.3, 1.5);
        ObjectSettings {
            kind,
            east_m: (index as f64 + 0.5 - 0.5 * OBJECTS as f64) * APART_M,
            north_m: side * between(5.0, 13.0),
            length_m: between(1.2, 2.5),
            width_m: between(0.6, 1.4),
            height_m,
            heading_deg: between(0.0, 180.0),
            buried_m: 0.0,
            strength_db: None,
        }
    });
    let objects = objects.collect();
    let mut scene = level_scene(DEPTH_M, line_m, objects);
    see_far(&mut scene, 30.0);
    scene
}

/// The box that an analyst draws around what the picture shows of an object.
fn drawn(truth: &Simulated, index: usize) -> Option<(Mark, f64)> {
    let object = &truth.objects[index];
    let seen = object.sightings.first()?;
    let shown = seen.shown.as_ref()?;
    let mark = Mark {
        side: seen.side,
        pings: shown.first_ping..shown.last_ping + 1,
        near_m: shown.near_m,
        far_m: shown.far_m,
    };
    Some((mark, object.height_m))
}

#[test]
fn heights_of_fifty_objects_from_their_shadows_have_a_median_error_under_a_tenth() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let (log, truth) = written(folder.path(), "fifty.sl2", &scene(), 11);
    let mut app = opened(&log);
    let mut errors = Vec::new();
    let mut unknown = 0;
    for (index, object) in truth.objects.iter().enumerate() {
        let Some((mark, height_m)) = drawn(&truth, index) else {
            println!("{index}: nothing is shown of it");
            continue;
        };
        let id = app.log.reviewing.review.next_id();
        edit(&mut app, Edit::Add { mark, class: 0 });
        let found = target(&app, id);
        let error = found.height_m / height_m - 1.0;
        println!(
            "{index}: {} at {:.1} m: {height_m:.2} m high, found {:.2} +- {:.2} m ({:+.0} %)",
            object.kind.name(),
            found.ground_m,
            found.height_m,
            found.height_sigma_m,
            100.0 * error
        );
        match error.is_nan() {
            true => unknown += 1,
            false => errors.push(error),
        }
    }
    let count = errors.len();
    let mut sizes: Vec<f64> = errors.iter().map(|error| error.abs()).collect();
    sizes.sort_by(f64::total_cmp);
    errors.sort_by(f64::total_cmp);
    let median = sizes[count / 2];
    println!(
        "{count} of {OBJECTS} heights known, {unknown} not; |error| {:.1} % (median), {:.1} % (90 %); error {:+.1} % (median)",
        100.0 * median,
        100.0 * sizes[9 * count / 10],
        100.0 * errors[count / 2]
    );
    assert!(count >= 40, "{count} of {OBJECTS}");
    assert!(median < 0.10, "{median}");
}

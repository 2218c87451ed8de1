use super::*;
use crate::Detection;
use crate::testing::navigation_of;
use bathyscope_log::survey::{SidePing, SideSpan, Survey};

const PINGS: usize = 1000;

fn identity() -> Identity {
    Identity { swapped_sides: false, file: "river.sl2".into(), byte_count: 4711, pings: PINGS }
}

fn names(names: &[&str]) -> Vec<String> {
    names.iter().map(|name| (*name).to_owned()).collect()
}

fn mark(side: Side, start: usize, near_m: f64) -> Mark {
    Mark::new(side, start..start + 10, [near_m, near_m + 2.0])
}

fn detection(class: usize, score: f32, mark: Mark) -> Detection {
    Detection { class, score, mark }
}

/// Creates a raster of pings a tenth of a second apart at 2 m/s: 0.2 m for each ping.
fn raster() -> Raster {
    let span = SideSpan::of_bytes(100, [0.0, 20.0]);
    let survey = Survey {
        side_scan: std::sync::Arc::new(
            (0..PINGS)
                .map(|ping| SidePing {
                    port: Some(span),
                    starboard: Some(span),
                    ..SidePing::with_depth(ping as f64 * 0.1, 2.0)
                })
                .collect(),
        ),
        ..Survey::default()
    };
    let navigation = navigation_of(PINGS);
    Raster::new(&survey, &navigation, 0.04)
}

/// Creates a review of three proposals: a rock at ping 100, a tyre at 200, a rock at 300 on the
/// other side.
fn proposed() -> Review {
    let empty = Review::new(identity(), names(&["rock", "tyre"]));
    let found = [
        detection(0, 0.6, mark(Side::Port, 100, 5.0)),
        detection(1, 0.9, mark(Side::Port, 200, 5.0)),
        detection(0, 0.3, mark(Side::Starboard, 300, 5.0)),
    ];
    empty.adopt("first", &names(&["rock", "tyre"]), &found, &raster(), 0..usize::MAX)
}

fn edited(review: &Review, edits: &[Edit]) -> Review {
    edits.iter().fold(review.clone(), |review, edit| {
        review.apply(edit).unwrap_or_else(|| panic!("{edit:?}"))
    })
}

fn states(review: &Review) -> Vec<(u32, State)> {
    review.boxes().map(|review_box| (review_box.id.0, review_box.state)).collect()
}

#[test]
fn decisions_are_made_and_taken_back() {
    let id = BoxId(1);
    let review = edited(&proposed(), &[Edit::Accept(id), Edit::Reject(BoxId(2))]);
    assert_eq!(states(&review), [(1, State::Accepted), (2, State::Rejected), (3, State::Proposed)]);
    assert_eq!(review.apply(&Edit::Accept(id)), None, "it stands already");
    assert_eq!(review.apply(&Edit::Accept(BoxId(9))), None, "no such box");
    let back = edited(&review, &[Edit::Undecide(id), Edit::Undecide(BoxId(2))]);
    assert_eq!(back, proposed());
}

#[test]
fn corrections_are_checked() {
    let id = BoxId(1);
    let review = proposed();
    let flat = Mark { far_m: 5.0, ..mark(Side::Port, 100, 5.0) };
    assert_eq!(review.apply(&Edit::Reshape(id, flat)), None);
    let late = mark(Side::Port, PINGS, 5.0);
    assert_eq!(review.apply(&Edit::Reshape(id, late)), None);
    let over_the_edge = mark(Side::Port, PINGS - 4, -1.0);
    let after = edited(
        &review,
        &[
            Edit::Classify(id, "tyre".into()),
            Edit::Reshape(id, over_the_edge),
            Edit::SwapSide(id),
            Edit::Note(id, "two of them".into()),
        ],
    );
    let review_box = after.get(id).unwrap();
    assert_eq!((review_box.class, review_box.mark.side), (1, Side::Starboard));
    assert_eq!(review_box.mark.pings, PINGS - 4..PINGS);
    assert_eq!((review_box.mark.near_m, review_box.mark.far_m), (0.0, 1.0));
    assert_eq!((review_box.note.as_str(), review_box.state), ("two of them", State::Proposed));
    assert!(review_box.is_kept());
}

#[test]
fn a_box_drawn_by_hand_is_added_or_rejected_and_can_go() {
    let review = proposed();
    let id = review.next_id();
    let add = Edit::Add { mark: mark(Side::Port, 500, 3.0), class: 0 };
    let after = edited(&review, &[add, Edit::Reject(id), Edit::Accept(id)]);
    assert_eq!(after.get(id).unwrap().state, State::Added);
    assert_eq!(after.apply(&Edit::Undecide(id)), None);
    assert_eq!(after.apply(&Edit::Remove(BoxId(1))), None, "by a model");
    let gone = edited(&after, &[Edit::Remove(id)]);
    assert_eq!(states(&gone), states(&review));
    assert_ne!(gone.next_id(), id, "numbers are never given twice");
}

#[test]
fn decisions_survive_a_change_of_model() {
    let id = proposed().next_id();
    let add = Edit::Add { mark: mark(Side::Port, 500, 3.0), class: 0 };
    let edits = [
        Edit::Accept(BoxId(1)),
        Edit::Classify(BoxId(3), "tyre".into()),
        add,
        Edit::Reject(id),
        Edit::Undecide(id),
    ];
    let review = edited(&proposed(), &edits);
    let classes = names(&["boat", "tyre"]);
    let found = [
        // The accepted rock again, a little off (IoU 0.71), and once more with a lower score.
        detection(0, 0.8, mark(Side::Port, 100, 5.3)),
        detection(0, 0.7, mark(Side::Port, 100, 5.2)),
        // The undecided tyre is found again.
        detection(1, 0.5, mark(Side::Port, 201, 5.0)),
        // A box at the place of the added box, but on the other side: not the same object.
        detection(0, 0.4, mark(Side::Starboard, 500, 3.0)),
    ];
    let after = review.adopt("second", &classes, &found, &raster(), 0..usize::MAX);
    assert_eq!(after.classes(), names(&["rock", "tyre", "boat"]));
    assert_eq!(
        states(&after),
        [
            (1, State::Accepted),
            (2, State::Proposed),
            (3, State::Proposed),
            (4, State::Added),
            (5, State::Proposed),
        ]
    );
    let review_box = after.get(BoxId(1)).unwrap();
    assert_eq!((review_box.class, review_box.score), (0, Some(0.8)));
    assert_eq!(review_box.mark, mark(Side::Port, 100, 5.0));
    assert_eq!(review_box.model.as_deref(), Some("first"));
    let tyre = after.get(BoxId(2)).unwrap();
    assert_eq!((tyre.class, tyre.score), (1, Some(0.5)));
    assert_eq!(tyre.model.as_deref(), Some("second"));
    assert_eq!(after.get(BoxId(5)).unwrap().class, 2);
    assert_eq!(after.get(id).unwrap().score, None);

    let none = after.adopt("third", &classes, &[], &raster(), 0..usize::MAX);
    assert_eq!(states(&none), states(&review.adopt("x", &[], &[], &raster(), 0..usize::MAX)));
}

#[test]
fn adoption_is_as_comparing_all_with_all() {
    let mut random = 7_u64;
    let mut next = |below: usize| {
        random = random.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (random >> 33) as usize % below
    };
    let side = |odd: usize| Side::BOTH[odd];
    let class = names(&["rock"]);
    let boxes: Vec<Detection> = (0..300)
        .map(|_| {
            let start = next(900);
            let pings = start..start + 2 + next(60);
            let near_m = next(40) as f64 * 0.25;
            let mark =
                Mark::new(side(next(2)), pings, [near_m, near_m + 1.0 + next(8) as f64 * 0.5]);
            detection(0, next(100) as f32 / 100.0, mark)
        })
        .collect();
    let (first, second) = boxes.split_at(150);
    let raster = raster();
    let mut review =
        Review::new(identity(), class.clone()).adopt("a", &class, first, &raster, 0..usize::MAX);
    for id in 1..=150 {
        review = edited(&review, &[Edit::Accept(BoxId(id))]);
    }
    let after = review.adopt("b", &class, second, &raster, 0..usize::MAX);
    let fresh = second.iter().filter(|found| {
        let rect = raster.rect_of(&found.mark);
        first.iter().all(|old| {
            old.mark.side != found.mark.side || raster.rect_of(&old.mark).iou(&rect) < 0.5
        })
    });
    let fresh: Vec<&Mark> = fresh.map(|found| &found.mark).collect();
    assert!((50..150).contains(&fresh.len()), "{}", fresh.len());
    let came: Vec<&Mark> = after.boxes().skip(150).map(|review_box| &review_box.mark).collect();
    assert_eq!(came, fresh);
}

fn line(review: &Review, queue: &Queue) -> Vec<u32> {
    let size_m = |mark: &Mark| mark.far_m - mark.near_m;
    let line = queue.sort_and_filter(review, size_m);
    line.into_iter().map(|id| id.0).collect()
}

#[test]
fn the_queue_is_sorted_and_filtered() {
    let review = proposed();
    let with = |set: &dyn Fn(&mut Queue)| {
        let mut queue = Queue::default();
        set(&mut queue);
        line(&review, &queue)
    };
    assert_eq!(with(&|_| {}), [2, 1, 3]);
    assert_eq!(with(&|queue| queue.sort = Sort::Position), [1, 2, 3]);
    assert_eq!(with(&|queue| queue.sort = Sort::Class), [1, 3, 2]);
    assert_eq!(with(&|queue| queue.threshold = 0.6), [2, 1]);
    assert_eq!(with(&|queue| queue.filter.class = Some("tyre".to_owned())), [2]);
    assert_eq!(with(&|queue| queue.filter.score = 0.0..=0.6), [1, 3]);
    assert_eq!(with(&|queue| queue.filter.size_m = 2.5..=9.0), [0; 0]);
    assert_eq!(with(&|queue| queue.filter.state = Some(State::Accepted)), [0; 0]);
}

#[test]
fn what_was_decided_stays_in_sight_and_is_counted() {
    let review = edited(&proposed(), &[Edit::Reject(BoxId(3))]);
    let queue = Queue { threshold: 0.95, ..Queue::default() };
    assert_eq!(line(&review, &queue), [3]);
    let counts = DecisionCounts::of(&review, &queue);
    assert_eq!((counts.rejected, counts.hidden), (1, 2));
    let counts = DecisionCounts::of(&review, &Queue::default());
    assert_eq!((counts.decided(), counts.total()), (1, 3));
}

#[test]
fn a_saved_review_comes_back() {
    let add = Edit::Add { mark: mark(Side::Port, 500, 3.0), class: 1 };
    let note = Edit::Note(BoxId(2), "see \"dive 3\"".into());
    let edits = [Edit::Accept(BoxId(1)), Edit::Reject(BoxId(3)), add, note];
    let review = edited(&proposed(), &edits);
    let text = review.to_json();
    assert_eq!(Review::from_json(&text, &identity()), Ok(review));
    let renamed = Identity { file: "copy.sl2".into(), ..identity() };
    assert!(Review::from_json(&text, &renamed).is_ok());
}

#[test]
fn a_file_that_cannot_be_believed_is_refused_with_the_reason() {
    let text = edited(&proposed(), &[Edit::Accept(BoxId(1))]).to_json();
    let other = Identity { pings: 999, ..identity() };
    let said = Review::from_json(&text, &other).unwrap_err().to_string();
    assert!(said.contains("another log") && said.ends_with("river.sl2"));
    for (from, to, reason) in [
        ("\"version\": 1", "\"version\": 2", "layout 2"),
        ("\"version\": 1", "\"version\": \"x\"", "no review"),
        ("\"id\": 2", "\"id\": 1", "twice"),
        ("\"id\": 2", "\"id\": 4294967295", "out of range"),
        ("\"id\": 2", "\"id\": -1", "damaged"),
        ("110", "1001", "outside the log"),
        ("110", "100", "outside the log"),
        ("\"far_m\": 7.0", "\"far_m\": 1e999", "damaged"),
        ("\"near_m\": 5.0", "\"near_m\": -5.0", "outside the log"),
        ("\"class\": \"tyre\"", "\"class\": \"car\"", "class"),
        ("\"tyre\"\n", "\"rock\"\n", "class name"),
        ("\"score\": 0.6", "\"score\": 1.5", "score"),
        ("\"accepted\"", "\"added\"", "state"),
        ("\"accepted\"", "\"maybe\"", "damaged"),
    ] {
        let wrong = text.replacen(from, to, 1);
        assert_ne!(wrong, text, "{from}");
        let error = Review::from_json(&wrong, &identity()).unwrap_err();
        assert!(error.to_string().contains(reason), "{to}: {error}");
    }
    for length in 0..text.len() {
        let half = text.get(..length).unwrap_or_default();
        assert!(Review::from_json(half, &identity()).is_err());
    }
}

#[test]
fn every_decided_box_is_in_a_tile_that_tells_the_truth_about_it() {
    let far = Mark { near_m: 17.0, far_m: 19.0, ..mark(Side::Port, 130, 17.0) };
    let add = Edit::Add { mark: far.clone(), class: 1 };
    let edits = [Edit::Accept(BoxId(1)), Edit::Reject(BoxId(3)), add];
    let review = edited(&proposed(), &edits);
    let raster = raster();
    let tiles = review.tiles(&raster);
    assert_eq!(tiles.len(), 3, "the undecided tyre makes no tile");
    let of_rock = &tiles[0];
    assert_eq!((of_rock.side, of_rock.rejected), (Side::Port, 0));
    let [rock] = of_rock.boxes.labels[..] else { panic!("{of_rock:?}") };
    let expected = raster.rect_of(&mark(Side::Port, 100, 5.0));
    let (column, row) = (of_rock.column as f32, of_rock.row as f32);
    assert_eq!(rock.rect.shifted(column, row), expected);
    // The added box is too far out for the rock's tile; its own tile is limited to the picture and
    // shows the rock too.
    let of_added = &tiles[1].boxes.labels;
    let added = of_added.iter().find(|label| label.class == 1);
    let whole = raster.rect_of(&far).area();
    assert_eq!(added.map(|label| label.rect.area()), Some(whole));
    assert_eq!(of_added.len(), 2);
    let negative = &tiles[2];
    assert_eq!((negative.side, negative.rejected), (Side::Starboard, 1));
    assert!(negative.boxes.labels.is_empty());

    // Two tiles later, the undecided box lies in the tile of a negative: it counts neither as found
    // nor as missed.
    let near = Edit::Reshape(BoxId(2), mark(Side::Starboard, 310, 5.0));
    let review = edited(&review, &[near]);
    let moved = edited(&review, &[Edit::SwapSide(BoxId(2)), Edit::SwapSide(BoxId(2))]);
    let tiles = moved.tiles(&raster);
    assert_eq!(tiles[2].boxes.ignored.len(), 1);
}

#[test]
fn a_search_that_was_stopped_leaves_what_it_has_not_come_to() {
    let (raster, names) = (raster(), names(&["rock"]));
    let at = |start: usize| detection(0, 0.5, mark(Side::Port, start, 3.0));
    let whole = Review::new(identity(), names.clone()).adopt(
        "first",
        &names,
        &[at(20), at(95), at(150)],
        &raster,
        0..usize::MAX,
    );
    assert!(whole.unsearched().is_empty() && whole.coverage().is_none());
    let part = whole.adopt("second", &names, &[at(60)], &raster, 0..100);
    let starts: Vec<usize> = part.boxes().map(|review_box| review_box.mark.pings.start).collect();
    assert_eq!(starts, [95, 150, 60], "the second saw nothing at 20");
    let searched = |review: &Review| {
        let all = review.searched().iter();
        all.map(|search| (search.model.to_string(), search.pings.clone())).collect::<Vec<_>>()
    };
    let both = [("second".to_owned(), 0..100), ("first".to_owned(), 100..PINGS)];
    assert_eq!(searched(&part), both);
    assert!(part.unsearched().is_empty(), "one or the other was there");

    let only = Review::new(identity(), names.clone());
    assert!(only.unsearched().is_empty(), "nobody knows of a search");
    let only = only.adopt("second", &names, &[], &raster, 0..80);
    assert_eq!(only.unsearched(), vec![80..PINGS; 1]);
    assert_eq!(only.coverage().as_deref(), Some("pings 0 to 79 of 1000"));
    let only = only.adopt("second", &names, &[], &raster, 0..120);
    assert_eq!(searched(&only), [("second".to_owned(), 0..120)]);
    let read = Review::from_json(&only.to_json(), &identity()).expect("our own file");
    assert_eq!(read, only);
    let damaged = only.to_json().replace("120", "1001");
    assert!(Review::from_json(&damaged, &identity()).is_err());
}

#[test]
fn edges_that_are_drawn_belong_to_the_box_until_they_are_left() {
    let (id, review) = (BoxId(1), proposed());
    let drawn = mark(Side::Port, 100, 5.0);
    let set = |border_m: f64| Edit::SetEdges { id, mark: drawn.clone(), border_m };
    assert_eq!(review.apply(&set(f64::NAN)), None);
    let border = |review: &Review| review.get(id).unwrap().extent.border_m();
    let after = edited(&review, &[set(5.4)]);
    assert_eq!(border(&after), Some(5.4));
    assert!(after.get(id).unwrap().is_kept(), "a new model leaves it");
    assert_eq!(border(&edited(&review, &[set(99.0)])), Some(drawn.far_m));
    let moved = edited(&after, &[Edit::Reshape(id, mark(Side::Port, 130, 6.0))]);
    assert!((border(&moved).unwrap() - 6.4).abs() < 1e-9);
    let left = edited(&moved, &[Edit::FindEdges(id)]);
    assert_eq!(border(&left), None);
    assert_eq!(left.apply(&Edit::FindEdges(id)), None);
}

#[test]
fn a_point_is_a_place_without_size() {
    let review = proposed();
    let id = review.next_id();
    let add = Edit::AddPoint { side: Side::Starboard, ping: 321, range_m: 7.5, class: 1 };
    let after = edited(&review, &[add]);
    let review_box = after.get(id).unwrap();
    assert_eq!((review_box.state, review_box.extent), (State::Added, ObjectExtent::Point));
    assert_eq!(review_box.mark, Mark::point(Side::Starboard, 321, 7.5));
    // The point has no edges to be found, and moves as a whole.
    assert_eq!(after.apply(&Edit::FindEdges(id)), None);
    let moved = edited(&after, &[Edit::Reshape(id, Mark::point(Side::Starboard, 322, 7.4))]);
    assert_eq!(moved.get(id).unwrap().extent, ObjectExtent::Point);
    let late = Edit::AddPoint { side: Side::Port, ping: PINGS, range_m: 7.5, class: 0 };
    assert_eq!(review.apply(&late), None);
    // A point makes no tile of its own: its size is unknown, so it is neither a label nor a
    // negative.
    let tiles = after.tiles(&raster());
    assert!(tiles.is_empty(), "a point makes no tile");
    let beside = edited(&after, &[Edit::Add { mark: mark(Side::Starboard, 322, 6.0), class: 0 }]);
    let tiles = beside.tiles(&raster());
    assert_eq!(tiles.len(), 1);
    assert_eq!(
        (tiles[0].boxes.labels.len(), tiles[0].boxes.ignored.len()),
        (1, 2),
        "the point and the proposal beside it are no background"
    );
}

#[test]
fn a_target_has_a_name_a_class_of_its_own_and_a_word_of_certainty() {
    let (id, review) = (BoxId(2), proposed());
    for edit in [
        Edit::Rename(id, "two\nlines".into()),
        Edit::Rename(id, "x".repeat(201)),
        Edit::Classify(id, "  ".into()),
    ] {
        assert_eq!(review.apply(&edit), None, "{edit:?}");
    }
    let after = edited(
        &review,
        &[
            Edit::Rename(id, " Anna ".into()),
            Edit::Classify(id, "steam tug".into()),
            Edit::Rate(id, Some(Certainty::Certain)),
        ],
    );
    let review_box = after.get(id).unwrap();
    assert_eq!((review_box.name.as_str(), review_box.class), ("Anna", 2));
    assert_eq!(after.classes(), names(&["rock", "tyre", "steam tug"]));
    assert_eq!(review_box.certainty, Some(Certainty::Certain));
    assert_eq!(after.apply(&Edit::Classify(id, "steam tug".into())), None);
    let known = edited(&after, &[Edit::Classify(id, "rock".into())]);
    assert_eq!(known.classes(), after.classes());
    assert_eq!(known.get(id).unwrap().class, 0);
    let cleared = edited(&after, &[Edit::Rename(id, String::new()), Edit::Rate(id, None)]);
    assert_eq!(cleared.get(id).unwrap().certainty, None);
}

#[test]
fn a_file_keeps_edges_points_names_and_refuses_those_that_make_no_sense() {
    let review = proposed();
    let id = BoxId(1);
    let [near_m, far_m] = [5.0, 7.0];
    let set = Edit::SetEdges {
        id,
        mark: Mark::new(Side::Port, 100..110, [near_m, far_m]),
        border_m: 5.5,
    };
    let point = Edit::AddPoint { side: Side::Starboard, ping: 321, range_m: 7.5, class: 1 };
    let named = Edit::Rename(id, "Anna".into());
    let rated = Edit::Rate(id, Some(Certainty::Unsure));
    let after = edited(&review, &[set, point, named, rated]);
    let text = after.to_json();
    assert_eq!(Review::from_json(&text, review.identity()), Ok(after));
    for (from, to) in [
        ("\"border_m\": 5.5", "\"border_m\": 9.5"),
        ("\"border_m\": 5.5", "\"border_m\": 5.5, \"point\": true"),
        ("\"name\": \"Anna\"", "\"name\": \"An\\nna\""),
        ("\"confidence\": \"unsure\"", "\"confidence\": \"maybe\""),
    ] {
        assert!(text.contains(from), "{text}");
        let wrong = text.replace(from, to);
        assert!(Review::from_json(&wrong, review.identity()).is_err(), "{to}");
    }
    // A file of an earlier version has none of these fields.
    let old = review.to_json();
    for field in ["border_m\"", "point\"", "name\"", "confidence\""] {
        assert!(!old.contains(&format!("\"{field}")), "{field}");
    }
    assert_eq!(Review::from_json(&old, review.identity()), Ok(review));
}

#[test]
fn labels_are_numbered_by_the_analysts_list_and_nameless_boxes_come_last() {
    let empty = Review::new(identity(), names(&[NAMELESS_CLASS]));
    let found = [detection(0, 0.6, mark(Side::Port, 100, 5.0))];
    let review = empty.adopt("first", &names(&["rock", "tyre"]), &found, &raster(), 0..usize::MAX);
    let list = names(&["wreck", "tyre"]);
    let (classes, places) = review.training_classes(&list);
    // A class without boxes is included only if it is in the list.
    assert_eq!(classes, ["wreck", "tyre", "rock"]);
    assert_eq!(places, [None, Some(2), Some(1)]);
    let drawn = Edit::Add { mark: mark(Side::Port, 500, 5.0), class: 0 };
    let review = review.apply(&drawn).expect("a box");
    let (classes, places) = review.training_classes(&list);
    assert_eq!(classes, ["wreck", "tyre", "rock", "object"]);
    assert_eq!(places, [Some(3), Some(2), Some(1)]);
}

#[test]
fn a_class_is_renamed_for_all_its_boxes_and_may_join_another() {
    let found = [
        detection(0, 0.6, mark(Side::Port, 100, 5.0)),
        detection(1, 0.7, mark(Side::Port, 300, 5.0)),
    ];
    let empty = Review::new(identity(), names(&[NAMELESS_CLASS]));
    let review = empty.adopt("first", &names(&["rock", "tyre"]), &found, &raster(), 0..usize::MAX);
    let classes = |review: &Review| -> Vec<String> {
        let class = |review_box: &Reviewed| review.class_name(review_box.class).to_owned();
        review.boxes().map(class).collect()
    };
    let renamed = review.with_class_renamed("tyre", "wheel").expect("a class");
    assert_eq!(classes(&renamed), ["rock", "wheel"]);
    let joined = review.with_class_renamed("tyre", "rock").expect("a class");
    assert_eq!(classes(&joined), ["rock", "rock"]);
    assert_eq!(review.with_class_renamed("buoy", "rock"), None);
    assert_eq!(review.with_class_renamed("rock", "rock"), None);
}

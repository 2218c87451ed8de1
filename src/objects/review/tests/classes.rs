//! Tests the names of classes: in labels for training, and renamed.

use super::*;

#[test]
fn labels_are_numbered_by_the_analysts_list_and_nameless_boxes_come_last() {
    let empty = Review::new(identity(), names(&[NAMELESS_CLASS]));
    let found = [detection(0, 0.6, mark(Side::Port, 100, 5.0))];
    let review = empty.adopt("first", &names(&["rock", "tyre"]), &found, &raster());
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
    let review = empty.adopt("first", &names(&["rock", "tyre"]), &found, &raster());
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

//! Describes the result of a search in words.

use bathyscope_products::outputs::Proposed;
use std::collections::BTreeMap;

/// `7 boxes (4 rock, 3 tyre)`, of the classes' names.
pub(super) fn boxes<'a>(names: impl Iterator<Item = &'a str>) -> String {
    let mut counts: BTreeMap<&str, usize> = BTreeMap::new();
    for name in names {
        *counts.entry(name).or_default() += 1;
    }
    let each: Vec<String> = counts.iter().map(|(name, count)| format!("{count} {name}")).collect();
    match counts.values().sum() {
        0 => "no objects".to_owned(),
        1 => format!("1 box ({})", each.join("")),
        count => format!("{count} boxes ({})", each.join(", ")),
    }
}

/// `7 boxes (4 rock, 3 tyre) on 5 objects`: an object that several lines saw has as many boxes.
pub(super) fn proposed(found: &Proposed, names: &[String]) -> String {
    let name = |class: usize| names.get(class).map_or("object", String::as_str);
    let boxes = boxes(found.boxes.iter().map(|one| name(one.class)));
    let objects = match found.objects {
        0 => String::new(),
        1 => " on 1 object".to_owned(),
        count => format!(" on {count} objects"),
    };
    let unplaced = match found.unplaced {
        0 => String::new(),
        count => format!(", {count} of them without a place in the world"),
    };
    boxes + &objects + &unplaced
}

#[cfg(test)]
mod tests {
    use super::*;
    use bathyscope_log::survey::Side;
    use bathyscope_objects::{Detection, Mark};

    fn summary_of(classes: &[usize], objects: usize, unplaced: usize) -> String {
        let one = |&class: &usize| Detection {
            class,
            score: 0.5,
            mark: Mark { side: Side::Port, pings: 0..4, near_m: 3.0, far_m: 4.0 },
        };
        let boxes = classes.iter().map(one).collect();
        let found = Proposed { boxes, objects, unplaced };
        proposed(&found, &["rock".to_owned(), "tyre".to_owned()])
    }

    #[test]
    fn boxes_are_distinguished_from_objects() {
        assert_eq!(summary_of(&[], 0, 0), "no objects");
        assert_eq!(summary_of(&[1], 1, 0), "1 box (1 tyre) on 1 object");
        assert_eq!(summary_of(&[0, 1, 0], 2, 0), "3 boxes (2 rock, 1 tyre) on 2 objects");
        assert_eq!(
            summary_of(&[0, 0], 0, 2),
            "2 boxes (2 rock), 2 of them without a place in the world"
        );
    }
}

//! Words of an object for plotters and map programs: a name, a line, and its columns as elements of
//! XML.

use bathyscope_bottom::presentation::text::plural;
use bathyscope_bottom::presentation::units::Units;
use bathyscope_log::support::printable::xml;
use bathyscope_objects::objects::{ListedObject, OBJECT_COLUMNS, Object};
use std::collections::HashMap;

/// Returns the description that a plotter shows beside the name, without unknown values.
pub(super) fn description(object: &Object) -> String {
    let units = Units::default();
    let mut parts = vec![object.class.clone(), object.state.name().to_owned()];
    if let Some(score) = object.score {
        parts.push(format!("score {score:.2}"));
    }
    if let Some(certainty) = object.certainty {
        parts.push(certainty.name().to_owned());
    }
    let (length_m, width_m) = (object.length_m, object.width_m);
    if length_m.is_finite() && width_m.is_finite() {
        parts.push(format!("{length_m:.2} x {width_m:.2} m"));
    }
    let known = [
        ("height", object.height.mean_m, object.height.sigma_m),
        ("depth", object.depth_m, f64::NAN),
        ("position within", object.sigma_m, f64::NAN),
    ];
    let known = known.iter().filter(|(_, metres, _)| metres.is_finite());
    parts.extend(known.map(|(what, metres, sigma_m)| {
        format!("{what} {}", units.with_sigma(*metres, *sigma_m, 2))
    }));
    let passes = plural(object.sightings, "pass", "passes");
    parts.push(format!("seen on {passes}"));
    if !object.remarks.is_empty() {
        parts.push(object.remarks.clone());
    }
    parts.join("; ")
}

/// Returns a different name for each object, because plotters take places of one name for one
/// place. `Anna`, `rock 12`; a name that several objects have is followed by their numbers.
pub(super) fn titles(objects: &[ListedObject<'_>]) -> Vec<String> {
    let mut times: HashMap<&str, usize> = HashMap::new();
    for ListedObject { object, .. } in objects {
        *times.entry(&object.name).or_default() += 1;
    }
    let title = |ListedObject { object, .. }: &ListedObject<'_>| {
        let name = object.name.as_str();
        match (name, times[name]) {
            ("", _) => format!("{} {}", object.class, object.number),
            (name, 1) => name.to_owned(),
            (name, _) => format!("{name} {}", object.number),
        }
    };
    objects.iter().map(title).collect()
}

/// The columns of an object that are known, each as an element that `element` makes of its name and
/// its value.
pub(super) fn elements(of: &ListedObject<'_>, element: impl Fn(&str, &str) -> String) -> String {
    let known = OBJECT_COLUMNS.iter().map(|column| (column.name, column.text(of)));
    let known = known.filter(|(_, text)| !text.is_empty());
    known.map(|(name, text)| element(name, &xml(&text))).collect()
}

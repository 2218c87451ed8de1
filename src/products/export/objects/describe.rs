//! Words of an object for plotters and map programs: a name, a line, and its columns as elements of
//! XML.

use bathyscope_bottom::presentation::text::plural;
use bathyscope_bottom::presentation::units::Units;
use bathyscope_log::support::printable::xml;
use bathyscope_objects::objects::{ListedObject, OBJECT_COLUMNS, SurveyObject};
use std::collections::HashMap;

/// What a plotter shows beside the name; what is not known is left out.
pub(super) fn description(object: &SurveyObject) -> String {
    let (units, summary, joint) = (Units::default(), &object.summary, &object.joint);
    let mut parts = vec![joint.class.clone(), summary.state.name().to_owned()];
    if let Some(score) = summary.score {
        parts.push(format!("score {score:.2}"));
    }
    if let Some(confidence) = summary.confidence {
        parts.push(confidence.name().to_owned());
    }
    let (length_m, width_m) = (summary.length_m, summary.width_m);
    if length_m.is_finite() && width_m.is_finite() {
        parts.push(format!("{length_m:.2} x {width_m:.2} m"));
    }
    let known = [
        ("height", joint.height.mean_m, joint.height.sigma_m),
        ("depth", summary.depth_m, f64::NAN),
        ("position within", joint.sigma_m, f64::NAN),
    ];
    let known = known.iter().filter(|(_, metres, _)| metres.is_finite());
    parts.extend(known.map(|(what, metres, sigma_m)| {
        format!("{what} {}", units.with_sigma(*metres, *sigma_m, 2))
    }));
    let passes = plural(object.sightings, "pass", "passes");
    parts.push(format!("seen on {passes}"));
    if !summary.notes.is_empty() {
        parts.push(summary.notes.clone());
    }
    parts.join("; ")
}

/// What each object is called, each otherwise: plotters take places of one name for one. `Anna`,
/// `rock 12`; a name that several objects have is followed by their numbers.
pub(super) fn titles(objects: &[ListedObject<'_>]) -> Vec<String> {
    let mut times: HashMap<&str, usize> = HashMap::new();
    for ListedObject { object, .. } in objects {
        *times.entry(&object.summary.name).or_default() += 1;
    }
    let title = |ListedObject { object, .. }: &ListedObject<'_>| {
        let name = object.summary.name.as_str();
        match (name, times[name]) {
            ("", _) => format!("{} {}", object.joint.class, object.number),
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

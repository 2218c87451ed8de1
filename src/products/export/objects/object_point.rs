//! An object as plotters and map programs show it: one point with a name, whatever the number of its boxes.

use super::ObjectRow;
use crate::detection::ObjectExtent;
use crate::detection::targets::ObjectHeight;
use crate::support::geo::LonLat;
use crate::support::presentation::text::plural;
use crate::support::presentation::units::Units;
use std::cmp::Ordering;
use std::collections::HashMap;

/// An object with what all its boxes say of it.
#[derive(Clone, Debug)]
pub struct ObjectPoint {
    /// Its number.
    pub number: usize,
    /// What the analyst calls it: that of the first of its boxes that has a name; empty where none has.
    pub name: String,
    /// The class that most of its boxes have.
    pub class: String,
    /// `proposed`, `accepted` or `added`.
    pub state: String,
    /// The highest score of its boxes; `None` where all were drawn by hand.
    pub score: Option<f32>,
    /// How sure the analyst is; empty where nobody has said.
    pub confidence: String,
    /// Remarks on its boxes, one after the other.
    pub note: String,
    /// Mean of the places of its boxes.
    pub position: LonLat,
    /// Standard deviation of that place, metres.
    pub sigma_m: f64,
    /// Length along the track and width across it by the box that tells its size best, metres; NaN where that is not known.
    pub size_m: [f64; 2],
    /// Its height above the bottom.
    pub height: ObjectHeight,
    /// Depth of the bottom there, metres.
    pub depth_m: f64,
    /// Passes of the boat that saw it.
    pub sightings: usize,
}

impl ObjectPoint {
    /// What the boxes of an object say of it; class, place and sightings are those of the box that tells its size best. `None` without a
    /// box that has a place.
    pub fn new(number: usize, boxes: &[&ObjectRow<'_>]) -> Option<Self> {
        let best = best_sized(boxes)?;
        let target = best.target.as_ref()?;
        let first_of = |text: fn(&ObjectRow<'_>) -> String| {
            let texts = boxes.iter().map(|row| text(row));
            texts.into_iter().find(|text| !text.is_empty())
        };
        let notes: Vec<&str> = (boxes.iter().map(|row| row.note))
            .filter(|note| !note.is_empty())
            .collect();
        Some(Self {
            number,
            name: first_of(|row| row.name.to_owned()).unwrap_or_default(),
            class: best.class.to_owned(),
            state: best.state.to_owned(),
            score: boxes
                .iter()
                .filter_map(|row| row.score)
                .max_by(f32::total_cmp),
            confidence: first_of(|row| row.confidence.to_owned()).unwrap_or_default(),
            note: notes.join("; "),
            position: target.position,
            sigma_m: target.sigma_m,
            size_m: [target.length_m, target.width_m],
            height: ObjectHeight::of(boxes.iter().filter_map(|row| row.target.as_ref())),
            depth_m: target.depth_m,
            sightings: 1,
        })
    }

    /// What a plotter shows beside the name; what is not known is left out.
    pub(super) fn description(&self) -> String {
        let units = Units::default();
        let mut parts = vec![self.class.clone(), self.state.clone()];
        if let Some(score) = self.score {
            parts.push(format!("score {score:.2}"));
        }
        if !self.confidence.is_empty() {
            parts.push(self.confidence.clone());
        }
        let [length_m, width_m] = self.size_m;
        if length_m.is_finite() && width_m.is_finite() {
            parts.push(format!("{length_m:.2} x {width_m:.2} m"));
        }
        let ObjectHeight { mean_m, sigma_m } = self.height;
        let known = [
            ("height", mean_m, sigma_m),
            ("depth", self.depth_m, f64::NAN),
            ("position within", self.sigma_m, f64::NAN),
        ];
        let known = known.iter().filter(|(_, metres, _)| metres.is_finite());
        parts.extend(known.map(|(what, metres, sigma_m)| {
            format!("{what} {}", units.with_sigma(*metres, *sigma_m, 2))
        }));
        let passes = plural(self.sightings, "pass", "passes");
        parts.push(format!("seen on {passes}"));
        if !self.note.is_empty() {
            parts.push(self.note.clone());
        }
        parts.join("; ")
    }
}

/// The box that tells the size of an object best: one whose edges were drawn, and of those the surest.
fn best_sized<'a, 'b>(boxes: &[&'a ObjectRow<'b>]) -> Option<&'a ObjectRow<'b>> {
    let rank = |row: &ObjectRow<'_>| {
        let target = row.target.as_ref();
        let is_drawn = target.is_some_and(|one| matches!(one.extent, ObjectExtent::Drawn { .. }));
        (is_drawn, row.score.unwrap_or(1.0))
    };
    let order = |a: &&&ObjectRow<'_>, b: &&&ObjectRow<'_>| -> Ordering {
        let (a, b) = (rank(a), rank(b));
        a.0.cmp(&b.0).then(a.1.total_cmp(&b.1))
    };
    // Of equal boxes the first counts.
    boxes.iter().rev().max_by(order).copied()
}

/// What each point is called, each otherwise: plotters take places of one name for one. `Anna`, `rock 12`; a name that several objects
/// have is followed by their numbers.
pub(super) fn titles(points: &[ObjectPoint]) -> Vec<String> {
    let mut times: HashMap<&str, usize> = HashMap::new();
    for point in points {
        *times.entry(&point.name).or_default() += 1;
    }
    let title = |point: &ObjectPoint| match (point.name.as_str(), times[point.name.as_str()]) {
        ("", _) => format!("{} {}", point.class, point.number),
        (name, 1) => name.to_owned(),
        (name, _) => format!("{name} {}", point.number),
    };
    points.iter().map(title).collect()
}

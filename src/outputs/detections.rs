//! Searches a survey for objects and writes what was found.

use super::record::{Coordinates, Made};
use crate::detection::targets::{GroupSettings, Sighting, group};
use crate::detection::{Detection, DetectorSettings, Mark, Model, Raster, find, review::State};
use crate::export::{self, ObjectRow, Summary};
use crate::pipeline::{Placing, Products};
use crate::progress::Progress;
use crate::survey::Survey;
use std::path::Path;

/// What a search proposes.
#[derive(Clone, Debug, PartialEq)]
pub struct Proposed {
    /// The boxes, in order of the pings.
    pub boxes: Vec<Detection>,
    /// Objects that they are sightings of: one that several lines saw has as many boxes.
    pub objects: usize,
    /// Boxes whose place in the world cannot be known, and so neither whose object they show.
    pub unplaced: usize,
    /// The boxes whose place is known, and the extent of these places in degrees.
    pub placed: Summary,
}

/// Searches the survey and writes `detections.csv`, `.geojson` and `.gpx` and `chips/` with a picture of each box into a folder that
/// exists.
///
/// # Errors
/// A sentence that names the file, or says that the work was cancelled.
pub fn write_detections(
    survey: &Survey,
    products: &Products,
    model: &Model,
    settings: &DetectorSettings,
    folder: &Path,
    progress: &Progress,
) -> Result<Proposed, String> {
    let navigation = &products.navigation;
    let mut found = find(survey, navigation, model, settings, progress, |_| ())
        .map_err(|error| error.to_string())?;
    found.retain(|one| !is_left_out(products, &one.mark));
    let raster = Raster::new(survey, navigation, model.pixel_m());
    let rows = proposed_rows(survey, products, model.names(), &found);
    export::chips(folder, survey, &raster, model.names(), &found, progress)
        .map_err(|error| error.to_string())?;
    export::objects_csv(&folder.join("detections.csv"), survey, &rows)
        .and_then(|()| export::objects_geojson(&folder.join("detections.geojson"), &rows))
        .and_then(|()| export::objects_gpx(&folder.join("detections.gpx"), &rows))
        .map_err(|error| error.to_string())?;
    let (objects, unplaced, placed) = (objects_in(&rows), unplaced_in(&rows), placed_in(&rows));
    Ok(Proposed {
        boxes: found,
        objects,
        unplaced,
        placed,
    })
}

impl Proposed {
    /// What [`write_detections`] wrote of it, without the chips.
    pub fn made(&self) -> Vec<Made> {
        let in_table = Summary {
            count: self.boxes.len(),
            ..self.placed
        };
        let files = [
            ("detections.csv", in_table),
            ("detections.geojson", self.placed),
            ("detections.gpx", self.placed),
        ];
        let made = files.map(|(name, summary)| Made {
            name,
            what: "Boxes that the detector proposes, not reviewed",
            coordinates: Coordinates::Degrees,
            counted: "boxes",
            measured: "",
            summary,
            regardless_of: &["cloud", "crs", "isobaths", "mosaic", "outliers", "surface"],
        });
        made.into()
    }
}

/// Whether the middle of a box lies in a stretch that is left out.
pub(super) fn is_left_out(products: &Products, mark: &Mark) -> bool {
    let middle = usize::midpoint(mark.pings.start, mark.pings.end);
    products.left_out.ping(middle).is_some()
}

/// Objects are numbered from 1 on.
fn objects_in(rows: &[ObjectRow<'_>]) -> usize {
    rows.iter().filter_map(|row| row.object).max().unwrap_or(0)
}

fn unplaced_in(rows: &[ObjectRow<'_>]) -> usize {
    rows.iter().filter(|row| row.object.is_none()).count()
}

fn placed_in(rows: &[ObjectRow<'_>]) -> Summary {
    let mut summary = Summary::default();
    for target in rows.iter().filter_map(|row| row.target.as_ref()) {
        let at = target.position;
        summary.add([at.lon_deg, at.lat_deg], f64::NAN);
    }
    summary
}

/// The rows of the tables of what was found; boxes of the same object share its number.
pub fn proposed_rows<'a>(
    survey: &Survey,
    products: &Products,
    names: &'a [String],
    found: &'a [Detection],
) -> Vec<ObjectRow<'a>> {
    let Products {
        navigation,
        returns,
        calibration,
        correction,
        ..
    } = products;
    let placing = Placing::new(survey, navigation, returns, calibration, correction);
    let mut rows: Vec<ObjectRow<'a>> = (1..)
        .zip(found)
        .map(|(id, one)| ObjectRow {
            id,
            class: names.get(one.class).map_or("", String::as_str),
            score: Some(one.score),
            state: State::Proposed.name(),
            mark: &one.mark,
            target: placing.place(&one.mark),
            object: None,
            note: "",
        })
        .collect();
    number_objects(&mut rows, |row| Some(found[row].class));
    rows
}

/// Gives sightings of one object the same number. `class_of` tells a row's class; rows without one are no objects.
pub(super) fn number_objects(
    rows: &mut [ObjectRow<'_>],
    class_of: impl Fn(usize) -> Option<usize>,
) {
    let mut objects: Vec<Option<usize>> = vec![None; rows.len()];
    let (members, sightings): (Vec<usize>, Vec<Sighting<'_>>) = rows
        .iter()
        .enumerate()
        .filter_map(|(row, one)| {
            let sighting = Sighting {
                log: 0,
                target: one.target.as_ref()?,
                class: class_of(row)?,
                // Who drew a box was sure of it.
                score: one.score.map_or(1.0, f64::from),
            };
            Some((row, sighting))
        })
        .unzip();
    let groups = group(&sightings, &GroupSettings::default());
    for (object, group) in (1..).zip(&groups) {
        for &member in &group.members {
            objects[members[member]] = Some(object);
        }
    }
    for (row, object) in rows.iter_mut().zip(objects) {
        row.object = object;
    }
}

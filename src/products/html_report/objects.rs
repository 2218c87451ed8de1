//! Returns the objects of the report: marks on the maps, and a table with a picture of each object.

use super::frame::{PageTransform, pixels};
use super::{ReportData, raster};
use crate::export::chip;
use bathyscope_bottom::presentation::page::{Value, context};
use bathyscope_bottom::presentation::text::{plural, position, typeset_count};
use bathyscope_log::support::progress::{Cancelled, Progress};
use bathyscope_objects::objects::{ColumnValues, ListedObject, Object, ObjectBox, ObjectColumn};
use bathyscope_objects::review::State;
use bathyscope_objects::targets::PassCount;

/// Largest number of rows of a table; the files of the run list all objects.
const MOST_ROWS: usize = 60;
/// Largest width of a picture in the table, pixels.
const LISTED_WIDTH: usize = 220;

/// Returns the boxes of targets, which are drawn and listed.
fn boxes<'a>(from: &'a ReportData<'_>) -> &'a [&'a ObjectBox] {
    let objects = from.objects.as_ref();
    objects.map_or(&[][..], |objects| &objects.boxes)
}

/// Returns the undecided boxes of a review; none without a review, because then all boxes are
/// targets.
pub(super) fn undecided<'a>(from: &'a ReportData<'_>) -> impl Iterator<Item = &'a ObjectBox> {
    let reviewed = (from.objects.as_ref()).filter(|objects| objects.list.is_reviewed());
    let boxes = reviewed.into_iter().flat_map(|objects| objects.list.boxes());
    boxes.filter(|object_box| object_box.one.state == State::Proposed)
}

/// Returns true if a person has decided about boxes; otherwise all boxes are proposals of the
/// detector.
pub(super) fn is_reviewed(from: &ReportData<'_>) -> bool {
    (from.objects.as_ref()).is_some_and(|objects| objects.list.is_reviewed())
}

/// Returns the targets, by number.
pub(super) fn targets<'a>(from: &'a ReportData<'_>) -> impl Iterator<Item = &'a Object> {
    (from.objects.iter()).flat_map(|objects| objects.list.targets())
}

/// Returns the number of targets, or of their boxes where no box has a place.
fn count(from: &ReportData<'_>) -> usize {
    match targets(from).count() {
        0 => boxes(from).len(),
        count => count,
    }
}

/// Returns the places of the rings and numbers that mark the targets on a map.
pub(super) fn marks(from: &ReportData<'_>, frame: &PageTransform) -> Vec<Value> {
    let mark = |object: &Object| {
        let [x, y] = frame.place(from.map.place(object.position));
        context! {
            x => pixels(x),
            y => pixels(y),
            text_x => pixels(x + 7.0),
            text_y => pixels(y + 4.0),
            number => object.number,
        }
    };
    targets(from).map(mark).collect()
}

/// Returns the numbers of passes that saw an object and that covered its place.
pub(super) fn passes_of(from: &ReportData<'_>, object: &Object) -> PassCount {
    let objects = from.objects.as_ref();
    let counted = objects.and_then(|objects| objects.passes.get(&object.number));
    counted.copied().unwrap_or_default()
}

/// Returns the values of the section on objects; `None` without a search or a review.
pub(super) fn values(
    from: &ReportData<'_>,
    progress: &Progress,
) -> Result<Option<Value>, Cancelled> {
    let Some(objects) = &from.objects else {
        return Ok(None);
    };
    let (boxes, listed) = (objects.boxes.len(), objects.listed.len());
    let columns: Vec<&ObjectColumn> = ObjectColumn::shown(from.logs.len()).collect();
    let heading = |column: &&ObjectColumn| {
        let is_length = column.values.is_length();
        context!(heading => column.heading, is_length, is_text => !column.values.is_number())
    };
    let rows = objects.listed.iter().take(MOST_ROWS).map(|of| {
        progress.check()?;
        let cells =
            columns.iter().map(|column| (!column.values.is_number(), cell(from, column, of)));
        let best = objects.list.members(of.object).nth(of.object.best);
        Ok(context! {
            cells => cells.collect::<Vec<(bool, String)>>(),
            picture => best.and_then(|best| picture(from, best, LISTED_WIDTH)),
        })
    });
    Ok(Some(context! {
        count => typeset_count(count(from)),
        is_reviewed => is_reviewed(from),
        origin => &objects.origin,
        undecided => undecided(from).count(),
        boxes,
        seen => seen_in(boxes, listed),
        first_rows => first_of(listed),
        columns => columns.iter().map(heading).collect::<Vec<Value>>(),
        rows => rows.collect::<Result<Vec<Value>, Cancelled>>()?,
        unplaced => unplaced(from, progress)?,
    }))
}

/// Describes the numbers of boxes and objects: `14 boxes on 9 objects`; `9 objects` where each has
/// one box.
fn seen_in(boxes: usize, objects: usize) -> String {
    let seen = plural(objects, "object", "objects");
    if boxes > objects { format!("{} boxes on {seen}", typeset_count(boxes)) } else { seen }
}

/// Returns the number of rows of a table that is cut; `None` where it is complete.
fn first_of(count: usize) -> Option<usize> {
    (count > MOST_ROWS).then_some(MOST_ROWS)
}

/// Returns a cell of an object: lengths to the centimetre, with their standard deviation if it is
/// known.
fn cell(from: &ReportData<'_>, column: &ObjectColumn, of: &ListedObject<'_>) -> String {
    let number = |value: f64| if value.is_finite() { format!("{value:.2}") } else { String::new() };
    match column.values {
        ColumnValues::Measured(value) => {
            let [length_m, sigma_m] = value(of);
            if sigma_m.is_finite() {
                format!("{length_m:.2} ± {sigma_m:.2}")
            } else {
                number(length_m)
            }
        }
        ColumnValues::Length(value) | ColumnValues::Number(_, value) => number(value(of)),
        ColumnValues::Count(_) if column.name == "sightings" => {
            let PassCount { seen, covered } = passes_of(from, of.object);
            format!("{seen} of {}", plural(covered, "pass", "passes"))
        }
        ColumnValues::Count(value) => value(of).to_string(),
        ColumnValues::Position(value) => position(value(of)),
        ColumnValues::Text(_) | ColumnValues::State(_) => column.text(of),
    }
}

/// Returns the boxes of targets without a position, with their pictures; `None` where all have one.
fn unplaced(from: &ReportData<'_>, progress: &Progress) -> Result<Option<Value>, Cancelled> {
    let unplaced = || boxes(from).iter().filter(|of| of.object.is_none());
    let count = unplaced().count();
    let rows = unplaced().take(MOST_ROWS).map(|of| {
        progress.check()?;
        let review_box = &of.one;
        Ok(context! {
            number => review_box.id.0,
            picture => picture(from, of, LISTED_WIDTH),
            class => &of.class,
            state => review_box.state.name(),
            score => review_box.score.map(|score| format!("{score:.2}")),
            remarks => &review_box.note,
        })
    });
    let rows = rows.collect::<Result<Vec<Value>, Cancelled>>()?;
    let found = || {
        context! {
            boxes => plural(count, "box", "boxes"),
            first_rows => first_of(count),
            rows,
        }
    };
    Ok((count > 0).then(found))
}

/// Returns the picture of a box, at most `width` pixels across; `None` where there is no raster for
/// its log.
pub(super) fn picture(from: &ReportData<'_>, of: &ObjectBox, width: usize) -> Option<Value> {
    let raster = from.objects.as_ref()?.rasters.get(of.log)?.as_ref()?;
    let chip = chip(&from.logs.get(of.log)?.survey, raster, &of.one.mark);
    Some(context! {
        class => &of.class,
        number => of.one.id.0,
        width => shown_width(chip.width, chip.height, width),
        address => raster::grey(&chip.levels, chip.width, chip.height),
    })
}

/// Returns the width of a picture on the page. In the table a picture keeps its width, up to the
/// room. A larger room is filled, unless pixels would become wider than four, or the picture higher
/// than the room is wide.
fn shown_width(width: usize, height: usize, room: usize) -> usize {
    if room <= LISTED_WIDTH {
        width.min(room)
    } else {
        room.min(4 * width).min(room * width / height.max(1))
    }
}

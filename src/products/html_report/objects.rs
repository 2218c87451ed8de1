//! Draws the objects of the report: marks on the maps, and a table with a picture of each object.

use super::frame::PageTransform;
use super::{ReportData, ReportObjects, raster};
use crate::export::chip;
use bathyscope_bottom::presentation::text::{plural, position, typeset_count};
use bathyscope_log::support::printable::xml;
use bathyscope_log::support::progress::{Cancelled, Progress};
use bathyscope_objects::objects::{ColumnValues, ListedObject, Object, ObjectBox, ObjectColumn};
use bathyscope_objects::review::State;
use bathyscope_objects::targets::PassCount;

/// Largest number of rows of a table; the files of the run list all objects.
const MOST_ROWS: usize = 60;
/// Largest width of a picture in the table, pixels.
const LISTED_WIDTH: usize = 220;

/// Returns the boxes of targets, which are drawn and listed.
pub(super) fn boxes<'a>(from: &'a ReportData<'_>) -> &'a [&'a ObjectBox] {
    let objects = from.objects.as_ref();
    objects.map_or(&[][..], |objects| &objects.boxes)
}

/// Returns the undecided boxes of a review; none without a review, because then all boxes are
/// targets.
pub(super) fn undecided<'a>(from: &'a ReportData<'_>) -> impl Iterator<Item = &'a ObjectBox> {
    let reviewed = (from.objects.as_ref()).filter(|objects| objects.list.is_reviewed());
    let boxes = reviewed.into_iter().flat_map(|objects| objects.list.boxes());
    boxes.filter(|one| one.one.state == State::Proposed)
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
pub(super) fn count(from: &ReportData<'_>) -> usize {
    match targets(from).count() {
        0 => boxes(from).len(),
        count => count,
    }
}

/// Draws a ring with the number of the target at each target.
pub(super) fn marks(from: &ReportData<'_>, frame: &PageTransform) -> String {
    let mut drawn = String::from(
        "<g font-size=\"11\" fill=\"#111111\" paint-order=\"stroke\" stroke=\"#ffffff\" stroke-width=\"3\">\n",
    );
    for object in targets(from) {
        let [x, y] = frame.place(from.map.place(object.position));
        drawn += &format!(
            "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"5\" fill=\"none\" stroke=\"#d4006a\" stroke-width=\"1.8\"/><text x=\"{:.1}\" y=\"{:.1}\">{}</text>\n",
            x + 7.0,
            y + 4.0,
            object.number,
        );
    }
    drawn + "</g>\n"
}

/// Returns the numbers of passes that saw an object and that covered its place.
pub(super) fn passes_of(from: &ReportData<'_>, object: &Object) -> PassCount {
    let objects = from.objects.as_ref();
    let counted = objects.and_then(|objects| objects.passes.get(&object.number));
    counted.copied().unwrap_or_default()
}

/// Returns the section on objects; empty without a search or a review.
pub(super) fn section(from: &ReportData<'_>, progress: &Progress) -> Result<String, Cancelled> {
    let Some(objects) = &from.objects else {
        return Ok(String::new());
    };
    let (boxes, count) = (objects.boxes.len(), objects.listed.len());
    let mut html = format!("<h2>Objects</h2>\n<p>{}. ", xml(&objects.origin));
    html += &not_listed(from);
    if boxes == 0 {
        let none = if is_reviewed(from) { "None was accepted." } else { "None was found." };
        return Ok(html + none + "</p>\n");
    }
    if count > 0 {
        html += &format!(
            "{}.{} Objects are numbered as on the maps. The picture is that of the sighting that tells the size best; the boat is to the left.</p>\n",
            seen_in(boxes, count),
            first_of(count)
        );
        html += &object_rows(from, objects, progress)?;
        html += "<p>";
    }
    Ok(html + &unplaced(from, progress)? + "</p>\n")
}

/// Describes the numbers of boxes and objects: `14 boxes on 9 objects`; `9 objects` where each has
/// one box.
fn seen_in(boxes: usize, objects: usize) -> String {
    let seen = plural(objects, "object", "objects");
    if boxes > objects { format!("{} boxes on {seen}", typeset_count(boxes)) } else { seen }
}

/// Returns a sentence that the table is cut; empty where it is complete.
fn first_of(count: usize) -> String {
    if count > MOST_ROWS {
        format!(" The first {MOST_ROWS} are listed; the files of this run hold all.")
    } else {
        String::new()
    }
}

/// Returns a table with a row for each target and the columns of the table of objects.
fn object_rows(
    from: &ReportData<'_>,
    objects: &ReportObjects<'_>,
    progress: &Progress,
) -> Result<String, Cancelled> {
    let columns: Vec<&ObjectColumn> = ObjectColumn::shown(from.logs.len()).collect();
    let heading = |column: &&ObjectColumn| match column.values {
        ColumnValues::Length(_) | ColumnValues::Measured(_) => {
            format!("<th>{}, m</th>", column.heading)
        }
        ColumnValues::Count(_) | ColumnValues::Number(..) => {
            format!("<th>{}</th>", column.heading)
        }
        _ => format!("<th class=\"text\">{}</th>", column.heading),
    };
    let headings: Vec<String> = columns.iter().map(heading).collect();
    let (number, rest) = headings.split_at(1.min(headings.len()));
    let mut html = format!(
        "<table><tr>{}<th class=\"text\">picture</th>{}</tr>\n",
        number.concat(),
        rest.concat()
    );
    for of in objects.listed.iter().take(MOST_ROWS) {
        progress.check()?;
        let cells = columns.iter().map(|column| cell(from, column, of));
        let cells: Vec<String> = cells.collect();
        let (number, rest) = cells.split_at(1.min(cells.len()));
        let best = objects.list.members(of.object).nth(of.object.best);
        let picture = best.map_or_else(String::new, |best| picture(from, best, LISTED_WIDTH));
        html += &format!(
            "<tr>{}<td class=\"text\">{picture}</td>{}</tr>\n",
            number.concat(),
            rest.concat()
        );
    }
    Ok(html + "</table>\n")
}

/// Returns a cell of an object: lengths to the centimetre, with their standard deviation if it is
/// known.
fn cell(from: &ReportData<'_>, column: &ObjectColumn, of: &ListedObject<'_>) -> String {
    let number = |value: f64| {
        if value.is_finite() { format!("<td>{value:.2}</td>") } else { "<td></td>".to_owned() }
    };
    match column.values {
        ColumnValues::Measured(value) => {
            let [length_m, sigma_m] = value(of);
            if sigma_m.is_finite() {
                format!("<td>{length_m:.2} ± {sigma_m:.2}</td>")
            } else {
                number(length_m)
            }
        }
        ColumnValues::Length(value) | ColumnValues::Number(_, value) => number(value(of)),
        ColumnValues::Count(_) if column.name == "sightings" => {
            let PassCount { seen, covered } = passes_of(from, of.object);
            format!("<td>{seen} of {}</td>", plural(covered, "pass", "passes"))
        }
        ColumnValues::Count(value) => format!("<td>{}</td>", value(of)),
        ColumnValues::Position(value) => {
            format!("<td class=\"text\">{}</td>", position(value(of)))
        }
        ColumnValues::Text(_) | ColumnValues::State(_) => {
            format!("<td class=\"text\">{}</td>", xml(&column.text(of)))
        }
    }
}

/// Returns the boxes of targets without a position, with their pictures; empty where all have one.
fn unplaced(from: &ReportData<'_>, progress: &Progress) -> Result<String, Cancelled> {
    let unplaced = || boxes(from).iter().filter(|of| of.object.is_none());
    let count = unplaced().count();
    if count == 0 {
        return Ok(String::new());
    }
    let mut html = format!(
        "{} without a position: the log has no position, heading or depth there.{}</p>\n<table><tr><th>box</th><th class=\"text\">picture</th><th class=\"text\">class</th><th class=\"text\">state</th><th>score</th><th class=\"text\">remarks</th></tr>\n",
        plural(count, "box", "boxes"),
        first_of(count)
    );
    for of in unplaced().take(MOST_ROWS) {
        progress.check()?;
        let one = &of.one;
        html += &format!(
            "<tr><td>{}</td><td class=\"text\">{}</td><td class=\"text\">{}</td><td class=\"text\">{}</td><td>{}</td><td class=\"text\">{}</td></tr>\n",
            one.id.0,
            picture(from, of, LISTED_WIDTH),
            xml(&of.class),
            one.state.name(),
            one.score.map_or_else(String::new, |score| format!("{score:.2}")),
            xml(&one.note),
        );
    }
    Ok(html + "</table>\n<p>")
}

/// Reports the undecided proposals of a review in a sentence; empty where there are none, or no
/// review.
fn not_listed(from: &ReportData<'_>) -> String {
    match undecided(from).count() {
        0 => String::new(),
        1 => "One proposal is undecided and not listed. ".to_owned(),
        undecided => format!("{undecided} proposals are undecided and not listed. "),
    }
}

/// Returns the picture of a box as an image of at most `width` pixels across; empty where there is
/// no raster for its log.
pub(super) fn picture(from: &ReportData<'_>, of: &ObjectBox, width: usize) -> String {
    let rasters = from.objects.as_ref().map(|objects| objects.rasters);
    let raster = rasters.and_then(|rasters| rasters.get(of.log)?.as_ref());
    let (Some(raster), Some(log)) = (raster, from.logs.get(of.log)) else {
        return String::new();
    };
    let chip = chip(&log.survey, raster, &of.one.mark);
    format!(
        "<img alt=\"{} {}\" width=\"{}\" src=\"{}\">",
        xml(&of.class),
        of.one.id.0,
        shown_width(chip.width, chip.height, width),
        raster::grey(&chip.levels, chip.width, chip.height)
    )
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

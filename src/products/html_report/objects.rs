//! What lies there: marks on the maps, and a table with a picture of each.

use super::frame::PageTransform;
use super::{ReportData, raster};
use crate::export::{ObjectRow, chip};
use bathyscope_bottom::presentation::text::{decimal, plural, position, typeset_count};
use bathyscope_log::support::printable::xml;
use bathyscope_log::support::progress::{Cancelled, Progress};
use bathyscope_objects::objects::{ObjectBox, SurveyObject};
use bathyscope_objects::review::State;
use bathyscope_objects::targets::{ObjectHeight, PassCount, Target};

/// Longest table; the files of the run list all.
const MOST_ROWS: usize = 60;
/// Width of a picture in the table, pixels.
const LISTED_WIDTH: usize = 220;

/// The boxes of targets, which are drawn and listed.
pub(super) fn rows<'a>(from: &'a ReportData<'_>) -> &'a [ObjectRow<'a>] {
    let objects = from.objects.as_ref();
    objects.map_or(&[][..], |objects| &objects.rows)
}

/// The boxes that nobody has decided about; none without a review, when they are the targets.
pub(super) fn undecided<'a>(from: &'a ReportData<'_>) -> impl Iterator<Item = &'a ObjectBox> {
    let reviewed = (from.objects.as_ref()).filter(|objects| objects.list.is_reviewed());
    let boxes = reviewed.into_iter().flat_map(|objects| objects.list.boxes());
    boxes.filter(|one| one.one.state == State::Proposed)
}

/// Whether somebody has decided about boxes; otherwise all of them are the detector's proposals.
pub(super) fn is_reviewed(from: &ReportData<'_>) -> bool {
    (from.objects.as_ref()).is_some_and(|objects| objects.list.is_reviewed())
}

/// The targets, by number.
pub(super) fn targets<'a>(from: &'a ReportData<'_>) -> impl Iterator<Item = &'a SurveyObject> {
    (from.objects.iter()).flat_map(|objects| objects.list.targets())
}

/// Objects that are listed; boxes where none has a place.
pub(super) fn count(from: &ReportData<'_>) -> usize {
    match targets(from).count() {
        0 => rows(from).len(),
        count => count,
    }
}

/// A ring with its number at each target.
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

/// The objects of several logs, one line each with the surest of its sightings.
fn seen_table(from: &ReportData<'_>, progress: &Progress) -> Result<String, Cancelled> {
    let mut html = String::from(
        "<table><tr><th>object</th><th class=\"text\">picture</th><th class=\"text\">kind</th><th>confidence</th><th class=\"text\">state</th><th class=\"text\">seen</th><th class=\"text\">position</th><th>length, m</th><th>width, m</th><th>height, m</th><th class=\"text\">shape, m</th><th>depth there, m</th><th>position within, m</th><th class=\"text\">note</th></tr>\n",
    );
    for object in targets(from).take(MOST_ROWS) {
        progress.check()?;
        let sightings = (rows(from).iter()).filter(|row| row.of.object == Some(object.number));
        let surest = sightings.max_by(|a, b| sure(a).total_cmp(&sure(b)));
        if let Some(row) = surest {
            html += &seen_line(from, object, row);
        }
    }
    Ok(html + "</table>\n")
}

/// Who drew a box was sure.
fn sure(row: &ObjectRow<'_>) -> f32 {
    row.of.one.score.unwrap_or(1.0)
}

/// Passes that saw an object, and that covered its place.
pub(super) fn passes_of(from: &ReportData<'_>, object: &SurveyObject) -> PassCount {
    let objects = from.objects.as_ref();
    let counted = objects.and_then(|objects| objects.passes.get(&object.number));
    counted.copied().unwrap_or_default()
}

fn seen_line(from: &ReportData<'_>, object: &SurveyObject, surest: &ObjectRow<'_>) -> String {
    let of_target = |value: fn(&Target) -> f64| {
        let known = surest.of.target.as_ref().map(value);
        known.map_or_else(String::new, |metres| decimal(metres, 2))
    };
    let PassCount { seen, covered } = passes_of(from, object);
    let (number, logs) = (object.number, object.logs().len());
    let of_passes = plural(covered, "pass", "passes");
    let in_logs = plural(logs, "log", "logs");
    format!(
        "<tr><td>{number}</td><td class=\"text\">{}</td><td class=\"text\">{}</td><td>{}</td><td class=\"text\">{}</td><td class=\"text\">{seen} of {of_passes}, in {in_logs}</td><td class=\"text\">{}</td><td>{}</td><td>{}</td><td>{}</td><td class=\"text\">{}</td><td>{}</td><td>{}</td><td class=\"text\">{}</td></tr>\n",
        picture(from, surest.of, LISTED_WIDTH),
        xml(&object.joint.class),
        (surest.of.one.score).map_or(String::new(), |score| format!("{score:.2}")),
        surest.of.one.state.name(),
        position(object.position),
        of_target(|target| target.length_m),
        of_target(|target| target.width_m),
        height_cell(object.joint.height),
        shape(surest),
        of_target(|target| target.depth_m),
        decimal(object.joint.sigma_m, 2),
        xml(&surest.of.one.note),
    )
}

/// `1.52 ± 0.12`, in metres.
fn height_cell(height: ObjectHeight) -> String {
    let mean = decimal(height.mean_m, 2);
    match height.sigma_m.is_finite() {
        true => format!("{mean} ± {:.2}", height.sigma_m),
        false => mean,
    }
}

/// The height of the object that a box shows; of a box without an object its own.
fn height_of(from: &ReportData<'_>, row: &ObjectRow<'_>) -> ObjectHeight {
    let objects = from.objects.as_ref();
    match objects.and_then(|objects| objects.list.object(row.of.object?)) {
        Some(object) => object.joint.height,
        None => ObjectHeight::of(row.of.target.iter()),
    }
}

/// The section; empty where nobody searched.
pub(super) fn section(from: &ReportData<'_>, progress: &Progress) -> Result<String, Cancelled> {
    let Some(objects) = &from.objects else {
        return Ok(String::new());
    };
    let (count, distinct) = (objects.rows.len(), targets(from).count());
    let mut html = format!("<h2>Objects</h2>\n<p>{}. ", xml(&objects.origin));
    html += &not_listed(from);
    if count == 0 {
        let none = match is_reviewed(from) {
            true => "None was accepted.",
            false => "None was found.",
        };
        return Ok(html + none + "</p>\n");
    }
    if from.logs.len() > 1 && distinct > 0 {
        let boxes = typeset_count(count);
        let seen = plural(distinct, "object", "objects");
        let listed = match distinct > MOST_ROWS {
            true => format!(" The first {MOST_ROWS} are listed; the files of this run hold all."),
            false => String::new(),
        };
        html += &format!(
            "{boxes} boxes on {seen}: the sightings of an object in all logs are one, at the mean of their places, with the picture and size of the surest.{listed} Objects are numbered as on the maps. In a picture the boat is to the left. {SHAPES}</p>\n"
        );
        return Ok(html + &seen_table(from, progress)?);
    }
    let mut rows: Vec<&ObjectRow<'_>> = objects.rows.iter().collect();
    // Sightings of one object beside each other, the surest first; what has no place in the world
    // last.
    let order = |row: &ObjectRow<'_>| (row.of.object.unwrap_or(u32::MAX), row.of.one.id.0);
    rows.sort_by(|a, b| {
        (order(a).0.cmp(&order(b).0))
            .then(sure(b).total_cmp(&sure(a)))
            .then(order(a).1.cmp(&order(b).1))
    });
    let seen = match distinct {
        0 => format!("{count} boxes."),
        distinct if distinct < count => format!(
            "{count} boxes on {distinct} objects: one that several lines passed is listed for each of its sightings."
        ),
        _ => format!("{count} objects."),
    };
    let listed = match count > MOST_ROWS {
        true => format!(" The first {MOST_ROWS} are listed; the files of this run hold all."),
        false => String::new(),
    };
    html += &format!(
        "{seen}{listed} Objects are numbered as on the maps. In a picture the boat is to the left. {SHAPES}</p>\n<table><tr><th>object</th><th class=\"text\">picture</th><th class=\"text\">kind</th><th>confidence</th><th class=\"text\">state</th><th>box</th><th class=\"text\">position</th><th>length, m</th><th>width, m</th><th>height, m</th><th class=\"text\">shape, m</th><th>depth there, m</th><th>position within, m</th><th class=\"text\">note</th></tr>\n"
    );
    for row in rows.into_iter().take(MOST_ROWS) {
        progress.check()?;
        html += &line(from, row);
    }
    Ok(html + "</table>\n")
}

/// What a review leaves undecided, in a sentence; empty where that is nothing, or everything.
fn not_listed(from: &ReportData<'_>) -> String {
    match undecided(from).count() {
        0 => String::new(),
        1 => "One proposal is undecided and not listed. ".to_owned(),
        undecided => format!("{undecided} proposals are undecided and not listed. "),
    }
}

/// What is seen in a box, as an image of so many pixels at most; empty where its log has no
/// pictures.
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

/// Width of a picture on the page. In the table it is as wide as it is, up to the room; a larger
/// room is filled, unless pixels would be larger than four, or the picture higher than wide.
fn shown_width(width: usize, height: usize, room: usize) -> usize {
    match room <= LISTED_WIDTH {
        true => width.min(room),
        false => room.min(4 * width).min(room * width / height.max(1)),
    }
}

/// `block, 0.99 x 0.75`; empty where no shape fits.
fn shape(row: &ObjectRow<'_>) -> String {
    row.shape.map_or_else(String::new, |shape| {
        let solid = &shape.posed.solid;
        let sizes = [solid.length_m, solid.width_m];
        let sizes = sizes.map(|size_m| decimal(size_m, 2)).join(" x ");
        format!("{}, {sizes}", solid.kind.name())
    })
}

/// What a table says of its shapes.
const SHAPES: &str =
    "A shape is the solid whose echo and shadow lie best over the picture: inferred, not measured.";

fn line(from: &ReportData<'_>, row: &ObjectRow<'_>) -> String {
    let picture = picture(from, row.of, LISTED_WIDTH);
    let (of, one) = (row.of, &row.of.one);
    let at = of.target.as_ref().map_or_else(
        || {
            "<td class=\"text\">unknown</td><td></td><td></td><td></td><td></td><td></td><td></td>"
                .to_owned()
        },
        |target| {
            let cells = |sizes: &[f64]| -> String {
                let cell = |size_m: &f64| format!("<td>{}</td>", decimal(*size_m, 2));
                sizes.iter().map(cell).collect()
            };
            format!(
                "<td class=\"text\">{}</td>{}<td>{}</td><td class=\"text\">{}</td>{}",
                position(target.position),
                cells(&[target.length_m, target.width_m]),
                height_cell(height_of(from, row)),
                shape(row),
                cells(&[target.depth_m, target.sigma_m])
            )
        },
    );
    format!(
        "<tr><td>{}</td><td class=\"text\">{picture}</td><td class=\"text\">{}</td><td>{}</td><td class=\"text\">{}</td><td>{}</td>{at}<td class=\"text\">{}</td></tr>\n",
        one.id.0,
        xml(&of.class),
        (one.score).map_or(String::new(), |score| format!("{score:.2}")),
        one.state.name(),
        (of.object).map_or(String::new(), |object| object.to_string()),
        xml(&one.note),
    )
}

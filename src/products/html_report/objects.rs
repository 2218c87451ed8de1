//! What lies there: marks on the maps, and a table with a picture of each.

use super::frame::Frame;
use super::{ReportData, SeenObject, raster};
use crate::detection::review::State;
use crate::detection::targets::{ObjectHeight, PassCount, Target};
use crate::products::export::{ObjectRow, chip};
use crate::support::presentation::text::{decimal, plural, position, typeset_count};
use crate::support::printable::xml;
use crate::support::progress::{Cancelled, Progress};
use std::collections::BTreeMap;
use std::fmt::Write as _;

/// Longest table; the files of the run list all.
const MOST_ROWS: usize = 60;
/// Width of a picture in the table, pixels.
const LISTED_WIDTH: usize = 220;

/// All boxes.
pub fn rows<'a>(from: &'a ReportData<'_>) -> &'a [ObjectRow<'a>] {
    let objects = from.objects.as_ref();
    objects.map_or(&[][..], |objects| objects.rows)
}

/// Whether nobody has decided about a box.
pub fn is_undecided(row: &ObjectRow<'_>) -> bool {
    row.state == State::Proposed.name()
}

/// Whether somebody has decided about boxes; otherwise all of them are the detector's proposals.
pub fn is_reviewed(from: &ReportData<'_>) -> bool {
    !rows(from).iter().all(is_undecided)
}

/// The boxes that are drawn and listed: of a review those that were accepted or added, for a proposal beside them would pass
/// for an object that somebody has seen; without a review the proposals.
fn shown<'a>(from: &'a ReportData<'_>) -> impl Iterator<Item = &'a ObjectRow<'a>> {
    let objects = [State::Accepted, State::Added].map(State::name);
    let is_reviewed = is_reviewed(from);
    rows(from)
        .iter()
        .filter(move |row| !is_reviewed || objects.contains(&row.state))
}

/// Objects that are listed; boxes where none has a number.
pub fn count(from: &ReportData<'_>) -> usize {
    let distinct = shown(from).filter_map(|row| row.object).max();
    distinct.unwrap_or_else(|| shown(from).count())
}

/// A ring with its number at each object, in the middle of its sightings.
pub fn marks(from: &ReportData<'_>, frame: &Frame) -> String {
    let mut drawn = String::from(
        "<g font-size=\"11\" fill=\"#111111\" paint-order=\"stroke\" stroke=\"#ffffff\" stroke-width=\"3\">\n",
    );
    let mut places: BTreeMap<usize, Vec<[f64; 2]>> = BTreeMap::new();
    for row in shown(from) {
        if let (Some(target), Some(object)) = (&row.target, row.object) {
            let place = from.map.place(target.position);
            places.entry(object).or_default().push(place);
        }
    }
    for (object, places) in places {
        let mean = |axis: usize| {
            let sum: f64 = places.iter().map(|place| place[axis]).sum();
            sum / places.len() as f64
        };
        let [x, y] = frame.place([mean(0), mean(1)]);
        // Writing to a string cannot fail.
        writeln!(
            drawn,
            "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"5\" fill=\"none\" stroke=\"#d4006a\" stroke-width=\"1.8\"/><text x=\"{:.1}\" y=\"{:.1}\">{object}</text>",
            x + 7.0,
            y + 4.0,
        )
        .ok();
    }
    drawn + "</g>\n"
}

/// The objects of several logs, one line each with the surest of its sightings.
fn seen_table(from: &ReportData<'_>, progress: &Progress) -> Result<String, Cancelled> {
    let seen = from
        .objects
        .as_ref()
        .map_or(&[][..], |objects| objects.seen);
    let mut html = String::from(
        "<table><tr><th>object</th><th class=\"text\">picture</th><th class=\"text\">kind</th><th>confidence</th><th class=\"text\">state</th><th class=\"text\">seen</th><th class=\"text\">position</th><th>length, m</th><th>width, m</th><th>height, m</th><th class=\"text\">shape, m</th><th>depth there, m</th><th>position within, m</th><th class=\"text\">note</th></tr>\n",
    );
    for (number, object) in (1..).zip(seen).take(MOST_ROWS) {
        progress.check()?;
        let sightings = shown(from).filter(|row| row.object == Some(number));
        let sure = |row: &ObjectRow<'_>| row.score.unwrap_or(1.0);
        let surest = sightings.max_by(|a, b| sure(a).total_cmp(&sure(b)));
        if let Some(row) = surest {
            html += &seen_line(from, number, object, row);
        }
    }
    Ok(html + "</table>\n")
}

fn seen_line(
    from: &ReportData<'_>,
    number: usize,
    object: &SeenObject,
    surest: &ObjectRow<'_>,
) -> String {
    let of_target = |value: fn(&Target) -> f64| {
        let known = surest.target.as_ref().map(value);
        known.map_or_else(String::new, |metres| decimal(metres, 2))
    };
    let SeenObject {
        passes: PassCount { seen, covered },
        height,
        logs,
        ..
    } = object;
    let of_passes = plural(*covered, "pass", "passes");
    let in_logs = plural(*logs, "log", "logs");
    format!(
        "<tr><td>{number}</td><td class=\"text\">{}</td><td class=\"text\">{}</td><td>{}</td><td class=\"text\">{}</td><td class=\"text\">{seen} of {of_passes}, in {in_logs}</td><td class=\"text\">{}</td><td>{}</td><td>{}</td><td>{}</td><td class=\"text\">{}</td><td>{}</td><td>{}</td><td class=\"text\">{}</td></tr>\n",
        picture(from, surest, LISTED_WIDTH),
        xml(&object.class),
        (surest.score).map_or(String::new(), |score| format!("{score:.2}")),
        surest.state,
        position(object.position),
        of_target(|target| target.length_m),
        of_target(|target| target.width_m),
        height_cell(*height),
        shape(surest),
        of_target(|target| target.depth_m),
        decimal(object.sigma_m, 2),
        xml(surest.note),
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
    let object = objects.and_then(|objects| objects.seen.get(row.object?.checked_sub(1)?));
    match object {
        Some(object) => object.height,
        None => ObjectHeight::of(row.target.iter()),
    }
}

/// The section; empty where nobody searched.
pub fn section(from: &ReportData<'_>, progress: &Progress) -> Result<String, Cancelled> {
    let Some(objects) = &from.objects else {
        return Ok(String::new());
    };
    let count = shown(from).count();
    let mut html = format!("<h2>Objects</h2>\n<p>{}. ", xml(&objects.origin));
    html += &left_out(from);
    if count == 0 {
        let none = match is_reviewed(from) {
            true => "None was accepted.",
            false => "None was found.",
        };
        return Ok(html + none + "</p>\n");
    }
    if from.logs.len() > 1 && !objects.seen.is_empty() {
        let boxes = typeset_count(count);
        let seen = plural(objects.seen.len(), "object", "objects");
        let listed = match objects.seen.len() > MOST_ROWS {
            true => format!(" The first {MOST_ROWS} are listed; the files of this run hold all."),
            false => String::new(),
        };
        // Writing to a string cannot fail.
        writeln!(
            html,
            "{boxes} boxes on {seen}: the sightings of an object in all logs are one, at the mean of their places, with the picture and size of the surest.{listed} Objects are numbered as on the maps. In a picture the boat is to the left. {SHAPES}</p>"
        )
        .ok();
        return Ok(html + &seen_table(from, progress)?);
    }
    let mut rows: Vec<&ObjectRow<'_>> = shown(from).collect();
    // Sightings of one object beside each other, the surest first; what has no place in the world last.
    let order = |row: &&ObjectRow<'_>| (row.object.unwrap_or(usize::MAX), row.id);
    rows.sort_by(|a, b| {
        let sure = |row: &ObjectRow<'_>| row.score.unwrap_or(1.0);
        (order(a).0.cmp(&order(b).0))
            .then(sure(b).total_cmp(&sure(a)))
            .then(order(a).1.cmp(&order(b).1))
    });
    let distinct = rows.iter().filter_map(|row| row.object).max();
    let seen = match distinct {
        Some(distinct) if distinct < count => format!(
            "{count} boxes on {distinct} objects: one that several lines passed is listed for each of its sightings."
        ),
        Some(_) => format!("{count} objects."),
        None => format!("{count} boxes."),
    };
    let listed = match count > MOST_ROWS {
        true => format!(" The first {MOST_ROWS} are listed; the files of this run hold all."),
        false => String::new(),
    };
    // Writing to a string cannot fail.
    write!(
        html,
        "{seen}{listed} Objects are numbered as on the maps. In a picture the boat is to the left. {SHAPES}</p>\n<table><tr><th>object</th><th class=\"text\">picture</th><th class=\"text\">kind</th><th>confidence</th><th class=\"text\">state</th><th>box</th><th class=\"text\">position</th><th>length, m</th><th>width, m</th><th>height, m</th><th class=\"text\">shape, m</th><th>depth there, m</th><th>position within, m</th><th class=\"text\">note</th></tr>\n"
    )
    .ok();
    for row in rows.into_iter().take(MOST_ROWS) {
        progress.check()?;
        html += &line(from, row);
    }
    Ok(html + "</table>\n")
}

/// What a review leaves undecided, in a sentence; empty where that is nothing, or everything.
fn left_out(from: &ReportData<'_>) -> String {
    match rows(from).iter().filter(|row| is_undecided(row)).count() {
        1 if is_reviewed(from) => "One proposal is undecided and not listed. ".to_owned(),
        undecided if undecided > 1 && is_reviewed(from) => {
            format!("{undecided} proposals are undecided and not listed. ")
        }
        _ => String::new(),
    }
}

/// What is seen in a box, as an image of so many pixels at most; empty where its log has no pictures.
pub fn picture(from: &ReportData<'_>, row: &ObjectRow<'_>, width: usize) -> String {
    let rasters = from.objects.as_ref().map(|objects| objects.rasters);
    let raster = rasters.and_then(|rasters| rasters.get(row.log)?.as_ref());
    let (Some(raster), Some(log)) = (raster, from.logs.get(row.log)) else {
        return String::new();
    };
    let chip = chip(&log.survey, raster, row.mark);
    format!(
        "<img alt=\"{} {}\" width=\"{}\" src=\"{}\">",
        xml(row.class),
        row.id,
        shown_width(chip.width, chip.height, width),
        raster::grey(&chip.levels, chip.width, chip.height)
    )
}

/// Width of a picture on the page. In the table it is as wide as it is, up to the room; a larger room is filled, unless pixels would be
/// larger than four, or the picture higher than wide.
fn shown_width(width: usize, height: usize, room: usize) -> usize {
    match room <= LISTED_WIDTH {
        true => width.min(room),
        false => room.min(4 * width).min(room * width / height.max(1)),
    }
}

/// `block, 0.99 x 0.75`; empty where no shape fits.
fn shape(row: &ObjectRow<'_>) -> String {
    row.shape.as_ref().map_or_else(String::new, |shape| {
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
    let picture = picture(from, row, LISTED_WIDTH);
    let at = row.target.as_ref().map_or_else(
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
        row.id,
        xml(row.class),
        row.score
            .map_or(String::new(), |score| format!("{score:.2}")),
        row.state,
        row.object
            .map_or(String::new(), |object| object.to_string()),
        xml(row.note),
    )
}

//! Returns the objects of the report: marks on the maps, a table with a picture of each object, and
//! a section on each target: its position and size, and the measurements of its height.

use super::frame::{PageTransform, pixels};
use super::{ReportData, ReportObjects, jpeg_address};
use crate::export::chip;
use bathyscope_bottom::presentation::page::{Value, context};
use bathyscope_bottom::presentation::text::{NONE, plural, position, typeset_count};
use bathyscope_bottom::presentation::units::Units;
use bathyscope_log::support::progress::{Cancelled, Progress};
use bathyscope_objects::ObjectExtent;
use bathyscope_objects::objects::{
    ColumnValues, ListedObject, Object, ObjectBox, ObjectColumn, ObjectList,
};
use bathyscope_objects::review::{Certainty, State};
use bathyscope_objects::targets::{ObjectHeight, PassCount, Target};

/// Largest number of rows of a table; the files of the run list all objects.
const MOST_ROWS: usize = 60;
/// Largest width of a picture in the table, pixels.
const LISTED_WIDTH: usize = 220;
/// Largest number of sections; the files of the run list all targets.
const MOST_SECTIONS: usize = 60;
/// Width of a picture in a section, pixels.
const PICTURE_WIDTH: usize = 360;

/// Returns the undecided boxes of a review; none without a review, because then all boxes are
/// targets.
fn undecided<'a>(objects: &'a ReportObjects<'_>) -> impl Iterator<Item = &'a ObjectBox> {
    let reviewed = objects.list.is_reviewed.then_some(objects.list.boxes.as_slice());
    let boxes = reviewed.unwrap_or_default().iter();
    boxes.filter(|object_box| object_box.one.state == State::Proposed)
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
    let targets = from.objects.iter().flat_map(|objects| objects.list.targets());
    targets.map(mark).collect()
}

/// Returns the numbers of passes that saw an object and that covered its place.
fn passes_of(objects: &ReportObjects<'_>, object: &Object) -> PassCount {
    objects.passes.get(&object.number).copied().unwrap_or_default()
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
            columns.iter().map(|column| (!column.values.is_number(), cell(objects, column, of)));
        let best = objects.list.members(of.object).nth(of.object.best);
        Ok(context! {
            cells => cells.collect::<Vec<(bool, String)>>(),
            picture => best.and_then(|best| picture(from, objects, best, LISTED_WIDTH)),
        })
    });
    // Where no box has a place, the boxes are counted.
    let count = match objects.list.targets().count() {
        0 => boxes,
        count => count,
    };
    Ok(Some(context! {
        count => typeset_count(count),
        is_reviewed => objects.list.is_reviewed,
        origin => &objects.origin,
        undecided => undecided(objects).count(),
        boxes,
        seen => seen_in(boxes, listed),
        first_rows => first_of(listed),
        columns => columns.iter().map(heading).collect::<Vec<Value>>(),
        rows => rows.collect::<Result<Vec<Value>, Cancelled>>()?,
        unplaced => unplaced(from, objects, progress)?,
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
fn cell(objects: &ReportObjects<'_>, column: &ObjectColumn, of: &ListedObject<'_>) -> String {
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
            let PassCount { seen, covered } = passes_of(objects, of.object);
            format!("{seen} of {}", plural(covered, "pass", "passes"))
        }
        ColumnValues::Count(value) => value(of).to_string(),
        ColumnValues::Position(value) => position(value(of)),
        ColumnValues::Text(_) | ColumnValues::State(_) => column.text(of),
    }
}

/// Returns the boxes of targets without a position, with their pictures; `None` where all have one.
fn unplaced(
    from: &ReportData<'_>,
    objects: &ReportObjects<'_>,
    progress: &Progress,
) -> Result<Option<Value>, Cancelled> {
    let unplaced = || objects.boxes.iter().filter(|of| of.object.is_none());
    let count = unplaced().count();
    let rows = unplaced().take(MOST_ROWS).map(|of| {
        progress.check()?;
        let review_box = &of.one;
        Ok(context! {
            number => review_box.id.0,
            picture => picture(from, objects, of, LISTED_WIDTH),
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
fn picture(
    from: &ReportData<'_>,
    objects: &ReportObjects<'_>,
    of: &ObjectBox,
    width: usize,
) -> Option<Value> {
    let raster = objects.rasters.get(of.log)?.as_ref()?;
    let chip = chip(&from.logs.get(of.log)?.survey, raster, &of.one.mark);
    Some(context! {
        class => &of.class,
        number => of.one.id.0,
        width => shown_width(chip.width, chip.height, width),
        address => jpeg_address(&chip.levels, chip.width, chip.height),
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

/// Returns the values of the sections; `None` where no person has decided about boxes and the
/// settings require no proposals.
pub(super) fn sections(
    from: &ReportData<'_>,
    progress: &Progress,
) -> Result<Option<Value>, Cancelled> {
    let Some(objects) = &from.objects else {
        return Ok(None);
    };
    let with_proposals = from.products.settings.report.proposals;
    let mut found: Vec<Shown<'_>> = Vec::new();
    if objects.list.is_reviewed || with_proposals {
        let targets = objects.list.targets();
        found.extend(targets.filter_map(|object| Shown::new(objects.list, object)));
    }
    // Without a review the proposals are shown as objects already.
    if with_proposals {
        found.extend(undecided(objects).map(|of| Shown { object: None, sightings: vec![of] }));
    }
    let shown = found.iter().take(MOST_SECTIONS).map(|target| {
        progress.check()?;
        Ok(target.values(from, objects))
    });
    let shown = shown.collect::<Result<Vec<Value>, Cancelled>>()?;
    let all = found.len();
    Ok((all > 0).then(|| context!(all, most => MOST_SECTIONS, shown)))
}

/// A target with the boxes that show it, or a proposal.
struct Shown<'a> {
    /// The target; `None` for a proposal.
    object: Option<&'a Object>,
    /// Boxes of the target, at least one: drawn extents first, then by score.
    sightings: Vec<&'a ObjectBox>,
}

impl<'a> Shown<'a> {
    fn new(list: &'a ObjectList, object: &'a Object) -> Option<Self> {
        let boxes = list.members(object).filter(|of| list.is_target(of));
        let mut sightings: Vec<&ObjectBox> = boxes.collect();
        let rank = |of: &ObjectBox| {
            let is_drawn = matches!(of.one.extent, ObjectExtent::Drawn { .. });
            (is_drawn, of.one.score.unwrap_or(1.0))
        };
        sightings.sort_by(|a, b| {
            let (a, b) = (rank(a), rank(b));
            b.0.cmp(&a.0).then(b.1.total_cmp(&a.1))
        });
        (!sightings.is_empty()).then_some(Self { object: Some(object), sightings })
    }

    fn values(&self, from: &ReportData<'_>, objects: &ReportObjects<'_>) -> Value {
        let (best, object) = (self.sightings[0], self.object);
        let target = best.target.as_ref();
        let position_of = |target: &Target| (target.position, target.sigma_m);
        let place = object.map(|object| (object.position, object.sigma_m));
        let place = place.or(target.map(position_of));
        let several_logs = from.logs.len() > 1;
        let pings = &best.one.mark.pings;
        context! {
            number => object.map(|object| object.number),
            name => object.map(|object| &object.name),
            class => object.map_or(&best.class, |object| &object.class),
            picture => picture(from, objects, best, PICTURE_WIDTH),
            position => place.map(|(at, _)| position(at)),
            within => place.map(|(_, sigma_m)| Units::default().measure(sigma_m, 2)),
            size => target.map(|target| self.size(target)),
            passes => object.map(|object| passes(objects, object)),
            log => from.names.get(best.log).filter(|_| several_logs),
            box => best.one.id.0,
            side => best.one.mark.side.name(),
            first_ping => pings.start,
            last_ping => pings.end.saturating_sub(1),
            ..self.decided()
        }
    }

    /// Returns length and width of a sighting, the height of its object, the shadow in the
    /// sighting, and the depth there.
    fn size(&self, target: &Target) -> Value {
        let units = Units::default();
        let is_known = target.length_m.is_finite() && target.width_m.is_finite();
        let known = |metres: f64| is_known.then(|| format!("{metres:.2}"));
        let of_sighting = || ObjectHeight::of(std::iter::once(target));
        let height = self.object.map_or_else(of_sighting, |object| object.height);
        context! {
            length_m => known(target.length_m),
            width_m => known(target.width_m),
            is_drawn => matches!(target.extent, ObjectExtent::Drawn { .. }),
            height => units.with_sigma(height.mean_m, height.sigma_m, 2),
            shadow => shadow(target),
            unknown => NONE,
            depth => units.measure(target.depth_m, 2),
        }
    }

    /// Returns the decisions of the analyst and the score of the detector.
    fn decided(&self) -> Value {
        let boxes = || self.sightings.iter().map(|of| &of.one);
        let score = boxes().filter_map(|review_box| review_box.score).max_by(f32::total_cmp);
        let notes =
            boxes().map(|review_box| review_box.note.as_str()).filter(|note| !note.is_empty());
        context! {
            state => self.sightings[0].one.state.name(),
            certainty => boxes()
                .filter_map(|review_box| review_box.certainty)
                .max()
                .map(Certainty::name),
            score => score.map(|score| format!("{score:.2}")),
            remarks => notes.collect::<Vec<&str>>().join("; "),
        }
    }
}

/// Returns the numbers of passes that saw an object and that covered its place, and of logs.
fn passes(objects: &ReportObjects<'_>, object: &Object) -> Value {
    let passes = passes_of(objects, object);
    context! {
        seen => passes.seen,
        covered => plural(passes.covered, "pass", "passes"),
        logs => plural(object.logs().len(), "log", "logs"),
    }
}

/// Returns the shadow: `from r_t = 17.20 to r_e = 22.90 m of slant range, altitude H = 8.01 m; h =
/// H (r_e - r_t) / r_e`; `None` where none is known.
fn shadow(target: &Target) -> Option<Value> {
    let [start_m, end_m] = target.shadow_m;
    let shadow = || {
        context! {
            is_measured => target.measured_shadow.is_some(),
            start_m => format!("{start_m:.2}"),
            end_m => end_m.is_finite().then(|| format!("{end_m:.2}")),
            altitude_m => format!("{:.2}", target.altitude_m),
        }
    };
    start_m.is_finite().then(shadow)
}

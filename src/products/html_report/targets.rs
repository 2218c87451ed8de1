//! Makes a section for each target: its picture, position and size, and the measurements of its
//! height.

use super::ReportData;
use super::objects::{is_reviewed, passes_of, picture, targets, undecided};
use bathyscope_bottom::presentation::text::{NONE, plural, position};
use bathyscope_bottom::presentation::units::Units;
use bathyscope_log::support::printable::xml;
use bathyscope_log::support::progress::{Cancelled, Progress};
use bathyscope_objects::ObjectExtent;
use bathyscope_objects::objects::{Object, ObjectBox};
use bathyscope_objects::review::Certainty;
use bathyscope_objects::targets::{ObjectHeight, Target};

/// Largest number of sections; the files of the run list all targets.
const MOST: usize = 60;
/// Width of a picture on the page, pixels.
const PICTURE_WIDTH: usize = 360;

/// Returns the sections; empty where no person has decided about boxes and the settings require no
/// proposals.
pub(super) fn section(from: &ReportData<'_>, progress: &Progress) -> Result<String, Cancelled> {
    let with_proposals = from.products.settings.report.proposals;
    let is_reviewed = is_reviewed(from);
    let mut shown: Vec<Shown<'_>> = Vec::new();
    if is_reviewed || with_proposals {
        shown.extend(targets(from).filter_map(|object| Shown::new(from, object)));
    }
    // Without a review the proposals are shown as objects already.
    let mut proposals: Vec<&ObjectBox> = Vec::new();
    if with_proposals {
        proposals.extend(undecided(from));
    }
    let count = shown.len() + proposals.len();
    if count == 0 {
        return Ok(String::new());
    }
    let mut html = String::from("<h2>Targets</h2>\n");
    if count > MOST {
        html += &format!("<p>The first {MOST} of {count}; the files of this run hold all.</p>\n");
    }
    for one in shown.iter().take(MOST) {
        progress.check()?;
        html += &of_object(from, one);
    }
    for one in proposals.iter().take(MOST.saturating_sub(shown.len())) {
        progress.check()?;
        html += &of_proposal(from, one);
    }
    Ok(html)
}

/// A target with the boxes that show it.
struct Shown<'a> {
    object: &'a Object,
    /// Boxes of the target: drawn extents first, then by score.
    sightings: Vec<&'a ObjectBox>,
}

impl<'a> Shown<'a> {
    fn new(from: &'a ReportData<'_>, object: &'a Object) -> Option<Self> {
        let list = from.objects.as_ref()?.list;
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
        (!sightings.is_empty()).then_some(Self { object, sightings })
    }
}

/// Facts about a target, as the rows of a description list.
#[derive(Default)]
struct Facts(String);

impl Facts {
    fn add(&mut self, name: &str, value: &str) {
        if !value.is_empty() {
            self.0 += &format!("<dt>{name}</dt><dd>{value}</dd>");
        }
    }
}

fn of_object(from: &ReportData<'_>, shown: &Shown<'_>) -> String {
    let Shown { object, sightings } = shown;
    let (best, number) = (sightings[0], object.number);
    let class = xml(&object.class);
    let title = match object.name.as_str() {
        "" => format!("{number}. {class}"),
        name => format!("{number}. {} ({class})", xml(name)),
    };
    let mut facts = Facts::default();
    facts.add("Class", &class);
    facts.add("Position", &position(object.position));
    facts.add("Within", &Units::default().measure(object.sigma_m, 2));
    if let Some(target) = &best.target {
        sizes(&mut facts, target, object.height);
    }
    let passes = passes_of(from, object);
    let seen = format!(
        "{} of {}, in {}",
        passes.seen,
        plural(passes.covered, "pass", "passes"),
        plural(object.logs().len(), "log", "logs")
    );
    facts.add("Seen", &seen);
    decided(&mut facts, sightings);
    of_box(from, &mut facts, best);
    card(from, &title, best, &facts)
}

fn of_proposal(from: &ReportData<'_>, of: &ObjectBox) -> String {
    let class = xml(&of.class);
    let mut facts = Facts::default();
    facts.add("Class", &class);
    if let Some(target) = &of.target {
        facts.add("Position", &position(target.position));
        facts.add("Within", &Units::default().measure(target.sigma_m, 2));
        let height = ObjectHeight::of(std::iter::once(target));
        sizes(&mut facts, target, height);
    }
    decided(&mut facts, &[of]);
    of_box(from, &mut facts, of);
    let title = format!("Proposal: {class}, box {}", of.one.id.0);
    card(from, &title, of, &facts)
}

/// Adds length and width of a sighting, the height of its object, the shadow in the sighting, and
/// the depth there.
fn sizes(facts: &mut Facts, target: &Target, height: ObjectHeight) {
    let units = Units::default();
    let size = if target.length_m.is_finite() && target.width_m.is_finite() {
        format!("{:.2} m along the track, {:.2} m across it", target.length_m, target.width_m)
    } else {
        "a point: not known".to_owned()
    };
    let is_drawn = target.extent.border_m().is_some();
    let edges = if is_drawn { ", by edges drawn by hand" } else { "" };
    facts.add("Size", &format!("{size}{edges}"));
    facts.add("Height", &units.with_sigma(height.mean_m, height.sigma_m, 2));
    facts.add("Shadow", &shadow(target));
    facts.add("Depth there", &units.measure(target.depth_m, 2));
}

/// Describes the shadow: `from r_t = 17.20 to r_e = 22.90 m of slant range, altitude H = 8.01 m; h
/// = H (r_e - r_t) / r_e`.
fn shadow(target: &Target) -> String {
    let [start_m, end_m] = target.shadow_m;
    let measured = if target.measured_shadow.is_some() { "measured, " } else { "" };
    match (start_m.is_finite(), end_m.is_finite()) {
        (true, true) => format!(
            "{measured}from r<sub>t</sub> = {start_m:.2} to r<sub>e</sub> = {end_m:.2} m of slant range, altitude H = {:.2} m; height h = H (r<sub>e</sub> − r<sub>t</sub>) / r<sub>e</sub>",
            target.altitude_m
        ),
        (true, false) => format!("{measured}from {start_m:.2} m, runs off the range"),
        (false, _) => NONE.to_owned(),
    }
}

/// Adds the decisions of the analyst and the score of the detector.
fn decided(facts: &mut Facts, sightings: &[&ObjectBox]) {
    let boxes = || sightings.iter().map(|of| &of.one);
    facts.add("State", sightings[0].one.state.name());
    let certainty = boxes().filter_map(|one| one.certainty).max();
    facts.add("Certainty", certainty.map_or("", Certainty::name));
    if let Some(score) = boxes().filter_map(|one| one.score).max_by(f32::total_cmp) {
        facts.add("Score of the detector", &format!("{score:.2}"));
    }
    let notes = boxes().filter(|one| !one.note.is_empty());
    let notes: Vec<String> = notes.map(|one| xml(&one.note)).collect();
    facts.add("Remarks", &notes.join("; "));
}

/// Adds the log, number, side and pings of the box that the picture and the size belong to.
fn of_box(from: &ReportData<'_>, facts: &mut Facts, of: &ObjectBox) {
    let log = match from.names.get(of.log) {
        Some(name) if from.logs.len() > 1 => format!("{}, ", xml(name)),
        _ => String::new(),
    };
    let (first, last) = (of.one.mark.pings.start, of.one.mark.pings.end.saturating_sub(1));
    let pings =
        if first < last { format!("pings {first} to {last}") } else { format!("ping {first}") };
    let side = of.one.mark.side.name();
    facts.add(
        "Picture",
        &format!("{log}box {}, {side}, {pings}; the boat is to the left", of.one.id.0),
    );
}

fn card(from: &ReportData<'_>, title: &str, of: &ObjectBox, facts: &Facts) -> String {
    format!(
        "<section class=\"target\"><h3>{title}</h3><div><figure>{}</figure><dl>{}</dl></div></section>\n",
        picture(from, of, PICTURE_WIDTH),
        facts.0
    )
}

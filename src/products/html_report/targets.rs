//! Returns the values of each target: its picture, position and size, and the measurements of its
//! height.

use super::ReportData;
use super::objects::{is_reviewed, passes_of, picture, targets, undecided};
use bathyscope_bottom::presentation::page::{Value, context};
use bathyscope_bottom::presentation::text::{NONE, plural, position};
use bathyscope_bottom::presentation::units::Units;
use bathyscope_log::support::progress::{Cancelled, Progress};
use bathyscope_objects::ObjectExtent;
use bathyscope_objects::objects::{Object, ObjectBox};
use bathyscope_objects::review::Certainty;
use bathyscope_objects::targets::{ObjectHeight, Target};

/// Largest number of sections; the files of the run list all targets.
const MOST: usize = 60;
/// Width of a picture on the page, pixels.
const PICTURE_WIDTH: usize = 360;

/// Returns the values of the sections; `None` where no person has decided about boxes and the
/// settings require no proposals.
pub(super) fn values(
    from: &ReportData<'_>,
    progress: &Progress,
) -> Result<Option<Value>, Cancelled> {
    let with_proposals = from.products.settings.report.proposals;
    let mut found: Vec<Shown<'_>> = Vec::new();
    if is_reviewed(from) || with_proposals {
        found.extend(targets(from).filter_map(|object| Shown::new(from, object)));
    }
    // Without a review the proposals are shown as objects already.
    if with_proposals {
        found.extend(undecided(from).map(|of| Shown { object: None, sightings: vec![of] }));
    }
    let shown = found.iter().take(MOST).map(|target| {
        progress.check()?;
        Ok(target.values(from))
    });
    let shown = shown.collect::<Result<Vec<Value>, Cancelled>>()?;
    let all = found.len();
    Ok((all > 0).then(|| context!(all, most => MOST, shown)))
}

/// A target with the boxes that show it, or a proposal.
struct Shown<'a> {
    /// The target; `None` for a proposal.
    object: Option<&'a Object>,
    /// Boxes of the target, at least one: drawn extents first, then by score.
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
        (!sightings.is_empty()).then_some(Self { object: Some(object), sightings })
    }

    fn values(&self, from: &ReportData<'_>) -> Value {
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
            picture => picture(from, best, PICTURE_WIDTH),
            position => place.map(|(at, _)| position(at)),
            within => place.map(|(_, sigma_m)| Units::default().measure(sigma_m, 2)),
            size => target.map(|target| self.size(target)),
            passes => object.map(|object| passes(from, object)),
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
fn passes(from: &ReportData<'_>, object: &Object) -> Value {
    let passes = passes_of(from, object);
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

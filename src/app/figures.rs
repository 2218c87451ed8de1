//! Counts the first returns, faults and points of a result once on a worker thread, so that no
//! panel counts points while it is drawn. First returns above the recorded depth are grouped into
//! stretches, so that an analyst who sees the bottom there can accept a stretch.

use bathyscope_bottom::cloud::{ClassCounts, CloudPoint, PointSource, Residuals, residuals};
use bathyscope_log::support::progress::{Cancelled, Progress};
use bathyscope_log::support::statistics::median_of;
use bathyscope_log::survey::{FaultCounts, Side, Survey};
use bathyscope_products::pipeline::Products;

/// Number of pings without a return above the recorded depth that separate two stretches.
const GAP_PINGS: u32 = 12;
/// Greatest number of stretches that are listed: those with most returns.
const MOST_LISTED: usize = 40;
/// Least number of returns of a stretch: fewer are a fish or a bubble.
const LEAST_RETURNS: usize = 4;
/// Share of the returns on one side above which they count as one-sided, as where the bottom slopes
/// across the track.
const ONE_SIDED: f64 = 0.75;

/// Counts and residuals of a result.
#[derive(Clone, Debug, PartialEq)]
pub struct Figures {
    /// First returns found to port.
    pub port_picks: usize,
    /// First returns found to starboard.
    pub starboard_picks: usize,
    /// The counts of first returns above the recorded depth.
    pub above_bottom: AboveBottom,
    /// Soundings with a fault, whether or not a first return confirms them.
    pub faults: FaultCounts,
    /// Points of the cloud by their classes.
    pub classes: ClassCounts,
    /// Elevation of side-scan points minus that of the recorded depth at the same ping.
    pub residuals: Option<Residuals>,
}

impl Figures {
    /// Counts the figures of the results of a log.
    pub fn of(
        survey: &Survey,
        products: &Products,
        progress: &Progress,
    ) -> Result<Self, Cancelled> {
        let found = |side| {
            let picks = products.returns.side(side).iter();
            picks.filter(|pick| pick.is_some()).count()
        };
        progress.check()?;
        Ok(Self {
            port_picks: found(Side::Port),
            starboard_picks: found(Side::Starboard),
            above_bottom: AboveBottom::of(survey, products),
            faults: FaultCounts::of(survey.soundings.iter().filter_map(|sounding| sounding.fault)),
            classes: ClassCounts::of(&products.cloud, &products.classes),
            residuals: residuals(survey, &products.cloud, &products.correction, &products.classes),
        })
    }
}

/// First returns that lie above the recorded depth by more than the margin: dashed in the
/// waterfall.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct AboveBottom {
    /// Number of these first returns on both sides.
    pub count: usize,
    /// Number of those that stand out from the bed, which the recorder follows less closely
    /// elsewhere nearby.
    pub standing: usize,
    /// Number of those that stand out but count as bottom all the same, because they go on for
    /// long.
    pub counted: usize,
    /// Median height above the recorded depth of those that stand out, metres; NaN without any.
    pub height_m: f64,
    /// The side with nearly all of those that stand out; `None` if both sides have many, or there
    /// are none.
    pub one_side: Option<Side>,
    /// Stretches of consecutive such first returns; those with most returns that do not count come
    /// first.
    pub stretches: Vec<AboveStretch>,
}

/// A stretch of first returns above the recorded depth, on one side.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AboveStretch {
    /// The side.
    pub side: Side,
    /// First and last ping.
    pub pings: [usize; 2],
    /// Number of first returns above the recorded depth in the stretch.
    pub count: usize,
    /// Number of these returns that do not count for the map.
    pub uncounted: usize,
    /// Median height of these returns above the recorded depth, metres.
    pub height_m: f64,
}

/// A first return above the recorded depth.
struct Above {
    ping: u32,
    height_m: f64,
    stands_out: bool,
    counts: bool,
}

impl AboveBottom {
    /// Finds the first returns above the recorded depth in the results of a log.
    fn of(survey: &Survey, products: &Products) -> Self {
        let sides = Side::BOTH.map(|side| (side, of_side(survey, products, side)));
        let standing = |side: usize| sides[side].1.iter().filter(|above| above.stands_out);
        let [port, starboard] = [standing(0).count(), standing(1).count()];
        let one_side = (Side::BOTH.into_iter())
            .zip([port, starboard])
            .find(|(_, of_side)| *of_side as f64 > ONE_SIDED * (port + starboard) as f64);
        let mut stretches: Vec<AboveStretch> = (sides.iter())
            .flat_map(|(side, all)| {
                let parted = |a: &Above, b: &Above| b.ping - a.ping <= GAP_PINGS;
                let parts = all.chunk_by(parted);
                parts.filter_map(|part| AboveStretch::of(*side, part))
            })
            .collect();
        stretches.sort_by_key(|stretch| std::cmp::Reverse((stretch.uncounted, stretch.count)));
        stretches.truncate(MOST_LISTED);
        Self {
            count: sides.iter().map(|(_, all)| all.len()).sum(),
            standing: port + starboard,
            counted: (standing(0).chain(standing(1))).filter(|above| above.counts).count(),
            height_m: median_of(heights_m(standing(0).chain(standing(1)))),
            one_side: one_side.map(|(side, _)| side),
            stretches,
        }
    }

    /// Returns the stretch of a side that contains a ping; `None` if no listed stretch does.
    pub(crate) fn stretch_at(&self, side: Side, ping: usize) -> Option<&AboveStretch> {
        let holds = |stretch: &&AboveStretch| {
            stretch.side == side && (stretch.pings[0]..=stretch.pings[1]).contains(&ping)
        };
        self.stretches.iter().find(holds)
    }
}

impl AboveStretch {
    fn of(side: Side, part: &[Above]) -> Option<Self> {
        let (first, last) = part.first().zip(part.last())?;
        (part.len() >= LEAST_RETURNS).then(|| Self {
            side,
            pings: [first.ping as usize, last.ping as usize],
            count: part.len(),
            uncounted: part.iter().filter(|above| !above.counts).count(),
            height_m: median_of(heights_m(part.iter())),
        })
    }
}

fn heights_m<'a>(all: impl Iterator<Item = &'a Above>) -> impl Iterator<Item = f64> {
    all.map(|above| above.height_m).filter(|height_m| height_m.is_finite())
}

/// Returns the first returns of a side that lie above the recorded depth, in ping order.
fn of_side(survey: &Survey, products: &Products, side: Side) -> Vec<Above> {
    let source = match side {
        Side::Port => PointSource::Port,
        Side::Starboard => PointSource::Starboard,
    };
    let start = products.cloud.points.start(source);
    let classes = products.classes.get(start..).unwrap_or_default();
    let points = products.cloud.points.of(source).iter().zip(classes);
    let picks = products.returns.side(side);
    let is_above = |point: &CloudPoint| {
        let pick = picks.get(point.ping as usize);
        pick.is_some_and(|pick| pick.above_bottom)
    };
    let above = points.filter(|(point, _)| is_above(point));
    above
        .map(|(point, class)| Above {
            ping: point.ping,
            height_m: height_m(survey, products, point),
            stands_out: point.is_above_bottom(),
            counts: class.is_kept(),
        })
        .collect()
}

/// Returns the height of a point above the recorded depth of its ping, metres; NaN without a depth.
fn height_m(survey: &Survey, products: &Products, point: &CloudPoint) -> f64 {
    let ping = survey.side_scan.get(point.ping as usize);
    ping.map_or(f64::NAN, |ping| {
        let depth_m = f64::from(ping.good_depth_m());
        point.z_m + products.correction.depth_m(ping.time_s, depth_m)
    })
}

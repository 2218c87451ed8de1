//! Tests that the gain makes a mosaic even: no step under the boat, no bands along the track, no
//! bars across it, relief kept.

use crate::mosaic::layout;
use crate::truth::{KnownSurvey, processed, results};
use bathyscope_bottom::mosaic::{Gain, MosaicSettings, gain_table, window};
use bathyscope_log::support::progress::Progress;
use bathyscope_log::survey::{Bytes, SampleOrder, Side, Survey};
use bathyscope_products::pipeline::{Products, Settings};
use bathyscope_simulation::{Artefacts, Scene};
use std::ops::Range;
use std::sync::Arc;

/// Distances between places that are looked at along a ray, metres on the ground.
const STEP_M: f64 = 0.1;
/// Ground nearer to the track than this is left out: a few samples fill it.
const NEAREST_M: f64 = 0.25;
/// The ground on both sides of the track on which a step is looked for.
const STEP_WITHIN_M: f64 = 3.0;
/// Pings before and behind whose median is what a ping's level should be.
const BAR_PINGS: usize = 25;
/// Pings and places before and behind, over whose mean relief rises.
const RELIEF_CELLS: usize = 5;

/// Levels of a mosaic at even steps beside every ping; NaN where nothing is shown.
struct Swaths {
    /// Levels by side (port first), ping, and step outward.
    levels: [Vec<Vec<f64>>; 2],
    /// Difference between the 99 % and the 1 % quantile of the picture: the figures are shares of
    /// it.
    range: f64,
}

impl Swaths {
    fn of(survey: &Survey, products: &Products, gain: Gain) -> Self {
        let settings = MosaicSettings { gain, ..MosaicSettings::default() };
        let progress = Progress::new();
        let layout = layout(survey, products, &settings, |place| place);
        let grid = layout.grid(settings.cell_m).expect("something is shown");
        let table = gain_table(survey, &layout, &progress).expect("nobody cancels");
        let picture = window(survey, &layout, &grid, &table, &settings, &progress);
        let picture = picture.expect("nobody cancels");
        let at = |[x, y]: [f64; 2]| {
            let level = grid.index_at(x, y).map_or(0, |cell| picture[cell]);
            if level > 0 { f64::from(level) } else { f64::NAN }
        };
        let pings = 0..survey.side_scan.len();
        let levels = Side::BOTH.map(|side| {
            let of_ping = |ping: usize| {
                let ray = layout.ray(ping, side);
                let steps =
                    ray.map_or(0, |ray| ((ray.reach_m(false) - NEAREST_M) / STEP_M) as usize);
                let step = |step: usize| {
                    let ground_m = NEAREST_M + step as f64 * STEP_M;
                    ray.map_or(f64::NAN, |ray| at(ray.place(ground_m)))
                };
                (0..steps).map(step).collect()
            };
            pings.clone().map(of_ping).collect()
        });
        let mut shown: Vec<u8> = picture.iter().copied().filter(|&level| level > 0).collect();
        shown.sort_unstable();
        let quantile = |share: f64| f64::from(shown[((shown.len() - 1) as f64 * share) as usize]);
        Self { levels, range: quantile(0.99) - quantile(0.01) }
    }

    /// Mean level by side and step, where at least half of the pings show something.
    fn profile(&self) -> [Vec<f64>; 2] {
        [0, 1].map(|side| {
            let pings = &self.levels[side];
            let steps = pings.iter().map(Vec::len).max().unwrap_or(0);
            let at = |step: usize| {
                let seen = pings.iter().filter_map(|ping| ping.get(step).copied());
                let seen: Vec<f64> = seen.filter(|level| !level.is_nan()).collect();
                if 2 * seen.len() >= pings.len() { mean(seen.into_iter()) } else { f64::NAN }
            };
            (0..steps).map(at).collect()
        })
    }

    /// Mean level to starboard less that to port, next to the track.
    fn step(&self) -> f64 {
        let steps = ((STEP_WITHIN_M - NEAREST_M) / STEP_M) as usize;
        let [port, starboard] = self
            .profile()
            .map(|side| mean(side.into_iter().take(steps).filter(|level| !level.is_nan())));
        (starboard - port) / self.range
    }

    /// Standard deviation of the mean levels across the track, both sides together.
    fn unevenness(&self) -> f64 {
        let profile = self.profile().concat();
        deviation(profile.into_iter().filter(|level| !level.is_nan())) / self.range
    }

    /// Computes the largest difference of a whole ping of one side from those around: of its
    /// differences from the median of these, place by place, the median. A boulder or its shadow
    /// fills a part of a ping, a bar all of it.
    fn bars(&self) -> f64 {
        let mut most: f64 = 0.0;
        for side in &self.levels {
            for (ping, levels) in side.iter().enumerate() {
                let around = ping.saturating_sub(BAR_PINGS)..(ping + BAR_PINGS + 1).min(side.len());
                let off = (0..levels.len()).step_by(4).filter_map(|step| {
                    let around = side[around.clone()].iter();
                    let around = around.filter_map(|other| other.get(step).copied());
                    Some(levels[step] - median(around)?)
                });
                most = most.max(median(off).unwrap_or(0.0).abs());
            }
        }
        most / self.range
    }

    /// Standard deviation of what rises above its surroundings, over some pings of both sides, as a
    /// share of the mean level: boulders, ripples.
    fn contrast(&self, pings: Range<usize>) -> f64 {
        let mut high = Vec::new();
        for side in &self.levels {
            for ping in pings.clone().step_by(3) {
                for step in (0..side[ping].len()).step_by(3) {
                    let level = side[ping][step];
                    let near = ping.saturating_sub(RELIEF_CELLS)
                        ..(ping + RELIEF_CELLS + 1).min(side.len());
                    let around = side[near].iter().flat_map(|ping| {
                        let first = step.saturating_sub(RELIEF_CELLS).min(ping.len());
                        &ping[first..(step + RELIEF_CELLS + 1).min(ping.len())]
                    });
                    let around = mean(around.copied().filter(|level| !level.is_nan()));
                    high.push(level - around);
                }
            }
        }
        let all = self.levels.iter().flatten().flatten().copied();
        let level = mean(all.filter(|level| !level.is_nan()));
        deviation(high.into_iter().filter(|level| !level.is_nan())) / level
    }
}

/// Returns the median of the known values; `None` where these are few.
fn median(values: impl Iterator<Item = f64>) -> Option<f64> {
    let mut known: Vec<f64> = values.filter(|value| !value.is_nan()).collect();
    let middle = known.len() / 2;
    (middle >= 5).then(|| *known.select_nth_unstable_by(middle, f64::total_cmp).1)
}

fn mean(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = values.fold((0.0, 0.0), |(sum, count), value| (sum + value, count + 1.0));
    sum / count
}

fn deviation(values: impl Iterator<Item = f64> + Clone) -> f64 {
    let mean_of_all = mean(values.clone());
    mean(values.map(|value| (value - mean_of_all).powi(2))).sqrt()
}

#[test]
fn the_river_shows_no_step_no_bands_and_no_bars_and_keeps_its_boulders() {
    let Some(data) = bathyscope_test_support::real_data() else {
        return;
    };
    let (survey, products) = processed(&data.join("humminbird-glen-canyon/Rec00001.DAT"));
    let [recorded, even] =
        [Gain::Recorded, Gain::Empirical].map(|gain| Swaths::of(&survey, &products, gain));
    // Boulders on both sides.
    let boulders = 0..1700;
    for (name, swaths) in [("recorded", &recorded), ("empirical", &even)] {
        eprintln!(
            "{name}: step {:+.3}, unevenness {:.3}, bars {:.3}, contrast {:.3}",
            swaths.step(),
            swaths.unevenness(),
            swaths.bars(),
            swaths.contrast(boulders.clone())
        );
    }
    assert!(even.step().abs() <= 0.02, "step {}", even.step());
    assert!(even.unevenness() <= 0.02, "{}", even.unevenness());
    assert!(even.bars() <= 0.10, "{}", even.bars());
    assert!(even.contrast(boulders) >= 0.085);
}

/// A line over gentle ground, recorded by a transducer whose starboard side is weak. Along two
/// metres of it a shoal of fish at half the depth was taken for the bottom, so that a few pings
/// have an altitude which no others have.
fn weak_to_starboard_and_misread() -> (Survey, Products) {
    let mut scene = Scene::gentle();
    scene.artefacts = Artefacts::none();
    scene.scattered_objects = 0;
    scene.track.lines = 1;
    scene.track.cross_lines = 0;
    scene.track.length_m = 60.0;
    let mut survey = KnownSurvey::new(&scene, 8).survey;
    let mut bytes = survey.bytes[0].to_vec();
    for ping in 0..survey.side_scan.len() {
        let Some(span) = survey.span(ping, Side::Starboard) else {
            continue;
        };
        assert_eq!(span.order, SampleOrder::NearToFar);
        let first = span.offset as usize;
        for level in &mut bytes[first..first + span.count as usize] {
            *level = (f64::from(*level) * 0.6) as u8;
        }
    }
    survey.bytes = vec![Bytes::Held(Arc::new(bytes))];
    let mut products = results(&survey, &Settings::default());
    let mut returns = (*products.returns).clone();
    for ping in 260..280 {
        for side in [&mut returns.port, &mut returns.starboard] {
            let pick = &mut Arc::make_mut(side)[ping];
            pick.sample *= 0.5;
            pick.above_bottom = false;
        }
    }
    products.returns = Arc::new(returns);
    (survey, products)
}

#[test]
fn a_weak_side_leaves_no_step_even_where_the_depth_is_misread() {
    let (survey, products) = weak_to_starboard_and_misread();
    let [recorded, even] =
        [Gain::Recorded, Gain::Empirical].map(|gain| Swaths::of(&survey, &products, gain));
    let figures = [&recorded, &even].map(|swaths| [swaths.step(), swaths.unevenness()]);
    eprintln!("step, unevenness: {figures:.3?}");
    // There is something to mend.
    assert!(recorded.step() < -0.3 && recorded.unevenness() > 0.15, "{figures:.3?}");
    assert!(even.step().abs() <= 0.02, "{figures:.3?}");
    assert!(even.unevenness() <= 0.04, "{figures:.3?}");
}

//! Measures how well the confidence of a first return predicts its error: the share of picks within
//! 25 cm of the true first return at each level.

use super::truth::KnownSurvey;
use bathyscope_bottom::first_return::{
    Evidence, FirstReturnSettings, ImageSettings, Method, SampleMode, evidence,
};
use bathyscope_log::support::progress::Progress;
use bathyscope_log::survey::Side;
use bathyscope_simulation::Scene;
use std::fs::File;
use std::io::{BufWriter, Write};

/// Ponds of each kind; `BATHYSCOPE_SEEDS` takes fewer, `BATHYSCOPE_FIRST_SEED=101` those that the
/// laws were fitted to.
const SEEDS: u64 = 20;
/// A pick is right within this, metres.
const RIGHT_M: f64 = 0.25;

type Way = (&'static str, SampleMode, Method, f64);

const WAYS: [Way; 4] = [
    ("tracker", SampleMode::Bytes, Method::Tracker, 0.5),
    ("bytes threshold, dead zone 0.5 m", SampleMode::Bytes, Method::Threshold, 0.5),
    ("bytes threshold, dead zone 0.815 m", SampleMode::Bytes, Method::Threshold, 0.815),
    ("published words threshold", SampleMode::Words, Method::Threshold, 0.815),
];

/// Picks and right ones at each level of confidence, 0.0 to 0.1 first.
#[derive(Clone, Copy, Default)]
struct Levels([[usize; 2]; 10]);

impl Levels {
    fn add(&mut self, confidence: f32, is_right: bool) {
        let level = ((10.0 * confidence) as usize).min(9);
        self.0[level][0] += 1;
        self.0[level][1] += usize::from(is_right);
    }

    fn row(&self) -> String {
        let cells = self.0.iter().map(|[picks, right]| match picks {
            0 => format!("{:>14}", "-"),
            _ => format!("{:6.1} {picks:7}", 100.0 * *right as f64 / *picks as f64),
        });
        cells.collect::<Vec<_>>().join(" ")
    }
}

/// Prints the shares in percent, each with how many picks it is of. `BATHYSCOPE_EVIDENCE=FILE.csv`
/// writes every pick with what speaks for it: what the laws were fitted to.
pub(super) fn run() {
    let number = |name: &str| std::env::var(name).ok().and_then(|text| text.parse().ok());
    let first: u64 = number("BATHYSCOPE_FIRST_SEED").unwrap_or(1);
    let seeds = first..first + number("BATHYSCOPE_SEEDS").unwrap_or(SEEDS);
    let file = std::env::var("BATHYSCOPE_EVIDENCE").ok();
    let mut out =
        file.map(|file| BufWriter::new(File::create(file).expect("a file that can be written")));
    if let Some(out) = &mut out {
        writeln!(
            out,
            "kind,seed,way,weed,error_m,range_m,sign_1,sign_2,sign_3,own,other,depth_m,beyond_dead_zone_m"
        )
        .expect("room for the file");
    }
    println!("picks within 25 cm of the truth, % and number, at confidences from 0.0, 0.1 ... 0.9");
    for (kind, scene) in
        [("gentle", Scene::gentle()), ("steep", Scene::steep()), ("rough", Scene::rough())]
    {
        // Weed left out, weed counted (its canopy gives the first return, and is not within 25 cm
        // of the ground), no depth recorded.
        let mut levels = [[Levels::default(); 3]; WAYS.len()];
        for seed in seeds.clone() {
            let pond = KnownSurvey::new(&scene, seed);
            for (way, levels) in WAYS.iter().zip(&mut levels) {
                let add = |error_m: f64, weed: bool, evidence: Evidence| {
                    let is_right = error_m.abs() <= RIGHT_M;
                    let confidence = evidence.chance(way.2);
                    let blind = Evidence { depth_m: f32::NAN, ..evidence };
                    levels[1].add(confidence, is_right);
                    if !weed {
                        levels[0].add(confidence, is_right);
                        levels[2].add(blind.chance(way.2), is_right);
                    }
                    if let Some(out) = &mut out {
                        write(out, &format!("{kind},{seed},{}", way.0), weed, error_m, evidence);
                    }
                };
                each_pick(&pond, *way, add);
            }
        }
        for ((name, ..), levels) in WAYS.iter().zip(&levels) {
            println!("{kind:7} {name}");
            for (what, levels) in ["weed left out", "weed counted", "no depth"].iter().zip(levels) {
                println!("  {what:14} {}", levels.row());
            }
        }
    }
}

/// Calls with the error of the range in metres, whether weed gives the first return there, and the
/// evidence.
fn each_pick(pond: &KnownSurvey, way: Way, mut add: impl FnMut(f64, bool, Evidence)) {
    let (_, samples, method, dead_zone_m) = way;
    let settings = FirstReturnSettings { method, dead_zone_m, ..FirstReturnSettings::default() };
    let image = ImageSettings { samples };
    let sides = evidence(&pond.survey, &image, &settings, &Progress::new());
    for (side, found) in Side::BOTH.into_iter().zip(&sides.expect("not cancelled")) {
        for (truth, evidence) in pond.truth.pings.iter().zip(found) {
            let truth = truth.side(side);
            let error_m = f64::from(evidence.range_m) - truth.first_return_m;
            if !error_m.is_nan() {
                add(error_m, truth.weed, *evidence);
            }
        }
    }
}

fn write(out: &mut impl Write, what: &str, weed: bool, error_m: f64, evidence: Evidence) {
    let Evidence { range_m, signs: [one, two, three], own, other, depth_m, beyond_dead_zone_m } =
        evidence;
    writeln!(
        out,
        "{what},{},{error_m:.3},{range_m:.3},{one:.3},{two:.3},{three:.3},{own:.3},{other:.3},{depth_m:.3},{beyond_dead_zone_m:.3}",
        u8::from(weed)
    )
    .expect("room for the file");
}

//! `bathyscope plan`: plans survey lines where they reduce the uncertainty most.

use super::process::all_processed;
use super::settings::SettingsArgs;
use super::status_line::StatusLine;
use super::survey_logs::{OpenedLog, all_or, inputs, open, survey_review, take_reviews};
use super::{Failure, output};
use bathyscope_bottom::planning::{Plan, PlanError, PlanSettings, WaterState, plan};
use bathyscope_bottom::presentation::text;
use bathyscope_log::formats::read_area;
use bathyscope_log::support::geo::{LocalFrame, LonLat};
use bathyscope_log::survey::WaterArea;
use bathyscope_products::export::{PlanFormat, PlannedWay, is_same_file};
use bathyscope_products::pipeline::list_objects;
use bathyscope_products::pipeline::survey_coverage;
use serde::Serialize;
use std::path::{Path, PathBuf};

/// Share of the given time below which a notice is printed that the plan uses less.
const USED: f64 = 0.8;

/// `bathyscope plan SURVEY... -o FILE`.
#[derive(Debug, clap::Args)]
pub(super) struct PlanArgs {
    /// The logs, or folders of logs; several are one survey. Or a project, NAME.bathyscope, with
    /// its settings and decisions
    #[arg(required = true)]
    surveys: Vec<PathBuf>,
    /// File for the lines: .gpx, .kml, .plan (QGroundControl) or .waypoints (Mission Planner)
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
    /// Time from the start of the first line to the end of the last, turns included
    #[arg(long, value_name = "MINUTES", default_value_t = PlanSettings::default().minutes)]
    minutes: f64,
    /// Speed of the boat, metres a second; the median of the survey when not given
    #[arg(long, value_name = "M/S")]
    speed: Option<f64>,
    /// Least radius that the boat turns with, metres
    #[arg(long, value_name = "METRES", default_value_t = PlanSettings::default().turn_radius_m)]
    turn_radius: f64,
    /// Distance between lines that is close enough, metres; without it they come as close as
    /// reduces the uncertainty most
    #[arg(long, value_name = "METRES")]
    spacing: Option<f64>,
    /// Polygon of water that lines and turns stay in, rings within it are islands: GeoJSON, KML or
    /// GPX. Without it they stay within the outline of what was sailed, in which small gaps and
    /// islands count as water
    #[arg(long, value_name = "POLYGON")]
    area: Option<PathBuf>,
    /// Decisions about the boxes of a log, LOG.review.json of Bathyscope: objects seen from one
    /// side only are passed on another. May be given again, for each of several logs
    #[arg(long, value_name = "FILE")]
    review: Vec<PathBuf>,
    /// Print JSON instead of lines
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    settings: SettingsArgs,
}

/// Plans the lines, writes them and prints the plan.
pub(super) fn run(args: PlanArgs) -> Result<(), Failure> {
    // Checked before the work, which takes minutes for a long survey.
    let format = PlanFormat::of(&args.output)?;
    let settings = PlanSettings {
        minutes: args.minutes,
        speed_mps: args.speed,
        turn_radius_m: args.turn_radius,
        spacing_m: args.spacing,
    };
    settings.check()?;
    let area = args.area.as_deref().map(read_area).transpose()?;
    args.refuse_overwrite()?;
    let inputs = inputs(&args.surveys, &args.settings, None)?;
    let (mut opened, failed) = open(&inputs)?;
    take_reviews(&mut opened, &args.review)?;
    if let Some(first) = opened.first() {
        let home = first.survey.track.fixes.first().map(|fix| fix.position);
        let frame = first.survey.track.frame.clone();
        let name = first.survey.name();
        let made = planned(&opened, &settings, area.as_ref(), &frame)?;
        let way = PlannedWay {
            name: &format!("{name} lines"),
            plan: &made,
            frame: &frame,
            home: home.unwrap_or(frame.origin()),
        };
        way.write(&args.output, format)?;
        if made.minutes() < USED * args.minutes {
            output::notify(format_args!(
                "warning: the lines take {:.1} of {} minutes: no other fits into the water and mends enough to be worth its time; --area names a larger one",
                made.minutes(),
                args.minutes
            ));
        }
        if args.json {
            output::json(&Printed::new(&made, &frame, &args.output))?
        } else {
            output::results(in_words(&made, &args.output))?
        }
    }
    all_or(failed, inputs.len())
}

impl PlanArgs {
    /// Refuses to write the lines over a file that they are made from.
    fn refuse_overwrite(&self) -> Result<(), Failure> {
        let mut read = self.surveys.iter().chain(&self.area).chain(&self.review);
        match read.find(|path| is_same_file(path, &self.output)) {
            Some(path) => Err(format!(
                "the lines would be written over a file that they are made from; choose another name: {}",
                path.display()
            ).into()),
            None => Ok(()),
        }
    }
}

/// Plans lines for some logs.
fn planned(
    opened: &[OpenedLog],
    settings: &PlanSettings,
    area: Option<&WaterArea>,
    frame: &LocalFrame,
) -> Result<Plan, Failure> {
    let status = StatusLine::new();
    let logs = all_processed(opened, &status)?;
    status.step("what is known");
    let review = survey_review(opened);
    let progress = &status.progress;
    let objects = list_objects(&logs, &review, progress)?;
    let known = survey_coverage(&logs, &objects, progress)?.ok_or(PlanError::NoLog)?;
    let rings = area.map(|area| {
        let ring = |ring: &Vec<LonLat>| ring.iter().map(|at| frame.to_enu(*at)).collect();
        area.rings.iter().map(ring).collect::<Vec<Vec<[f64; 2]>>>()
    });
    status.step("lines");
    plan(&known, rings.as_deref(), settings, progress).map_err(|error| match area {
        Some(area) if error.is_about_area() => format!("{error}: {}", area.path.display()).into(),
        _ => error.into(),
    })
}

fn in_words(plan: &Plan, path: &Path) -> String {
    let Plan { before, after, .. } = plan;
    let mut lines = vec![
        format!(
            "{} of {:.0} m, {:.0} m with turns: {:.1} min at {:.1} m/s",
            text::plural(plan.lines.len(), "line", "lines"),
            plan.lines_m,
            plan.length_m,
            plan.minutes(),
            plan.speed_mps
        ),
        format!(
            "mean sigma of the depth over {:.0} m2: {:.3} m now, {:.3} m after (predicted)",
            plan.area_m2, before.mean_sigma_m, after.mean_sigma_m
        ),
        format!(
            "not insonified: {:.0} m2 now, {:.0} m2 after; once: {:.0} m2 now, {:.0} m2 after",
            before.looked_m2[0], after.looked_m2[0], before.looked_m2[1], after.looked_m2[1]
        ),
    ];
    if before.one_sided > 0 {
        lines.push(format!(
            "objects seen from one side only: {} now, {} after",
            before.one_sided, after.one_sided
        ));
    }
    lines.push(format!("wrote {}", path.display()));
    lines.join("\n")
}

/// Plan as printed with `--json`.
#[derive(Serialize)]
struct Printed {
    file: String,
    lines: Vec<PrintedLine>,
    lines_m: f64,
    length_m: f64,
    minutes: f64,
    speed_mps: f64,
    turn_radius_m: f64,
    area_m2: f64,
    before: PrintedState,
    after: PrintedState,
}

#[derive(Serialize)]
struct PrintedLine {
    /// Longitude and latitude of the start, degrees.
    from: [f64; 2],
    to: [f64; 2],
    heading_deg: f64,
    length_m: f64,
}

#[derive(Serialize)]
struct PrintedState {
    mean_sigma_m: f64,
    not_insonified_m2: f64,
    insonified_once_m2: f64,
    objects_seen_from_one_side: usize,
}

impl Printed {
    fn new(plan: &Plan, frame: &LocalFrame, path: &Path) -> Self {
        let lon_lat = |[east_m, north_m]: [f64; 2]| {
            let LonLat { lon_deg, lat_deg } = frame.to_lon_lat(east_m, north_m);
            [lon_deg, lat_deg]
        };
        let lines = plan.lines.iter().map(|leg| PrintedLine {
            from: lon_lat(leg.from),
            to: lon_lat(leg.to),
            heading_deg: leg.heading_rad().to_degrees().rem_euclid(360.0),
            length_m: leg.length_m(),
        });
        let state = |state: &WaterState| PrintedState {
            mean_sigma_m: state.mean_sigma_m,
            not_insonified_m2: state.looked_m2[0],
            insonified_once_m2: state.looked_m2[1],
            objects_seen_from_one_side: state.one_sided,
        };
        Self {
            file: path.display().to_string(),
            lines: lines.collect(),
            lines_m: plan.lines_m,
            length_m: plan.length_m,
            minutes: plan.minutes(),
            speed_mps: plan.speed_mps,
            turn_radius_m: plan.turn_radius_m,
            area_m2: plan.area_m2,
            before: state(&plan.before),
            after: state(&plan.after),
        }
    }
}

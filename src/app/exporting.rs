//! Writes products and reviewed boxes into a folder in a background thread, and composes the text
//! around a printed view: title, dates, coordinate system, level that depths count from, and scale.

use super::jobs::JobKey;
use super::{Action, App, LogId, OpenLogs, View};
use bathyscope_bottom::calibration::PingRange;
use bathyscope_log::support::calendar;
use bathyscope_log::support::geo::{CoordinateFormat, UtmZone};
use bathyscope_log::support::printable::one_line;
use bathyscope_log::support::progress::Progress;
use bathyscope_products::export::{LogPartChoice, copy_log};
use bathyscope_products::outputs::{self, Amounts, EarlierRun, Order, OutputFile, Product};
use bathyscope_products::pipeline::map_plane;
use std::error::Error;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::time::{SystemTime, UNIX_EPOCH};

/// Greatest number of logs that a title names; of more logs it states the number.
const NAMED: usize = 3;

/// The text around a printed view.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct PrintText {
    /// Title above the view.
    pub title: String,
    /// Sentences below the view, one a line.
    pub facts: Vec<String>,
}

/// The files of a run that this window has written.
pub(super) struct Exported {
    log: LogId,
    folder: PathBuf,
    run: EarlierRun,
}

impl OpenLogs {
    /// Returns sentences for the readers of the products: the level that depths count from, missing
    /// corrections, and the coordinate system.
    pub(crate) fn export_statement(&self) -> Vec<String> {
        let logs = self.processed();
        let Some(first) = logs.first() else {
            return Vec::new();
        };
        let of_first = first.products.correction.sentences();
        let of_logs: Vec<_> = logs.iter().map(|log| log.products.correction.sentences()).collect();
        let mut sentences = Vec::new();
        for (index, sentence) in of_first.into_iter().enumerate() {
            sentences.push(match of_logs.iter().all(|of_log| of_log[index] == sentence) {
                true => sentence,
                false if index == 0 => {
                    "What was applied to depths differs between the logs; report.html lists it."
                        .to_owned()
                }
                false => "What is not corrected differs between the logs.".to_owned(),
            });
        }
        let plane = map_plane(&first.survey, &first.products.settings);
        sentences.extend(plane.ok().map(|plane| format!("Coordinates are of {}.", plane.crs)));
        sentences
    }

    /// Returns a sentence about the days of the recordings and of the print.
    fn recorded(&self, now: SystemTime) -> String {
        let starts = self.visible().filter_map(|log| {
            let survey = log.survey.as_ref()?;
            let (from_s, _) = survey.time_span_s()?;
            Some(survey.start_unix_s? + from_s)
        });
        let days: Vec<f64> = starts.collect();
        let first = days.iter().copied().reduce(f64::min).map(calendar::date);
        let last = days.iter().copied().reduce(f64::max).map(calendar::date);
        let recorded = match (first, last) {
            (Some(first), Some(last)) if first == last => format!("Recorded {first} UTC"),
            (Some(first), Some(last)) => format!("Recorded {first} to {last} UTC"),
            _ => "Recorded on an unknown day".to_owned(),
        };
        let now_s = now.duration_since(UNIX_EPOCH).unwrap_or_default();
        let printed = calendar::date(now_s.as_secs_f64());
        format!("{recorded}, printed {printed} by Bathyscope {}.", env!("CARGO_PKG_VERSION"))
    }
}

impl App {
    /// Writes something in a background thread; the analyst is notified of the outcome.
    pub fn write<E: Error + Send + Sync + 'static>(
        &mut self,
        write: impl FnOnce(&Progress) -> Result<String, E> + Send + 'static,
    ) {
        self.start_writing(write, |app| app.written_into = None);
    }

    /// Writes something in a background thread; before the analyst is notified of what was written,
    /// `written` is called, which sets the folder that was written into.
    fn start_writing<E: Error + Send + Sync + 'static>(
        &mut self,
        write: impl FnOnce(&Progress) -> Result<String, E> + Send + 'static,
        written: impl FnOnce(&mut Self) + Send + 'static,
    ) {
        self.jobs.run(JobKey::Export, write, |app, text| {
            app.notices.withdraw(Action::OpenExported);
            match text {
                Ok(text) => {
                    written(app);
                    match app.written_into {
                        Some(_) => app.notices.offer(text, Action::OpenExported),
                        None => app.notices.notify(text),
                    }
                }
                Err(error) => app.notices.warn(error),
            }
            app.logs.say_lost(&mut app.notices);
        });
    }

    /// Writes one set of products of the visible logs into a folder, as `process` does: the
    /// requested products, including the comparison with the reference, and the report with the
    /// present decisions about boxes.
    pub(super) fn export(&mut self, folder: PathBuf) {
        let logs = self.logs.processed();
        let Some(first) = logs.first() else {
            return;
        };
        let excluded_products = &self.view.options.excluded_products;
        let requested: Vec<Product> = (Product::ALL.into_iter())
            .filter(|product| !excluded_products.contains(product))
            .collect();
        let against = self.map.comparing.against(&first.products.settings);
        let against = against.filter(|_| requested.contains(&Product::Residuals));
        let review = self.survey_review();
        let run = (logs.len() == 1).then(|| (self.logs.shown.id, folder.clone()));
        let into = folder.clone();
        let derived = self.pipeline.deriving.results.clone();
        let write = move |progress: &Progress| {
            let reference = against.as_ref().map(|(reference, _)| &**reference);
            let surveys = logs.iter().map(|log| &*log.survey);
            let run = outputs::begin(&folder, surveys, reference)?;
            let order = Order {
                logs: &logs,
                derived: &derived,
                requested: &requested,
                reference: (against.as_ref()).map(|(reference, matching)| (reference, *matching)),
                search: None,
                review: &review,
                corrections: &[],
            };
            let written = outputs::write(&order, run, progress, |_| ());
            written.map(|written| written.summary(&folder))
        };
        let written = |app: &mut Self| {
            if let Some((log, folder)) = run {
                let run = EarlierRun::read(&folder);
                app.files.exported = run.map(|run| Exported { log, folder, run });
            }
            app.written_into = Some(into);
        };
        self.start_writing(write, written);
    }

    /// Writes the shown log, or some of its pings, into a file.
    pub(super) fn export_log(&mut self, path: PathBuf, pings: Option<Range<usize>>) {
        let Some(survey) = self.logs.shown.survey.clone() else {
            return;
        };
        if self.refuses_log(self.logs.shown.id, &path) {
            return;
        }
        let settings = self.logs.shown.settings.clone();
        let pings = pings.map(|pings| PingRange {
            start: pings.start,
            end: pings.end.min(survey.side_scan.len()),
        });
        let choice = LogPartChoice { pings, ..LogPartChoice::default() };
        self.write(move |progress| {
            let positions = settings.position_settings();
            let copied = copy_log(&path, &survey, positions, &choice, progress)?;
            let losses = copied.losses.iter().map(|loss| format!("; {loss}"));
            let losses: String = losses.collect();
            let path = path.display();
            Ok::<_, bathyscope_products::Error>(format!(
                "Wrote {} to {path}{losses}",
                copied.summary()
            ))
        });
    }

    /// Returns the folder for products unless the analyst names another: the one that was written
    /// last, else one beside the project or the log.
    pub(crate) fn export_folder(&self) -> PathBuf {
        if let Some(folder) = &self.written_into {
            return folder.clone();
        }
        let survey = self.logs.shown.survey.as_ref();
        let log = survey.and_then(|survey| survey.source.files.first());
        let beside = self.files.project_saving.path().or(log.map(PathBuf::as_path));
        let name = beside.and_then(Path::file_stem).unwrap_or_default();
        let name = format!("{}-products", name.to_string_lossy());
        beside.and_then(Path::parent).unwrap_or(Path::new("")).join(name)
    }

    /// Returns the amounts that determine the sizes of the products.
    pub(crate) fn amounts(&self) -> Amounts {
        let depth_map = self.depth_map().flatten();
        Amounts::of(&self.logs.processed(), depth_map.map(|map| &**map))
    }

    /// Returns the last written files of the shown log that its present settings would change, and
    /// their folder; `None` if there are none.
    pub fn out_of_date(&self) -> Option<(&Path, Vec<&'static OutputFile>)> {
        let Exported { log, folder, run } = self.files.exported.as_ref()?;
        let files = run.out_of_date(&self.logs.shown.settings);
        (*log == self.logs.shown.id && !files.is_empty()).then_some((folder, files))
    }

    /// Returns the text around a print of a view. `scale` is a sentence about the scale on paper;
    /// `now` is the time of printing.
    pub(crate) fn print_text(&self, view: View, scale: String, now: SystemTime) -> PrintText {
        let products = self.logs.shown.products.as_ref();
        let datum = products.map(|products| products.correction.statement());
        let datum = datum.map(|statement| self.view.options.units.sentence(&statement));
        let facts = [Some(self.logs.recorded(now)), self.system(view), datum, Some(scale)];
        let facts = facts.into_iter().flatten();
        PrintText {
            title: format!("{} · {}", one_line(&self.print_name()), view.title()),
            facts: facts.map(|fact| one_line(&fact)).collect(),
        }
    }

    /// Returns the name of the project, or the names of the logs.
    fn print_name(&self) -> String {
        if let Some(project) = self.files.project_saving.path().and_then(|path| path.file_stem()) {
            return project.to_string_lossy().into_owned();
        }
        let names: Vec<String> = self.logs.visible().map(|log| log.name()).collect();
        match names.len() {
            0..=NAMED => names.join(", "),
            count => format!("{count} logs, {} and others", names[..NAMED].join(", ")),
        }
    }

    /// Returns sentences about the coordinate system of positions and the unit of lengths.
    fn system(&self, view: View) -> Option<String> {
        let survey = self.logs.shown.survey.as_ref()?;
        let zone = UtmZone::of(survey.track.frame.origin());
        let positions = match self.view.options.coordinates {
            CoordinateFormat::Utm => format!("{} (EPSG:{})", zone.name(), zone.epsg()),
            other => format!("WGS 84 (EPSG:4326), {}", other.name()),
        };
        let lengths = self.view.options.units.length.name();
        Some(match view {
            View::Map => format!("Coordinates: {positions}. Lengths in {lengths}."),
            _ => format!("Lengths in {lengths}. Positions: {positions}."),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::app::{Command, Jobs};

    #[test]
    fn a_print_says_what_when_where_and_from_where_depths_count() {
        let mut app = App::new(Jobs::Inline);
        app.apply(Command::OpenDemo);
        for _ in 0..50 {
            app.poll();
        }
        let day = UNIX_EPOCH + std::time::Duration::from_secs(1_700_000_000);
        let text = app.print_text(View::Map, "Scale 1 : 500.".to_owned(), day);
        assert_eq!(text.title, "demo · Map");
        let [when, system, datum, scale] = &text.facts[..] else {
            panic!("{text:?}");
        };
        let version = env!("CARGO_PKG_VERSION");
        let printed = format!("printed 2023-11-14 by Bathyscope {version}.");
        assert!(when.starts_with("Recorded 2021-10-12 UTC"), "{when}");
        assert!(when.ends_with(&printed), "{when}");
        assert!(system.contains("WGS 84 (EPSG:4326), decimal degrees"));
        assert!(system.contains("metres"), "{system}");
        assert!(datum.starts_with("Depths are below"), "{datum}");
        assert_eq!(scale, "Scale 1 : 500.");
        app.view.options.coordinates = CoordinateFormat::Utm;
        let text = app.print_text(View::Map, String::new(), day);
        assert!(text.facts[1].contains("EPSG:326"), "{}", text.facts[1]);
    }
}

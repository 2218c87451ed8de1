//! Composes the text around a printed view: title, dates, coordinate system, level that depths
//! count from, and scale.

use super::{App, OpenLogs, View};
use bathyscope_log::support::calendar;
use bathyscope_log::support::geo::{CoordinateFormat, UtmZone};
use bathyscope_log::support::printable::one_line;
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

impl OpenLogs {
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
            View::Waterfall | View::Cloud | View::Objects => {
                format!("Lengths in {lengths}. Positions: {positions}.")
            }
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

//! Writes the measured figure into a file.

use super::App;
use super::error::AppError;
use bathyscope_products::export::{self, MeasuredFigure};
use bathyscope_products::project::MeasurementKind;
use std::path::{Path, PathBuf};

impl App {
    /// Returns the measured figure; `None` without results, or before it has enough corners to
    /// measure.
    pub fn measured(&self) -> Option<MeasuredFigure> {
        let (survey, products) =
            self.logs.shown.survey.as_ref().zip(self.logs.shown.products.as_ref())?;
        let figure = &self.map.measuring.figure.as_deref()?.measurement;
        if !figure.is_measurable() {
            return None;
        }
        let (area_m2, stations) = match figure.kind {
            MeasurementKind::Distance => (None, &[][..]),
            MeasurementKind::Area => (Some(figure.area_m2()), &[][..]),
            MeasurementKind::Profile => (None, self.map.measuring.stations()),
            MeasurementKind::Height => (None, &[][..]),
        };
        let shadow = self.measured_height().and_then(Result::ok);
        let stations = stations.iter().map(|station| {
            let [east_m, north_m] = station.place;
            let at = products.navigation.to_lon_lat(&survey.track, east_m, north_m);
            (at, station.distance_m, station.depth_m)
        });
        Some(MeasuredFigure {
            log: survey.name(),
            kind: figure.kind.name(),
            corners: figure.corners.clone(),
            distances_m: figure.distances_m(),
            length_m: figure.length_m(),
            area_m2,
            shadow,
            stations: stations.collect(),
        })
    }

    /// Writes the measured figure into a file.
    pub(super) fn save_figure(&mut self, path: PathBuf) {
        let Some(figure) = self.measured() else {
            return;
        };
        if self.refuses_log(self.logs.shown.id, &path) {
            return;
        }
        match write(self, &figure, &path) {
            Ok(()) => self.notices.notify(format!("Wrote the measurement to {}", path.display())),
            Err(error) => self.notices.warn(error.to_string()),
        }
    }
}

fn write(app: &App, figure: &MeasuredFigure, path: &Path) -> Result<(), AppError> {
    let ending = path.extension().unwrap_or_default().to_string_lossy();
    let written = match ending.to_lowercase().as_str() {
        "geojson" | "json" => export::figure_geojson(path, figure),
        // The depths along a profile are more useful than its corners.
        "csv" => match app.profile_csv() {
            Some(text) => export::write_bytes(path, text),
            None => export::figure_csv(path, figure),
        },
        _ => return Err(AppError::FigureFormat(path.to_owned())),
    };
    Ok(written?)
}

//! What the analyst draws on the map to measure: a line, an area, or the line of a depth profile.

use super::reviewing::{Step, Tool};
use super::{App, ProfileLine};
use crate::bathymetry::Station;
use crate::export;
use crate::geo::LonLat;
use crate::project::{Measurement, MeasurementKind};
use std::path::PathBuf;
use std::sync::Arc;

/// What is drawn on the map.
#[derive(Clone, Debug, PartialEq)]
pub struct Figure {
    /// What it measures, and between which corners.
    pub measurement: Measurement,
    /// The next corner begins another figure.
    pub done: bool,
}

/// A request about the figure.
#[derive(Clone, Debug, PartialEq)]
pub enum Measure {
    /// One more corner here.
    Corner(LonLat),
    /// Where the next corner would be, under the pointer.
    Next(Option<LonLat>),
}

/// The figure and the tool that draws it.
#[derive(Default)]
pub struct Measuring {
    /// What a click on the map draws.
    pub tool: Option<MeasurementKind>,
    /// What was drawn last.
    pub figure: Option<Arc<Figure>>,
    /// Where the next corner would be.
    pub(super) next: Option<LonLat>,
    /// Depths along the figure, if it is the line of a profile,
    pub(super) set: Option<Arc<ProfileLine>>,
    /// and on to the next corner while it is drawn.
    pub(super) drawn: Option<Arc<ProfileLine>>,
}

impl Measuring {
    /// What is drawn of it.
    pub(super) fn for_picture(&self) -> Self {
        Self {
            tool: None,
            figure: self.figure.clone(),
            ..Self::default()
        }
    }

    /// Depths along the figure; none where it is not the line of a profile.
    pub fn stations(&self) -> &[Station] {
        self.set.as_ref().map_or(&[], |set| &set.stations)
    }

    /// The line of the profile with its depths, on to the next corner while it is drawn.
    pub fn profile(&self) -> Option<&ProfileLine> {
        self.drawn.as_deref()
    }

    /// Whether the plot of a depth profile is requested.
    pub fn shows_profile(&self) -> bool {
        let drawn = self.figure.as_ref().map(|figure| figure.measurement.kind);
        self.tool.or(drawn) == Some(MeasurementKind::Profile)
    }

    /// Whether a corner would go on with the figure there is.
    pub fn is_drawing(&self) -> bool {
        let open = self.figure.as_ref().filter(|figure| !figure.done);
        open.is_some_and(|figure| Some(figure.measurement.kind) == self.tool)
    }
}

impl App {
    /// Takes a measuring tool in hand, or lays it down.
    pub(super) fn take_measuring_tool(&mut self, kind: MeasurementKind) {
        let again = self.measuring.tool == Some(kind);
        self.end_figure();
        self.measuring.tool = (!again && self.log.survey.is_some()).then_some(kind);
        self.log.reviewing.tool = Tool::Look;
    }

    /// Lays the tool down; whether there was one in hand.
    pub(super) fn leave_measuring(&mut self) -> bool {
        let had_tool = self.measuring.tool.take().is_some();
        if had_tool {
            self.end_figure();
        }
        had_tool
    }

    /// Removes the figure, and lays the tool down.
    pub(super) fn remove_figure(&mut self) {
        self.measuring.tool = None;
        if self.measuring.figure.is_some() {
            self.draw(None);
        }
    }

    /// Carries out a request about the figure.
    pub(super) fn measure(&mut self, request: Measure) {
        match request {
            Measure::Corner(at) => {
                let Some(kind) = self.measuring.tool else {
                    return;
                };
                let open = self
                    .measuring
                    .figure
                    .as_ref()
                    .filter(|_| self.measuring.is_drawing());
                let none = || Measurement {
                    kind,
                    corners: Vec::new(),
                    note: String::new(),
                };
                let begun = open.map_or_else(none, |figure| figure.measurement.clone());
                self.draw(Some(Figure {
                    measurement: begun.with(at),
                    done: false,
                }));
            }
            Measure::Next(place) => self.measuring.next = place,
        }
    }

    /// Takes the last corner back; a finished figure is drawn on.
    pub(super) fn take_corner_back(&mut self) {
        if let Some(figure) = &self.measuring.figure {
            let mut figure = (**figure).clone();
            let corners = &mut figure.measurement.corners;
            corners.pop();
            let is_left = !corners.is_empty();
            figure.done = false;
            self.draw(is_left.then_some(figure));
        }
    }

    /// Ends the figure: the next corner begins another one. What cannot be measured goes.
    pub(super) fn end_figure(&mut self) {
        match &self.measuring.figure {
            Some(figure) if !figure.measurement.is_measurable() => self.draw(None),
            Some(figure) if !figure.done => {
                self.measuring.figure = Some(Arc::new(Figure {
                    done: true,
                    ..(**figure).clone()
                }));
                self.keep_project("measurement");
            }
            _ => {}
        }
    }

    /// Makes `figure` the one on the map, as an undo step.
    fn draw(&mut self, figure: Option<Figure>) {
        let before = self.step_now();
        let after = Step {
            figure: figure.map(Arc::new),
            ..before.clone()
        };
        let label = match after.figure {
            Some(_) => "corner",
            None => "measurement",
        };
        self.measuring.figure = after.figure.clone();
        self.record_step(&before, &after, label, false);
    }

    /// The depth profile as a table; `None` while there is none.
    pub fn profile_csv(&self) -> Option<String> {
        let (survey, products) = self.log.survey.as_ref().zip(self.log.products.as_ref())?;
        let stations = self.measuring.stations();
        let drawn = self.measuring.shows_profile() && !stations.is_empty();
        drawn.then(|| export::profile_csv(survey, &products.navigation, stations))
    }

    /// Writes the depth profile into a file.
    pub(super) fn save_profile(&mut self, path: PathBuf) {
        let Some(text) = self.profile_csv() else {
            return;
        };
        if self.refuses_log(&path) {
            return;
        }
        match export::write_profile_csv(&path, &text) {
            Ok(()) => self.notify(
                format!("Wrote the depth profile to {}", path.display()),
                false,
            ),
            Err(error) => self.notify(error.to_string(), true),
        }
    }
}

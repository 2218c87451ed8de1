//! All files of a run.

use super::boxes::reviewed_rows;
use super::clouds::{write_clouds, write_tables};
use super::comparison::write_comparison;
use super::depth::write_depth;
use super::detections::{Proposed, proposed_rows, write_detections};
use super::mosaic::{MosaicWritten, write_mosaic};
use super::overwrite::{inputs, refuse_overwrite};
use super::product::Product;
use super::record::{Made, write_record};
use super::run_folder::RunFolder;
use super::track::write_track;
use crate::bathymetry::Surface;
use crate::bathymetry::compare::Matching;
use crate::detection::review::{Review, State};
use crate::detection::{Model, Raster};
use crate::export::{ObjectRow, write_aside};
use crate::geo::MapPlane;
use crate::handover::{self, Handover, Objects};
use crate::pipeline::{self, Agreement, Input, NamedComparison, Products, Reference, Report};
use crate::progress::{Cancelled, Progress};
use crate::survey::Survey;
use std::io::Write as _;
use std::path::Path;
use std::sync::Arc;

/// The manifest of a run, in place last.
const REPORT: &str = "report.json";

/// What is to be written.
pub struct Order<'a> {
    /// The log.
    pub survey: &'a Survey,
    /// What the pipeline made of it.
    pub products: &'a Products,
    /// What is written beside `first_returns.csv`, `cloud.csv` and `report.json`.
    pub wanted: &'a [Product],
    /// What the depths are compared with besides, and how a point finds its reference.
    pub reference: Option<(&'a Arc<Reference>, Matching)>,
    /// Where boxes come from.
    pub boxes: Searched<'a>,
}

/// Where boxes of objects come from.
pub enum Searched<'a> {
    /// Nobody searched.
    Not,
    /// They are to be found by a model, and written as `detections.*` and `chips`.
    By(&'a Model),
    /// They were found before and decided about; the report shows them.
    Reviewed(&'a Review, &'a Raster),
}

/// What was written.
#[derive(Clone, Debug)]
pub struct Written {
    /// File names, in the order of writing; beside each but the reports lies its record, `NAME.json`.
    pub files: Vec<&'static str>,
    /// Files of an earlier run that were removed, since this one wrote none in their place.
    pub removed: Vec<String>,
    /// The report, as written to `report.json`.
    pub report: Report,
    /// What was found, where a model searched.
    pub found: Option<Proposed>,
}

impl Written {
    /// What was written and removed, in a sentence or two.
    pub fn summary(&self, folder: &Path) -> String {
        let files = self.files.join(", ");
        // Where comes first: the list of files is long, and the window shows a few lines of it.
        let wrote = format!(
            "wrote into {}: {files}, each with its record (.json)",
            folder.display()
        );
        match self.removed.as_slice() {
            [] => wrote,
            removed => format!("{wrote}; removed of an earlier run: {}", removed.join(", ")),
        }
    }
}

/// What has been written so far.
struct Writing<'a> {
    order: &'a Order<'a>,
    folder: &'a Path,
    progress: &'a Progress,
    map: MapPlane,
    report: Report,
    /// Each with the files that it was made from besides the survey's.
    made: Vec<(Made, Vec<Input>)>,
    surface: Option<Surface>,
    comparisons: Vec<NamedComparison>,
    found: Option<Proposed>,
}

/// Writes `first_returns.csv`, `cloud.csv`, the wanted products, what differs from the reference, the boxes that are found, a record
/// of each, `report.html` and `report.json`, and puts them in the place of an earlier run's files.
///
/// `on_step` is told what comes next.
///
/// # Errors
/// A sentence that names the file, or says that the work was cancelled; the folder is then as it was.
pub fn write(
    order: &Order<'_>,
    run: RunFolder,
    progress: &Progress,
    mut on_step: impl FnMut(&'static str),
) -> Result<Written, String> {
    on_step("writing");
    let Order {
        survey, products, ..
    } = *order;
    // Before the work: a system that does not fit should not cost a hash of all inputs first.
    let map = pipeline::map_plane(survey, &products.settings)?;
    refuse_overwrite(inputs(survey, products), run.destination())?;
    let folder = run.path();
    let mut writing = Writing {
        order,
        folder: &folder,
        progress,
        map,
        report: Report::new(survey, products, progress).map_err(in_words)?,
        made: Vec::new(),
        surface: None,
        comparisons: Vec::new(),
        found: None,
    };
    writing.points(&mut on_step)?;
    writing.maps(&mut on_step)?;
    writing.comparison(&mut on_step)?;
    writing.detections(&mut on_step)?;
    on_step("records");
    writing.report.name_run(run.files(progress)?)?;
    writing.records()?;
    writing.page(&mut on_step)?;
    let Writing {
        mut report,
        made,
        found,
        ..
    } = writing;
    report.files = run.files(progress)?;
    write_report(&report, &folder)?;
    let mut files: Vec<&'static str> = made.iter().map(|(made, _)| made.name).collect();
    files.extend(found.as_ref().map(|_| "chips"));
    files.extend(
        order
            .wanted
            .contains(&Product::Report)
            .then_some(handover::NAME),
    );
    files.push(REPORT);
    Ok(Written {
        files,
        removed: run.commit(REPORT)?,
        report,
        found,
    })
}

fn in_words(error: Cancelled) -> String {
    error.to_string()
}

impl Writing<'_> {
    fn wants(&self, product: Product) -> bool {
        self.order.wanted.contains(&product)
    }

    fn add(&mut self, made: impl IntoIterator<Item = Made>) {
        let made = made.into_iter().map(|made| (made, Vec::new()));
        self.made.extend(made);
    }

    /// Tables, clouds and track.
    fn points(&mut self, on_step: &mut impl FnMut(&'static str)) -> Result<(), String> {
        let Order {
            survey, products, ..
        } = *self.order;
        let (folder, progress) = (self.folder, self.progress);
        let tables = write_tables(survey, products, folder, progress)?;
        self.add(tables);
        if self.wants(Product::Cloud) {
            let clouds = write_clouds(survey, products, &self.map, folder, progress)?;
            if clouds.is_empty() {
                self.report.warnings.push(no_cloud(products).to_owned());
            }
            self.add(clouds);
        }
        if self.wants(Product::Track) {
            on_step("track");
            let (track, warnings) = write_track(survey, products, &self.map, folder, progress)?;
            self.add(track);
            self.report.warnings.extend(warnings);
        }
        Ok(())
    }

    /// Depths and mosaic.
    fn maps(&mut self, on_step: &mut impl FnMut(&'static str)) -> Result<(), String> {
        let Order {
            survey,
            products,
            wanted,
            ..
        } = *self.order;
        on_step("depths");
        let depth = write_depth(survey, products, wanted, self.folder, self.progress)?;
        self.add(depth.made);
        self.report.warnings.extend(depth.warnings);
        self.surface = depth.surface;
        self.comparisons = depth.comparisons;
        if survey.has_side_scan() && self.wants(Product::Mosaic) {
            on_step("mosaic");
            match write_mosaic(survey, products, self.folder, self.progress)? {
                MosaicWritten::File(mosaic) => self.add([*mosaic]),
                MosaicWritten::None(why) => self.report.warnings.push(why),
            }
        }
        Ok(())
    }

    /// The survey against the reference.
    fn comparison(&mut self, on_step: &mut impl FnMut(&'static str)) -> Result<(), String> {
        let Order {
            survey, products, ..
        } = *self.order;
        let Some((reference, matching)) = self.order.reference else {
            return Ok(());
        };
        on_step("comparing");
        let (folder, progress) = (self.folder, self.progress);
        let agreement = Agreement::with_reference(survey, products, reference, matching, progress)?;
        let (made, inputs) = write_comparison(survey, products, &agreement, folder, progress)?;
        let made = made.into_iter().map(|made| (made, inputs.clone()));
        self.made.extend(made);
        self.comparisons.extend(agreement.by_source(products));
        let notes = reference.notes.iter().cloned();
        self.report.warnings.extend(notes);
        Ok(())
    }

    /// The search for objects.
    fn detections(&mut self, on_step: &mut impl FnMut(&'static str)) -> Result<(), String> {
        let Order {
            survey, products, ..
        } = *self.order;
        let Searched::By(model) = self.order.boxes else {
            return Ok(());
        };
        if !survey.has_side_scan() {
            return Ok(());
        }
        on_step("objects");
        let settings = &products.settings.detector;
        let (folder, progress) = (self.folder, self.progress);
        let found = write_detections(survey, products, model, settings, folder, progress)?;
        self.add(found.made());
        self.found = Some(found);
        Ok(())
    }

    fn records(&self) -> Result<(), String> {
        for (made, more) in &self.made {
            self.progress.check().map_err(in_words)?;
            if more.is_empty() {
                write_record(made, &self.report, self.folder)?;
                continue;
            }
            let mut report = self.report.clone();
            report.inputs.extend(more.iter().cloned());
            write_record(made, &report, self.folder)?;
        }
        Ok(())
    }

    /// `report.html`.
    fn page(&mut self, on_step: &mut impl FnMut(&'static str)) -> Result<(), String> {
        if !self.wants(Product::Report) {
            return Ok(());
        }
        on_step("report");
        let Order {
            survey, products, ..
        } = *self.order;
        let searched: Raster;
        let boxes: Option<(Vec<ObjectRow<'_>>, &Raster, String)> =
            match (&self.order.boxes, &self.found) {
                (Searched::Reviewed(review, raster), _) => {
                    let rows = reviewed_rows(survey, products, review, self.progress)?;
                    Some((rows, *raster, summary(review)))
                }
                (Searched::By(model), Some(found)) => {
                    let names = model.names();
                    let rows = proposed_rows(survey, products, names, &found.boxes);
                    searched = Raster::new(survey, &products.navigation, model.pixel_m());
                    let origin = "Proposed by the detector, not reviewed".to_owned();
                    Some((rows, &searched, origin))
                }
                _ => None,
            };
        let objects = boxes.as_ref().map(|(rows, raster, origin)| Objects {
            rows,
            raster,
            origin: origin.clone(),
        });
        let files: Vec<&'static str> = self.made.iter().map(|(made, _)| made.name).collect();
        let chips = self.found.as_ref().map(|_| "chips");
        let files: Vec<&'static str> = files.into_iter().chain([REPORT]).chain(chips).collect();
        let from = Handover {
            survey,
            products,
            report: &self.report,
            map: &self.map,
            surface: self.surface.as_ref(),
            comparisons: &self.comparisons,
            objects,
            files: &files,
        };
        let html = handover::page(&from, self.progress).map_err(in_words)?;
        write_aside(&self.folder.join(handover::NAME), |mut file| {
            file.write_all(html.as_bytes())
        })
        .map_err(|error| error.to_string())
    }
}

fn write_report(report: &Report, folder: &Path) -> Result<(), String> {
    write_aside(&folder.join(REPORT), |mut file| {
        let text = serde_json::to_vec_pretty(report)?;
        file.write_all(&text)?;
        file.write_all(b"\n")
    })
    .map_err(|error| error.to_string())
}

/// Why there is no point to write.
fn no_cloud(products: &Products) -> &'static str {
    match products.cloud.points.is_empty() {
        true => {
            "no cloud: there is no point, since no first return and no recorded depth has a place and a heading"
        }
        false => {
            "no cloud: the outlier filter kept no point; see outliers.radius_m and outliers.min_neighbors"
        }
    }
}

/// How far a review has come: `Boxes of the review: 12 accepted, 1 added, 3 rejected, 4 undecided`.
fn summary(review: &Review) -> String {
    let count = |state: State| review.boxes().filter(|one| one.state == state).count();
    let part = match review.coverage() {
        Some(part) => format!(". The search was stopped: it covers {part}"),
        None => String::new(),
    };
    if count(State::Proposed) == review.boxes().len() {
        return format!("Proposed by the detector, not reviewed{part}");
    }
    format!(
        "Boxes of the review: {} accepted, {} added, {} rejected, {} undecided{part}",
        count(State::Accepted),
        count(State::Added),
        count(State::Rejected),
        count(State::Proposed)
    )
}

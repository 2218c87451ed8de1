//! Keeps the list of objects of the visible logs ([`ObjectList`]) up to date.
//!
//! A background job makes the list again when a box, a position, the confidence or the logs change.
//! An object keeps its number while its boxes are decided, moved or hidden.

use super::jobs::{JobKey, JobQueue, Kept};
use super::reviewing::{Entries, LocatedObject};
use super::{App, ObjectTable, OpenLog, OpenLogs};
use bathyscope_log::support::progress::Progress;
use bathyscope_log::survey::{Exclusions, Navigation, Survey};
use bathyscope_objects::objects::{
    ListedObject, LogBox, LogId, LogReview, Object, ObjectBox, ObjectList, ObjectNumbers,
    SurveyReview,
};
use bathyscope_objects::targets::{FittedShape, PassCount, PassLog, ShapeError, Target};
use bathyscope_products::pipeline::{ProcessedLog, Same, object_shape};
use std::sync::Arc;

/// The parts of a log from which objects are made.
#[derive(Clone)]
struct LogBoxes {
    review: LogReview,
    survey: Arc<Survey>,
    navigation: Arc<Navigation>,
    exclusions: Arc<Exclusions>,
    entries: Entries,
}

impl PartialEq for LogBoxes {
    fn eq(&self, other: &Self) -> bool {
        self.review.log == other.review.log
            && self.review.threshold == other.review.threshold
            && Arc::ptr_eq(&self.review.review, &other.review.review)
            && Arc::ptr_eq(&self.entries, &other.entries)
            && Arc::ptr_eq(&self.exclusions, &other.exclusions)
    }
}

impl LogBoxes {
    /// Returns the boxes that count and have a position. A box that was moved gets its new position
    /// a moment later; until then its earlier position counts.
    fn boxes(&self, log: usize) -> impl Iterator<Item = ObjectBox> {
        let boxes = self.review.boxes(&self.exclusions);
        boxes.filter_map(move |review_box| {
            let (_, placed) = self.entries.get(&review_box.id)?;
            let target = placed.as_ref()?.target.clone();
            Some(self.review.object_box(log, review_box, Some(target)))
        })
    }

    fn pass_log(&self) -> PassLog<'_> {
        (&self.survey, &self.navigation)
    }
}

/// The object whose passes are counted, with its boxes and its position in metres, and the logs of
/// these passes.
type PassesOf = (u32, Vec<LogBox>, [f64; 2], Vec<(LogId, Same<Navigation>)>);

/// The boxes of an object with their positions, to which its shape is fitted.
type ShapeOf = Vec<(LogBox, Same<LocatedObject>)>;
/// The shape of an object, and the boxes that it was fitted to.
type ShapeFound = (Vec<LogBox>, Result<FittedShape, ShapeError>);

/// Inputs of the rows of the table: objects, order and filter, and names of the logs.
type Listed = (Same<ObjectList>, ObjectTable, Same<Vec<String>>);

/// State of the list of objects.
#[derive(Default)]
pub struct Objects {
    /// The numbers that objects had when the project was opened.
    first: Arc<ObjectNumbers>,
    list: Kept<Vec<LogBoxes>, Arc<ObjectList>>,
    passes: Kept<PassesOf, (u32, PassCount)>,
    shape: Kept<ShapeOf, ShapeFound>,
    listing: Kept<Listed, Vec<u32>>,
    /// Names of the logs of the objects; empty if there is only one log.
    log_names: Arc<Vec<String>>,
}

impl Objects {
    /// Returns the objects that the boxes of all visible logs show, by number.
    pub fn all(&self) -> &[Object] {
        let list = self.list.result();
        list.map_or(&[], |list| list.objects.as_slice())
    }

    /// Returns the numbers of the objects that the table lists, in its order.
    pub fn listed(&self) -> &[u32] {
        self.listing.result().map_or(&[], Vec::as_slice)
    }

    /// Returns an object as a row of tables, without its shape.
    pub fn listed_object<'a>(&'a self, object: &'a Object) -> ListedObject<'a> {
        let log_names = &self.log_names;
        ListedObject { object, shape: None, outline: None, log_names }
    }

    /// Returns the object with a number; `None` if there is none.
    pub fn get(&self, number: u32) -> Option<&Object> {
        self.list.result()?.object(number)
    }

    /// Returns the object that a box shows; `None` for a box without a position, or of a log that
    /// is not visible.
    pub fn of_box(&self, id: LogBox) -> Option<&Object> {
        self.list.result()?.object_of(id)
    }

    /// Drops all objects, and sets the numbers of a project, which its objects keep.
    pub(super) fn renumber(&mut self, first: ObjectNumbers, jobs: &mut JobQueue) {
        use JobKey::{CountPasses, FitShape, JoinObjects, ListObjects};
        for key in [JoinObjects, CountPasses, FitShape, ListObjects] {
            jobs.stop(&key);
        }
        *self = Self { first: Arc::new(first), ..Self::default() };
    }

    /// Returns the present numbers of the objects.
    pub(super) fn numbers(&self) -> &ObjectNumbers {
        let list = self.list.result();
        list.map_or(&*self.first, |list| &list.numbers)
    }
}

impl OpenLogs {
    /// Returns the box that is shown for an object: preferably one of the shown log, then the box
    /// with the highest score.
    pub(crate) fn best_box(&self, object: &Object) -> Option<LogBox> {
        let rank = |id: &LogBox| {
            let score = self.log_box(*id).and_then(|review_box| review_box.score);
            (id.log == self.shown.id, score.unwrap_or(1.0))
        };
        let best = object.boxes.iter().max_by(|a, b| {
            let (a, b) = (rank(a), rank(b));
            a.0.cmp(&b.0).then(a.1.total_cmp(&b.1))
        });
        best.copied()
    }
}

impl App {
    /// Returns the decisions about the boxes of each of [`OpenLogs::processed`], and the present
    /// numbers of the objects.
    pub(super) fn survey_review(&self) -> SurveyReview {
        let shown = self.logs.visible();
        let shown = shown.filter(|log| log.survey.is_some() && log.products.is_some());
        SurveyReview {
            logs: shown.map(|log| log.reviewing.has_boxes().then(|| log.review())).collect(),
            numbers: self.objects.numbers().clone(),
        }
    }

    /// Returns the object of the selected box.
    pub fn selected_object(&self) -> Option<&Object> {
        self.objects.of_box(self.logs.shown.selected_box()?)
    }

    /// Returns the shape of the selected object, or the reason that it has none; `None` until it is
    /// fitted.
    pub fn selected_object_shape(&self) -> Option<&Result<FittedShape, ShapeError>> {
        let (boxes, shape) = self.objects.shape.result()?;
        let object = self.selected_object()?;
        (*boxes == object.boxes).then_some(shape)
    }

    /// Returns the number of passes of the boat, over all visible logs, that saw the selected
    /// object, and the number that covered its position; `None` until they are counted.
    pub fn selected_object_passes(&self) -> Option<PassCount> {
        let (number, passes) = self.objects.passes.result()?;
        let object = self.selected_object()?;
        // An earlier count may belong to other boxes.
        (*number == object.number && passes.seen == object.sightings).then_some(*passes)
    }

    /// Starts making the list of objects again if its inputs have changed.
    pub(super) fn follow_objects(&mut self) {
        let boxes = |log: &OpenLog| {
            let products = log.products.as_ref()?;
            Some(LogBoxes {
                review: log.review(),
                survey: log.survey.clone()?,
                navigation: products.navigation.clone(),
                exclusions: products.exclusions.clone(),
                entries: log.reviewing.entries().clone(),
            })
        };
        let (names, logs): (Vec<String>, Vec<LogBoxes>) =
            self.logs.visible().filter_map(|log| Some((log.name(), boxes(log)?))).unzip();
        let Objects { list, first, log_names, .. } = &mut self.objects;
        let names = if names.len() > 1 { names } else { Vec::new() };
        if **log_names != names {
            *log_names = Arc::new(names);
        }
        let (before, first) = (list.result().cloned(), first.clone());
        let of = logs.clone();
        let key = logs.clone();
        let work = move |_: &Progress| {
            let before = before.as_ref().map_or(&*first, |list| &list.numbers);
            let boxes = (of.iter().enumerate()).flat_map(|(log, boxes)| boxes.boxes(log));
            let pass_logs: Vec<PassLog<'_>> = of.iter().map(LogBoxes::pass_log).collect();
            Some(Arc::new(ObjectList::join(boxes.collect(), &pass_logs, before)))
        };
        self.keep(JobKey::JoinObjects, key, work, |app| Some(&mut app.objects.list));
        self.list_objects();
        self.count_passes(logs);
        self.fit_shape();
    }

    /// Starts sorting and filtering the table again if the objects, the order or the filter have
    /// changed.
    fn list_objects(&mut self) {
        let Objects { list, log_names, .. } = &self.objects;
        let Some(list) = list.result().cloned() else {
            return;
        };
        let table = self.view.options.objects.clone();
        let names = log_names.clone();
        let key = (Same(list.clone()), table.clone(), Same(names.clone()));
        let work = move |_: &Progress| Some(table.list(&list.objects, &names));
        self.keep(JobKey::ListObjects, key, work, |app| Some(&mut app.objects.listing));
    }

    /// Starts fitting a shape to the selected object again if its boxes or their positions have
    /// changed.
    fn fit_shape(&mut self) {
        let boxes = self.selected_object().map(|object| object.boxes.clone());
        let placed = boxes.into_iter().flatten().filter_map(|id| {
            let log = self.logs.get(id.log)?;
            Some((id, log.with_results()?, log.reviewing.placed(id.id)?.clone()))
        });
        let placed: Vec<(LogBox, ProcessedLog, Arc<LocatedObject>)> = placed.collect();
        if placed.is_empty() {
            return self.objects.shape.drop_all(&mut self.jobs, &JobKey::FitShape);
        }
        let of = placed.iter().map(|(id, _, at)| (*id, Same(at.clone())));
        let key: ShapeOf = of.collect();
        let work = move |_: &Progress| {
            let boxes: Vec<(&ProcessedLog, &Target)> =
                (placed.iter()).map(|(_, log, at)| (log, &at.target)).collect();
            let ids = placed.iter().map(|(id, ..)| *id).collect();
            Some((ids, object_shape(&boxes)))
        };
        self.keep(JobKey::FitShape, key, work, |app| Some(&mut app.objects.shape));
    }

    fn count_passes(&mut self, logs: Vec<LogBoxes>) {
        let Some(object) = self.selected_object() else {
            return self.objects.passes.drop_all(&mut self.jobs, &JobKey::CountPasses);
        };
        let (number, list) = (object.number, self.objects.list.result().cloned());
        let track =
            |log_boxes: &LogBoxes| (log_boxes.review.log, Same(log_boxes.navigation.clone()));
        let tracks = logs.iter().map(track).collect();
        let of: PassesOf = (number, object.boxes.clone(), object.place_m, tracks);
        let work = move |_: &Progress| {
            let logs: Vec<PassLog<'_>> = logs.iter().map(LogBoxes::pass_log).collect();
            Some((number, list?.object(number)?.passes(&logs)))
        };
        self.keep(JobKey::CountPasses, of, work, |app| Some(&mut app.objects.passes));
    }
}

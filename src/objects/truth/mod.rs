//! Holds known objects of a survey, and compares them with a review's boxes.
//!
//! In: a file of known objects, and the boxes of a review. Out: which boxes are right, and the
//! mistakes.
//!
//! `file` reads the truth: the table of objects that `bathyscope simulate` writes, or a review of
//! the same log by somebody who knew the objects. [`RasterTruth`] converts it to boxes in the
//! survey's raster and ignores objects that nobody could see; [`TruthComparison`] pairs it with
//! boxes.

mod file;

pub use file::TruthError;

use super::dataset::KnownObject;
use super::metrics::{
    AtScore, Cause, Confusion, CurvePoint, Image, MatchCounts, Matched, MetricSettings, TrueBox,
};
use super::review::{BoxId, Review};
use super::{Mark, NAMELESS_CLASS, Raster, Rect, Scored, class_index};
use bathyscope_log::survey::Side;
use std::sync::Arc;

/// Ending of the file name of the table of objects that `bathyscope simulate` writes next to a log;
/// it replaces the ending of the log's name.
pub const SIDECAR: &str = "objects.csv";

/// Objects whose place in a survey is known.
#[derive(Clone, Debug, PartialEq)]
pub struct SurveyTruth {
    /// Class names that [`KnownObject::class`] is an index into.
    pub classes: Vec<String>,
    /// Sightings of the objects: one entry for each pass that insonified an object.
    pub objects: Vec<KnownObject>,
    /// True if somebody drew the boxes around what they saw: all boxes count. Otherwise the boxes
    /// are computed from the geometry, and objects that do not stand out in the picture are
    /// ignored.
    pub was_seen: bool,
}

impl SurveyTruth {
    /// Returns the name of a class; empty if there is no class with this index.
    pub fn class_name(&self, class: usize) -> &str {
        self.classes.get(class).map_or("", String::as_str)
    }
}

/// The objects of a truth as boxes in the pixels of a raster.
#[derive(Clone, Debug)]
pub struct RasterTruth {
    truth: Arc<SurveyTruth>,
    /// Boxes on each of the two sides, each with the index of its object.
    sides: [Vec<(TrueBox, usize)>; 2],
}

impl RasterTruth {
    /// Converts the objects to boxes in the raster. Objects that a detector cannot be expected to
    /// find, by the rule for training data ([`KnownObject::is_plain`]), are ignored unless a person
    /// saw them.
    pub fn new(raster: &Raster, truth: Arc<SurveyTruth>) -> Self {
        let rasterise = |known: &KnownObject| TrueBox {
            class: known.class,
            rect: raster.rect_of(&known.whole),
            ignored: !truth.was_seen && !known.is_plain(raster),
        };
        let on_raster: Vec<TrueBox> = truth.objects.iter().map(rasterise).collect();
        let on = |side: Side| {
            let all = on_raster.iter().zip(&truth.objects).enumerate();
            all.filter(|(_, (_, known))| known.whole.side == side)
                .map(|(object, (on_raster, _))| (*on_raster, object))
                .collect()
        };
        Self { sides: Side::BOTH.map(on), truth }
    }

    /// Ignores the objects for which `is_out` is true, and returns how many of them counted until
    /// then.
    fn ignore(&mut self, is_out: impl Fn(&Mark) -> bool) -> usize {
        let mut count = 0;
        for (on_raster, object) in self.sides.iter_mut().flatten() {
            if !on_raster.ignored && is_out(&self.truth.objects[*object].whole) {
                on_raster.ignored = true;
                count += 1;
            }
        }
        count
    }

    /// Returns the two sides as pictures without predicted boxes. Classes are indices into
    /// `classes`, matched by name; classes that only the truth has are appended to it.
    pub fn images(&self, classes: &mut Vec<String>) -> [Image; 2] {
        let names = self.truth.classes.iter();
        let class_of: Vec<usize> = names.map(|name| class_index(classes, name)).collect();
        [0, 1].map(|side: usize| {
            let of_side = self.sides[side].iter();
            Image {
                truth: of_side
                    .map(|(known, _)| TrueBox {
                        class: class_of.get(known.class).copied().unwrap_or(usize::MAX),
                        ..*known
                    })
                    .collect(),
                predicted: Vec::new(),
            }
        })
    }
}

/// Boxes of the model, paired with the truth at every score, whatever the decision about them.
/// Boxes without a score, which no model has found, are left out.
#[derive(Clone, Debug)]
pub struct TruthComparison {
    on_raster: RasterTruth,
    /// Class names, in the order of the confusion's indices: those of the review, then those that
    /// only the truth has.
    pub classes: Vec<String>,
    /// Paired boxes; the two sides are two pictures.
    matched: Matched,
    boxes: [Vec<BoxId>; 2],
    /// Number of visible objects that do not count, because no search has covered their pings.
    pub unsearched: usize,
    /// Precision and recall for every score that occurs, by falling score.
    pub curve: Vec<CurvePoint>,
    pixel_m: f64,
}

/// A mistake to examine.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Mistake {
    /// A box that found no object.
    FalseAlarm {
        /// Number of the box.
        id: BoxId,
        /// Score of the box.
        score: f32,
        /// Cause of the false alarm.
        cause: Cause,
        /// Longer side of the box, metres.
        size_m: f64,
    },
    /// An object that no box found.
    Miss {
        /// Index into the truth's objects.
        object: usize,
        /// Longer side of the object's box, metres.
        size_m: f64,
    },
}

impl Mistake {
    /// Returns the longer side of the box, metres.
    pub fn size_m(&self) -> f64 {
        match self {
            Mistake::FalseAlarm { size_m, .. } | Mistake::Miss { size_m, .. } => *size_m,
        }
    }
}

/// Result of the comparison for the boxes of at least a score.
#[derive(Clone, Debug, PartialEq)]
pub struct Standing {
    /// Least score of the boxes.
    pub score: f32,
    /// Counts of found, false and missed, all classes together.
    pub counts: MatchCounts,
    /// Boxes by true and by predicted class, with the names in [`TruthComparison::classes`].
    pub confusion: Confusion,
    /// False alarms by falling score, then misses by falling size.
    pub mistakes: Vec<Mistake>,
}

impl TruthComparison {
    /// Pairs the boxes with the truth, by Darknet's rule at IoU 0.5, in the raster's pixels, each
    /// side by itself. Classes are compared by name; a box of unknown class gets the class of the
    /// object that it overlaps most. Objects and boxes in pings that the review's searches have not
    /// covered are left out: an object is not missed where there was no search.
    pub fn new(review: &Review, mut on_raster: RasterTruth, raster: &Raster) -> Self {
        let gaps = review.unsearched();
        let unsearched = on_raster.ignore(|whole| Review::reaches_into(&gaps, whole));
        let mut classes = review.classes().to_vec();
        let mut images = on_raster.images(&mut classes);
        let mut boxes = [Vec::new(), Vec::new()];
        for review_box in
            review.boxes().filter(|review_box| !Review::reaches_into(&gaps, &review_box.mark))
        {
            let Some(score) = review_box.score else {
                continue;
            };
            let side = review_box.mark.side as usize;
            boxes[side].push(review_box.id);
            let rect = raster.rect_of(&review_box.mark);
            images[side].predicted.push(Scored::new(review_box.class, score, rect));
        }
        if let Some(nameless) = classes.iter().position(|name| name == NAMELESS_CLASS) {
            for image in &mut images {
                image.name_by_truth(nameless);
            }
        }
        let matched = Matched::new(&images, classes.len(), &MetricSettings::darknet());
        Self {
            curve: matched.curve(),
            matched,
            on_raster,
            classes,
            boxes,
            unsearched,
            pixel_m: raster.pixel_m,
        }
    }

    /// Returns the truth that boxes are compared with.
    pub fn truth(&self) -> &SurveyTruth {
        &self.on_raster.truth
    }

    /// Returns the number of objects that count: the visible ones in searched pings.
    pub fn counted(&self) -> usize {
        let all = self.on_raster.sides.iter().flatten();
        all.filter(|(truth, _)| !truth.ignored).count()
    }

    /// Returns the result of the boxes of at least a score.
    pub fn at(&self, score: f32) -> Standing {
        let AtScore { counts, confusion, false_alarms, misses, .. } = self.matched.at(score);
        let images = &self.matched.images;
        let size_m =
            |rect: &Rect| f64::from((rect.x1 - rect.x0).max(rect.y1 - rect.y0)) * self.pixel_m;
        let mut mistakes: Vec<Mistake> = false_alarms
            .iter()
            .map(|alarm| {
                let predicted = &images[alarm.image].predicted[alarm.predicted];
                Mistake::FalseAlarm {
                    id: self.boxes[alarm.image][alarm.predicted],
                    score: predicted.score,
                    cause: alarm.cause,
                    size_m: size_m(&predicted.rect),
                }
            })
            .collect();
        let first_miss = mistakes.len();
        mistakes.extend(misses.iter().map(|miss| Mistake::Miss {
            object: self.on_raster.sides[miss.image][miss.truth].1,
            size_m: size_m(&images[miss.image].truth[miss.truth].rect),
        }));
        mistakes[first_miss..].sort_by(|a, b| b.size_m().total_cmp(&a.size_m()));
        Standing { score, counts, confusion, mistakes }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Detection;
    use crate::metrics::evaluate;
    use crate::review::Edit;
    use crate::testing::survey;
    use bathyscope_log::survey::Identity;

    const HEADER: &str =
        "object,kind,side,box_first_ping,box_last_ping,box_near_m,box_far_m,shown\n";

    fn identity(pings: usize) -> Identity {
        Identity { swapped_sides: false, file: "pond.sl2".into(), byte_count: 1, pings }
    }

    fn mark(start: usize, near_m: f64) -> Mark {
        Mark::new(Side::Port, start..start + 10, [near_m, near_m + 2.0])
    }

    fn read(lines: &str) -> Result<SurveyTruth, TruthError> {
        SurveyTruth::parse(&format!("{HEADER}{lines}"), &identity(200))
    }

    #[test]
    fn the_table_gives_boxes_and_objects_that_were_not_insonified_are_left_out() {
        let truth = read(
            "0,tyre,port,40,49,3.0,5.0,1\n1,rock,,,,,,\n2,log,starboard,0,199,2,3,0\n3,tyre,port,5,5,1,2,1\n",
        );
        let truth = truth.expect("a table");
        assert_eq!(truth.classes, ["tyre", "log"]);
        assert!(!truth.was_seen);
        let [tyre, log, other] = &truth.objects[..] else {
            panic!("{truth:?}");
        };
        assert_eq!(tyre.whole, mark(40, 3.0));
        assert!(tyre.shown && !log.shown && other.shown);
        assert_eq!((log.class, log.whole.side), (1, Side::Starboard));
        assert_eq!((other.class, other.whole.pings.clone()), (0, 5..6));
    }

    #[test]
    fn what_is_no_truth_of_this_log_is_refused_in_a_sentence() {
        for (line, part) in [
            ("0,tyre,port,40,200,3.0,5.0,1", "line 2: ping 200 is beyond the 200"),
            ("0,tyre,left,40,49,3.0,5.0,1", "`left` is no side"),
            ("0,tyre,port,40,49,nan,5.0,1", "`nan` is no range"),
            ("0,tyre,port,-1,49,3.0,5.0,1", "`-1` is no ping"),
            ("0,tyre,port,50,49,3.0,5.0,1", "inside out"),
            ("0,tyre,port,40,49,3.2,3.2,1", "inside out"),
            ("0,tyre,port,40,49,3.0,5.0,yes", "`yes` in `shown`"),
            ("0,tyre,port", "broken"),
        ] {
            let sentence = read(line).expect_err(line).to_string();
            assert!(sentence.contains(part), "{line}: {sentence}");
        }
        let other =
            SurveyTruth::parse("id,class\n1,rock\n", &identity(9)).expect_err("another table");
        assert!(other.to_string().contains("no column `kind`"), "{other}");
        let review = Review::new(identity(100), vec!["rock".into()]).to_json();
        let other = SurveyTruth::parse(&review, &identity(200)).expect_err("another log's review");
        assert!(other.to_string().contains("another log"), "{other}");
    }

    #[test]
    fn a_review_is_truth_by_what_was_accepted_and_added() {
        let (survey, navigation) = survey(200, |_, _| 0);
        let raster = Raster::new(&survey, &navigation, 0.04);
        let names = ["rock".to_owned()];
        let found =
            [20, 60].map(|start| Detection { class: 0, score: 0.5, mark: mark(start, 3.0) });
        let review = Review::new(identity(200), names.to_vec());
        let review = review.adopt("model", &names, &found, &raster, 0..usize::MAX);
        let review = review.apply(&Edit::Accept(BoxId(1))).expect("accepted");
        let review = review.apply(&Edit::Reject(BoxId(2))).expect("rejected");
        let drawn = Edit::Add { mark: mark(100, 4.0), class: 0 };
        let review = review.apply(&drawn).expect("added");
        let truth = SurveyTruth::parse(&review.to_json(), &identity(200)).expect("a review");
        let marks: Vec<&Mark> = truth.objects.iter().map(|known| &known.whole).collect();
        assert_eq!(marks, [&mark(20, 3.0), &mark(100, 4.0)]);
        assert!(truth.was_seen);
    }

    #[test]
    fn objects_that_nothing_shows_or_that_are_slivers_count_only_when_somebody_saw_them() {
        let (survey, navigation) = survey(200, |_, _| 0);
        let raster = Raster::new(&survey, &navigation, 0.04);
        let lines =
            "0,tyre,port,40,49,3,5,1\n0,tyre,port,100,109,3,5,0\n0,tyre,port,140,149,3,3.1,1\n";
        let mut truth = read(lines).expect("a table");
        let rasterise = |truth: &SurveyTruth| {
            let [port, starboard] = RasterTruth::new(&raster, Arc::new(truth.clone())).sides;
            assert!(starboard.is_empty());
            port.iter().map(|(truth, _)| truth.ignored).collect::<Vec<_>>()
        };
        assert_eq!(rasterise(&truth), [false, true, true]);
        truth.was_seen = true;
        assert_eq!(rasterise(&truth), [false; 3]);
    }

    /// Returns a comparison with boxes at pings 20 (right), 60 (wrong class), 100 (no object) and
    /// 20 again (looser), and no box at 140.
    fn compared() -> TruthComparison {
        compared_with("tyre")
    }

    /// Returns the same comparison with another class name for the box at ping 60.
    fn compared_with(at_60: &str) -> TruthComparison {
        let (survey, navigation) = survey(200, |_, _| 0);
        let raster = Raster::new(&survey, &navigation, 0.04);
        let truth = SurveyTruth {
            classes: vec!["log".into(), "tyre".into()],
            objects: [(1, 20), (0, 60), (1, 140)]
                .map(|(class, start)| KnownObject {
                    class,
                    whole: mark(start, 3.0),
                    shown: true,
                    slices: Vec::new(),
                })
                .to_vec(),
            was_seen: true,
        };
        // The model's class indices differ from those of the truth.
        let mut names = vec!["tyre".to_owned(), "rock".to_owned()];
        let at_60 = class_index(&mut names, at_60);
        let found = [
            (0, 0.9, mark(20, 3.0)),
            (at_60, 0.8, mark(60, 3.0)),
            (1, 0.6, mark(100, 3.0)),
            (0, 0.3, mark(20, 3.4)),
        ];
        let found = found.map(|(class, score, mark)| Detection { class, score, mark });
        let review = Review::new(identity(200), Vec::new());
        let review = review.adopt("model", &names, &found, &raster, 0..usize::MAX);
        let review = review.apply(&Edit::Reject(BoxId(3))).expect("rejected");
        let on_raster = RasterTruth::new(&raster, Arc::new(truth));
        TruthComparison::new(&review, on_raster, &raster)
    }

    #[test]
    fn a_box_without_a_name_finds_an_object_of_any_class() {
        let counts = |at_60: &str| {
            let standing = compared_with(at_60).at(0.7);
            (standing.counts.found, standing.counts.false_alarms)
        };
        assert_eq!(counts("tyre"), (1, 1));
        assert_eq!(counts(NAMELESS_CLASS), (2, 0));
    }

    #[test]
    fn the_slider_counts_what_a_full_evaluation_counts() {
        let comparison = compared();
        assert_eq!(comparison.classes, ["tyre", "rock", "log"]);
        for (score, found, false_alarms) in
            [(0.95, 0, 0), (0.85, 1, 0), (0.7, 1, 1), (0.5, 1, 2), (0.1, 1, 3)]
        {
            let standing = comparison.at(score);
            let counts = standing.counts;
            assert_eq!((counts.found, counts.false_alarms), (found, false_alarms), "{score}");
            assert_eq!(counts.missed(), 3 - found);
            let settings = MetricSettings { score, ..MetricSettings::darknet() };
            let whole = evaluate(&comparison.matched.images, 3, &settings);
            assert_eq!(standing.counts, whole.shown.counts);
            assert_eq!(standing.confusion, whole.shown.confusion);
            assert_eq!(comparison.curve, whole.curve);
        }
    }

    #[test]
    fn mistakes_name_boxes_and_objects_with_their_cause_and_size() {
        let standing = compared().at(0.1);
        let alarm = |mistake: &Mistake| match *mistake {
            Mistake::FalseAlarm { id, cause, .. } => Some((id.0, cause)),
            Mistake::Miss { .. } => None,
        };
        let alarms: Vec<_> = standing.mistakes.iter().filter_map(alarm).collect();
        assert_eq!(alarms, [(2, Cause::OtherClass), (3, Cause::Background), (4, Cause::Duplicate)]);
        let misses: Vec<usize> = (standing.mistakes.iter())
            .filter_map(|mistake| match mistake {
                Mistake::Miss { object, .. } => Some(*object),
                Mistake::FalseAlarm { .. } => None,
            })
            .collect();
        assert_eq!(misses, [1, 2], "the log and the tyre at ping 140");
        // The boxes are ten pings of 0.2 m long, and 2 m in range.
        for mistake in &standing.mistakes {
            assert!((mistake.size_m() - 2.0).abs() < 0.03, "{mistake:?}");
        }
        assert_eq!(standing.confusion.at(2, 0), 1, "the log was taken for a tyre");
        assert_eq!(standing.confusion.at(3, 1), 1, "a rock where nothing is");
        assert_eq!(standing.confusion.at(0, 3), 1, "a tyre was missed");
    }
}

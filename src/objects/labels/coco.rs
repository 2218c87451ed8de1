//! Reads COCO's JSON: a data set, or a list of results.

use super::{
    Label, LabelError, LabelFault, LabelFormat, LabelSet, MOST_CLASSES, PictureLabels, text,
};
use crate::Rect;
use serde::Deserialize;
use std::collections::HashSet;
use std::fmt;
use std::path::Path;

/// Greatest length of a file, bytes: longer than the labels of any survey.
const LONGEST: u64 = 256 << 20;

#[derive(Deserialize)]
struct DataSet {
    images: Vec<Picture>,
    annotations: Vec<Annotation>,
    categories: Vec<Category>,
}

#[derive(Deserialize)]
struct Picture {
    id: Number,
    file_name: String,
    width: Option<u32>,
    height: Option<u32>,
}

#[derive(Deserialize)]
struct Category {
    id: u64,
    name: String,
}

#[derive(Deserialize)]
struct Annotation {
    image_id: Number,
    category_id: u64,
    bbox: [f64; 4],
    #[serde(default)]
    iscrowd: u8,
    score: Option<f64>,
}

/// Number of a picture; some writers put its name there.
#[derive(Deserialize)]
#[serde(untagged)]
enum Number {
    Whole(u64),
    Name(String),
}

impl fmt::Display for Number {
    fn fmt(&self, out: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Number::Whole(number) => write!(out, "{number}"),
            Number::Name(name) => write!(out, "{name}"),
        }
    }
}

/// Reads a data set of true boxes.
///
/// # Errors
/// When a file cannot be read or is not of this format; the error names it.
pub(super) fn read_truth(file: &Path) -> Result<LabelSet, LabelError> {
    let text = text(file, LONGEST)?;
    if text.trim_start().starts_with('[') {
        return Err(LabelError::new(LabelFault::OnlyResults, file));
    }
    let (mut set, annotations) = data_set(&text, file)?;
    add(&mut set, annotations, false)?;
    Ok(set)
}

/// Reads predictions: a list of results that refer to the picture numbers of `truth`, or a data set
/// whose annotations have scores.
///
/// # Errors
/// When a file cannot be read or is not of this format; the error names it.
pub(super) fn read_predicted(file: &Path, truth: &LabelSet) -> Result<LabelSet, LabelError> {
    let text = text(file, LONGEST)?;
    let (mut set, annotations) = if text.trim_start().starts_with('[') {
        let mut set = LabelSet::empty(LabelFormat::Coco, file);
        set.categories = truth.categories.clone();
        set.numbers = truth.numbers.clone();
        (set, parse(&text, file)?)
    } else {
        data_set(&text, file)?
    };
    add(&mut set, annotations, true)?;
    Ok(set)
}

fn parse<'a, T: Deserialize<'a>>(text: &'a str, file: &Path) -> Result<T, LabelError> {
    serde_json::from_str(text).map_err(|error| LabelError::new(LabelFault::NotCoco(error), file))
}

/// Reads a data set. Returns its pictures and categories, without boxes, and its annotations.
fn data_set(text: &str, file: &Path) -> Result<(LabelSet, Vec<Annotation>), LabelError> {
    let DataSet { images, annotations, mut categories } = parse(text, file)?;
    if categories.len() > MOST_CLASSES {
        let what = LabelFault::TooManyClasses { count: categories.len(), named: "categories" };
        return Err(LabelError::new(what, file));
    }
    let mut set = LabelSet::empty(LabelFormat::Coco, file);
    categories.sort_by_key(|category| category.id);
    for (class, category) in categories.into_iter().enumerate() {
        set.categories.insert(category.id, class);
        set.names.push(category.name);
    }
    let stem = |name: &str| {
        let stem = Path::new(name).file_stem();
        stem.map_or(name.to_owned(), |stem| stem.to_string_lossy().into_owned())
    };
    let stems: HashSet<String> = images.iter().map(|image| stem(&image.file_name)).collect();
    for image in &images {
        // Pictures with the same name in several folders keep the folder in their name.
        let name = if stems.len() == images.len() {
            stem(&image.file_name)
        } else {
            image.file_name.clone()
        };
        set.numbers.entry(name.clone()).or_insert(name.clone());
        set.numbers.insert(image.id.to_string(), name.clone());
        let size_px = image.width.zip(image.height).map(Into::into);
        let picture = PictureLabels { size_px, labels: Vec::new() };
        set.pictures.insert(name, picture);
    }
    Ok((set, annotations))
}

/// Adds boxes to the pictures that they belong to.
fn add(
    set: &mut LabelSet,
    annotations: Vec<Annotation>,
    predicted: bool,
) -> Result<(), LabelError> {
    let file = set.path.clone();
    for (index, annotation) in annotations.into_iter().enumerate() {
        let refuse = |what: &str| {
            let number = index + 1;
            let what = what.to_owned();
            Err(LabelError::new(LabelFault::Annotation { number, what }, &file))
        };
        let number = annotation.image_id.to_string();
        // Without numbers (the true boxes are in YOLO labels) the number is the name.
        let name = match set.numbers.get(&number) {
            Some(name) => name.clone(),
            None if set.numbers.is_empty() => number,
            None => return refuse(&format!("there is no picture {number}")),
        };
        let class = if set.categories.is_empty() {
            usize::try_from(annotation.category_id).ok().filter(|&class| class < MOST_CLASSES)
        } else {
            set.categories.get(&annotation.category_id).copied()
        };
        let Some(class) = class else {
            return refuse(&format!("there is no category {}", annotation.category_id));
        };
        let score = annotation.score.filter(|score| predicted && (0.0..=1.0).contains(score));
        if predicted && score.is_none() {
            return refuse("a predicted box needs a score from 0 to 1");
        }
        let [x, y, width, height] = annotation.bbox;
        if !annotation.bbox.iter().all(|edge| edge.is_finite()) || width < 0.0 || height < 0.0 {
            return refuse("its bbox is [left, top, width, height] in pixels");
        }
        let label = Label {
            class,
            score: score.map(|score| score as f32),
            ignored: annotation.iscrowd == 1 && !predicted,
            rect: Rect::new([x as f32, y as f32], [(x + width) as f32, (y + height) as f32]),
        };
        set.pictures.entry(name).or_default().labels.push(label);
    }
    Ok(())
}

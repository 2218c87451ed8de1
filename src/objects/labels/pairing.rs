//! Brings true and predicted boxes of the same pictures together.

use super::{LabelError, LabelFault, LabelFormat, LabelSet, PictureLabels};
use crate::metrics::{Image, TrueBox};
use crate::{Rect, Scored, TILE_PX};

/// Pictures with their true and predicted boxes, ready for [`crate::metrics`].
#[derive(Clone, Debug, PartialEq)]
pub struct Paired {
    /// Names of the pictures, one for each of `images`.
    pub names: Vec<String>,
    /// Boxes of each picture, in pixels.
    pub images: Vec<Image>,
    /// Name of each class; its number where no name is known.
    pub classes: Vec<String>,
    /// Notes for the analyst, in sentences.
    pub notes: Vec<String>,
}

/// Brings the true and the predicted boxes of each picture together. A picture that only one of the
/// two sets has gets no boxes from the other.
///
/// # Errors
/// When there are predicted boxes, but no picture is in both sets.
pub fn pair(truth: &LabelSet, predicted: &LabelSet) -> Result<Paired, LabelError> {
    let shared = |name: &&String| truth.pictures.contains_key(*name);
    if predicted.boxes() > 0 && !predicted.pictures.keys().any(|name| shared(&name)) {
        return Err(LabelError::new(LabelFault::OtherPictures, &predicted.path));
    }
    let mut notes = Vec::new();
    let alone: Vec<&String> = predicted.pictures.keys().filter(|name| !shared(name)).collect();
    if let [first, ..] = &alone[..] {
        notes.push(format!(
            "{} predicted pictures have no truth and count as empty, the first of them {first}",
            alone.len()
        ));
    }
    let mut names: Vec<String> = truth.pictures.keys().chain(alone).cloned().collect();
    names.sort();
    let (mut images, mut unsized_pictures) = (Vec::with_capacity(names.len()), 0);
    for name in &names {
        let pictures = [truth.pictures.get(name), predicted.pictures.get(name)];
        let size_px = pictures.iter().flatten().find_map(|picture| picture.size_px);
        unsized_pictures += usize::from(size_px.is_none());
        images.push(image(truth, predicted, pictures, size_px));
    }
    if unsized_pictures > 0 && truth.format == LabelFormat::Yolo {
        notes.push(format!(
            "{unsized_pictures} pictures lie beside no labels; sizes count in pictures of {TILE_PX} x {TILE_PX} pixels"
        ));
    }
    Ok(Paired { classes: classes(truth, predicted), names, images, notes })
}

fn image(
    truth: &LabelSet,
    predicted: &LabelSet,
    pictures: [Option<&PictureLabels>; 2],
    size_px: Option<[u32; 2]>,
) -> Image {
    let size_px = size_px.unwrap_or([TILE_PX as u32; 2]);
    let [true_ones, proposed] =
        pictures.map(|picture| picture.into_iter().flat_map(|picture| &picture.labels));
    Image {
        truth: true_ones
            .map(|label| TrueBox {
                class: label.class,
                rect: pixels(label.rect, truth.format, size_px),
                ignored: label.ignored,
            })
            .collect(),
        predicted: proposed
            .map(|label| {
                let rect = pixels(label.rect, predicted.format, size_px);
                Scored::new(label.class, label.score.unwrap_or(0.0), rect)
            })
            .collect(),
    }
}

fn pixels(rect: Rect, format: LabelFormat, [width, height]: [u32; 2]) -> Rect {
    let (width, height) = match format {
        LabelFormat::Yolo => (width as f32, height as f32),
        LabelFormat::Coco => (1.0, 1.0),
    };
    Rect::new([rect.x0 * width, rect.y0 * height], [rect.x1 * width, rect.y1 * height])
}

/// Returns a name for every class that has a name or a box.
fn classes(truth: &LabelSet, predicted: &LabelSet) -> Vec<String> {
    let names = if truth.names.is_empty() { &predicted.names } else { &truth.names };
    let used = [truth, predicted]
        .into_iter()
        .flat_map(|set| set.pictures.values())
        .flat_map(|picture| &picture.labels)
        .map(|label| label.class + 1)
        .max();
    let count = names.len().max(used.unwrap_or(0));
    (0..count).map(|class| names.get(class).cloned().unwrap_or_else(|| class.to_string())).collect()
}

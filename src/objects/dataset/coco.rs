//! Labels as COCO tools read them: one JSON file for many pictures.

use super::PictureBoxes;
use crate::{Labelled, TILE_PX};
use serde::Serialize;

/// A COCO file of object boxes. Category ids count from 1, in the order of the class names; ignored
/// boxes are written with `iscrowd` 1, which COCO's rule neither rewards nor punishes.
#[derive(Clone, Debug, Serialize)]
pub struct Coco {
    images: Vec<CocoImage>,
    annotations: Vec<Annotation>,
    categories: Vec<Category>,
}

#[derive(Clone, Debug, Serialize)]
struct CocoImage {
    id: usize,
    file_name: String,
    width: usize,
    height: usize,
}

#[derive(Clone, Debug, Serialize)]
struct Annotation {
    id: usize,
    image_id: usize,
    category_id: usize,
    /// Left, top, width, height, pixels.
    bbox: [f32; 4],
    area: f32,
    iscrowd: u8,
    /// The outline as `x, y, x, y, ...`, where it is known.
    #[serde(skip_serializing_if = "Option::is_none")]
    segmentation: Option<[Vec<f32>; 1]>,
}

#[derive(Clone, Debug, Serialize)]
struct Category {
    id: usize,
    name: String,
}

impl Coco {
    /// A file without pictures.
    pub fn new<'a>(class_names: impl IntoIterator<Item = &'a str>) -> Self {
        let categories = class_names.into_iter().enumerate();
        Self {
            images: Vec::new(),
            annotations: Vec::new(),
            categories: categories
                .map(|(index, name)| Category { id: index + 1, name: name.to_owned() })
                .collect(),
        }
    }

    /// Adds a picture (its name relative to the folder of pictures) and its boxes.
    pub fn add(&mut self, file_name: String, boxes: &PictureBoxes) {
        let id = self.images.len() + 1;
        self.images.push(CocoImage { id, file_name, width: TILE_PX, height: TILE_PX });
        for (group, iscrowd) in [(&boxes.labels, 0), (&boxes.ignored, 1)] {
            for (index, Labelled { class, rect }) in group.iter().enumerate() {
                let outline = boxes.outlines.get(index).filter(|_| iscrowd == 0);
                self.annotations.push(Annotation {
                    id: self.annotations.len() + 1,
                    image_id: id,
                    category_id: class + 1,
                    bbox: [rect.x0, rect.y0, rect.x1 - rect.x0, rect.y1 - rect.y0],
                    area: rect.area(),
                    iscrowd,
                    segmentation: outline
                        .filter(|outline| !outline.is_empty())
                        .map(|outline| [outline.concat()]),
                });
            }
        }
    }
}

//! Makes pictures with known boxes, to train and judge detectors on: chips, and label files for
//! other tools.
//!
//! In: tiles of a survey, and the objects known in them. Out: pictures, and texts of labels.
//!
//! A chip is a tile with the boxes that a detector should find in it; YOLO, COCO and Pascal VOC
//! tools read the labels. The same code serves simulated surveys and reviewed ones.

use super::{Labelled, Mark, Raster, RasterTile, Rect, TILE_PX, level};
use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use image::{ExtendedColorType, ImageEncoder as _};
use serde::Serialize;
use std::fmt::Write as _;

/// Least share of an object that must lie in a tile for the object to have a label there.
pub(crate) const LEAST_SHARE: f32 = 0.4;
/// Least width and height of a box, pixels.
pub(crate) const LEAST_PX: f32 = 6.0;
/// The edges of a tile, in its own pixels.
const FRAME: Rect = Rect::new([0.0, 0.0], [TILE_PX as f32, TILE_PX as f32]);

/// An object whose place is known.
#[derive(Clone, Debug, PartialEq)]
pub struct KnownObject {
    /// Index into the class names.
    pub class: usize,
    /// Box around the visible part of its echo and its shadow.
    pub whole: Mark,
    /// True if any part of the object is visible. An object that a person has seen is visible.
    pub shown: bool,
    /// Part of the object on each ping, in the order of the pings; empty where only its box is
    /// known.
    pub slices: Vec<Slice>,
}

/// Part of an object on one ping.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Slice {
    /// Index of the ping.
    pub ping: usize,
    /// Nearest slant range of the object on this ping, metres.
    pub near_m: f64,
    /// Farthest slant range of the object on this ping, metres.
    pub far_m: f64,
    /// Contribution to the object's visibility: if the sum over the object is at least 1, an
    /// observer distinguishes the object from chance.
    pub visibility: f32,
}

/// The part of an object in a tile.
///
/// A tile's edge may cut an object. If its slices are known, the box is drawn around the slices in
/// the tile: if the upper half of a slanting pipe is cut away, the box is around the lower half
/// only.
#[derive(Clone, Debug, PartialEq)]
struct ObjectPart {
    /// Box around the part, in the tile's pixels.
    rect: Rect,
    /// Outline of the part as a polygon of columns and rows; empty where only the object's box is
    /// known.
    outline: Vec<[f32; 2]>,
    /// Share of the object that lies in this part: of its visibility, or of the area of its box.
    share: f32,
    /// True if the part is visible.
    shown: bool,
}

impl ObjectPart {
    /// Returns true if a detector can be expected to find the part: it is visible, at least 6
    /// pixels wide and high, and holds at least 40 % of the object. If the object is known ping by
    /// ping, the slices in the tile must be visible by themselves.
    fn is_plain(&self) -> bool {
        let large = (self.rect.x1 - self.rect.x0).min(self.rect.y1 - self.rect.y0) >= LEAST_PX;
        self.shown && large && self.share >= LEAST_SHARE
    }
}

impl KnownObject {
    /// Returns true if a detector can be expected to find the whole object, by the rule of
    /// [`ObjectPart::is_plain`].
    pub fn is_plain(&self, raster: &Raster) -> bool {
        let rect = raster.rect_of(&self.whole);
        self.part(rect, 1.0).is_plain()
    }

    /// Returns the part of the object that lies in a tile of its side; `None` if no part does.
    fn part_in(&self, tile: &RasterTile, raster: &Raster) -> Option<ObjectPart> {
        let place = |mark: &Mark| {
            let rect = raster.rect_of(mark);
            rect.shifted(-(tile.column as f32), -(tile.row as f32))
        };
        let whole = place(&self.whole);
        let inside = whole.intersection(&FRAME);
        if inside.area() <= 0.0 {
            return None;
        }
        if self.slices.is_empty() {
            return Some(self.part(inside, inside.area() / whole.area()));
        }
        let rows = self.slices.iter().filter_map(|slice| {
            let pings = slice.ping..slice.ping + 1;
            let row = place(&Mark::new(self.whole.side, pings, [slice.near_m, slice.far_m]));
            let cut = row.intersection(&FRAME);
            (cut.area() > 0.0).then(|| (cut, slice.visibility * cut.area() / row.area()))
        });
        self.part_of_rows(&rows.collect::<Vec<_>>())
    }

    /// Returns the part of the object that these rows form; each row comes with the visibility that
    /// remains of it. `None` if there are no rows, as in a gap.
    fn part_of_rows(&self, rows: &[(Rect, f32)]) -> Option<ObjectPart> {
        let (first, others) = rows.split_first()?;
        let around = others.iter().fold(first.0, |sum, (row, _)| sum.hull(row));
        let visibility: f32 = rows.iter().map(|(_, visibility)| visibility).sum();
        let all: f32 = self.slices.iter().map(|slice| slice.visibility).sum();
        Some(ObjectPart {
            outline: outline(rows),
            shown: self.shown && visibility >= 1.0,
            ..self.part(around, visibility / all)
        })
    }

    fn part(&self, rect: Rect, share: f32) -> ObjectPart {
        ObjectPart { rect, outline: Vec::new(), share, shown: self.shown }
    }
}

/// Returns the outline of some rows: down their near edges, and up their far edges.
fn outline(rows: &[(Rect, f32)]) -> Vec<[f32; 2]> {
    let near = rows.iter().flat_map(|(row, _)| [[row.x0, row.y0], [row.x0, row.y1]]);
    let far = rows.iter().rev();
    let far = far.flat_map(|(row, _)| [[row.x1, row.y1], [row.x1, row.y0]]);
    near.chain(far).collect()
}

/// A tile with its grey levels adjusted ([`level`]), and its boxes.
#[derive(Clone, Debug, PartialEq)]
pub struct Chip {
    /// [`TILE_PX`] rows of [`TILE_PX`] grey levels.
    pub pixels: Vec<u8>,
    /// Boxes of the objects in it.
    pub boxes: PictureBoxes,
}

/// The boxes of a picture, in its pixels.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PictureBoxes {
    /// Boxes (echo and shadow) that a detector should find.
    pub labels: Vec<Labelled>,
    /// The outline of each label as a polygon of columns and rows; empty where only its box is
    /// known.
    pub outlines: Vec<Vec<[f32; 2]>>,
    /// Boxes that a detector may find or not: cut off by the tile's edge, or too small or faint to
    /// be seen.
    pub ignored: Vec<Labelled>,
}

impl Chip {
    /// Labels a tile, then adjusts its grey levels. An object gets a label if a detector can be
    /// expected to find its part in the tile ([`ObjectPart::is_plain`]); other objects that reach
    /// into the tile get an ignored box.
    pub fn new(mut tile: RasterTile, raster: &Raster, known: &[KnownObject]) -> Self {
        let mut boxes = PictureBoxes::default();
        for object in known.iter().filter(|object| object.whole.side == tile.side) {
            let Some(part) = object.part_in(&tile, raster) else {
                continue;
            };
            let label = Labelled { class: object.class, rect: part.rect };
            if part.is_plain() {
                boxes.labels.push(label);
                boxes.outlines.push(part.outline);
            } else {
                boxes.ignored.push(label);
            }
        }
        level(&mut tile.pixels);
        Self { pixels: tile.pixels, boxes }
    }

    /// Returns the picture as PNG: 8-bit grey, compressed fast. Each row is written as its
    /// difference from the row before, since one ping is much like the last: without this, speckle
    /// hardly compresses.
    pub fn png(&self) -> Vec<u8> {
        let mut bytes = Vec::new();
        let encoder =
            PngEncoder::new_with_quality(&mut bytes, CompressionType::Fast, FilterType::Up);
        let side = TILE_PX as u32;
        // Writing to memory cannot fail, and the number of pixels is right for the size.
        encoder.write_image(&self.pixels, side, side, ExtendedColorType::L8).ok();
        bytes
    }
}

/// Returns the labels as lines `class cx cy w h`, one a box; centre and size are shares of the
/// picture.
pub fn yolo_lines(labels: &[Labelled]) -> String {
    let mut text = String::new();
    let side = TILE_PX as f32;
    for Labelled { class, rect } in labels {
        let [cx, cy] = [rect.x0 + rect.x1, rect.y0 + rect.y1].map(|sum| 0.5 * sum / side);
        let [width, height] = [rect.x1 - rect.x0, rect.y1 - rect.y0].map(|size| size / side);
        // Writing to a string cannot fail.
        writeln!(text, "{class} {cx:.6} {cy:.6} {width:.6} {height:.6}").ok();
    }
    text
}

/// COCO file of object boxes. Category ids count from 1, in the order of the class names; ignored
/// boxes have `iscrowd` 1, which COCO's rule neither rewards nor punishes.
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
    /// Outline as `x, y, x, y, ...`; `None` where it is unknown.
    #[serde(skip_serializing_if = "Option::is_none")]
    segmentation: Option<[Vec<f32>; 1]>,
}

#[derive(Clone, Debug, Serialize)]
struct Category {
    id: usize,
    name: String,
}

impl Coco {
    /// Creates a file with these categories and without pictures.
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

/// Returns the labels of a picture as Pascal VOC XML: pixels are counted from 1, edges included, as
/// in VOC; ignored boxes are `difficult`.
pub fn voc_xml(file_name: &str, class_names: &[String], boxes: &PictureBoxes) -> String {
    let mut text = format!(
        "<annotation>\n<filename>{}</filename>\n<size><width>{TILE_PX}</width><height>{TILE_PX}</height><depth>1</depth></size>\n<segmented>0</segmented>\n",
        escaped(file_name)
    );
    for (list, difficult) in [(&boxes.labels, 0), (&boxes.ignored, 1)] {
        for Labelled { class, rect } in list {
            let name = class_names.get(*class).map_or("object", String::as_str);
            let least = |edge: f32| edge.round().max(0.0) as u32 + 1;
            let most = |edge: f32| (edge.round().max(1.0) as u32).min(TILE_PX as u32);
            let cut = |low: f32, high: f32| u8::from(low <= 0.0 || high >= TILE_PX as f32);
            let truncated = cut(rect.x0, rect.x1).max(cut(rect.y0, rect.y1));
            // Writing to a string cannot fail.
            writeln!(
                text,
                "<object><name>{}</name><truncated>{truncated}</truncated><difficult>{difficult}</difficult><bndbox><xmin>{}</xmin><ymin>{}</ymin><xmax>{}</xmax><ymax>{}</ymax></bndbox></object>",
                escaped(name),
                least(rect.x0),
                least(rect.y0),
                most(rect.x1),
                most(rect.y1),
            )
            .ok();
        }
    }
    text.push_str("</annotation>\n");
    text
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::survey;
    use bathyscope_log::survey::Side;

    fn rect(x0: f32, y0: f32, x1: f32, y1: f32) -> Rect {
        Rect { x0, y0, x1, y1 }
    }

    /// Creates a pipe that leads away from the boat: it is on 20 pings from ping 100 on, each 0.2 m
    /// farther out and 0.4 m wide, each with 0.16 of the visibility.
    fn pipe(shown: bool, slices: bool) -> KnownObject {
        let near_m = |ping: usize| 1.0 + 0.2 * (ping - 100) as f64;
        KnownObject {
            class: 2,
            whole: Mark::new(Side::Port, 100..120, [near_m(100), near_m(119) + 0.4]),
            shown,
            slices: (100..120)
                .filter(|_| slices)
                .map(|ping| Slice {
                    ping,
                    near_m: near_m(ping),
                    far_m: near_m(ping) + 0.4,
                    visibility: 0.16,
                })
                .collect(),
        }
    }

    /// Returns the part of an object in the tile that starts `pings` pings before ping 100, the
    /// first ping of the object; if negative, the tile starts after it.
    fn part(known: &KnownObject, pings: isize) -> Option<ObjectPart> {
        let (survey, navigation) = survey(300, |_, _| 0);
        let raster = Raster::new(&survey, &navigation, 0.04);
        let row = raster.row_of((100 - pings) as f64) as usize;
        known.part_in(&raster.tile(&survey, Side::Port, row, 0), &raster)
    }

    #[test]
    fn a_cut_object_has_the_box_of_what_is_left() {
        let close = |a: Rect, b: Rect| {
            let off = [a.x0 - b.x0, a.y0 - b.y0, a.x1 - b.x1, a.y1 - b.y1];
            assert!(off.iter().all(|off| off.abs() < 1.0), "{a:?} for {b:?}");
        };
        // Five rows of pixels to a ping, 25 columns to a metre.
        let whole = part(&pipe(true, true), 20).expect("in the tile");
        close(whole.rect, rect(25.0, 100.0, 130.0, 200.0));
        assert_eq!(whole.outline.len(), 4 * 20);
        assert!(whole.is_plain());
        // The upper half is cut away, and with it the near half of the box; a sliver of the ping
        // before is left.
        let lower = part(&pipe(true, true), -10).expect("in the tile");
        close(lower.rect, rect(70.0, 0.0, 130.0, 50.0));
        assert!(lower.is_plain());
        // For a box that somebody drew, the place of the object in it is unknown: the box itself is
        // cut.
        let drawn = part(&pipe(true, false), -10).expect("in the tile");
        close(drawn.rect, rect(25.0, 0.0, 130.0, 50.0));
        assert!(drawn.is_plain() && drawn.outline.is_empty());
        assert_eq!(part(&pipe(true, true), -30), None);
    }

    #[test]
    fn what_is_too_little_or_drowns_in_the_speckle_is_not_asked_for() {
        // Seven of twenty pings are less than 40 % of the object.
        assert!(!part(&pipe(true, true), -13).expect("a part").is_plain());
        assert!(part(&pipe(true, true), -11).expect("a part").is_plain());
        assert!(!part(&pipe(false, true), 20).expect("a part").is_plain());
        // The whole object is visible, half of it is not.
        let mut faint = pipe(true, true);
        faint.slices.iter_mut().for_each(|slice| slice.visibility = 0.08);
        assert!(part(&faint, 20).expect("a part").is_plain());
        assert!(!part(&faint, -10).expect("a part").is_plain());
    }

    #[test]
    fn yolo_and_coco_tell_the_same_boxes() {
        let label = |class, rect| Labelled { class, rect };
        let boxes = PictureBoxes {
            labels: vec![
                label(2, rect(104.0, 0.0, 312.0, 208.0)),
                label(0, rect(10.5, 20.25, 30.0, 416.0)),
            ],
            outlines: vec![vec![[104.0, 0.0], [104.0, 208.0], [312.0, 99.5]], vec![]],
            ignored: vec![label(1, rect(1.0, 2.0, 3.0, 5.0))],
        };
        let yolo = yolo_lines(&boxes.labels);
        assert!(yolo.starts_with("2 0.500000 0.250000 0.500000 0.500000\n"), "{yolo}");
        let mut coco = Coco::new(["rock", "block", "tyre"]);
        coco.add("000000.png".into(), &PictureBoxes::default());
        coco.add("000001.png".into(), &boxes);
        let json = serde_json::to_value(&coco).unwrap();
        let annotations = json["annotations"].as_array().unwrap();
        for (line, annotation) in yolo.lines().zip(annotations) {
            let numbers: Vec<f64> = line.split(' ').map(|word| word.parse().unwrap()).collect();
            let bbox: Vec<f64> = annotation["bbox"]
                .as_array()
                .unwrap()
                .iter()
                .map(|v| v.as_f64().unwrap())
                .collect();
            assert_eq!(annotation["category_id"].as_f64(), Some(numbers[0] + 1.0));
            assert_eq!(annotation["image_id"], 2);
            for axis in 0..2 {
                let side = TILE_PX as f64;
                assert!(
                    (numbers[1 + axis] * side - bbox[axis] - 0.5 * bbox[2 + axis]).abs() < 1e-3
                );
                assert!((numbers[3 + axis] * side - bbox[2 + axis]).abs() < 1e-3);
            }
        }
        let crowds: Vec<&serde_json::Value> =
            annotations.iter().map(|annotation| &annotation["iscrowd"]).collect();
        assert_eq!(crowds, [0, 0, 1]);
        assert_eq!(annotations[2]["area"], 6.0);
        let outline = serde_json::json!([[104.0, 0.0, 104.0, 208.0, 312.0, 99.5]]);
        assert_eq!(annotations[0]["segmentation"], outline);
        assert!(annotations[1..].iter().all(|annotation| annotation.get("segmentation").is_none()));
        assert_eq!(json["categories"][2]["name"], "tyre");
    }

    #[test]
    fn edges_count_from_one_and_ignored_boxes_are_difficult() {
        let label = |x0, x1| Labelled { class: 0, rect: Rect::new([x0, 10.0], [x1, 30.0]) };
        let boxes = PictureBoxes {
            labels: vec![label(20.0, 50.0)],
            outlines: Vec::new(),
            ignored: vec![label(400.0, 416.0)],
        };
        let text = voc_xml("1.png", &["rock & co".to_owned()], &boxes);
        assert!(text.contains("<name>rock &amp; co</name><truncated>0</truncated><difficult>0"));
        assert!(text.contains("<xmin>21</xmin><ymin>11</ymin><xmax>50</xmax><ymax>30</ymax>"));
        assert!(text.contains("<truncated>1</truncated><difficult>1"));
        assert!(text.contains("<xmax>416</xmax>"));
    }
}

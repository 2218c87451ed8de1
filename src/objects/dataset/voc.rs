//! Labels as Pascal VOC tools read them: one XML file a picture.

use super::PictureBoxes;
use crate::{Labelled, TILE_PX};
use std::fmt::Write as _;

/// The labels of a picture: pixels counted from 1, edges included, as in VOC; ignored boxes are
/// `difficult`.
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
            // Writing to a string does not fail.
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
    use crate::Rect;

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

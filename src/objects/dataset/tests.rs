use super::*;
use crate::testing::survey;
use crate::{Labelled, Mark, Raster, Rect, TILE_PX};
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

/// Returns the part of an object in the tile that starts `pings` pings before ping 100, the first
/// ping of the object; if negative, the tile starts after it.
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
    // The upper half is cut away, and with it the near half of the box; a sliver of the ping before
    // is left.
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
        let bbox: Vec<f64> =
            annotation["bbox"].as_array().unwrap().iter().map(|v| v.as_f64().unwrap()).collect();
        assert_eq!(annotation["category_id"].as_f64(), Some(numbers[0] + 1.0));
        assert_eq!(annotation["image_id"], 2);
        for axis in 0..2 {
            let side = TILE_PX as f64;
            assert!((numbers[1 + axis] * side - bbox[axis] - 0.5 * bbox[2 + axis]).abs() < 1e-3);
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

use super::visible::{Contrast, Smoothed};
use super::*;
use crate::detection::{Labelled, Rect, TILE_PX};

fn rect(x0: f32, y0: f32, x1: f32, y1: f32) -> Rect {
    Rect { x0, y0, x1, y1 }
}

/// A tile of grey noise between 80 and 119, with a patch of another level.
fn noisy(patch: &Rect, level: u8) -> Vec<u8> {
    let inside = |x: usize, y: usize| {
        let (x, y) = (x as f32, y as f32);
        x >= patch.x0 && x < patch.x1 && y >= patch.y0 && y < patch.y1
    };
    let pixel = |index: usize| {
        let noise = (index.wrapping_mul(2_654_435_761) >> 7) % 40;
        if inside(index % TILE_PX, index / TILE_PX) {
            level
        } else {
            80 + noise as u8
        }
    };
    (0..TILE_PX * TILE_PX).map(pixel).collect()
}

#[test]
fn an_echo_or_a_shadow_is_seen_and_level_ground_is_not() {
    let echo = rect(200.0, 100.0, 215.0, 130.0);
    let shadow = rect(215.0, 100.0, 250.0, 130.0);
    let whole = echo.hull(&shadow);
    let contrast =
        |patch: &Rect, level| Contrast::of(&Smoothed::new(&noisy(patch, level)), &echo, &whole);
    let bright = contrast(&echo, 140);
    assert!(
        bright.is_seen() && bright.echo.rise > 5.0 && !bright.shadow.is_seen(),
        "{bright:?}"
    );
    let dark = contrast(&shadow, 60);
    assert!(
        dark.is_seen() && dark.shadow.rise > 5.0 && !dark.echo.is_seen(),
        "{dark:?}"
    );
    let nothing = contrast(&rect(0.0, 0.0, 0.0, 0.0), 0);
    assert!(!nothing.is_seen(), "{nothing:?}");
}

#[test]
fn yolo_and_coco_tell_the_same_boxes() {
    let label = |class, rect| Labelled { class, rect };
    let boxes = Boxes {
        labels: vec![
            label(2, rect(104.0, 0.0, 312.0, 208.0)),
            label(0, rect(10.5, 20.25, 30.0, 416.0)),
        ],
        ignored: vec![label(1, rect(1.0, 2.0, 3.0, 5.0))],
    };
    let yolo = yolo_lines(&boxes.labels);
    assert!(
        yolo.starts_with("2 0.500000 0.250000 0.500000 0.500000\n"),
        "{yolo}"
    );
    let mut coco = Coco::new(["rock", "block", "tyre"]);
    coco.add("000000.png".into(), &Boxes::default());
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
            assert!((numbers[1 + axis] * side - bbox[axis] - 0.5 * bbox[2 + axis]).abs() < 1e-3);
            assert!((numbers[3 + axis] * side - bbox[2 + axis]).abs() < 1e-3);
        }
    }
    let crowds: Vec<&serde_json::Value> = annotations.iter().map(|one| &one["iscrowd"]).collect();
    assert_eq!(crowds, [0, 0, 1]);
    assert_eq!(annotations[2]["area"], 6.0);
    assert_eq!(json["categories"][2]["name"], "tyre");
}

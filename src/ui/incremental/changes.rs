//! Finds the areas of the window that differ between two frames.

use egui::epaint::ClippedShape;
use egui::{Pos2, Rect, Shape, TextureId};
use std::collections::HashSet;

/// Most areas that are drawn apart: beyond, one that holds them all costs less.
const MOST_AREAS: usize = 24;

/// An area of whole pixels; its ends are excluded.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct PixelArea {
    pub min: [i32; 2],
    pub max: [i32; 2],
}

impl PixelArea {
    /// The pixels that a rectangle touches.
    fn around(rect: Rect, pixels_per_point: f32) -> Self {
        let low = |at: f32| (at * pixels_per_point).floor() as i32;
        let high = |at: f32| (at * pixels_per_point).ceil() as i32;
        Self { min: [low(rect.min.x), low(rect.min.y)], max: [high(rect.max.x), high(rect.max.y)] }
    }

    /// Its rectangle, points.
    pub(super) fn rect(&self, pixels_per_point: f32) -> Rect {
        let corner = |[x, y]: [i32; 2]| Pos2::new(x as f32, y as f32) / pixels_per_point;
        Rect::from_min_max(corner(self.min), corner(self.max))
    }

    /// Returns true if two areas share a pixel.
    pub(super) fn overlaps(&self, other: &Self) -> bool {
        (0..2).all(|axis| self.min[axis] < other.max[axis] && other.min[axis] < self.max[axis])
    }

    fn union(&self, other: &Self) -> Self {
        Self {
            min: [0, 1].map(|axis| self.min[axis].min(other.min[axis])),
            max: [0, 1].map(|axis| self.max[axis].max(other.max[axis])),
        }
    }

    fn pixels(&self) -> i64 {
        let side = |axis: usize| i64::from(self.max[axis]) - i64::from(self.min[axis]);
        side(0) * side(1)
    }

    /// Returns true if drawing both as one costs no more than drawing them apart: about a quarter
    /// more pixels.
    fn joins(&self, other: &Self) -> bool {
        let apart = self.pixels() + other.pixels();
        self.overlaps(other) || 4 * self.union(other).pixels() <= 5 * apart
    }
}

/// Pixels that a shape can cover, soft edges included; `None` where it covers none.
pub(super) fn covered(shape: &ClippedShape, pixels_per_point: f32) -> Option<PixelArea> {
    let sharp_corners = match &shape.shape {
        Shape::Path(path) => path.stroke.width,
        _ => 0.0,
    };
    let bounds = shape.shape.visual_bounding_rect().expand(sharp_corners);
    let reach = (shape.transform_after_tessellation * bounds).expand(1.0 / pixels_per_point);
    let rect = reach.intersect(shape.clip_rect);
    bounds
        .is_finite()
        .then(|| PixelArea::around(rect, pixels_per_point))
        .filter(|area| area.min[0] < area.max[0] && area.min[1] < area.max[1])
}

/// The areas, none over another, outside of which two frames look the same. `textures` are those
/// with new content.
pub(super) fn changed(
    before: &[ClippedShape],
    now: &[ClippedShape],
    textures: &HashSet<TextureId>,
    pixels_per_point: f32,
) -> Vec<PixelArea> {
    let mut areas = Areas::default();
    let mut add = |shape: &ClippedShape| areas.add(covered(shape, pixels_per_point));
    let [runs_before, runs_now] = [before, now].map(runs);
    let has_same_clip = |a: &&[ClippedShape], b: &&[ClippedShape]| a[0].clip_rect == b[0].clip_rect;
    let aligned = align(&runs_before, &runs_now, has_same_clip);
    for run in aligned.removed.iter().chain(aligned.added) {
        run.iter().for_each(&mut add);
    }
    for (before, now) in aligned.pairs {
        let is_one_to_one = before.len() == now.len();
        let shapes = align(before, now, |a, b| is_one_to_one || is_same(a, b, textures));
        shapes.removed.iter().chain(shapes.added).for_each(&mut add);
        for (before, now) in shapes.pairs {
            if is_one_to_one && !is_same(before, now, textures) {
                add(before);
                add(now);
            }
        }
    }
    areas.apart
}

/// Shapes that follow each other with one clip rectangle.
fn runs(shapes: &[ClippedShape]) -> Vec<&[ClippedShape]> {
    shapes.chunk_by(|a, b| a.clip_rect == b.clip_rect).collect()
}

/// Two sequences, the beginnings and the ends of which belong together.
struct Aligned<'a, T> {
    pairs: Vec<(&'a T, &'a T)>,
    removed: &'a [T],
    added: &'a [T],
}

fn align<'a, T>(
    before: &'a [T],
    now: &'a [T],
    belong_together: impl Fn(&T, &T) -> bool,
) -> Aligned<'a, T> {
    let head = (before.iter().zip(now)).take_while(|(a, b)| belong_together(a, b)).count();
    let [left_before, left_now] = [&before[head..], &now[head..]];
    let tail = (left_before.iter().rev().zip(left_now.iter().rev()))
        .take_while(|(a, b)| belong_together(a, b))
        .count();
    let (removed, tail_before) = left_before.split_at(left_before.len() - tail);
    let (added, tail_now) = left_now.split_at(left_now.len() - tail);
    let pairs = before[..head].iter().zip(now);
    Aligned { pairs: pairs.chain(tail_before.iter().zip(tail_now)).collect(), removed, added }
}

/// Returns true if two shapes are drawn alike.
fn is_same(before: &ClippedShape, now: &ClippedShape, textures: &HashSet<TextureId>) -> bool {
    !reads(&now.shape, textures) && before == now
}

/// Returns true if a shape shows one of the textures, or one that another owner can draw into at
/// any time.
fn reads(shape: &Shape, textures: &HashSet<TextureId>) -> bool {
    match shape {
        Shape::Vec(shapes) => shapes.iter().any(|shape| reads(shape, textures)),
        shape => match shape.texture_id() {
            TextureId::User(_) => true,
            managed => textures.contains(&managed),
        },
    }
}

/// Areas none of which lies over another.
#[derive(Default)]
struct Areas {
    apart: Vec<PixelArea>,
}

impl Areas {
    fn add(&mut self, area: Option<PixelArea>) {
        let Some(mut area) = area else {
            return;
        };
        while let Some(near) = self.apart.iter().position(|other| other.joins(&area)) {
            area = area.union(&self.apart.swap_remove(near));
        }
        self.apart.push(area);
        if self.apart.len() > MOST_AREAS {
            let whole = self.apart.drain(..).reduce(|a, b| a.union(&b));
            self.apart.extend(whole);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use egui::{Color32, vec2};
    use proptest::{collection::vec, prelude::*};

    fn square(at: [f32; 2], clip: Rect, colour: Color32) -> ClippedShape {
        let rect = Rect::from_min_size(at.into(), vec2(10.0, 10.0));
        ClippedShape::new(clip, Shape::rect_filled(rect, 0.0, colour))
    }

    fn clip(x: f32) -> Rect {
        Rect::from_min_size(Pos2::new(x, 0.0), vec2(100.0, 100.0))
    }

    fn areas(before: &[ClippedShape], now: &[ClippedShape]) -> Vec<[i32; 4]> {
        let mut areas: Vec<[i32; 4]> = changed(before, now, &HashSet::new(), 1.0)
            .iter()
            .map(|area| [area.min[0], area.min[1], area.max[0], area.max[1]])
            .collect();
        areas.sort_unstable();
        areas
    }

    #[test]
    fn a_frame_like_the_one_before_changes_nothing() {
        let frame = [square([10.0, 10.0], clip(0.0), Color32::RED)];
        assert_eq!(areas(&frame, &frame), Vec::<[i32; 4]>::new());
    }

    #[test]
    fn a_shape_that_moves_changes_where_it_was_and_where_it_is() {
        let [left, right] = [clip(0.0), clip(200.0)];
        let still = square([210.0, 10.0], right, Color32::BLUE);
        let before = [square([10.0, 10.0], left, Color32::RED), still.clone()];
        let now = [square([70.0, 70.0], left, Color32::RED), still];
        let expected = vec![[9, 9, 21, 21], [69, 69, 81, 81]];
        assert_eq!(areas(&before, &now), expected);
    }

    #[test]
    fn shapes_that_are_added_move_no_others() {
        let [left, right] = [clip(0.0), clip(200.0)];
        let first = square([10.0, 10.0], left, Color32::RED);
        let last = square([60.0, 60.0], left, Color32::RED);
        let beside = square([210.0, 10.0], right, Color32::BLUE);
        let added = square([40.0, 10.0], left, Color32::GREEN);
        let before = [first.clone(), last.clone(), beside.clone()];
        let now = [first.clone(), added.clone(), last.clone(), beside.clone()];
        assert_eq!(areas(&before, &now), [[39, 9, 51, 21]]);
        // And with a part of the window that was not there before.
        let other = ClippedShape { clip_rect: clip(20.0), ..added };
        let now = [first, last, other, beside];
        assert_eq!(areas(&before, &now), [[39, 9, 51, 21]]);
    }

    #[test]
    fn shapes_that_change_their_order_are_drawn_again() {
        let [a, b] = [[10.0, 10.0], [15.0, 15.0]];
        let below = square(a, clip(0.0), Color32::RED);
        let above = square(b, clip(1.0), Color32::BLUE);
        let changed = areas(&[below.clone(), above.clone()], &[above, below]);
        assert_eq!(changed, [[9, 9, 26, 26]]);
    }

    #[test]
    fn a_texture_with_new_content_changes_what_shows_it() {
        let shown = |id| {
            let mut mesh = egui::Mesh::with_texture(id);
            mesh.add_rect_with_uv(clip(0.0), clip(0.0), Color32::WHITE);
            [ClippedShape::new(clip(0.0), Shape::mesh(mesh))]
        };
        let [new, old] = [TextureId::Managed(3), TextureId::Managed(4)];
        let textures = HashSet::from([new]);
        let count = |frame: &[ClippedShape]| changed(frame, frame, &textures, 1.0).len();
        assert_eq!([count(&shown(new)), count(&shown(old))], [1, 0]);
    }

    proptest! {
        #[test]
        fn many_areas_become_few_and_none_lies_over_another(
            corners in vec((0..1200, 0..700, 1..90, 1..90), 1..400),
        ) {
            let mut areas = Areas::default();
            let all: Vec<PixelArea> = (corners.into_iter())
                .map(|(x, y, width, height)| PixelArea { min: [x, y], max: [x + width, y + height] })
                .collect();
            all.iter().for_each(|area| areas.add(Some(*area)));
            prop_assert!(areas.apart.len() <= MOST_AREAS);
            let is_held =
                |area: &PixelArea| areas.apart.iter().any(|kept| kept.union(area) == *kept);
            prop_assert!(all.iter().all(is_held));
            for (index, area) in areas.apart.iter().enumerate() {
                prop_assert!(!areas.apart[..index].iter().any(|earlier| earlier.overlaps(area)));
            }
        }
    }
}

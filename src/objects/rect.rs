//! Boxes in a picture's pixels.

/// An axis-parallel box. `x` grows with slant range, `y` along the track; pixel `i` covers `i` to
/// `i + 1`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rect {
    /// Near edge.
    pub x0: f32,
    /// First edge along the track.
    pub y0: f32,
    /// Far edge.
    pub x1: f32,
    /// Last edge along the track.
    pub y1: f32,
}

/// A box of known class.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Labelled {
    /// Index into the class names.
    pub class: usize,
    /// Edges of the box.
    pub rect: Rect,
}

/// A box that a detector proposes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scored {
    /// Index into the class names.
    pub class: usize,
    /// Score, 0 to 1.
    pub score: f32,
    /// Edges of the box.
    pub rect: Rect,
}

impl Scored {
    /// A box of a class.
    pub const fn new(class: usize, score: f32, rect: Rect) -> Self {
        Self { class, score, rect }
    }
}

impl Rect {
    /// A box by the corners with its least and its greatest coordinates.
    pub const fn new([x0, y0]: [f32; 2], [x1, y1]: [f32; 2]) -> Self {
        Self { x0, y0, x1, y1 }
    }

    /// Width times height; 0 for a box that is inside out.
    pub fn area(&self) -> f32 {
        (self.x1 - self.x0).max(0.0) * (self.y1 - self.y0).max(0.0)
    }

    /// Returns the intersection of two boxes; inside out (area 0) when they do not meet.
    pub fn intersection(&self, other: &Rect) -> Rect {
        Self::new(
            [self.x0.max(other.x0), self.y0.max(other.y0)],
            [self.x1.min(other.x1), self.y1.min(other.y1)],
        )
    }

    /// The smallest box around both.
    pub fn hull(&self, other: &Rect) -> Rect {
        Self::new(
            [self.x0.min(other.x0), self.y0.min(other.y0)],
            [self.x1.max(other.x1), self.y1.max(other.y1)],
        )
    }

    /// Intersection over union, 0 to 1; 0 for two boxes without area.
    pub fn iou(&self, other: &Rect) -> f32 {
        let shared = self.intersection(other).area();
        let union = self.area() + other.area() - shared;
        if union > 0.0 { shared / union } else { 0.0 }
    }

    /// The box moved.
    pub(crate) fn shifted(&self, dx: f32, dy: f32) -> Rect {
        Self::new([self.x0 + dx, self.y0 + dy], [self.x1 + dx, self.y1 + dy])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn iou_is_shared_area_over_joint_area() {
        let rect = |x0, y0, x1, y1| Rect { x0, y0, x1, y1 };
        let a = rect(0.0, 0.0, 4.0, 2.0);
        assert_eq!(a.iou(&rect(2.0, 0.0, 6.0, 2.0)), 4.0 / 12.0);
        assert_eq!(a.iou(&a), 1.0);
        assert_eq!(a.iou(&rect(4.0, 0.0, 6.0, 2.0)), 0.0);
        assert_eq!(a.iou(&rect(5.0, 5.0, 4.0, 4.0)), 0.0);
    }
}

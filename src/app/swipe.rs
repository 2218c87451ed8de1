//! Divides the map to compare layers: a divider, and the side of it on which each layer is drawn.

use super::{LayerStack, MapLayer};
use serde::{Deserialize, Serialize};

/// Side of the divider on which a layer is drawn while the map is divided.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum SwipeSide {
    /// Both sides.
    #[default]
    Both,
    /// Left of the divider only.
    Left,
    /// Right of the divider only.
    Right,
}

bathyscope_log::named! {
    /// All sides in the order of the menu.
    pub SwipeSide {
        Left: "left",
        Both: "both",
        Right: "right",
    }
}

/// The division of the map.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Swipe {
    /// True if the map is divided.
    pub on: bool,
    /// Position of the divider, as a share of the map's width.
    pub share: f32,
    /// Layers that are drawn on one side only.
    sides: Vec<(MapLayer, SwipeSide)>,
}

impl Default for Swipe {
    /// Creates an undivided map, whose division shows the mosaic on the left and the depths on the
    /// right.
    fn default() -> Self {
        Self {
            on: false,
            share: 0.5,
            sides: vec![
                (MapLayer::Mosaic, SwipeSide::Left),
                (MapLayer::DepthMap, SwipeSide::Right),
                (MapLayer::HillShade, SwipeSide::Right),
            ],
        }
    }
}

impl Swipe {
    /// Returns the side of the divider on which a layer is drawn.
    pub fn side(&self, layer: MapLayer) -> SwipeSide {
        let found = self.sides.iter().find(|(other, _)| *other == layer);
        found.map_or(SwipeSide::Both, |(_, side)| *side)
    }

    /// Draws a layer on `side` from now on.
    pub(crate) fn set_side(&mut self, layer: MapLayer, side: SwipeSide) {
        self.sides.retain(|(other, _)| *other != layer);
        if side != SwipeSide::Both {
            self.sides.push((layer, side));
        }
    }

    /// Moves the divider by a share of the map's width, within the map.
    pub fn shift(&mut self, by: f32) {
        self.share = if self.share.is_finite() { (self.share + by).clamp(0.02, 0.98) } else { 0.5 };
    }

    /// Divides the map, or makes it whole. If no layer of a side is visible, the first layer of
    /// that side is shown.
    pub fn toggle(&mut self, stack: &mut LayerStack) {
        self.on = !self.on;
        for side in [SwipeSide::Left, SwipeSide::Right] {
            let own = || self.sides.iter().filter(|(_, other)| *other == side);
            let seen = own().any(|(layer, _)| stack.is_visible(*layer));
            if let (true, false, Some((layer, _))) = (self.on, seen, own().next()) {
                stack.set_visible(*layer, true);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_divided_map_shows_something_else_on_either_side() {
        let mut stack = LayerStack::default();
        for layer in MapLayer::ALL {
            stack.set_visible(layer, false);
        }
        let mut swipe = Swipe::default();
        swipe.toggle(&mut stack);
        assert!(
            swipe.on && stack.is_visible(MapLayer::Mosaic) && stack.is_visible(MapLayer::DepthMap)
        );
        assert!(!stack.is_visible(MapLayer::HillShade), "one of them is enough");
        swipe.toggle(&mut stack);
        assert!(!swipe.on);
    }

    #[test]
    fn a_layer_lies_on_the_side_it_was_put_on() {
        let mut swipe = Swipe::default();
        assert_eq!(swipe.side(MapLayer::Track), SwipeSide::Both);
        swipe.set_side(MapLayer::Track, SwipeSide::Right);
        swipe.set_side(MapLayer::Track, SwipeSide::Left);
        assert_eq!(swipe.side(MapLayer::Track), SwipeSide::Left);
        swipe.set_side(MapLayer::Track, SwipeSide::Both);
        assert_eq!(swipe.side(MapLayer::Track), SwipeSide::Both);
        for by in [5.0, -9.0] {
            swipe.shift(by);
            assert!((0.0..=1.0).contains(&swipe.share));
        }
        let text = serde_json::to_string(&swipe).unwrap();
        assert_eq!(serde_json::from_str::<Swipe>(&text).unwrap(), swipe);
    }
}

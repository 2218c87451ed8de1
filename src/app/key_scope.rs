//! Views in which the bare key of an action acts: a key without Ctrl and Alt that is no function
//! key, and could be part of a text.

use super::{Action, View};

/// View or panel that has the keyboard.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum KeyFocus {
    /// One of the views of the centre.
    View(View),
    /// A control of the panel in which boxes are reviewed: its buttons, its lists.
    Review,
}

/// Views and panels in which a bare key acts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum KeyScope {
    /// Every view.
    Views,
    /// Every view and the review of boxes.
    Boxes,
    /// The waterfall and the review of boxes.
    BoxesInWaterfall,
    /// The waterfall.
    Waterfall,
    /// The waterfall and the map.
    WaterfallAndMap,
    /// The map.
    Map,
    /// The 3D view.
    Cloud,
}

impl KeyScope {
    /// All of them.
    #[cfg(test)]
    pub const ALL: [KeyScope; 7] = [
        KeyScope::Views,
        KeyScope::Boxes,
        KeyScope::BoxesInWaterfall,
        KeyScope::Waterfall,
        KeyScope::WaterfallAndMap,
        KeyScope::Map,
        KeyScope::Cloud,
    ];

    /// Returns true if the key acts while this has the keyboard.
    pub fn holds(self, focus: KeyFocus) -> bool {
        use KeyFocus::{Review, View as In};
        use View::{Cloud, Map, Waterfall};
        match self {
            KeyScope::Views => matches!(focus, In(_)),
            KeyScope::Boxes => true,
            KeyScope::BoxesInWaterfall => matches!(focus, In(Waterfall) | Review),
            KeyScope::Waterfall => focus == In(Waterfall),
            KeyScope::WaterfallAndMap => matches!(focus, In(Waterfall | Map)),
            KeyScope::Map => focus == In(Map),
            KeyScope::Cloud => focus == In(Cloud),
        }
    }

    /// Returns the phrase that follows the key in the manual.
    pub fn name(self) -> &'static str {
        match self {
            KeyScope::Views => "in each view",
            KeyScope::Boxes => "in each view and the review",
            KeyScope::BoxesInWaterfall => "in the waterfall and the review",
            KeyScope::Waterfall => "in the waterfall",
            KeyScope::WaterfallAndMap => "in the waterfall and on the map",
            KeyScope::Map => "on the map",
            KeyScope::Cloud => "in the 3D cloud",
        }
    }
}

/// Returns true if a key of the table could be part of a text: no Ctrl, no Alt, no function key.
pub fn is_bare(keys: &str) -> bool {
    let is_function_key = |key: &str| {
        let number = key.strip_prefix('F');
        number.is_some_and(|number| number.parse::<u8>().is_ok())
    };
    let mut names = keys.split('+');
    !names.any(|name| matches!(name, "Ctrl" | "Alt") || is_function_key(name))
}

impl Action {
    /// Returns the scope of the action's bare key; `None` where it has no such key.
    pub fn key_scope(self) -> Option<KeyScope> {
        use Action as A;
        Some(match self {
            A::FocusWaterfall | A::FocusMap | A::FocusCloud | A::FocusObjects => KeyScope::Boxes,
            A::Fit | A::ZoomIn | A::ZoomOut | A::Theme | A::Boxes => KeyScope::Views,
            A::Play | A::PreviousPing | A::NextPing | A::Back25 | A::Forward25 => KeyScope::Views,
            A::FirstPing | A::LastPing | A::NextPass | A::LeaveTool | A::SwapSides => {
                KeyScope::Views
            }
            A::NextBox | A::PreviousBox | A::NextSighting | A::FlyToBox | A::ZoomToBoxes => {
                KeyScope::Boxes
            }
            A::AcceptBox | A::RejectBox | A::UndecideBox | A::RemoveBox => KeyScope::Boxes,
            A::AcceptObject | A::RejectObject | A::UndecideObject => KeyScope::Boxes,
            A::NextMistake | A::PreviousMistake => KeyScope::Boxes,
            A::EditBox | A::NextEdge | A::SwapSide | A::UseShadow => KeyScope::BoxesInWaterfall,
            A::GainNormalised | A::GroundRange | A::WaterColumn | A::OneToOne => {
                KeyScope::Waterfall
            }
            A::NextChannel | A::Orientation | A::FirstReturnLine => KeyScope::Waterfall,
            A::ThresholdDown | A::ThresholdUp => KeyScope::Waterfall,
            A::NewBox | A::MarkTarget | A::DrawBottom | A::HeightFromShadow => KeyScope::Waterfall,
            A::Exclude | A::IncludeAgain | A::Calibrate => KeyScope::WaterfallAndMap,
            A::MeasureDistance | A::MeasureArea | A::DepthProfile => KeyScope::WaterfallAndMap,
            A::SetCorner | A::TakeCornerBack | A::EndFigure => KeyScope::WaterfallAndMap,
            A::Swipe | A::PlanLines => KeyScope::Map,
            A::TopView | A::SideView | A::NextCloudColour | A::Bottom3d => KeyScope::Cloud,
            A::NextBottomColour | A::TurnLight | A::Points3d | A::ClipBox3d => KeyScope::Cloud,
            A::Cut3d | A::Water3d | A::OutlierPreview => KeyScope::Cloud,
            _ => return None,
        })
    }

    /// Returns true if its bare key only offers it, with a button that does it: it changes depths
    /// or places of the whole log, and a slip of the hand must not.
    pub(crate) fn asks_by_key(self) -> bool {
        matches!(self, Action::SwapSides)
    }

    /// Returns true if it decides about the selected box or changes it, so that the box must be in
    /// sight.
    pub(crate) fn is_about_selected_box(self) -> bool {
        use Action as A;
        matches!(
            self,
            A::AcceptBox
                | A::RejectBox
                | A::UndecideBox
                | A::RemoveBox
                | A::SwapSide
                | A::AcceptObject
                | A::RejectObject
                | A::UndecideObject
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_bare_key_has_a_scope_and_no_other_key_has() {
        for action in Action::ALL {
            let has_bare_key = action.all_keys().any(is_bare);
            let label = action.label();
            assert_eq!(action.key_scope().is_some(), has_bare_key, "{label}");
            assert!(has_bare_key || !action.asks_by_key(), "{label}");
        }
    }

    #[test]
    fn keys_that_could_be_typed_are_bare() {
        for keys in ["A", "Shift+A", "[", "+", "=", "Tab", "F", "Shift+F", "1"] {
            assert!(is_bare(keys), "{keys}");
        }
        for keys in ["Ctrl+A", "Ctrl+Shift+A", "F2", "F11", "Shift+F11", "Alt+X"] {
            assert!(!is_bare(keys), "{keys}");
        }
    }

    #[test]
    fn each_scope_holds_somewhere_and_the_narrow_ones_not_everywhere() {
        let views = View::ALL.map(KeyFocus::View);
        let everywhere = [views.as_slice(), &[KeyFocus::Review]].concat();
        for scope in KeyScope::ALL {
            let held = everywhere.iter().filter(|focus| scope.holds(**focus));
            let count = held.count();
            assert!(count > 0, "{scope:?}");
            assert_eq!(count == everywhere.len(), scope == KeyScope::Boxes, "{scope:?}");
        }
    }
}

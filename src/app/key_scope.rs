//! Defines the views in which the bare key of an action acts. A bare key has no Ctrl and no Alt and
//! is no function key, so that it could be part of a text.

use super::View;

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

#[cfg(test)]
bathyscope_log::listed! {
    /// All scopes.
    pub KeyScope { Views, Boxes, BoxesInWaterfall, Waterfall, WaterfallAndMap, Map, Cloud }
}

impl KeyScope {
    /// Returns true if a key of this scope acts while `focus` has the keyboard.
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

#[cfg(test)]
mod tests {
    use super::*;

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

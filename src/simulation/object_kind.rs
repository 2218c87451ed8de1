//! The kinds of objects that a scene may hold.

use bathyscope_log::named;
use serde::{Deserialize, Serialize};

/// Kind of an object.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ObjectKind {
    /// A rounded, bumpy boulder.
    Rock,
    /// A crate or block with steep sides and a flat top.
    Block,
    /// A pipe or drum lying on its side.
    Cylinder,
    /// A tyre lying flat: a ring.
    Tyre,
    /// A sunken boat, open or keel up; its bow points along the heading.
    Boat,
    /// A tree trunk with branches, tapering and bent.
    Log,
    /// A body: head, torso and limbs.
    Effigy,
}

named! {
    /// All kinds, in the order of a detector's classes.
    pub ObjectKind {
        Rock: "rock",
        Block: "block",
        Cylinder: "cylinder",
        Tyre: "tyre",
        Boat: "boat",
        Log: "log",
        Effigy: "effigy",
    }
}

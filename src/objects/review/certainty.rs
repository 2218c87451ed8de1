//! The certainty of the analyst.

use bathyscope_log::named;
use serde::{Deserialize, Serialize};

/// The certainty of the analyst that there is an object, and of what it is: a word of their own,
/// beside the score of a model.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Certainty {
    /// It may be something else, or nothing.
    Unsure,
    /// More likely than not.
    Probable,
    /// No doubt.
    Certain,
}

named! {
    /// All of them, the least sure first.
    pub Certainty {
        Unsure: "unsure",
        Probable: "probable",
        Certain: "certain",
    }
}

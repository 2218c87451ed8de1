//! How sure the analyst is of an object.

use serde::{Deserialize, Serialize};

/// How sure the analyst is that there is an object, and of what it is: a word of their own, beside the score of a model.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Confidence {
    /// It may be something else, or nothing.
    Unsure,
    /// More likely than not.
    Probable,
    /// No doubt.
    Certain,
}

impl Confidence {
    /// All of them, the least sure first.
    pub const ALL: [Confidence; 3] = [
        Confidence::Unsure,
        Confidence::Probable,
        Confidence::Certain,
    ];

    /// `unsure`, `probable` or `certain`.
    pub fn name(self) -> &'static str {
        match self {
            Confidence::Unsure => "unsure",
            Confidence::Probable => "probable",
            Confidence::Certain => "certain",
        }
    }
}

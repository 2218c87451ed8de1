//! Reads and writes the reason of a stretch as text: the reason of its exclusion, or `kept` where
//! it counts.

use super::ExclusionReason;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

/// The reason of a stretch that counts.
#[derive(Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
enum Included {
    Kept,
}

#[derive(Serialize, Deserialize)]
#[serde(untagged, expecting = "a reason is `turn`, `stop`, `bad`, `drawn` or `kept`")]
enum Verdict {
    Excluded(ExclusionReason),
    Included(Included),
}

pub(super) fn serialize<S: Serializer>(
    reason: &Option<ExclusionReason>,
    to: S,
) -> Result<S::Ok, S::Error> {
    let verdict = reason.map_or(Verdict::Included(Included::Kept), Verdict::Excluded);
    verdict.serialize(to)
}

pub(super) fn deserialize<'de, D: Deserializer<'de>>(
    from: D,
) -> Result<Option<ExclusionReason>, D::Error> {
    Ok(match Verdict::deserialize(from)? {
        Verdict::Excluded(reason) => Some(reason),
        Verdict::Included(Included::Kept) => None,
    })
}

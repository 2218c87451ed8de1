//! Finds false positions and soundings in a recording before results are computed from them.
//!
//! A position is checked against the positions before and after it and the speed of the boat, a
//! sounding against its neighbours along the track. A value that contradicts these by more than
//! their errors is false: it does not count, and a sentence reports when, how many and why. The
//! rules are in metres of track and in the log's own intervals and speeds, so that they apply to
//! recorders of any rate; times in seconds only limit how far apart compared values may be.

mod fixes;
mod soundings;

pub(crate) use fixes::drop_false_fixes;
pub(crate) use soundings::{NEAREST_SOUNDING_S, give_depths, mark_faults_from};
pub use soundings::{differ_as_no_bed, is_step_of_no_bed, mark_faults};

use crate::named;
use serde::ser::{Serialize, SerializeMap, Serializer};

/// The reason why a sounding does not count.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SoundingFault {
    /// The recorder had lost the bottom: the depths jump up and down.
    LostBottom,
    /// The depth is between a leap far below the bottom and the leap back.
    FarBelow,
    /// The depth differs alone from the depths before and after it.
    Glitch,
    /// The depth is from the echo that went to the bottom twice: it is twice that of the first
    /// returns of both sides.
    SecondEcho,
    /// The recorder repeats its last depth while the first returns of both sides change.
    Held,
}

named! {
    /// All faults, in the order of [`FaultCounts`].
    pub SoundingFault {
        LostBottom: "lost bottom",
        FarBelow: "far below the bottom",
        Glitch: "glitch",
        SecondEcho: "second echo",
        Held: "held depth",
    }
}

impl SoundingFault {
    /// Returns the sign of the fault as the end of a sentence about several soundings.
    pub fn sentence(self) -> &'static str {
        match self {
            Self::LostBottom => "jump up and down (the recorder had lost the bottom)",
            Self::FarBelow => "lie between a leap far below the bottom and the leap back",
            Self::Glitch => "depart from those before and after them",
            Self::SecondEcho => {
                "are twice as deep as the first returns of both sides (the recorder took the second echo of the bottom)"
            }
            Self::Held => {
                "stay the same while the first returns of both sides move (the recorder had lost the bottom and wrote its last depth)"
            }
        }
    }
}

/// Number of soundings with each fault.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct FaultCounts([usize; SoundingFault::ALL.len()]);

impl FaultCounts {
    /// Counts faults.
    pub fn of(faults: impl IntoIterator<Item = SoundingFault>) -> Self {
        let mut counts = Self::default();
        for fault in faults {
            counts.0[fault as usize] += 1;
        }
        counts
    }

    /// Adds the counts of another log.
    pub fn add(&mut self, other: &Self) {
        for (count, more) in self.0.iter_mut().zip(other.0) {
            *count += more;
        }
    }

    /// Returns the number of soundings with any fault.
    pub fn all(&self) -> usize {
        self.0.iter().sum()
    }

    /// Returns the faults that occur, with their numbers of soundings.
    pub fn found(&self) -> impl Iterator<Item = (SoundingFault, usize)> + '_ {
        let counts = SoundingFault::ALL.into_iter().map(|fault| (fault, self.0[fault as usize]));
        counts.filter(|(_, count)| *count > 0)
    }

    /// Describes the counts in words: "83 lost bottom, 12 glitch".
    pub fn summary(&self) -> String {
        let each = self.found().map(|(fault, count)| format!("{count} {}", fault.name()));
        each.collect::<Vec<_>>().join(", ")
    }
}

/// Writes a map from the name of each fault that occurs to its number of soundings.
impl Serialize for FaultCounts {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(None)?;
        for (fault, count) in self.found() {
            map.serialize_entry(fault.name(), &count)?;
        }
        map.end()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn faults_are_counted_by_their_names() {
        use SoundingFault::{Glitch, Held, LostBottom};
        let mut counts = FaultCounts::of([Glitch, Held, Glitch]);
        counts.add(&FaultCounts::of([LostBottom]));
        assert_eq!(counts.all(), 4);
        assert_eq!(counts.summary(), "1 lost bottom, 2 glitch, 1 held depth");
        assert_eq!(FaultCounts::default().summary(), "");
    }
}

//! Correction of an error that all positions of a log share.

use super::mounting::ways_in_words;
use serde::{Deserialize, Serialize};

/// `position_shift.*` settings: of one log each. A receiver without corrections is off by a metre
/// or two, which changes little in an hour: what crossings with other logs show of it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct PositionShift {
    /// Added to every position, metres to the east.
    pub east_m: f64,
    /// Added to every position, metres to the north.
    pub north_m: f64,
}

impl PositionShift {
    /// East and north, metres; `None` where nothing is moved.
    pub(crate) fn by_m(&self) -> Option<[f64; 2]> {
        let by_m = [self.east_m, self.north_m];
        (by_m != [0.0; 2]).then_some(by_m)
    }

    /// Describes the shift of the positions in a sentence; empty where there is none.
    pub fn statement(&self) -> String {
        let ways = [["east", "west"], ["north", "south"]];
        let by = ways_in_words([self.east_m, self.north_m], ways, |m| format!("{m} m"));
        if by.is_empty() { by } else { format!("Positions are moved by {by}.") }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_shift_is_said_in_words() {
        let shift = |east_m, north_m| PositionShift { east_m, north_m };
        assert_eq!(shift(0.0, 0.0).statement(), "");
        let said = shift(1.25, -0.5).statement();
        assert_eq!(said, "Positions are moved by 1.25 m east and 0.5 m south.");
        assert_eq!(shift(-2.0, 0.0).statement(), "Positions are moved by 2 m west.");
    }
}

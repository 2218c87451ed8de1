//! Edits the stretches in which an analyst accepts first returns above the recorded depth as
//! bottom: these first returns stay where they were found.

use super::{BottomEdit, BottomSettings};
use bathyscope_log::survey::Side;

impl BottomEdit {
    /// Creates the edit that accepts the first returns of these pings as bottom where they were
    /// found.
    fn accepted(side: Side, pings: [usize; 2]) -> Self {
        Self { side, pings, corners: Vec::new(), accepted: true }
    }
}

impl BottomSettings {
    /// Returns the settings with the first returns of these pings accepted as bottom where they
    /// were found; manual picks in these pings stay.
    pub fn accepting(&self, side: Side, pings: [usize; 2]) -> Self {
        let drawn = self.lines.iter().filter(|line| !line.accepted && line.side == side);
        let whole = vec![BottomEdit::accepted(side, pings)];
        let parts = drawn.fold(whole, |parts, line| {
            let cut = |part: BottomEdit| {
                let meets = part.pings[0] <= line.pings[1] && part.pings[1] >= line.pings[0];
                let rest = meets.then(|| part.outside(line.pings));
                let whole = (!meets).then_some(part);
                whole.into_iter().chain(rest.into_iter().flatten())
            };
            parts.into_iter().flat_map(cut).collect()
        });
        parts.into_iter().fold(self.clone(), |all, part| all.with(part))
    }

    /// Returns the settings with no first return of these pings accepted; manual picks in these
    /// pings stay.
    pub fn not_accepting(&self, side: Side, pings: [usize; 2]) -> Self {
        let accepted = BottomSettings {
            lines: (self.lines.iter().filter(|line| line.accepted)).cloned().collect(),
            ..*self
        };
        let rest = accepted.without(side, pings).lines;
        rest.into_iter().fold(self.drawn_only(), |all, part| all.with(part))
    }

    /// Returns the settings with the manual picks alone: no first return is accepted.
    pub fn drawn_only(&self) -> Self {
        let lines = self.lines.iter().filter(|line| !line.accepted);
        Self { lines: lines.cloned().collect(), ..*self }
    }

    /// Returns true if first returns of any stretch were accepted as bottom.
    pub fn has_accepted(&self) -> bool {
        self.lines.iter().any(|line| line.accepted)
    }

    /// Returns the number of pings whose first returns were accepted as bottom, each side counted.
    pub fn accepted_count(&self) -> usize {
        self.count(true)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::first_return::{FirstReturns, Pick};
    use bathyscope_log::survey::{SidePing, SideSpan, Survey};

    #[test]
    fn an_accepted_stretch_is_bottom_where_it_was_found_and_leaves_what_was_drawn() {
        let recorded = SidePing {
            port: Some(SideSpan::of_bytes(100, [0.0, 10.0])),
            ..SidePing::with_depth(0.0, 3.0)
        };
        let survey = Survey::of_pings(vec![recorded; 40]);
        let flagged = Pick { sample: 24.0, confidence: 0.02, above_bottom: true };
        let drawn = BottomSettings::of(&survey).with(BottomEdit {
            corners: vec![[10.0, 2.0], [13.0, 2.0]],
            accepted: false,
            ..BottomEdit::accepted(Side::Port, [10, 12])
        });
        let all = drawn.accepting(Side::Port, [5, 20]);
        assert_eq!(all.check(), Ok(()));
        assert_eq!((all.ping_count(), all.accepted_count()), (3, 13));
        assert_eq!(all.drawn_only(), drawn);
        let mut returns = FirstReturns {
            port: vec![flagged; 40].into(),
            starboard: vec![Pick::NONE; 40].into(),
            ..FirstReturns::default()
        };
        all.apply(&survey, &mut returns);
        for (ping, pick) in returns.port.iter().enumerate() {
            assert_eq!(pick.above_bottom, !(5..=20).contains(&ping), "{ping}");
        }
        assert_eq!(returns.port[7].sample, flagged.sample, "it stays in its place");
        assert!(returns.port[7].confidence > 0.6, "{:?}", returns.port[7]);
        assert_eq!(returns.port[11].sample, 20.0, "what was drawn stays");
        assert!(!returns.is_drawn(Side::Port, 7) && returns.is_drawn(Side::Port, 11));
        // The edits can be removed again, and written and read.
        assert_eq!(all.without(Side::Port, [0, 39]).lines, []);
        let text = toml::to_string(&all).expect("text");
        assert_eq!(toml::from_str::<BottomSettings>(&text), Ok(all));
    }
}

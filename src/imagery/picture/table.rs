//! The scales and factors of all pings as texels, for the reductions that tiles are drawn at.

use super::PingScales;
use crate::survey::Side;

/// Texels `[altitude, scale, offset, factor of the stripe filter]`, port and starboard of a ping beside each other, first of all pings,
/// then of all pairs of pings, and so on to a single one.
#[derive(Clone, Debug, PartialEq)]
pub struct PingTable {
    texels: Vec<[f32; 4]>,
    /// Where the pings of each reduction begin, in pairs of texels.
    starts: Vec<u32>,
    pings: usize,
}

impl PingTable {
    /// Of the scales and factors of a log; without factors they are 1.
    pub fn new(scales: &PingScales, factors: Option<&[Vec<f32>; 2]>) -> Self {
        let pings = scales.side(Side::Port).len();
        let texel = |side: Side, ping: usize| {
            let scale = scales.at(side, ping);
            let factor = factors.and_then(|factors| factors[side as usize].get(ping));
            let factor = factor.copied().unwrap_or(1.0);
            [scale.altitude_m, scale.scale, scale.offset_m, factor]
        };
        // The reductions together have as many pings as the log, and a few where counts are odd.
        let mut texels = Vec::with_capacity(4 * pings + 2 * usize::BITS as usize);
        texels.extend((0..pings).flat_map(|ping| Side::BOTH.map(|side| texel(side, ping))));
        let (mut starts, mut from, mut count) = (vec![0], 0, pings);
        while count > 1 {
            let next = count.div_ceil(2);
            starts.push((from + count) as u32);
            for pair in 0..next {
                for side in 0..2 {
                    let at = |ping: usize| texels[2 * (from + ping.min(count - 1)) + side];
                    let (one, other) = (at(2 * pair), at(2 * pair + 1));
                    texels.push(std::array::from_fn(|part| 0.5 * (one[part] + other[part])));
                }
            }
            from += count;
            count = next;
        }
        Self {
            texels,
            starts,
            pings,
        }
    }

    /// All texels.
    pub fn texels(&self) -> &[[f32; 4]] {
        &self.texels
    }

    /// The pair of texels of the `2^halvings` pings from `ping` on; the last one beyond the end.
    pub fn pair(&self, halvings: u8, ping: usize) -> u32 {
        let level = usize::from(halvings).min(self.starts.len() - 1);
        let count = self.pings.div_ceil(1 << level).max(1);
        self.starts[level] + (ping >> level).min(count - 1) as u32
    }

    /// How many pairs follow each other from there within the reduction, itself included.
    pub fn pairs_from(&self, halvings: u8, ping: usize) -> u32 {
        let level = usize::from(halvings).min(self.starts.len() - 1);
        let count = self.pings.div_ceil(1 << level).max(1);
        (count - (ping >> level).min(count - 1)) as u32
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::survey::{SidePing, Survey};

    fn table(pings: usize) -> PingTable {
        let ping = SidePing::with_depth(0.0, f32::NAN);
        let survey = Survey::of_pings(vec![ping; pings]);
        let scales = PingScales::unknown(&survey);
        let port: Vec<f32> = (0..pings).map(|ping| ping as f32).collect();
        PingTable::new(&scales, Some(&[port, vec![1.0; pings]]))
    }

    #[test]
    fn a_reduction_holds_the_means_of_its_pings() {
        let table = table(5);
        let factor = |halvings, ping| table.texels()[2 * table.pair(halvings, ping) as usize][3];
        assert_eq!([factor(0, 3), factor(0, 4), factor(0, 9)], [3.0, 4.0, 4.0]);
        assert_eq!([factor(1, 0), factor(1, 2), factor(1, 4)], [0.5, 2.5, 4.0]);
        assert_eq!([factor(2, 0), factor(2, 4)], [1.5, 4.0]);
        // Beyond the last reduction.
        assert_eq!(factor(3, 0), factor(9, 4));
        assert_eq!([table.pairs_from(0, 3), table.pairs_from(1, 0)], [2, 3]);
        let none = super::PingTable::new(&PingScales::default(), None);
        assert_eq!((none.pair(0, 7), none.texels().len()), (0, 0));
    }
}

//! The scales and factors of all pings as texels, for the reductions that tiles are drawn at.

use super::PingScales;
use crate::survey::Side;

/// Where the texels of a log's pings lie: `[altitude, scale, offset, factor of the stripe filter]`, port and starboard of a ping beside
/// each other, first of all pings, then of all pairs of pings, and so on to a single one. The texels themselves are made for the GPU and
/// are not kept: a 2 GB log has 40 MB of them.
#[derive(Clone, Debug, PartialEq)]
pub struct PingTable {
    /// Where the pings of each reduction begin, in pairs of texels.
    starts: Vec<u32>,
    pings: usize,
}

impl PingTable {
    /// Of so many pings.
    pub fn new(pings: usize) -> Self {
        let (mut starts, mut from, mut count) = (vec![0], 0, pings);
        while count > 1 {
            from += count;
            starts.push(from as u32);
            count = count.div_ceil(2);
        }
        Self { starts, pings }
    }

    /// All texels, by the scales and factors of the log; without factors they are 1.
    pub fn texels(&self, scales: &PingScales, factors: Option<&[Vec<f32>; 2]>) -> Vec<[f32; 4]> {
        let texel = |side: Side, ping: usize| {
            let scale = scales.at(side, ping);
            let factor = factors.and_then(|factors| factors[side as usize].get(ping));
            let factor = factor.copied().unwrap_or(1.0);
            [scale.altitude_m, scale.scale, scale.offset_m, factor]
        };
        // The reductions together have as many pings as the log, and a few where counts are odd.
        let mut texels = Vec::with_capacity(4 * self.pings + 2 * usize::BITS as usize);
        texels.extend((0..self.pings).flat_map(|ping| Side::BOTH.map(|side| texel(side, ping))));
        for reduction in self.starts.windows(2) {
            let [from, end] = [reduction[0] as usize, reduction[1] as usize];
            for pair in (from..end).step_by(2) {
                for side in 0..2 {
                    let at = |ping: usize| texels[2 * ping.min(end - 1) + side];
                    let (one, other) = (at(pair), at(pair + 1));
                    texels.push(std::array::from_fn(|part| 0.5 * (one[part] + other[part])));
                }
            }
        }
        texels
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

    /// Of pings whose factors to port count up.
    fn texels(table: &PingTable) -> Vec<[f32; 4]> {
        let ping = SidePing::with_depth(0.0, f32::NAN);
        let survey = Survey::of_pings(vec![ping; table.pings]);
        let scales = PingScales::unknown(&survey);
        let port: Vec<f32> = (0..table.pings).map(|ping| ping as f32).collect();
        table.texels(&scales, Some(&[port, vec![1.0; table.pings]]))
    }

    #[test]
    fn a_reduction_holds_the_means_of_its_pings() {
        let table = PingTable::new(5);
        let texels = texels(&table);
        assert_eq!(texels.len(), 2 * (5 + 3 + 2 + 1));
        let factor = |halvings, ping| texels[2 * table.pair(halvings, ping) as usize][3];
        assert_eq!([factor(0, 3), factor(0, 4), factor(0, 9)], [3.0, 4.0, 4.0]);
        assert_eq!([factor(1, 0), factor(1, 2), factor(1, 4)], [0.5, 2.5, 4.0]);
        assert_eq!([factor(2, 0), factor(2, 4)], [1.5, 4.0]);
        // Beyond the last reduction.
        assert_eq!(factor(3, 0), factor(9, 4));
        assert_eq!([table.pairs_from(0, 3), table.pairs_from(1, 0)], [2, 3]);
        let none = PingTable::new(0);
        let texels = none.texels(&PingScales::default(), None);
        assert_eq!((none.pair(0, 7), texels.len()), (0, 0));
    }
}

//! Reduces a layout to the pings that a coarse picture needs.

use super::MosaicLayout;

impl MosaicLayout {
    /// Returns the layout without the pings that a picture with cells of `apart_m` does not need:
    /// between two pings that stay, neither the boat nor the far ends of its swath move farther
    /// than `apart_m`. The ends of every stretch stay. A ping that stays represents the pings that
    /// are nearer to it than to the next one.
    pub fn thinned(&self, apart_m: f64) -> Self {
        let mut chosen: Vec<usize> = Vec::new();
        let mut joined = Vec::new();
        for ping in 0..self.placed.len() {
            let goes_on = self.joined[ping];
            let began = chosen.last().zip(joined.last());
            let last = began.filter(|(_, joined)| **joined).map(|(last, _)| *last);
            let is_near = last.is_some_and(|last| self.moved_m(last, ping) < apart_m);
            if self.placed[ping].is_none() || (is_near && goes_on) {
                continue;
            }
            chosen.push(ping);
            joined.push(goes_on);
        }
        let pick = |ping: &usize| self.pings[*ping];
        let known = |values: &Vec<f32>| -> Vec<f32> {
            let of_ping = |&ping: &usize| values.get(ping).copied().unwrap_or(f32::NAN);
            chosen.iter().map(of_ping).collect()
        };
        Self {
            pings: chosen.iter().map(pick).collect(),
            stands_for: self.nearest_to(&chosen, &joined),
            placed: chosen.iter().map(|&ping| self.placed[ping]).collect(),
            ranges: [0, 1].map(|side| {
                let of_side = |&ping: &usize| self.ranges[side].get(ping).copied().flatten();
                chosen.iter().map(of_side).collect()
            }),
            altitudes_m: self.altitudes_m.each_ref().map(known),
            relief: (self.relief.as_ref())
                .map(|(relief, under_m)| (relief.clone(), under_m.each_ref().map(known))),
            joined,
            water_column: self.water_column,
            far_m: self.far_m,
            shown_m: Default::default(),
            boxes: Vec::new(),
        }
        .boxed()
    }

    /// Returns the range of pings of the survey that each chosen ping represents: from half way to
    /// the one before to half way to the next, within a stretch.
    fn nearest_to(&self, chosen: &[usize], joined: &[bool]) -> Vec<[u32; 2]> {
        let half_way = |index: usize| match (joined.get(index), chosen.get(index + 1)) {
            (Some(true), Some(next)) => Some(chosen[index].midpoint(*next) + 1),
            _ => None,
        };
        let around = (0..chosen.len()).map(|index| {
            let before = index.checked_sub(1).and_then(half_way);
            let from = before.unwrap_or(chosen[index]).min(chosen[index]);
            let to = half_way(index).unwrap_or(chosen[index] + 1);
            [self.pings[from], self.pings[to - 1] + 1]
        });
        around.collect()
    }

    /// Returns the sum of the distances that the boat and an end of its swath move from one ping to
    /// another, metres.
    fn moved_m(&self, from: usize, to: usize) -> f64 {
        let (Some(from), Some(to)) = (self.placed[from], self.placed[to]) else {
            return f64::INFINITY;
        };
        let off = |a: [f64; 2], b: [f64; 2]| (a[0] - b[0]).hypot(a[1] - b[1]);
        off(from.at, to.at) + self.far_m * off(from.starboard, to.starboard)
    }
}

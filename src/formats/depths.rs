//! Which of the recorded depths are the soundings, and which of them each side-scan ping has.

use super::report::Report;
use crate::survey::{ChannelKind, SidePing, Sounding, mark_bottom_lock, nearest_in_time};

/// A side-scan ping takes its depth from the nearest sounding, not from one this far away in time, seconds.
const NEAREST_SOUNDING_S: f64 = 5.0;

/// The depths of one channel, in time order: the traditional sonar's, unless another knows four times as many.
/// All channels repeat the same bottom lock, so that two of them would only say it twice.
pub(super) fn choose(mut depths: Vec<(ChannelKind, Vec<Sounding>)>) -> Vec<Sounding> {
    depths.sort_by_key(|(kind, _)| *kind);
    let most = depths
        .iter()
        .map(|(_, soundings)| soundings.len())
        .max()
        .unwrap_or(0);
    let best = depths.into_iter().find(|(kind, soundings)| {
        let is_down = matches!(
            kind,
            ChannelKind::Primary | ChannelKind::Secondary | ChannelKind::DownScan
        );
        // Side-scan channels ping faster than the lock: their count says nothing against a slower channel.
        soundings.len() * if is_down { 4 } else { 1 } >= most
    });
    let mut soundings = best.map(|(_, soundings)| soundings).unwrap_or_default();
    soundings.sort_by(|a, b| a.time_s.total_cmp(&b.time_s));
    mark_bottom_lock(&mut soundings);
    soundings
}

/// Gives every ping the depth of the sounding nearest in time. Both are in time order.
pub(super) fn give_to(pings: &mut [SidePing], soundings: &[Sounding]) {
    for ping in pings {
        let nearest = nearest_in_time(soundings, ping.time_s, |sounding| sounding.time_s)
            .map(|index| &soundings[index])
            .filter(|sounding| (sounding.time_s - ping.time_s).abs() <= NEAREST_SOUNDING_S);
        ping.depth_m = nearest.map_or(f32::NAN, |sounding| sounding.depth_m);
        ping.depth_locked = nearest.is_some_and(|sounding| sounding.locked);
    }
}

/// Says where the recorder's depth cannot be believed.
pub(super) fn warn_of_lost_bottom(soundings: &[Sounding], report: &Report) {
    let lost = || soundings.iter().filter(|sounding| !sounding.locked);
    let (Some(first), Some(last)) = (lost().next(), lost().next_back()) else {
        return;
    };
    report.log(format!(
        "the recorder had lost the bottom at {} of {} soundings (between {:.0} s and {:.0} s its depth jumps): they are shown, but nothing is measured against them",
        lost().count(),
        soundings.len(),
        first.time_s,
        last.time_s
    ));
}

//! Which of the recorded depths are the soundings, and which of them each side-scan ping has.

use super::report::WarningReport;
use crate::survey::{ChannelKind, Fix, Sounding, mark_bottom_lock};

/// The depths of one channel, in time order: the traditional sonar's, unless another knows four
/// times as many; of the tail of a log those of the channel that was chosen for the log. All
/// channels repeat the same bottom lock, so that two of them would only say it twice.
pub(super) fn choose(
    mut depths: Vec<(ChannelKind, Vec<Sounding>)>,
    chosen: Option<ChannelKind>,
    fixes: &[Fix],
    has_side_scan: bool,
) -> (Option<ChannelKind>, Vec<Sounding>) {
    if let Some(chosen) = chosen {
        depths.retain(|(kind, _)| *kind == chosen);
    }
    depths.sort_by_key(|(kind, _)| *kind);
    let most = depths.iter().map(|(_, soundings)| soundings.len()).max().unwrap_or(0);
    let best = depths.into_iter().find(|(kind, soundings)| {
        let is_down =
            matches!(kind, ChannelKind::Primary | ChannelKind::Secondary | ChannelKind::DownScan);
        // Side-scan channels ping faster than the lock: their count says nothing against a slower
        // channel.
        soundings.len() * if is_down { 4 } else { 1 } >= most
    });
    let (kind, mut soundings) =
        best.map_or((None, Vec::new()), |(kind, depths)| (Some(kind), depths));
    soundings.sort_by(|a, b| a.time_s.total_cmp(&b.time_s));
    mark_bottom_lock(&mut soundings, fixes, has_side_scan);
    (kind, soundings)
}

/// Says where the recorder's depth cannot be believed.
pub(super) fn warn_of_lost_bottom(soundings: &[Sounding], report: &WarningReport) {
    let lost = || soundings.iter().filter(|sounding| !sounding.locked);
    let (Some(first), Some(last)) = (lost().next(), lost().next_back()) else {
        return;
    };
    report.log(format!(
        "the recorder had lost the bottom at {} of {} soundings (between {:.0} s and {:.0} s its depth jumps): they are shown, and count only where a first return confirms them",
        lost().count(),
        soundings.len(),
        first.time_s,
        last.time_s
    ));
}

//! Chooses the soundings among the recorded depths, and warns of false ones.

use super::report::WarningReport;
use crate::survey::{ChannelKind, Fix, Sounding, SoundingFault, mark_faults};

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
    mark_faults(&mut soundings, fixes, has_side_scan);
    (kind, soundings)
}

/// Says which of the recorder's depths are false: a warning for each fault.
pub(super) fn warn_of_lost_bottom(soundings: &[Sounding], report: &WarningReport) {
    for fault in SoundingFault::ALL {
        let mut with = soundings.iter().filter(|sounding| sounding.fault == Some(fault));
        let Some(first) = with.next() else { continue };
        let (count, last) = with.fold((1, first), |(count, _), sounding| (count + 1, sounding));
        report.log(format!(
            "{count} of {} soundings between {:.0} s and {:.0} s {}: they are shown, and count only where a first return confirms them",
            soundings.len(),
            first.time_s,
            last.time_s,
            fault.sentence()
        ));
    }
}

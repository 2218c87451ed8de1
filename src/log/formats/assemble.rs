//! Assembles a [`Survey`] from channels in file order: joins the sides, chooses the soundings,
//! assigns depths by time and recognises noise.

use super::collected::{Collected, CollectedPair, HalfPing, WarningReport};
use super::log_format::Reading;
use crate::support::statistics::upper_median;
use crate::survey::{
    Channel, ChannelKind, Echogram, Fix, KnownTimes, Side, SidePair, SidePing, SideScanState,
    Sounding, SoundingFault, Survey, Track, drop_false_fixes, give_depths, mark_faults,
};
use std::sync::Arc;

/// Warning about positions in metres of a coordinate system that the log does not name.
pub(super) const UNNAMED_SYSTEM: &str = "positions are metres of a coordinate system that the log does not name, and are shown around longitude 0, latitude 0; set source.crs to its EPSG number, EPSG:32633 for UTM zone 33 north";
/// Longest range of stuck pings, metres: Lowrance units without a side-scan transducer record 5 ft
/// of noise (1.524 m), and no unit in use has a range this short.
const STUCK_RANGE_M: f32 = 1.6;
/// Share of stuck pings from which on the side-scan counts as noise.
const STUCK_SHARE: f64 = 0.95;
/// Longest time between two halves of the same ping where no ping rate can be measured, seconds.
const HALVES_TOGETHER_S: f64 = 0.1;

/// Assembles a survey from the parts of a log; for the tail of a log, with the choices that were
/// made for the log before.
pub(super) fn assemble(mut log: Collected, reading: &Reading<'_>) -> Survey {
    let known = reading.known();
    let pairs = show_first(&mut log);
    let mut side_scan = join_sides(&mut log, known);
    let echograms = echograms(&mut log);
    let chosen = known.and_then(|known| known.sounding_channel);
    let fixes = clean_track(&mut log);
    let depths = std::mem::take(&mut log.depths);
    let (sounding_channel, soundings) = choose(depths, chosen, &fixes, !side_scan.is_empty());
    warn_of_lost_bottom(&soundings, &log.report);
    give_depths(&mut side_scan, &soundings);
    let mut swath = std::mem::take(&mut log.swath);
    swath.sort_by(|a, b| a.time_s.total_cmp(&b.time_s));
    let side_scan_state = judge(&side_scan, &mut log);
    if soundings.is_empty() && swath.is_empty() {
        log.report.log("the log holds no depth; heights can only come from the side-scan itself");
    }
    if log.projected.is_some() && !fixes.is_empty() {
        log.report.log(UNNAMED_SYSTEM);
    }
    if fixes.is_empty() {
        log.report.log("the log holds no position; nothing in it can be placed on a map");
    }
    let track = Track {
        projected: log.projected.take(),
        has_assumed_times: !log.has_times,
        ..Track::new(fixes)
    };
    warn_of_lost_fixes(&track, &soundings, &side_scan, &log.report);
    let mut channels: Vec<Channel> = log.channels.into_iter().map(|(_, channel)| channel).collect();
    channels.sort_by(|a, b| (a.kind, &a.recorder_name).cmp(&(b.kind, &b.recorder_name)));
    let mut survey = Survey {
        source: log.source,
        start_unix_s: log.start_unix_s,
        clock_offset_s: 0.0,
        sounding_lag_s: 0.0,
        swapped_sides: false,
        channels,
        side_scan: Arc::new(side_scan),
        pairs: Vec::new(),
        side_scan_state,
        range_source: log.range_source,
        echograms,
        soundings: Arc::new(soundings),
        sounding_channel,
        swath: Arc::new(swath),
        track,
        warnings: Vec::new(),
        bytes: log.bytes,
    };
    survey.pairs = side_pairs(pairs, &survey);
    if let Some(summary) = survey.pairs_summary() {
        log.report.log(summary);
    }
    survey.warnings = log.report.finish();
    survey
}

/// Moves the halves of the first of several pairs to the sides of the log and returns all pairs.
fn show_first(log: &mut Collected) -> Vec<CollectedPair> {
    if let Some(shown) = log.pairs.first_mut() {
        log.port = std::mem::take(&mut shown.port);
        log.starboard = std::mem::take(&mut shown.starboard);
    }
    std::mem::take(&mut log.pairs)
}

/// Returns the pairs of a log that has several; the first pair shares the pings of `survey`.
fn side_pairs(pairs: Vec<CollectedPair>, survey: &Survey) -> Vec<SidePair> {
    if pairs.len() < 2 {
        return Vec::new();
    }
    let pair = |(index, pair): (usize, CollectedPair)| {
        let side_scan = match index {
            0 => survey.side_scan.clone(),
            _ => {
                let mut pings = joined(pair.port, pair.starboard);
                give_depths(&mut pings, &survey.soundings);
                Arc::new(pings)
            }
        };
        SidePair { name: pair.name, frequency_khz: pair.frequency_khz, side_scan }
    };
    pairs.into_iter().enumerate().map(pair).collect()
}

/// Returns the side-scan pings in time order. A unit that records both layouts stores each ping
/// twice: the layout with more pings is kept, and for the tail of a log the layout that was kept
/// for the log before.
fn join_sides(log: &mut Collected, known: Option<&Survey>) -> Vec<SidePing> {
    let composite = std::mem::take(&mut log.composite);
    let port = std::mem::take(&mut log.port);
    let starboard = std::mem::take(&mut log.starboard);
    let halves = port.len().max(starboard.len());
    if !composite.is_empty() && halves > 0 {
        log.report.log(format!(
            "the log holds side-scan twice: {} pings of both sides in one and {halves} of each side apart; the larger is shown",
            composite.len()
        ));
    }
    let is_composite = match known {
        Some(known) => {
            let counts = |kind| {
                let of_kind = known.channels.iter().filter(move |channel| channel.kind == kind);
                of_kind.map(|channel| channel.ping_count).sum::<usize>()
            };
            let halves = counts(ChannelKind::Port).max(counts(ChannelKind::Starboard));
            counts(ChannelKind::Composite) >= halves
        }
        None => composite.len() >= halves,
    };
    let mut pings = if is_composite { composite } else { joined(port, starboard) };
    pings.sort_by(|a, b| a.time_s.total_cmp(&b.time_s));
    pings
}

/// Returns the pings of sides that were recorded separately, in time order.
fn joined(mut port: Vec<HalfPing>, mut starboard: Vec<HalfPing>) -> Vec<SidePing> {
    for halves in [&mut port, &mut starboard] {
        halves.sort_by(|a, b| a.time_s.total_cmp(&b.time_s));
    }
    let mut pings = join_halves(&port, &starboard);
    pings.sort_by(|a, b| a.time_s.total_cmp(&b.time_s));
    pings
}

/// Joins the port and the starboard halves that a recorder writes separately, where both have the
/// same time (within half a ping interval); the other halves become pings with one side.
fn join_halves(port: &[HalfPing], starboard: &[HalfPing]) -> Vec<SidePing> {
    let within_s =
        interval_s(port).or(interval_s(starboard)).map_or(HALVES_TOGETHER_S, |s| s / 2.0);
    let mut pings = Vec::with_capacity(port.len().max(starboard.len()));
    let (mut p, mut s) = (0, 0);
    while let (Some(left), Some(right)) = (port.get(p), starboard.get(s)) {
        let apart_s = apart_s(left, right);
        // A half whose partner is damaged must not be joined with a half of the next ping: of two
        // candidates the closer in time is joined.
        let left_is_alone = nearer(port.get(p + 1), right, apart_s);
        let right_is_alone = nearer(starboard.get(s + 1), left, apart_s);
        let too_far = apart_s > within_s;
        if left_is_alone || (too_far && left.time_s < right.time_s) {
            pings.push(ping(Some(left), None));
            p += 1;
        } else if right_is_alone || too_far {
            pings.push(ping(None, Some(right)));
            s += 1;
        } else {
            pings.push(ping(Some(left), Some(right)));
            p += 1;
            s += 1;
        }
    }
    pings.extend(port[p..].iter().map(|left| ping(Some(left), None)));
    pings.extend(starboard[s..].iter().map(|right| ping(None, Some(right))));
    pings
}

fn apart_s(a: &HalfPing, b: &HalfPing) -> f64 {
    (a.time_s - b.time_s).abs()
}

fn nearer(next: Option<&HalfPing>, other: &HalfPing, than_s: f64) -> bool {
    next.is_some_and(|next| apart_s(next, other) < than_s)
}

fn ping(port: Option<&HalfPing>, starboard: Option<&HalfPing>) -> SidePing {
    let time_s = port.or(starboard).map_or(f64::NAN, |half| half.time_s);
    SidePing {
        port: port.map(|half| half.span),
        starboard: starboard.map(|half| half.span),
        ..SidePing::with_depth(time_s, f32::NAN)
    }
}

/// Returns the median time between pings, seconds; `None` below three pings, or where the median is
/// not positive.
fn interval_s(halves: &[HalfPing]) -> Option<f64> {
    let mut steps: Vec<f64> =
        halves.windows(2).map(|pair| pair[1].time_s - pair[0].time_s).collect();
    if steps.len() < 2 {
        return None;
    }
    upper_median(&mut steps, f64::total_cmp).filter(|median| *median > 0.0)
}

/// Returns the channels that look down, each in time order; channels that show more of the bottom
/// come first.
fn echograms(log: &mut Collected) -> Vec<Echogram> {
    let mut echograms = std::mem::take(&mut log.echograms);
    for echogram in &mut echograms {
        Arc::make_mut(&mut echogram.pings).sort_by(|a, b| a.time_s.total_cmp(&b.time_s));
    }
    echograms.sort_by_key(|echogram| std::cmp::Reverse(echogram.kind));
    echograms
}

/// Chooses the soundings among the recorded depths: those of one channel, in time order. The
/// traditional sonar is preferred, unless another channel has more than four times as many depths;
/// for the tail of a log the channel that was chosen for the log before is used. All channels
/// repeat the same bottom lock, so that soundings of two channels would only be duplicates.
fn choose(
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
        // Side-scan channels ping faster than the bottom lock changes: their larger count is no
        // reason to drop a slower channel.
        soundings.len() * if kind.looks_down() { 4 } else { 1 } >= most
    });
    let (kind, mut soundings) =
        best.map_or((None, Vec::new()), |(kind, depths)| (Some(kind), depths));
    soundings.sort_by(|a, b| a.time_s.total_cmp(&b.time_s));
    mark_faults(&mut soundings, fixes, has_side_scan);
    (kind, soundings)
}

/// Adds a warning for each fault that soundings of the recorder have.
fn warn_of_lost_bottom(soundings: &[Sounding], report: &WarningReport) {
    for fault in SoundingFault::ALL {
        let mut with = soundings.iter().filter(|sounding| sounding.fault == Some(fault));
        let Some(first) = with.next() else { continue };
        let (count, last) = with.fold((1, first), |(count, _), sounding| (count + 1, sounding));
        report.log(format!(
            "{count} of {} soundings {} {}: they are shown, and count only where a first return confirms them",
            soundings.len(),
            times([first.time_s, last.time_s]),
            fault.sentence()
        ));
    }
}

/// Returns the words for a span of times, seconds: `at 36 s`, or `between 36 s and 40 s`.
fn times([first_s, last_s]: [f64; 2]) -> String {
    let [first, last] = [first_s, last_s].map(|time_s| format!("{time_s:.0} s"));
    if first == last { format!("at {first}") } else { format!("between {first} and {last}") }
}

/// Returns the fixes in time order, without fixes where the boat cannot have been.
fn clean_track(log: &mut Collected) -> Vec<Fix> {
    let mut fixes = std::mem::take(&mut log.fixes);
    fixes.sort_by(|a, b| a.time_s.total_cmp(&b.time_s));
    for sentence in drop_false_fixes(&mut fixes, log.has_times) {
        log.report.log(sentence);
    }
    fixes
}

/// Adds a warning about soundings and side-scan pings without a position because no fix was
/// recorded around them.
fn warn_of_lost_fixes(
    track: &Track,
    soundings: &[Sounding],
    side_scan: &[SidePing],
    report: &WarningReport,
) {
    let known = KnownTimes::of(track);
    let soundings = known.unknown(soundings.iter().map(|sounding| sounding.time_s));
    let pings = known.unknown(side_scan.iter().map(|ping| ping.time_s));
    let lost = [(soundings, "sounding"), (pings, "side-scan ping")];
    let lost = lost.into_iter().filter_map(|(lost, of)| Some((lost?, of)));
    let said = lost.map(|((count, span_s), of)| {
        let ending = if count == 1 { "" } else { "s" };
        format!("{count} {of}{ending} ({})", times(span_s))
    });
    let said = said.collect::<Vec<_>>().join(" and ");
    if !said.is_empty() {
        report.log(format!(
            "without a position, and so on no map, because no fix was recorded around then: {said}"
        ));
    }
}

/// Returns the usability of the side-scan; adds a warning where the side-scan is not usable.
fn judge(pings: &[SidePing], log: &mut Collected) -> SideScanState {
    if pings.is_empty() {
        let has_echoes = |(_, channel): &(u16, Channel)| channel.sample_count.1 > 0;
        log.report.log(if log.channels.iter().any(has_echoes) {
            "the log holds no side-scan: connect a side-scan transducer and switch its recording on"
        } else {
            "the log holds depths only, and no echoes of side-scan or of the sonar that looks down"
        });
        return SideScanState::Absent;
    }
    let far_m = |ping: &SidePing| {
        Side::BOTH
            .iter()
            .filter_map(|&side| ping.side(side))
            .map(|span| span.far_m)
            .fold(0.0_f32, f32::max)
    };
    let stuck = pings.iter().filter(|ping| far_m(ping) <= STUCK_RANGE_M).count();
    if (stuck as f64) < STUCK_SHARE * pings.len() as f64 {
        return SideScanState::Usable;
    }
    let range_m = pings.first().map_or(0.0, far_m);
    log.report.log(format!(
        "the side-scan is noise: its range is stuck at {range_m:.1} m, which is what a unit records without a side-scan transducer"
    ));
    SideScanState::Noise { range_m }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::survey::SideSpan;

    fn halves(times_s: &[f64]) -> Vec<HalfPing> {
        let span = SideSpan::of_bytes(1, [0.0, 1.0]);
        times_s.iter().map(|&time_s| HalfPing { time_s, span }).collect()
    }

    /// Joins pings and returns a letter for each: `b` for both sides, `p` and `s` for one side.
    fn joined(port_s: &[f64], starboard_s: &[f64]) -> String {
        let letter = |ping: &SidePing| match (ping.port, ping.starboard) {
            (Some(_), Some(_)) => 'b',
            (Some(_), None) => 'p',
            _ => 's',
        };
        join_halves(&halves(port_s), &halves(starboard_s)).iter().map(letter).collect()
    }

    #[test]
    fn halves_find_their_partners() {
        assert_eq!(joined(&[0.0, 0.1, 0.2], &[0.01, 0.11, 0.21]), "bbb");
        assert_eq!(joined(&[0.0, 0.1, 0.2, 0.3], &[0.01, 0.21, 0.31]), "bpbb");
        assert_eq!(joined(&[0.1, 0.2], &[0.0, 0.1, 0.2, 0.3]), "sbbs");
        assert_eq!(joined(&[0.0, 0.1, 0.2], &[]), "ppp");
        assert_eq!(joined(&[], &[5.0]), "s");
        // The later side is 40 % of a ping interval behind: both halves are still the same ping.
        assert_eq!(joined(&[0.0, 1.0, 2.0], &[0.4, 1.4, 2.4]), "bbb");
    }
}

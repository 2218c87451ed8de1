//! From channels in file order to a [`Survey`]: sides joined, depths matched by time, noise named.

use super::collected::{Collected, HalfPing};
use crate::survey::{
    Channel, ChannelKind, Fix, Side, SidePing, SideScanState, Sounding, Survey, Track,
    mark_bottom_lock,
};

/// Lowrance units without a side-scan transducer record 5 ft of noise (1.524 m); no unit has so short a range in use.
const STUCK_RANGE_M: f32 = 1.6;
/// Share of stuck pings from which the side-scan is noise.
const STUCK_SHARE: f64 = 0.95;
/// A side-scan ping takes its depth from the nearest sounding, not from one this far away in time, seconds.
const NEAREST_SOUNDING_S: f64 = 5.0;
/// A fix this far from the log's median position is damage, degrees (some 200 km).
const STRAY_FIX_DEG: f64 = 2.0;
/// Two halves without any other measure of the ping rate belong together within this time, seconds.
const HALVES_TOGETHER_S: f64 = 0.1;

/// Puts the pieces of a log together.
pub(super) fn assemble(mut log: Collected) -> Survey {
    let mut side_scan = join_sides(&mut log);
    let mut soundings = choose_soundings(std::mem::take(&mut log.depths));
    mark_bottom_lock(&mut soundings);
    warn_of_lost_bottom(&soundings, &mut log);
    match_depths(&mut side_scan, &soundings);
    let fixes = clean_track(&mut log);
    let side_scan_state = judge(&side_scan, &mut log);
    if soundings.is_empty() {
        log.report
            .log("the log holds no depth; heights can only come from the side-scan itself");
    }
    if fixes.is_empty() {
        log.report
            .log("the log holds no position; nothing in it can be placed on a map");
    }
    let mut channels: Vec<Channel> = log
        .channels
        .into_iter()
        .map(|(_, channel)| channel)
        .collect();
    channels.sort_by(|a, b| (a.kind, &a.recorder_name).cmp(&(b.kind, &b.recorder_name)));
    Survey {
        source: log.source,
        start_unix_s: log.start_unix_s,
        channels,
        side_scan,
        side_scan_state,
        soundings,
        track: Track::new(fixes),
        warnings: log.report.finish(),
        bytes: log.bytes,
    }
}

/// Side-scan pings in time order. A unit that records both layouts says everything twice: the fuller one is kept.
fn join_sides(log: &mut Collected) -> Vec<SidePing> {
    let composite = std::mem::take(&mut log.composite);
    let mut port = std::mem::take(&mut log.port);
    let mut starboard = std::mem::take(&mut log.starboard);
    let halves = port.len().max(starboard.len());
    if !composite.is_empty() && halves > 0 {
        log.report.log(format!(
            "the log holds side-scan twice: {} pings of both sides in one and {halves} of each side apart; the larger is shown",
            composite.len()
        ));
    }
    let mut pings = if composite.len() >= halves {
        composite
    } else {
        port.sort_by(|a, b| a.time_s.total_cmp(&b.time_s));
        starboard.sort_by(|a, b| a.time_s.total_cmp(&b.time_s));
        join_halves(&port, &starboard)
    };
    pings.sort_by(|a, b| a.time_s.total_cmp(&b.time_s));
    pings
}

/// Joins port and starboard halves that were heard at the same time (within half a ping); the others stay alone.
fn join_halves(port: &[HalfPing], starboard: &[HalfPing]) -> Vec<SidePing> {
    let within_s = interval_s(port)
        .or(interval_s(starboard))
        .map_or(HALVES_TOGETHER_S, |s| s / 2.0);
    let mut pings = Vec::with_capacity(port.len().max(starboard.len()));
    let (mut p, mut s) = (0, 0);
    while let (Some(left), right) = (port.get(p), starboard.get(s)) {
        let Some(right) = right else {
            pings.push(ping(Some(left), None));
            p += 1;
            continue;
        };
        let apart_s = (left.time_s - right.time_s).abs();
        // A damaged half leaves its partner next to the neighbour's: the closer pair wins.
        let closer_left = port
            .get(p + 1)
            .is_some_and(|next| (next.time_s - right.time_s).abs() < apart_s);
        let closer_right = starboard
            .get(s + 1)
            .is_some_and(|next| (next.time_s - left.time_s).abs() < apart_s);
        if closer_left || (apart_s > within_s && left.time_s < right.time_s) {
            pings.push(ping(Some(left), None));
            p += 1;
        } else if closer_right || apart_s > within_s {
            pings.push(ping(None, Some(right)));
            s += 1;
        } else {
            pings.push(ping(Some(left), Some(right)));
            p += 1;
            s += 1;
        }
    }
    pings.extend(starboard[s..].iter().map(|right| ping(None, Some(right))));
    pings
}

fn ping(port: Option<&HalfPing>, starboard: Option<&HalfPing>) -> SidePing {
    SidePing {
        time_s: port.or(starboard).map_or(f64::NAN, |half| half.time_s),
        depth_m: f32::NAN,
        depth_locked: false,
        port: port.map(|half| half.span),
        starboard: starboard.map(|half| half.span),
    }
}

/// The median time between pings; `None` below three pings.
fn interval_s(halves: &[HalfPing]) -> Option<f64> {
    let mut steps: Vec<f64> = halves
        .windows(2)
        .map(|pair| pair[1].time_s - pair[0].time_s)
        .collect();
    if steps.len() < 2 {
        return None;
    }
    let middle = steps.len() / 2;
    let (_, &mut median, _) = steps.select_nth_unstable_by(middle, f64::total_cmp);
    (median > 0.0).then_some(median)
}

/// The depths of one channel, in time order: the traditional sonar's, unless another knows twice as many.
/// All channels repeat the same bottom lock, so that two of them would only say it twice.
fn choose_soundings(mut depths: Vec<(ChannelKind, Vec<Sounding>)>) -> Vec<Sounding> {
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
    soundings
}

fn match_depths(pings: &mut [SidePing], soundings: &[Sounding]) {
    let mut next = 0;
    for ping in pings {
        while soundings
            .get(next)
            .is_some_and(|sounding| sounding.time_s < ping.time_s)
        {
            next += 1;
        }
        let around = [next.checked_sub(1), Some(next)];
        let nearest = around
            .into_iter()
            .flatten()
            .filter_map(|index| soundings.get(index))
            .map(|sounding| ((sounding.time_s - ping.time_s).abs(), sounding))
            .filter(|(apart_s, _)| *apart_s <= NEAREST_SOUNDING_S)
            .min_by(|a, b| a.0.total_cmp(&b.0));
        ping.depth_m = nearest.map_or(f32::NAN, |(_, sounding)| sounding.depth_m);
        ping.depth_locked = nearest.is_some_and(|(_, sounding)| sounding.locked);
    }
}

fn warn_of_lost_bottom(soundings: &[Sounding], log: &mut Collected) {
    let lost = || soundings.iter().filter(|sounding| !sounding.locked);
    let (Some(first), Some(last)) = (lost().next(), lost().next_back()) else {
        return;
    };
    log.report.log(format!(
        "the recorder had lost the bottom at {} of {} soundings (between {:.0} s and {:.0} s its depth jumps): they are shown, but nothing is measured against them",
        lost().count(),
        soundings.len(),
        first.time_s,
        last.time_s
    ));
}

/// Fixes in time order, without those that a damaged header threw far away.
fn clean_track(log: &mut Collected) -> Vec<Fix> {
    let mut fixes = std::mem::take(&mut log.fixes);
    let median = |pick: fn(&Fix) -> f64| {
        let mut values: Vec<f64> = fixes.iter().map(pick).collect();
        let middle = values.len() / 2;
        (!values.is_empty()).then(|| *values.select_nth_unstable_by(middle, f64::total_cmp).1)
    };
    let (Some(lon_deg), Some(lat_deg)) = (
        median(|fix| fix.position.lon_deg),
        median(|fix| fix.position.lat_deg),
    ) else {
        return fixes;
    };
    let before = fixes.len();
    fixes.retain(|fix| {
        (fix.position.lat_deg - lat_deg).abs() < STRAY_FIX_DEG
            && (fix.position.lon_deg - lon_deg).abs() * lat_deg.to_radians().cos() < STRAY_FIX_DEG
    });
    if fixes.len() < before {
        log.report.log(format!(
            "{} positions lie hundreds of kilometres from all others and were dropped",
            before - fixes.len()
        ));
    }
    fixes.sort_by(|a, b| a.time_s.total_cmp(&b.time_s));
    fixes
}

/// Whether the side-scan is worth drawing, with a sentence where it is not.
fn judge(pings: &[SidePing], log: &mut Collected) -> SideScanState {
    if pings.is_empty() {
        log.report.log(
            "the log holds no side-scan: connect a side-scan transducer and switch its recording on",
        );
        return SideScanState::Absent;
    }
    let far_m = |ping: &SidePing| {
        Side::BOTH
            .iter()
            .filter_map(|&side| ping.side(side))
            .map(|span| span.far_m)
            .fold(0.0_f32, f32::max)
    };
    let stuck = pings
        .iter()
        .filter(|ping| far_m(ping) <= STUCK_RANGE_M)
        .count();
    if (stuck as f64) < STUCK_SHARE * pings.len() as f64 {
        return SideScanState::Usable;
    }
    let range_m = pings.first().map_or(0.0, far_m);
    log.report.log(format!(
        "the side-scan is noise: its range is stuck at {range_m:.1} m, which is what a unit records without a side-scan transducer"
    ));
    SideScanState::Noise { range_m }
}

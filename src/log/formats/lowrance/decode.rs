//! Decodes frames of Lowrance logs to pings, depths and fixes in SI units.

use super::frame::{LowranceFrame, STRUCTURE_SCAN_3D, metres};
use super::sides;
use super::swath::SwathTotals;
use crate::formats::clock::{Clock, ClockVerdict};
use crate::formats::collected::{Collected, Counted};
use crate::formats::report::WarningKind;
use crate::support::geo::{self, LonLat, MPS_PER_KNOT};
use crate::survey::{ChannelKind, Fix};

/// Range of Unix seconds: values below (year 2000) are a counter, not a time; values above (2100)
/// are damage.
const UNIX_S: std::ops::Range<u32> = 946_684_800..4_102_444_800;

/// Decodes frames, two frames behind the walk so that damaged times are recognised.
#[derive(Default)]
pub(super) struct Reader {
    clock: Clock<LowranceFrame>,
    keel_ft: f32,
    swath: SwathTotals,
    /// The last position, as recorded and in degrees, for reuse: units repeat a fix for tens of
    /// frames.
    place: Option<([i32; 2], LonLat)>,
}

impl Reader {
    /// Decodes the next frame of the file.
    pub(super) fn take(&mut self, log: &mut Collected, frame: LowranceFrame) {
        if let Some(verdict) = self.clock.push(time_s(&frame), frame) {
            self.settle(log, verdict);
        }
    }

    /// Processes the frames that still wait for a verdict of the clock, and warns about a keel
    /// offset.
    pub(super) fn finish(&mut self, log: &mut Collected) {
        while let Some(verdict) = self.clock.next() {
            self.settle(log, verdict);
        }
        log.report.set_back(self.clock.set_back_s);
        self.swath.report(log);
        if self.keel_ft != 0.0 {
            let keel_m = metres(self.keel_ft);
            log.report.log(format!(
                "the unit added a keel offset of {keel_m:.2} m to the depths it shows; it was taken off again, so that depths count from the transducer; set draft_m to what the transducer hangs below the water's surface",
            ));
        }
    }

    fn settle(&mut self, log: &mut Collected, verdict: ClockVerdict<LowranceFrame>) {
        match verdict {
            ClockVerdict::Sound { record, time_s } => self.keep(log, &record, time_s),
            ClockVerdict::Damaged(frame) => {
                let text = format!(
                    "a frame's time ({:.1} s) fits neither neighbour; its header is damaged and it was dropped",
                    time_s(&frame)
                );
                log.report.at(WarningKind::Frame, 0, frame.offset, text);
            }
        }
    }

    fn keep(&mut self, log: &mut Collected, frame: &LowranceFrame, time_s: f64) {
        let kind = channel_kind(frame.channel);
        if log.start_unix_s.is_none() && UNIX_S.contains(&frame.clock) {
            log.start_unix_s = Some(f64::from(frame.clock));
        }
        let counted = Counted {
            record: (0, frame.offset + frame.size),
            time_s,
            samples: sides::samples_a_side(kind, frame),
            range_m: sides::range_m(kind, frame),
        };
        log.count(frame.channel, counted, || {
            (kind, frame.channel.to_string(), frequency_khz(frame.frequency))
        });
        let is_sonar = !matches!(kind, ChannelKind::Swath | ChannelKind::Other(_));
        if is_sonar && frame.depth_ft > 0.0 {
            // Keel offsets above a metre are rare; ten metres are damage.
            let keel_ft = Some(frame.keel_ft).filter(|ft| ft.abs() < 33.0).unwrap_or(0.0);
            self.keel_ft = keel_ft;
            log.add_depth(kind, time_s, metres(frame.depth_ft) - metres(keel_ft));
        }
        if frame.x_m != 0 && frame.y_m != 0 {
            log.add_fix(fix(frame, time_s, self.position(frame)));
        }
        match kind {
            ChannelKind::Swath => self.swath.keep(log, frame, time_s),
            _ => sides::keep(log, kind, frame, time_s),
        }
    }

    fn position(&mut self, frame: &LowranceFrame) -> LonLat {
        let recorded = [frame.x_m, frame.y_m];
        if let Some((_, degrees)) = self.place.filter(|(place, _)| *place == recorded) {
            return degrees;
        }
        let degrees = geo::lowrance_mercator_inverse(f64::from(frame.x_m), f64::from(frame.y_m));
        self.place = Some((recorded, degrees));
        degrees
    }
}

fn fix(frame: &LowranceFrame, time_s: f64, position: LonLat) -> Fix {
    Fix {
        time_s,
        position,
        cog_rad: if frame.course_rad.is_finite() { frame.course_rad } else { f32::NAN },
        // Without a compass this field is 0 on every unit seen.
        compass_rad: if frame.heading_rad == 0.0 || !frame.heading_rad.is_finite() {
            f32::NAN
        } else {
            frame.heading_rad
        },
        speed_mps: if frame.speed_kn >= 0.0 {
            (f64::from(frame.speed_kn) * MPS_PER_KNOT) as f32
        } else {
            f32::NAN
        },
    }
}

fn channel_kind(channel: u16) -> ChannelKind {
    match channel {
        0 => ChannelKind::Primary,
        1 => ChannelKind::Secondary,
        2 => ChannelKind::DownScan,
        3 => ChannelKind::Port,
        4 => ChannelKind::Starboard,
        5 => ChannelKind::Composite,
        STRUCTURE_SCAN_3D => ChannelKind::Swath,
        other => ChannelKind::Other(other),
    }
}

/// Nominal frequencies by code, kHz; for the chirp codes the middle of the band.
pub(super) const FREQUENCIES_KHZ: [f32; 11] =
    [200.0, 50.0, 83.0, 455.0, 800.0, 38.0, 28.0, 170.0, 120.0, 50.0, 35.0];

fn frequency_khz(code: u16) -> Option<f32> {
    FREQUENCIES_KHZ.get(usize::from(code)).copied()
}

fn time_s(frame: &LowranceFrame) -> f64 {
    f64::from(frame.time_ms) / 1000.0
}

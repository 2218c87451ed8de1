//! Decodes pings of SON files to sides, depths and fixes in SI units.

use super::dat::{Dat, FRESH};
use super::ping::PingHeader;
use crate::formats::clock::{Clock, ClockVerdict};
use crate::formats::collected::{Collected, Counted, HalfPing, is_sound};
use crate::support::geo::{LonLat, humminbird_mercator_inverse};
use crate::survey::{ChannelKind, Fix, SideSpan};
use std::f64::consts::PI;

/// Length of the side-scan transducer, metres, and the frequency for which the formula of other
/// readers is made, Hz.
const TRANSDUCER_M: f64 = 0.108;
const NOMINAL_HZ: f64 = 455_000.0;

/// Decodes the pings of one SON file.
pub(super) struct Reader {
    file: usize,
    name: String,
    sample_m: f64,
    clock: Clock<(usize, PingHeader)>,
}

impl Reader {
    /// Creates a reader of the file with this index; `name` (`B002`) gives the beam where a ping
    /// does not.
    pub(super) fn new(file: usize, name: String, dat: Option<Dat>) -> Self {
        Self {
            file,
            name,
            sample_m: sample_m(dat.and_then(|dat| dat.salinity()).unwrap_or(FRESH)),
            clock: Clock::default(),
        }
    }

    /// Decodes the next ping of the file.
    pub(super) fn take(&mut self, log: &mut Collected, offset: usize, ping: PingHeader) {
        if let Some(verdict) = self.clock.push(time_s(&ping), (offset, ping)) {
            self.settle(log, verdict);
        }
    }

    /// Processes the pings that still wait for a verdict of the clock.
    pub(super) fn finish(&mut self, log: &mut Collected) {
        while let Some(verdict) = self.clock.next() {
            self.settle(log, verdict);
        }
        log.report.set_back(self.clock.set_back_s);
    }

    fn settle(&self, log: &mut Collected, verdict: ClockVerdict<(usize, PingHeader)>) {
        match verdict {
            ClockVerdict::Sound { record: (offset, ping), time_s } => {
                self.keep(log, offset, &ping, time_s)
            }
            ClockVerdict::Damaged((offset, ping)) => {
                let time = format!("a ping's time ({:.1} s)", time_s(&ping));
                log.report.odd_time(self.file, offset, &time);
            }
        }
    }

    fn keep(&self, log: &mut Collected, offset: usize, ping: &PingHeader, time_s: f64) {
        let kind = self.channel_kind(ping);
        let span = self.span(offset, ping);
        let is_side = kind.side().is_some();
        let number = self.file as u16;
        let counted = Counted {
            record: (self.file, offset + ping.size()),
            time_s,
            samples: ping.sample_count as usize,
            range_m: is_side.then_some((span.near_m, span.far_m)),
        };
        log.count(number, counted, || {
            let frequency_khz = (ping.frequency_hz > 0).then(|| ping.frequency_hz as f32 / 1000.0);
            (kind, self.name.clone(), frequency_khz)
        });
        log.add_depth(kind, time_s, ping.depth_dm as f32 / 10.0);
        if ping.easting_m != 0 && ping.northing_m != 0 {
            log.add_fix(fix(ping, time_s));
        }
        log.add_echogram(kind, time_s, span);
        if is_side && !is_sound(&span) {
            log.report_no_picture(kind, &span);
        } else if is_side {
            let half = HalfPing { time_s, span };
            match kind {
                ChannelKind::Port => log.port.push(half),
                _ => log.starboard.push(half),
            }
        }
    }

    fn channel_kind(&self, ping: &PingHeader) -> ChannelKind {
        let by_name = || self.name.strip_prefix("B00").and_then(|digit| digit.parse().ok());
        match ping.beam.or_else(by_name) {
            // The high frequency is the one that is used for the bottom lock and for most displays.
            Some(0) => ChannelKind::Secondary,
            Some(1) => ChannelKind::Primary,
            Some(2) => ChannelKind::Port,
            Some(3) => ChannelKind::Starboard,
            Some(4) => ChannelKind::DownScan,
            beam => ChannelKind::Other(beam.map_or(u16::MAX, u16::from)),
        }
    }

    fn span(&self, offset: usize, ping: &PingHeader) -> SideSpan {
        let far_m = (f64::from(ping.sample_count) * self.sample_m) as f32;
        SideSpan {
            file: self.file as u8,
            offset: (offset + ping.header_len) as u64,
            ..SideSpan::of_bytes(ping.sample_count, [0.0, far_m])
        }
    }
}

/// Returns the slant range that one sample covers, metres. The file does not state it; as in PyHum
/// and PING-Mapper, it is computed from the transducer's beam width at 455 kHz and the speed of
/// sound at 10 degrees Celsius (Medwin's simplified formula): `2/pi asin(c / (L f))`; 0.01877 m in
/// fresh water.
fn sample_m(salinity: f64) -> f64 {
    let t = 1.0_f64;
    let sound_mps = 1449.05 + 45.7 * t - 5.21 * t.powi(2)
        + 0.23 * t.powi(3)
        + (1.333 - 0.126 * t + 0.009 * t.powi(2)) * (salinity - 35.0);
    2.0 / PI * (sound_mps / (TRANSDUCER_M * NOMINAL_HZ)).asin()
}

fn fix(ping: &PingHeader, time_s: f64) -> Fix {
    Fix {
        // Without a heading sensor this is the course from GPS, and the file does not state whether
        // there is a sensor.
        cog_rad: if ping.heading_quality > 0 && ping.heading_decideg < 3600 {
            (f32::from(ping.heading_decideg) / 10.0).to_radians()
        } else {
            f32::NAN
        },
        speed_mps: if ping.speed_quality > 0 {
            f32::from(ping.speed_dmps) / 10.0
        } else {
            f32::NAN
        },
        ..Fix::at(time_s, lon_lat(ping.easting_m, ping.northing_m))
    }
}

fn lon_lat(easting_m: i32, northing_m: i32) -> LonLat {
    humminbird_mercator_inverse(f64::from(easting_m), f64::from(northing_m))
}

fn time_s(ping: &PingHeader) -> f64 {
    f64::from(ping.time_ms) / 1000.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scale_and_position_match_the_peers() {
        assert!((sample_m(FRESH) - 0.01877).abs() < 1e-5);
        // The start of the survey by its own notes: 36.877 N, 111.516 W.
        let start = lon_lat(-12_414_199, 4_396_652);
        assert!((start.lat_deg - 36.877).abs() < 0.003, "{start:?}");
        assert!((start.lon_deg + 111.516).abs() < 0.003, "{start:?}");
    }
}

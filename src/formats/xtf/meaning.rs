//! From pings to sides, altitudes and fixes in SI units.

use super::channels::{self, XtfChannel};
use super::raw::{FileHeader, PacketHeader, PingChannel, PingHeader, record};
use crate::formats::clock::{Clock, Verdict};
use crate::formats::collected::{Collected, Counted, HalfPing, is_sound};
use crate::formats::report::Kind;
use crate::geo::{LocalFrame, LonLat, MPS_PER_KNOT};
use crate::survey::{ChannelKind, Encoding, Fix, SideSpan};

/// Packet type of a side-scan ping.
const PING: u8 = 0;
/// The year 2000 in hundredths of Unix seconds: earlier dates are none.
const YEAR_2000_UNIX_CS: i64 = 94_668_480_000;
/// Speed of sound where the file gives a time instead of a range, metres a second.
const SOUND_MPS: f32 = 1500.0;

/// Gives pings their meaning.
pub(super) struct Reader<'a> {
    bytes: &'a [u8],
    channels: Vec<XtfChannel>,
    nav_units: Option<u16>,
    /// Index of the port and of the starboard channel that are shown: the first of each with samples.
    shown: [Option<u16>; 2],
    clock: Clock<(usize, PingHeader)>,
    /// Time of the first sound ping: the log's time zero.
    zero_cs: Option<i64>,
    /// First projected position, where positions are in metres.
    local_origin: Option<[f64; 2]>,
    skipped_packets: usize,
    unread_samples: usize,
    hidden_pings: usize,
}

impl<'a> Reader<'a> {
    /// A reader of this file.
    pub(super) fn new(bytes: &'a [u8], header: Option<FileHeader>) -> Self {
        Self {
            bytes,
            channels: channels::list(bytes, header),
            nav_units: header.map(|header| header.nav_units),
            shown: [None; 2],
            clock: Clock::default(),
            zero_cs: None,
            local_origin: None,
            skipped_packets: 0,
            unread_samples: 0,
            hidden_pings: 0,
        }
    }

    /// Takes the next packet of the file.
    pub(super) fn take(&mut self, log: &mut Collected, offset: usize, packet: &PacketHeader) {
        let ping = (packet.kind == PING)
            .then(|| record::<PingHeader>(self.bytes, offset))
            .flatten();
        let Some(ping) = ping else {
            self.skipped_packets += 1;
            return;
        };
        if let Some(verdict) = self
            .clock
            .push(unix_cs(&ping) as f64 / 100.0, (offset, ping))
        {
            self.settle(log, verdict);
        }
    }

    /// Takes the pings that still wait for a verdict and says what was left out.
    pub(super) fn finish(&mut self, log: &mut Collected) {
        while let Some(verdict) = self.clock.finish() {
            self.settle(log, verdict);
        }
        self.fit_samples(log);
        log.start_unix_s = self
            .zero_cs
            .filter(|&zero_cs| zero_cs > YEAR_2000_UNIX_CS)
            .map(|zero_cs| zero_cs as f64 / 100.0);
        if self.local_origin.is_some() {
            log.report.log("positions are projected metres of an unknown zone; they are shown as local coordinates around longitude 0, latitude 0");
        }
        if self.channels.iter().any(|channel| channel.ground_range) {
            log.report.log("the water column was taken out of this file (ground-range correction): there is no first return in it");
        }
        let counts = [
            (
                self.skipped_packets,
                "packets that are no side-scan pings were skipped",
            ),
            (
                self.unread_samples,
                "pings hold samples of a kind that is not read (neither 1 nor 2 bytes)",
            ),
            (
                self.hidden_pings,
                "pings of a second pair of side-scan channels are counted but not shown",
            ),
        ];
        for (count, what) in counts.into_iter().filter(|(count, _)| *count > 0) {
            log.report.log(format!("{count} {what}"));
        }
    }

    fn settle(&mut self, log: &mut Collected, verdict: Verdict<(usize, PingHeader)>) {
        match verdict {
            Verdict::Sound((offset, ping)) => self.keep(log, offset, &ping),
            Verdict::Damaged((offset, _)) => {
                let text = "a ping's time fits neither neighbour; its header is damaged and it was dropped";
                log.report.at(Kind::Frame, 0, offset, text.to_owned());
            }
        }
    }

    fn keep(&mut self, log: &mut Collected, offset: usize, ping: &PingHeader) {
        let now_cs = unix_cs(ping);
        let time_s = (now_cs - *self.zero_cs.get_or_insert(now_cs)) as f64 / 100.0;
        log.add_depth(ChannelKind::Primary, time_s, ping.sensor_altitude_m);
        if let Some(position) = self.position(ping) {
            log.add_fix(fix(ping, time_s, position));
        }
        let end = offset + ping.packet.size as usize;
        let mut at = offset + size_of::<PingHeader>();
        for _ in 0..ping.packet.channels {
            let header = record::<PingChannel>(self.bytes, at)
                .filter(|_| at + size_of::<PingChannel>() <= end);
            let Some(header) = header else { break };
            let channel = self.channel(header.channel);
            let first = at + size_of::<PingChannel>();
            let width = channel
                .width
                .unwrap_or_else(|| inferred_width(ping, header.samples));
            let stored = (header.samples as usize).saturating_mul(width);
            if stored == 0 || stored > end.saturating_sub(first) {
                let text = format!(
                    "channel {} of a ping says that it has {} samples, which do not lie in the ping; it was dropped",
                    { header.channel },
                    { header.samples }
                );
                log.report.at(Kind::Frame, 0, at, text);
                break;
            }
            self.keep_channel(log, &channel, &header, width, first, time_s);
            at = first + stored;
        }
    }

    fn keep_channel(
        &mut self,
        log: &mut Collected,
        channel: &XtfChannel,
        header: &PingChannel,
        width: usize,
        first: usize,
        time_s: f64,
    ) {
        let count = header.samples;
        let far_m = far_m(header);
        let number = header.channel;
        if !log.knows(number) {
            let name = channel.name.clone();
            log.introduce(number, channel.kind, name, channel.frequency_khz);
        }
        let counted = Counted {
            time_s,
            samples: count as usize,
            range_m: Some((0.0, far_m)),
        };
        log.count(number, counted);
        let side = match channel.kind {
            ChannelKind::Port => 0,
            ChannelKind::Starboard => 1,
            _ => return,
        };
        let Some(encoding) = channels::encoding(width) else {
            self.unread_samples += 1;
            return;
        };
        if *self.shown[side].get_or_insert(header.channel) != header.channel {
            self.hidden_pings += 1;
            return;
        }
        let span = SideSpan {
            file: 0,
            encoding,
            order: channels::order(channel.kind),
            offset: first as u64,
            count,
            near_m: 0.0,
            far_m,
        };
        if !is_sound(&span) {
            let text = format!(
                "a side of a ping has {count} samples over {far_m} m, which is no picture; it was dropped"
            );
            log.report.at(Kind::Value, 0, first, text);
            return;
        }
        let half = HalfPing { time_s, span };
        if side == 0 {
            log.port.push(half)
        } else {
            log.starboard.push(half)
        }
    }

    fn channel(&self, index: u16) -> XtfChannel {
        let listed = self.channels.get(usize::from(index)).cloned();
        listed.unwrap_or_else(|| channels::guess(index))
    }

    /// The sonar's position, or the ship's where the sonar has none.
    fn position(&mut self, ping: &PingHeader) -> Option<LonLat> {
        let sensor = [ping.sensor_x, ping.sensor_y];
        let ship = [ping.ship_x, ping.ship_y];
        let is_set = |[x, y]: &[f64; 2]| x.is_finite() && y.is_finite() && *x != 0.0 && *y != 0.0;
        let [x, y] = [sensor, ship].into_iter().find(is_set)?;
        let fits_degrees = x.abs() <= 180.0 && y.abs() <= 90.0;
        if self.nav_units == Some(3) || (self.local_origin.is_none() && fits_degrees) {
            return Some(LonLat {
                lon_deg: x,
                lat_deg: y,
            });
        }
        let [x0, y0] = *self.local_origin.get_or_insert([x, y]);
        let frame = LocalFrame::new(LonLat {
            lon_deg: 0.0,
            lat_deg: 0.0,
        });
        Some(frame.to_lon_lat(x - x0, y - y0))
    }

    /// Chooses which eight bits of 16-bit samples are shown, one choice a side.
    fn fit_samples(&self, log: &mut Collected) {
        for halves in [&mut log.port, &mut log.starboard] {
            let wide: Vec<&SideSpan> = halves
                .iter()
                .map(|half| &half.span)
                .filter(|span| span.encoding != Encoding::U8)
                .collect();
            if wide.is_empty() {
                continue;
            }
            let shift = channels::shift_to_fit(self.bytes, &wide);
            for half in halves {
                if let Encoding::U16 { shift: chosen } = &mut half.span.encoding {
                    *chosen = shift;
                }
            }
        }
    }
}

/// Bytes a sample where the file header does not say: what the packet has room for.
fn inferred_width(ping: &PingHeader, samples: u32) -> usize {
    let channels = usize::from(ping.packet.channels).max(1);
    let headers = size_of::<PingHeader>() + channels * size_of::<PingChannel>();
    let room = (ping.packet.size as usize).saturating_sub(headers) / channels;
    if room >= 2 * samples as usize { 2 } else { 1 }
}

fn far_m(header: &PingChannel) -> f32 {
    if header.slant_range_m > 0.0 {
        header.slant_range_m
    } else {
        header.time_duration_s * SOUND_MPS / 2.0
    }
}

fn fix(ping: &PingHeader, time_s: f64, position: LonLat) -> Fix {
    let first_set = |values: [f32; 2]| {
        values
            .into_iter()
            .find(|value| value.is_finite() && *value != 0.0)
    };
    let heading_deg = first_set([ping.sensor_heading_deg, ping.ship_gyro_deg]);
    let speed_kn = first_set([ping.sensor_speed_kn, ping.ship_speed_kn]);
    Fix {
        time_s,
        position,
        cog_rad: f32::NAN,
        compass_rad: heading_deg.map_or(f32::NAN, f32::to_radians),
        speed_mps: speed_kn.map_or(f32::NAN, |knots| (f64::from(knots) * MPS_PER_KNOT) as f32),
    }
}

/// Hundredths of Unix seconds of a ping's date and time, by Hinnant's days-from-civil.
fn unix_cs(ping: &PingHeader) -> i64 {
    let (month, day) = (i64::from(ping.month), i64::from(ping.day));
    let year = i64::from(ping.year) - i64::from(month <= 2);
    let year_of_era = year.rem_euclid(400);
    let day_of_year = (153 * (month + if month > 2 { -3 } else { 9 }) + 2) / 5 + day - 1;
    let day_of_era = year_of_era * 365 + year_of_era / 4 - year_of_era / 100 + day_of_year;
    let days = year.div_euclid(400) * 146_097 + day_of_era - 719_468;
    let minutes = i64::from(ping.hour) * 60 + i64::from(ping.minute);
    let seconds = days * 86_400 + minutes * 60 + i64::from(ping.second);
    seconds * 100 + i64::from(ping.hundredths)
}

#[cfg(test)]
mod tests {
    use super::*;
    use bytemuck::Zeroable;

    #[test]
    fn dates_become_unix_seconds() {
        let mut ping = PingHeader::zeroed();
        (ping.year, ping.month, ping.day) = (2009, 11, 8);
        (ping.hour, ping.minute, ping.second, ping.hundredths) = (12, 36, 34, 33);
        // `date -u -d "2009-11-08 12:36:34" +%s`
        assert_eq!(unix_cs(&ping), 125_768_379_433);
        (ping.year, ping.month, ping.day) = (2024, 2, 29);
        assert_eq!(unix_cs(&ping) / 100, 1_709_210_194);
    }
}

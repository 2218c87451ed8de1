//! Reads one page of a Klein SDF file: a ping with all its channels.

use crate::formats::clock::YEARS;
use crate::formats::scalar::{Fields, u32_le};
use crate::formats::walk::MessageFormat;
use crate::support::geo::LonLat;
use chrono::NaiveDate;

/// Marker before every page.
const MARKER: u32 = u32::MAX;
/// Bytes of the marker.
const MARKER_LENGTH: usize = 4;
/// Versions of pages that exist or may exist.
const VERSIONS: std::ops::Range<u32> = 3000..8000;
/// Plausible bytes of a page without the marker: at least a header; longer pages are damage.
const LENGTHS: std::ops::Range<usize> = 256..1 << 26;

/// Marker and length of pages, with which a walk finds the next page.
pub(super) const FORMAT: MessageFormat = MessageFormat {
    noun: "page",
    marker: [0xFF, 0xFF],
    length: |bytes, at| Some(length(bytes, at)? + MARKER_LENGTH),
};

/// Returns the bytes of the page whose marker begins at an offset, without the marker; `None` where
/// no page can begin.
fn length(bytes: &[u8], at: usize) -> Option<usize> {
    let word = |index: usize| u32_le(bytes, at.checked_add(4 * index)?);
    let length = word(1)? as usize;
    let is_page = word(0)? == MARKER && LENGTHS.contains(&length) && VERSIONS.contains(&word(2)?);
    is_page.then_some(length)
}

/// Frequency band of a pair of channels.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Band {
    /// Low frequency.
    Low,
    /// High frequency.
    High,
}

/// Place of the samples of one channel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Channel {
    /// Frequency band of the channel.
    pub(super) band: Band,
    /// Side of the boat: 0 port, 1 starboard.
    pub(super) side: usize,
    /// Bytes of one sample.
    pub(super) width: usize,
    /// Offset of the first sample in the file.
    pub(super) first: usize,
    /// Number of samples.
    pub(super) count: usize,
}

/// A complete page.
#[derive(Clone, Copy, Debug)]
pub(super) struct Page<'a> {
    /// Offsets of the marker and of the end of the page.
    pub(super) at: usize,
    pub(super) end: usize,
    /// Version of the page, which gives the sonar and the layout.
    pub(super) version: u32,
    /// Fields of the page, without the marker.
    fields: Fields<'a>,
}

impl<'a> Page<'a> {
    /// Returns the page whose marker begins at an offset; `None` where there is none, or it is
    /// truncated.
    pub(super) fn at(bytes: &'a [u8], at: usize) -> Option<Self> {
        let from = at + MARKER_LENGTH;
        let end = from.checked_add(length(bytes, at)?)?;
        let fields = Fields(bytes.get(from..end)?);
        Some(Self { at, end, version: fields.u32(4), fields })
    }

    /// Returns the name of the sonar that wrote the page.
    pub(super) fn sonar(&self) -> &'static str {
        match self.version {
            3000..3500 => "System 3000",
            3500..4000 => "3500 series",
            5000..6000 => "System 5000",
            7000..8000 => "System 7000",
            _ => "another sonar",
        }
    }

    /// Returns true if the layout is known, so that the channels can be read.
    pub(super) fn is_known(&self) -> bool {
        matches!(self.version, 3000 | 3001 | 3501 | 3502)
    }

    /// Returns the channels with samples; a channel whose samples exceed the page is left out, with
    /// all channels after it.
    pub(super) fn channels(&self) -> Vec<Channel> {
        let (bands, width): (&[Band], usize) = match self.version {
            3000 | 3001 => (&[Band::Low, Band::High], 2),
            3501 => (&[Band::Low], 4),
            3502 => (&[Band::High], 4),
            _ => return Vec::new(),
        };
        let shortest = if self.version == 3000 { 256 } else { 512 };
        let mut at = (self.fields.u32(180) as usize).max(shortest);
        let mut channels = Vec::new();
        for (band, side) in bands.iter().flat_map(|band| [(*band, 0), (*band, 1)]) {
            // The number of samples is stored in as many bytes as a sample.
            let count = match width {
                2 => usize::from(self.fields.u16(at)),
                _ => self.fields.u32(at) as usize,
            };
            let from = at.saturating_add(width);
            let to = from.saturating_add(count.saturating_mul(width));
            if to > self.fields.0.len() {
                break;
            }
            at = to;
            if count > 0 {
                channels.push(Channel {
                    band,
                    side,
                    width,
                    first: self.at + MARKER_LENGTH + from,
                    count,
                });
            }
        }
        channels
    }

    /// Returns the time in Unix seconds; `None` where the date is not plausible.
    pub(super) fn unix_s(&self) -> Option<f64> {
        let [year, month, day, hour, minute, second] =
            [68, 72, 76, 80, 84, 88].map(|at| self.fields.u32(at));
        let year = i32::try_from(year).ok().filter(|year| YEARS.contains(year))?;
        let moment =
            NaiveDate::from_ymd_opt(year, month, day)?.and_hms_opt(hour, minute, second)?;
        let hundredths = self.fields.u32(92);
        // Headers of version 3 have a field for the fraction with more digits.
        let fraction_s = [self.fields.f32(216), hundredths as f32 / 100.0];
        let fraction_s = fraction_s
            .into_iter()
            .find(|fraction_s| (0.0..1.0).contains(fraction_s) && *fraction_s > 0.0);
        Some(moment.and_utc().timestamp() as f64 + f64::from(fraction_s.unwrap_or(0.0)))
    }

    /// Returns the slant range of the last of `count` samples, metres: from the sample rate where
    /// this agrees with the range setting of the sonar, which is stored in whole metres; otherwise
    /// the setting.
    pub(super) fn far_m(&self, count: usize) -> f32 {
        let set_m = self.fields.u32(28) as f32;
        let sound_mps = self.fields.u32(36) as f32 / 100.0;
        let rate_hz = self.fields.u32(224) as f32;
        let sampled_m = count as f32 * sound_mps / 2.0 / rate_hz;
        if (sampled_m - set_m).abs() < 0.1 * set_m { sampled_m } else { set_m }
    }

    /// Returns the height of the transducer above the bottom, metres; 0 where unknown.
    pub(super) fn altitude_m(&self) -> f32 {
        self.first_set([124, 208])
    }

    /// Returns the position of the sonar; `None` where unknown. A vehicle writes its own position
    /// into the field of the ship.
    pub(super) fn position(&self) -> Option<LonLat> {
        let place = |at: usize| {
            let [lat_rad, lon_rad] = [at, at + 8].map(|at| self.f64(at));
            let is_set = lat_rad != 0.0 && lon_rad != 0.0;
            let position = LonLat::new(lon_rad.to_degrees(), lat_rad.to_degrees());
            (is_set && position.is_on_earth()).then_some(position)
        };
        let [ship, fish] = [place(144), place(160)];
        if self.is_vehicle() { ship.or(fish) } else { fish.or(ship) }
    }

    /// Returns the heading, degrees; NaN where unknown.
    pub(super) fn heading_deg(&self) -> f32 {
        let heading_deg = self.first_set([108, 136]);
        if heading_deg == 0.0 { f32::NAN } else { heading_deg }
    }

    /// Returns the speed of the ship, metres a second; NaN where unknown.
    pub(super) fn speed_mps(&self) -> f32 {
        let speed_mps = self.fields.f32(132);
        if speed_mps > 0.0 && speed_mps.is_finite() { speed_mps } else { f32::NAN }
    }

    /// Returns the frequency, kHz; `None` where the page does not state it.
    pub(super) fn frequency_khz(&self) -> Option<f32> {
        let khz = self.fields.u32(404);
        (self.is_vehicle() && (1..10_000).contains(&khz)).then_some(khz as f32)
    }

    /// Returns true for the 3500 series, whose vehicles write into the fields of the ship and the
    /// auxiliary sensors.
    fn is_vehicle(&self) -> bool {
        matches!(self.version, 3501 | 3502)
    }

    /// Returns the value of the first of two fields that is set: the field of the towed body, then
    /// that of the ship or an auxiliary sensor; for a vehicle in reverse order. 0 where neither is
    /// set.
    fn first_set(&self, mut at: [usize; 2]) -> f32 {
        if self.is_vehicle() {
            at.reverse();
        }
        let values = at.map(|at| self.fields.f32(at));
        let is_set = |value: &f32| value.is_finite() && *value != 0.0;
        values.into_iter().find(is_set).unwrap_or(0.0)
    }

    fn f64(&self, at: usize) -> f64 {
        let [low, high] = [at, at + 4].map(|at| u64::from(self.fields.u32(at)));
        f64::from_bits(high << 32 | low)
    }
}

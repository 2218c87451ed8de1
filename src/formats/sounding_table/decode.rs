//! From rows to depths and fixes in SI units.

use super::Line;
use super::layout::{Layout, PlaceColumns};
use crate::formats::clock::{Clock, ClockVerdict};
use crate::formats::collected::{Collected, Counted};
use crate::formats::points::columns::{fields, number};
use crate::formats::report::WarningKind;
use crate::support::calendar::unix_from_text;
use crate::support::geo::LonLat;
use crate::survey::{ChannelKind, Fix, ProjectedTrack};

/// Times below this, seconds, count from the beginning of the recording; beyond [`UNIX_MS`] they are milliseconds.
const LEAST_UNIX_S: f64 = 1e8;
const UNIX_MS: f64 = 1e11;
/// No recording is of a later time, Unix seconds (2100).
const LATEST_UNIX_S: f64 = 4_102_444_800.0;
/// No coordinate system counts so far, metres.
const FARTHEST_M: f64 = 1e8;
/// The only channel.
const CHANNEL: u16 = 0;

/// A row that waits for its time to be believed.
#[derive(Debug)]
struct Row {
    at: usize,
    end: usize,
    depth_m: Option<f64>,
    fix: Option<Fix>,
}

/// Decodes rows.
pub(super) struct Reader {
    layout: Layout,
    clock: Clock<Row>,
    rows: usize,
    /// Whether times are read. Where the first row has none, none are.
    has_times: Option<bool>,
    zero_s: Option<f64>,
    /// First place in metres.
    origin_m: Option<[f64; 2]>,
}

impl Reader {
    /// A reader of a table of this layout.
    pub(super) fn new(layout: Layout) -> Self {
        Self {
            layout,
            clock: Clock::default(),
            rows: 0,
            has_times: None,
            zero_s: None,
            origin_m: None,
        }
    }

    /// Takes the next row.
    pub(super) fn take(&mut self, log: &mut Collected, line: &Line) {
        let row = fields(&line.text, self.layout.separator);
        let value = |column: usize| {
            let number = number(row.get(column)?, self.layout.separator)?;
            Some(number).filter(|number| number.is_finite())
        };
        let depth_m = value(self.layout.depth).map(|depth| depth * self.layout.unit_m);
        let told_s = self.told_s(&row);
        let has_times = *self.has_times.get_or_insert(told_s.is_some());
        let radians = |column: Option<usize>| {
            column
                .and_then(value)
                .map_or(f32::NAN, |degrees| degrees.to_radians() as f32)
        };
        let place = match self.layout.place {
            PlaceColumns::Degrees(x, y) | PlaceColumns::Metres(x, y) => value(x).zip(value(y)),
        };
        let [cog_rad, compass_rad] = [self.layout.course, self.layout.heading].map(radians);
        let position = place.and_then(|place| self.position(place));
        self.rows += 1;
        let time_s = match has_times {
            true => told_s,
            false => Some((self.rows - 1) as f64),
        };
        let Some(time_s) = time_s.filter(|_| depth_m.is_some() || position.is_some()) else {
            let text = "a row has no depth, place or time that can be read; it was dropped";
            return log.report.at(WarningKind::Value, 0, line.at, text);
        };
        let fix = position.map(|position| Fix {
            time_s,
            position,
            cog_rad,
            compass_rad,
            speed_mps: f32::NAN,
        });
        let row = Row {
            at: line.at,
            end: line.end,
            depth_m,
            fix,
        };
        if let Some(verdict) = self.clock.push(time_s, row) {
            self.settle(log, verdict);
        }
    }

    /// The time of a row, Unix seconds or seconds of the recording.
    fn told_s(&self, row: &[&str]) -> Option<f64> {
        let text = *row.get(self.layout.time?)?;
        let with_date = || unix_from_text(&format!("{} {text}", row.get(self.layout.date?)?));
        let told_s = unix_from_text(text).or_else(|| number(text, self.layout.separator));
        let told_s = told_s.or_else(with_date);
        let told_s = told_s.map(|told_s| {
            if told_s > UNIX_MS {
                told_s / 1e3
            } else {
                told_s
            }
        });
        told_s.filter(|told_s| told_s.abs() < LATEST_UNIX_S)
    }

    /// The place of a row. Programs write 0, 0 where there is none.
    fn position(&mut self, (x, y): (f64, f64)) -> Option<LonLat> {
        if (x, y) == (0.0, 0.0) {
            return None;
        }
        match self.layout.place {
            PlaceColumns::Degrees(..) => {
                let position = LonLat::new(x, y);
                position.is_on_earth().then_some(position)
            }
            PlaceColumns::Metres(..) => {
                if x.abs().max(y.abs()) > FARTHEST_M {
                    return None;
                }
                let [x0, y0] = *self.origin_m.get_or_insert([x, y]);
                Some(ProjectedTrack::frame().to_lon_lat(x - x0, y - y0))
            }
        }
    }

    fn settle(&mut self, log: &mut Collected, verdict: ClockVerdict<Row>) {
        let (row, time_s) = match verdict {
            ClockVerdict::Sound { record, time_s } => (record, time_s),
            ClockVerdict::Damaged(row) => {
                let text = "a row's time fits neither neighbour; it was dropped";
                return log.report.at(WarningKind::Value, 0, row.at, text);
            }
        };
        let zero_s = *self.zero_s.get_or_insert(time_s);
        // Unix seconds hold fewer digits than are written.
        let time_s = ((time_s - zero_s) * 1e3).round() / 1e3;
        if let Some(depth_m) = row.depth_m {
            if !log.knows(CHANNEL) {
                let name = "column of depths".to_owned();
                log.introduce(CHANNEL, ChannelKind::Primary, name, None);
            }
            let counted = Counted {
                record: (0, row.end),
                time_s,
                samples: 0,
                range_m: None,
            };
            log.count(CHANNEL, counted);
            log.add_depth(ChannelKind::Primary, time_s, depth_m as f32);
        }
        if let Some(fix) = row.fix {
            log.add_fix(Fix { time_s, ..fix });
        }
    }

    /// Takes what still waits, and says what had to be assumed.
    pub(super) fn finish(&mut self, log: &mut Collected) {
        while let Some(verdict) = self.clock.next() {
            self.settle(log, verdict);
        }
        log.report.set_back(self.clock.set_back_s());
        log.projected = self.origin_m.map(ProjectedTrack::new);
        let has_times = self.has_times == Some(true);
        log.start_unix_s = self
            .zero_s
            .filter(|zero_s| has_times && *zero_s >= LEAST_UNIX_S);
        if !has_times {
            log.report.log("the rows have no time that can be read (Unix seconds, 2021-10-12T00:53:20Z); they are taken as one second apart, in the order of the file");
        }
        if !self.layout.names_unit {
            log.report.log("the column of the depths names no unit; they are taken as metres, and are feet where it is named depth_ft");
        }
        if self.layout.unit_m < 0.0 {
            log.report.log("the depths are negative in most rows; they are taken as counted upwards from the water");
        }
    }
}

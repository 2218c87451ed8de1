//! Decodes rows of a table to depths, fixes and pings in SI units.

use super::Line;
use super::layout::{Layout, Lengths, PlaceColumns};
use crate::formats::clock::{Clock, ClockVerdict};
use crate::formats::collected::{Collected, Counted, WarningKind, is_range};
use crate::formats::points::text_file::{fields, number};
use crate::support::calendar::{DateOrder, unix_from_date, unix_from_iso, unix_from_text};
use crate::support::geo::{LonLat, distance_m};
use crate::survey::{ChannelKind, Fix, ProjectedTrack};

/// Lowest Unix time, seconds: lower times count from the beginning of the recording; times above
/// [`UNIX_MS`] are milliseconds.
const LEAST_UNIX_S: f64 = 1e8;
const UNIX_MS: f64 = 1e11;
/// Latest plausible time, Unix seconds (2100).
const LATEST_UNIX_S: f64 = 4_102_444_800.0;
/// Limit of the number of a row of a picture.
const LAST_ROW: f64 = 4e9;
/// Largest plausible easting or northing, metres.
const FARTHEST_M: f64 = 1e8;
/// Number of the channel of the depths.
const CHANNEL: u16 = 0;
/// Time between rows without times, seconds; also the longest between rows with equal times.
const APART_S: f64 = 1.0;
/// Speed of a boat from which the time between pings without times is computed, metres a second:
/// side-scan is recorded at 1 to 3.
const USUAL_SPEED_MPS: f64 = 1.5;
/// Shortest time between two pings, seconds: times are stored in milliseconds.
const LEAST_APART_S: f64 = 0.001;

/// A row whose time is not confirmed by the clock yet.
#[derive(Debug)]
struct Row {
    at: usize,
    end: usize,
    depth_m: Option<f64>,
    fix: Option<Fix>,
    ping: Option<TablePing>,
}

/// A ping in a picture.
#[derive(Clone, Copy, Debug)]
pub(in crate::formats) struct TablePing {
    /// Seconds after the log's time zero.
    pub(in crate::formats) time_s: f64,
    /// Row of the picture as the table counts it; where the table has no column for it, the row of
    /// the table, counted from 0.
    pub(in crate::formats) row: usize,
    /// Slant range of the near edge of the innermost sample and of the far edge of the outermost
    /// sample, metres.
    pub(in crate::formats) range_m: (f32, f32),
    /// Offsets of the beginning and the end of the ping's row in the table.
    pub(in crate::formats) place: (usize, usize),
}

/// Decodes rows and collects pings.
pub(in crate::formats) struct Reader {
    /// Columns of the table.
    pub(super) layout: Layout,
    /// Index of the table among the log's files.
    file: usize,
    clock: Clock<Row>,
    /// Confirmed rows with the same time, and that time, seconds.
    together: (f64, Vec<Row>),
    /// Seconds between the last rows with equal times.
    apart_s: f64,
    has_spread: bool,
    /// Number of rows so far.
    pub(in crate::formats) rows: usize,
    /// Pings so far.
    pub(in crate::formats) pings: Vec<TablePing>,
    /// True if times are read; `None` before the first row. If the first row has no time, no times
    /// are read.
    has_times: Option<bool>,
    zero_s: Option<f64>,
    /// First position in metres.
    origin_m: Option<[f64; 2]>,
    /// Number of rows whose position is 0, 0.
    without_place: usize,
}

impl Reader {
    /// Creates a reader of a table with this layout; `file` is the index of the table in the log.
    pub(in crate::formats) fn new(layout: Layout, file: usize) -> Self {
        Self {
            layout,
            file,
            clock: Clock::default(),
            together: (0.0, Vec::new()),
            apart_s: APART_S,
            has_spread: false,
            rows: 0,
            pings: Vec::new(),
            has_times: None,
            zero_s: None,
            origin_m: None,
            without_place: 0,
        }
    }

    /// Returns true if the rows name rows of a picture.
    pub(in crate::formats) fn names_rows(&self) -> bool {
        let pings = self.layout.pings.as_ref();
        pings.is_some_and(|pings| pings.row.is_some())
    }

    /// Decodes the next row.
    pub(super) fn take(&mut self, log: &mut Collected, line: &Line) {
        let row = fields(&line.text, self.layout.separator);
        let value = |column: usize| {
            let number = number(row.get(column)?, self.layout.separator)?;
            Some(number).filter(|number| number.is_finite())
        };
        let depth = self.layout.depth.and_then(value);
        let depth_m = depth.map(|depth| depth * self.layout.unit_m);
        let row_time_s = self.time_s(&row);
        let has_times = *self.has_times.get_or_insert(row_time_s.is_some());
        let radians = |column: Option<usize>| {
            column.and_then(value).map_or(f32::NAN, |degrees| degrees.to_radians() as f32)
        };
        let place = self.layout.place.and_then(|place| match place {
            PlaceColumns::Degrees(x, y) | PlaceColumns::Metres(x, y) => value(x).zip(value(y)),
        });
        let ping = self.ping(line, value);
        let [cog_rad, compass_rad] = [self.layout.course, self.layout.heading].map(radians);
        let position = place.and_then(|place| self.position(place));
        self.rows += 1;
        let time_s = match has_times {
            true => row_time_s,
            // Rows of pings are spread in time after the last row.
            false if self.layout.has_pings() => Some(0.0),
            false => Some((self.rows - 1) as f64 * APART_S),
        };
        let holds = depth_m.is_some() || position.is_some() || ping.is_some();
        let Some(time_s) = time_s.filter(|_| holds) else {
            let text = "a row has no depth, place or time that can be read; it was dropped";
            return log.report.at(WarningKind::Value, self.file, line.at, text);
        };
        if self.layout.has_pings() && ping.is_none() {
            let text = "a row has no range that a sonar can have, or names no row of a picture; its echoes were left out";
            log.report.at(WarningKind::Value, self.file, line.at, text);
        }
        let fix =
            position.map(|position| Fix { cog_rad, compass_rad, ..Fix::at(time_s, position) });
        let row = Row { at: line.at, end: line.end, depth_m, fix, ping };
        if let Some(verdict) = self.clock.push(time_s, row) {
            self.settle(log, verdict);
        }
    }

    /// Returns the ping of a row, without its time; `None` where its range or its row of the
    /// picture cannot be read.
    fn ping(&self, line: &Line, value: impl Fn(usize) -> Option<f64>) -> Option<TablePing> {
        let columns = self.layout.pings.as_ref()?;
        let metres = |(column, unit_m): Lengths| value(column).map(|range| (range * unit_m) as f32);
        let near_m = columns.near.and_then(metres).unwrap_or(0.0);
        let far_m = metres(columns.range)?;
        let row = match columns.row.map(value) {
            None => self.rows,
            Some(row) => {
                row.filter(|row| row.fract() == 0.0 && (0.0..LAST_ROW).contains(row))? as usize
            }
        };
        is_range(near_m, far_m).then_some(TablePing {
            time_s: f64::NAN,
            row,
            range_m: (near_m, far_m),
            place: (line.at, line.end),
        })
    }

    /// Returns the time of a row, in Unix seconds or seconds of the recording; `None` where it
    /// cannot be read.
    fn time_s(&self, row: &[&str]) -> Option<f64> {
        let text = *row.get(self.layout.time?)?;
        let with_date = || {
            let text = format!("{} {text}", row.get(self.layout.date?)?);
            unix_from_iso(&text).or_else(|| unix_from_date(&text, self.layout.date_order))
        };
        let time_s = unix_from_text(text).or_else(|| number(text, self.layout.separator));
        let time_s = time_s.or_else(with_date);
        let time_s = time_s.or_else(|| unix_from_date(text, self.layout.date_order));
        let time_s = time_s.map(|time_s| if time_s > UNIX_MS { time_s / 1e3 } else { time_s });
        time_s.filter(|time_s| time_s.abs() < LATEST_UNIX_S)
    }

    /// Returns the position of a row; `None` where it is missing or not plausible. Programs write
    /// 0, 0 for a missing position.
    fn position(&mut self, (x, y): (f64, f64)) -> Option<LonLat> {
        if (x, y) == (0.0, 0.0) {
            self.without_place += 1;
            return None;
        }
        match self.layout.place? {
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
                return log.report.at(WarningKind::Value, self.file, row.at, text);
            }
        };
        if !self.layout.has_pings() {
            return self.keep(log, row, time_s);
        }
        if self.together.0 != time_s {
            self.keep_together(log, Some(time_s));
            self.together.0 = time_s;
        }
        self.together.1.push(row);
    }

    /// Adds the rows with the same time, evenly spread up to the next time, since times may be in
    /// whole seconds.
    fn keep_together(&mut self, log: &mut Collected, next_s: Option<f64>) {
        let (from_s, rows) = std::mem::take(&mut self.together);
        if rows.is_empty() {
            return;
        }
        if let Some(next_s) = next_s {
            self.apart_s = (next_s - from_s).clamp(0.0, APART_S) / rows.len() as f64;
        }
        self.has_spread |= rows.len() > 1;
        for (row, index) in rows.into_iter().zip(0_u32..) {
            self.keep(log, row, from_s + f64::from(index) * self.apart_s);
        }
    }

    /// Adds a row with a confirmed time to the log.
    fn keep(&mut self, log: &mut Collected, row: Row, time_s: f64) {
        let zero_s = *self.zero_s.get_or_insert(time_s);
        // Unix seconds in f64 have fewer decimals than are written.
        let time_s = ((time_s - zero_s) * 1e3).round() / 1e3;
        if let Some(depth_m) = row.depth_m {
            let counted =
                Counted { record: (self.file, row.end), time_s, samples: 0, range_m: None };
            log.count(CHANNEL, counted, || {
                (ChannelKind::Primary, "column of depths".to_owned(), None)
            });
            log.add_depth(ChannelKind::Primary, time_s, depth_m as f32);
        }
        if let Some(fix) = row.fix {
            log.add_fix(Fix { time_s, ..fix });
        }
        let ping = row.ping.map(|ping| TablePing { time_s, ..ping });
        self.pings.extend(ping);
    }

    /// Processes the rows that still wait for a verdict of the clock, and adds warnings about
    /// assumptions.
    pub(super) fn finish(&mut self, log: &mut Collected) {
        while let Some(verdict) = self.clock.next() {
            self.settle(log, verdict);
        }
        let has_times = self.has_times == Some(true);
        if !has_times {
            self.apart_s = usual_apart_s(&self.together.1).unwrap_or(APART_S);
        }
        self.keep_together(log, None);
        log.report.set_back(self.clock.set_back_s);
        log.projected = self.origin_m.map(ProjectedTrack::new);
        log.has_times = has_times;
        log.start_unix_s = self.zero_s.filter(|zero_s| has_times && *zero_s >= LEAST_UNIX_S);
        if !has_times {
            let apart = if self.layout.has_pings() {
                format!(
                    "{:.3} s apart, as far as a boat of {USUAL_SPEED_MPS} m/s makes them",
                    self.apart_s
                )
            } else {
                "one second apart".to_owned()
            };
            log.report.log(format!("the rows have no time that can be read (Unix seconds, 2021-10-12T00:53:20Z); they are taken as {apart}, in the order of the file"));
        }
        if self.has_spread && has_times {
            log.report.log(
                "several rows have the same time; they are taken as evenly spread up to the next",
            );
        }
        if self.without_place > 0 {
            log.report.log(format!(
                "{} of {} rows have no position (0, 0): their depths are placed between the rows around them, where those are close",
                self.without_place, self.rows
            ));
        }
        if self.layout.is_assumed {
            log.report.log("no line names the columns; they are taken as latitude, longitude and depth in metres: write names into the first line where they are others");
        }
        if has_times && self.layout.date_order == DateOrder::Ambiguous {
            log.report.log("dates are taken as month/day/year, for no number above 12 tells the day from the month: write them as 2021-08-26 where that is wrong");
        }
        if !self.layout.names_unit {
            log.report.log("the column of the depths names no unit; they are taken as metres, and are feet where it is named depth_ft");
        }
        if self.layout.unit_m < 0.0 {
            log.report.log("the depths are negative in most rows; they are taken as counted upwards from the water");
        }
    }
}

/// Returns the seconds between rows without times, from the distance between their positions and
/// the usual speed of a boat; `None` where they have no positions.
fn usual_apart_s(rows: &[Row]) -> Option<f64> {
    let places = rows.iter().filter_map(|row| Some(row.fix.as_ref()?.position));
    let places: Vec<LonLat> = places.collect();
    let way_m: f64 = places.windows(2).map(|two| distance_m(two[0], two[1])).sum();
    let steps = rows.len().checked_sub(1).filter(|_| way_m > 0.0)?;
    let apart_s = way_m / USUAL_SPEED_MPS / steps as f64;
    Some(apart_s.clamp(LEAST_APART_S, APART_S))
}

//! Recognises the columns of a table by their names, or by their values.

use crate::formats::instrument_files::{HEADING, LAT, LON, TIME};
use crate::formats::points::text_file::{fields, is_header, number, separator_of};
use crate::support::calendar::DateOrder;
use crate::support::geo::METRES_PER_FOOT;

/// Names of columns in lower case, without unit; the first name in the header is used.
const EAST: &[&str] = &["easting", "east", "utm_x", "x"];
const NORTH: &[&str] = &["northing", "north", "utm_y", "y"];
const DEPTH: &[&str] = &["depth", "water_depth", "waterdepth", "sonar_depth", "bottom_depth"];
/// Names of heights of the bottom; heights are only used if most are negative, because then they
/// count from the water's surface.
const BOTTOM: &[&str] = &["elevationbottom", "elevation_bottom", "bottom_elevation"];
const COURSE: &[&str] = &["cog", "course"];
/// Names of columns in tables beside a picture: slant range of the outermost and of the innermost
/// sample of a side, and the row of the picture.
const RANGE: &[&str] = &["range", "slant_range", "max_range", "range_max"];
const NEAR: &[&str] = &["min_range", "range_min"];
const ROW: &[&str] = &["row", "picture_row", "line"];
/// Further names of columns like [`TIME`].
const MOMENT: &[&str] = &["datetime", "date_time", "utc_time", "timestamp_utc", "date"];
/// Names that only tables of Bathyscope contain together.
const OWN: [&str; 3] = ["east_m", "north_m", "lon"];
/// Units at the end of a name, and their length in metres (1 for degrees).
const UNITS: &[(&str, f64)] = &[
    ("m", 1.0),
    ("metres", 1.0),
    ("meters", 1.0),
    ("ft", METRES_PER_FOOT),
    ("feet", METRES_PER_FOOT),
    ("fathoms", 6.0 * METRES_PER_FOOT),
    ("deg", 1.0),
    ("degrees", 1.0),
];
/// Range of Unix milliseconds, 2001 to 2100.
const UNIX_MS: std::ops::Range<f64> = 1e12..4_102_444_800e3;
/// Fewest decimals of degrees of a position; four decimals are 11 m.
const DECIMALS_OF_A_PLACE: usize = 4;
/// Largest extent of a survey, degrees.
const SURVEY_DEG: f64 = 2.0;
/// Fewest rows with which a table without names is recognised.
const FEWEST_ROWS: usize = 3;

/// Kind of a table.
#[derive(Clone, Debug, PartialEq)]
pub(in crate::formats) enum Recognised {
    /// A table of soundings or pings.
    Table(Layout),
    /// A table that Bathyscope wrote.
    Own,
}

/// Columns of the position.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum PlaceColumns {
    /// Columns of longitude and latitude, degrees.
    Degrees(usize, usize),
    /// Columns of easting and northing, metres.
    Metres(usize, usize),
}

/// Index of a column of lengths, and metres of its unit.
pub(super) type Lengths = (usize, f64);

/// Columns of a table of pings, beside a picture of them.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct PingColumns {
    /// Slant range of the outermost sample of each side.
    pub(super) range: Lengths,
    /// Slant range of the innermost sample of each side.
    pub(super) near: Option<Lengths>,
    /// Row of the picture.
    pub(super) row: Option<usize>,
}

/// Columns of a table, by their content.
#[derive(Clone, Debug, PartialEq)]
pub(in crate::formats) struct Layout {
    /// Separator between the fields.
    pub(super) separator: Option<char>,
    /// Columns of the position.
    pub(super) place: Option<PlaceColumns>,
    /// Column of the depth.
    pub(super) depth: Option<usize>,
    /// Columns of the pings of a picture; `None` where the rows are no pings.
    pub(super) pings: Option<PingColumns>,
    /// Metres of the depth's unit; negative where depths count upwards.
    pub(super) unit_m: f64,
    /// True if the name of the depth contains its unit, or there is no depth.
    pub(super) names_unit: bool,
    /// Column of the time, or of the time of day.
    pub(super) time: Option<usize>,
    /// Column of the date of a time of day.
    pub(super) date: Option<usize>,
    /// Column of the heading, degrees.
    pub(super) heading: Option<usize>,
    /// Column of the course over ground, degrees.
    pub(super) course: Option<usize>,
    /// Order of day and month in dates with slashes.
    pub(super) date_order: DateOrder,
    /// True if the columns are assumed without a line that names them.
    pub(super) is_assumed: bool,
    is_deeper: bool,
}

impl Layout {
    /// Recognises a table by its first lines; `None` where its rows are neither soundings nor
    /// pings.
    pub(super) fn of(lines: &[String]) -> Option<Recognised> {
        let first = lines.first()?;
        let separator = separator_of(first);
        separator?;
        let header = fields(first, separator);
        if !is_header(&header, separator) {
            let deeper = Self::of_deeper(lines, separator);
            let layout = deeper.or_else(|| Self::of_places(lines, separator));
            return layout.map(Recognised::Table);
        }
        let is_there = |name: &&str| header.iter().any(|field| field == name);
        if OWN.iter().all(is_there) {
            return Some(Recognised::Own);
        }
        let names: Vec<(String, Option<f64>)> =
            header.iter().map(|field| name_and_unit(field)).collect();
        let find = |known: &[&str]| {
            let position = |name: &&str| names.iter().position(|(field, _)| field == name);
            known.iter().find_map(position)
        };
        let lengths = |column: usize| (column, names[column].1.unwrap_or(1.0));
        let range = find(RANGE).map(lengths);
        let pings =
            range.map(|range| PingColumns { range, near: find(NEAR).map(lengths), row: find(ROW) });
        let height = find(BOTTOM);
        let depth = find(DEPTH).or(height);
        let depth_unit_m = depth.and_then(|depth| names[depth].1);
        let degrees = find(LON).or(find(&["long"])).zip(find(LAT));
        let metres = find(EAST).zip(find(NORTH));
        let place = degrees.map(|(lon, lat)| PlaceColumns::Degrees(lon, lat));
        let place = place.or(metres.map(|(east, north)| PlaceColumns::Metres(east, north)));
        let layout = Self {
            place,
            depth,
            pings,
            unit_m: depth_unit_m.unwrap_or(1.0),
            names_unit: depth.is_none() || depth_unit_m.is_some(),
            time: find(TIME).or(find(MOMENT)),
            date: find(&["date"]),
            heading: find(HEADING).or(find(&["yaw"])),
            course: find(COURSE),
            ..Self::unnamed(separator)
        };
        let is_height = depth.is_some() && depth == height;
        let layout = layout.fitting(&lines[1..]);
        let layout = layout.filter(|layout| !is_height || layout.unit_m < 0.0);
        let layout = layout.filter(|layout| layout.has_pings() || layout.has_soundings());
        layout.map(Recognised::Table)
    }

    /// Recognises rows of latitude, longitude, depth, and Unix milliseconds before or after the
    /// temperature.
    fn of_deeper(lines: &[String], separator: Option<char>) -> Option<Self> {
        let time_of = |line: &String| {
            let numbers = fields(line, separator).into_iter();
            let numbers: Vec<f64> = numbers.map_while(|field| number(field, separator)).collect();
            let [lat, lon, depth, ref rest @ ..] = numbers[..] else {
                return None;
            };
            let is_place = lat.abs() <= 90.0 && lon.abs() <= 180.0;
            let is_row = numbers.len() <= 5 && is_place && (0.0..1e4).contains(&depth);
            let time = rest.iter().position(|number| UNIX_MS.contains(number))?;
            is_row.then_some(3 + time)
        };
        let time = time_of(lines.first()?)?;
        let is_table = lines.len() >= FEWEST_ROWS;
        (is_table && lines.iter().all(|line| time_of(line) == Some(time))).then_some(Self {
            time: Some(time),
            is_deeper: true,
            ..Self::unnamed(separator)
        })
    }

    /// Recognises rows of only latitude, longitude and depth.
    fn of_places(lines: &[String], separator: Option<char>) -> Option<Self> {
        let row = |line: &String| {
            let texts = fields(line, separator);
            let [lat, lon, depth] = texts[..] else {
                return None;
            };
            let is_precise = |text: &str| {
                let decimals = text.split_once(['.', ',']);
                decimals.is_some_and(|(_, decimals)| decimals.len() >= DECIMALS_OF_A_PLACE)
            };
            let [lat_deg, lon_deg, depth] =
                [number(lat, separator)?, number(lon, separator)?, number(depth, separator)?];
            let is_place = lat_deg.abs() <= 90.0 && lon_deg.abs() <= 180.0;
            let is_row =
                is_precise(lat) && is_precise(lon) && is_place && (0.0..1e4).contains(&depth);
            is_row.then_some([lat_deg, lon_deg])
        };
        let rows: Option<Vec<[f64; 2]>> = lines.iter().map(row).collect();
        let rows = rows.filter(|rows| rows.len() >= FEWEST_ROWS)?;
        let is_near = |[lat, lon]: &[f64; 2]| {
            (lat - rows[0][0]).abs() < SURVEY_DEG && (lon - rows[0][1]).abs() < SURVEY_DEG
        };
        rows.iter().all(is_near).then_some(Self { is_assumed: true, ..Self::unnamed(separator) })
    }

    /// Returns the layout of a table without names: latitude, longitude and depth in metres.
    fn unnamed(separator: Option<char>) -> Self {
        Self {
            separator,
            place: Some(PlaceColumns::Degrees(1, 0)),
            depth: Some(2),
            pings: None,
            unit_m: 1.0,
            names_unit: true,
            time: None,
            date: None,
            heading: None,
            course: None,
            date_order: DateOrder::Unknown,
            is_assumed: false,
            is_deeper: false,
        }
    }

    /// Returns the layout completed from the first rows: direction of depths, order of dates,
    /// positions in degrees. `None` where no row has a depth and the rows are no pings.
    fn fitting(mut self, rows: &[String]) -> Option<Self> {
        let rows: Vec<Vec<&str>> = rows.iter().map(|row| fields(row, self.separator)).collect();
        let value = |row: &Vec<&str>, column: usize| {
            let number = number(row.get(column)?, self.separator)?;
            Some(number).filter(|number| number.is_finite() && *number != 0.0)
        };
        let depths = rows.iter().filter_map(|row| value(row, self.depth?));
        let (count, upwards) = depths.fold((0, 0), |(count, upwards), depth| {
            (count + 1, upwards + usize::from(depth < 0.0))
        });
        if count == 0 && self.pings.is_none() {
            return None;
        }
        if 2 * upwards > count {
            self.unit_m = -self.unit_m;
        }
        let dates = self.date.or(self.time);
        let dates = rows.iter().filter_map(|row| row.get(dates?).copied());
        self.date_order = DateOrder::of(dates);
        if let Some(PlaceColumns::Metres(x, y)) = self.place {
            let is_degrees = |row: &Vec<&str>| {
                let place = value(row, x).zip(value(row, y));
                place.is_none_or(|(x, y)| x.abs() <= 180.0 && y.abs() <= 90.0)
            };
            if rows.iter().all(is_degrees) {
                self.place = Some(PlaceColumns::Degrees(x, y));
            }
        }
        Some(self)
    }

    /// Returns true if the rows are soundings.
    pub(super) fn has_soundings(&self) -> bool {
        self.depth.is_some() && self.place.is_some()
    }

    /// Returns the layout without pings, for a table without a picture beside it.
    pub(super) fn without_pings(self) -> Self {
        Self { pings: None, ..self }
    }

    /// Returns true if the rows are pings of a picture.
    pub(in crate::formats) fn has_pings(&self) -> bool {
        self.pings.is_some()
    }

    /// Returns true if the first line names the columns.
    pub(super) fn has_header(&self) -> bool {
        !self.is_deeper && !self.is_assumed
    }

    /// Returns the name of the recorder; empty where the layout does not show it.
    pub(super) fn device(&self) -> &'static str {
        if self.is_deeper { "Deeper" } else { "" }
    }
}

/// Splits a column's name into name and metres of its unit: `Water Depth (ft)` into `water_depth`
/// and 0.3048.
fn name_and_unit(field: &str) -> (String, Option<f64>) {
    let field = field.to_lowercase();
    let unit_m = |text: &str| {
        let text = text.trim_matches(|letter: char| !letter.is_alphabetic());
        let unit = UNITS.iter().find(|(unit, _)| *unit == text);
        unit.map(|(_, unit_m)| *unit_m)
    };
    let name_of = |text: &str| text.trim().replace([' ', '-', '.'], "_");
    if let Some((name, unit)) = field.split_once(['(', '[']) {
        return (name_of(name), unit_m(unit));
    }
    let name = name_of(&field);
    if let Some((before, unit)) = name.rsplit_once('_')
        && let Some(unit_m) = unit_m(unit)
    {
        // `depth_in_feet` is in feet, but `depth_in` may be in inches.
        return (before.strip_suffix("_in").unwrap_or(before).to_owned(), Some(unit_m));
    }
    (name, None)
}

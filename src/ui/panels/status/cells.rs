//! Composes facts of a place for the status bar, shortened to the available width.

use crate::app::{App, LogPlace};
use crate::ui::{place, text};
use bathyscope_log::survey::Side;

/// One fact of a place.
pub(super) struct StatusCell {
    /// Full text.
    pub text: String,
    /// Short text for a narrow bar; `None` if the full text is used there, too.
    short: Option<String>,
    /// Rank of importance: cells with the highest rank are left out first when the window becomes
    /// narrower.
    rank: u8,
}

impl StatusCell {
    fn new(rank: u8, text: String) -> Self {
        let short = None;
        Self { text, short, rank }
    }
}

/// Returns position, ping, range, altitude, depth, heading, speed and time of a place, in the order
/// of the bar.
pub(super) fn of(app: &App, mark: LogPlace) -> Vec<StatusCell> {
    let units = app.view.options.units;
    let survey = app.logs.shown.survey.as_ref();
    let Some(ping) = survey.and_then(|survey| survey.side_scan.get(mark.ping)) else {
        return Vec::new();
    };
    let position = place::lon_lat(app, mark).map(|at| StatusCell::new(0, place::written(app, at)));
    let range = place::range_m(app, mark).map(|range_m| {
        let side = match mark.side {
            Some(Side::Port) => " port",
            Some(Side::Starboard) => " stbd",
            None => "",
        };
        StatusCell::new(2, format!("range {}{side}", units.measure(range_m, 2)))
    });
    let products = app.logs.shown.products.as_ref();
    let here = products.and_then(|products| products.navigation.pings.get(mark.ping));
    let speed = here.map_or(f64::NAN, |here| here.speed_mps);
    let start_unix_s = survey.and_then(|survey| survey.start_unix_s);
    let bottom = place::bottom(app, mark.ping);
    let metres = |of: fn(place::BottomBelow) -> f64| units.measure(bottom.map_or(f64::NAN, of), 2);
    let depth = StatusCell {
        text: format!("depth {}", place::depth(app, mark.ping)),
        short: Some(format!("depth {}", metres(|bottom| bottom.depth_m))),
        rank: 1,
    };
    let cells = [
        position,
        Some(StatusCell::new(4, format!("ping {}", mark.ping))),
        range,
        Some(StatusCell::new(3, format!("altitude {}", metres(|bottom| bottom.altitude_m)))),
        Some(depth),
        Some(StatusCell::new(6, place::labelled_heading(app, mark.ping))),
        Some(StatusCell::new(7, units.speed(speed, 1))),
        Some(StatusCell::new(5, text::clock(start_unix_s, ping.time_s))),
    ];
    cells.into_iter().flatten().collect()
}

/// Returns the texts that fit into `room`, in their order: all full texts, or all short ones, or
/// the short ones without the least important cells. `width` returns the width of a text with the
/// gap behind it.
pub(super) fn fitting(cells: &[StatusCell], room: f32, width: impl Fn(&str) -> f32) -> Vec<&str> {
    let total = |texts: &[&str]| texts.iter().map(|text| width(text)).sum::<f32>();
    let full: Vec<&str> = cells.iter().map(|cell| cell.text.as_str()).collect();
    if total(&full) <= room {
        return full;
    }
    let last = cells.iter().map(|cell| cell.rank).max().unwrap_or(0);
    let upto = |rank: u8| -> Vec<&str> {
        let cells = cells.iter().filter(|cell| cell.rank <= rank);
        cells.map(|cell| cell.short.as_ref().unwrap_or(&cell.text).as_str()).collect()
    };
    let candidates = (0..=last).rev().map(upto);
    let mut fitting = candidates.filter(|texts| total(texts) <= room);
    fitting.next().unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_matters_least_gives_way_first() {
        let cells = [
            StatusCell::new(0, "position".to_owned()),
            StatusCell::new(2, "ping".to_owned()),
            StatusCell {
                text: "depth below transducer".to_owned(),
                short: Some("depth".to_owned()),
                rank: 1,
            },
            StatusCell::new(3, "speed".to_owned()),
        ];
        let shown = |room: f32| fitting(&cells, room, |text| text.len() as f32).join(" ");
        assert_eq!(shown(39.0), "position ping depth below transducer speed");
        assert_eq!(shown(38.0), "position ping depth speed");
        assert_eq!(shown(22.0), "position ping depth speed");
        assert_eq!(shown(21.0), "position ping depth");
        assert_eq!(shown(16.0), "position depth");
        assert_eq!(shown(12.0), "position");
        assert_eq!(shown(7.0), "", "nothing is cut off");
        assert!(fitting(&[], 10.0, |_| 1.0).is_empty());
    }
}

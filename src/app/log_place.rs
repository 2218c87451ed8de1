//! A place in the survey, and the request to show one.

use bathyscope_log::survey::Side;

/// A place in the survey, the same in all views.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LogPlace {
    /// Side-scan ping.
    pub ping: usize,
    /// Side, when the place is off the track.
    pub side: Option<Side>,
    /// Distance outward in u8 samples.
    pub sample: Option<f32>,
    /// Point of the cloud.
    pub point: Option<usize>,
}

impl LogPlace {
    /// A place on the track.
    pub fn ping(ping: usize) -> Self {
        Self { ping, side: None, sample: None, point: None }
    }
}

/// A request to bring a place into view; views act when the serial number changes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reveal {
    /// The place.
    pub mark: LogPlace,
    /// Grows with each request.
    pub serial: u64,
    /// Object that the views enlarge; without it they only bring the place into view.
    pub close_up: Option<CloseUp>,
}

/// Scale at which an object is shown.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Enlarged {
    /// It fills about a third of the view.
    Third,
    /// A sample of the picture is a point of the screen; what does not fit in so, with what lies
    /// around it, is smaller. For the waterfall alone: the other views only bring it into view.
    OneToOne,
    /// The scale stays; the box comes into the middle where it is not well in view. For the
    /// waterfall alone as well.
    AsItIs,
}

/// An object that the views enlarge.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CloseUp {
    /// Scale at which it is shown.
    pub enlarged: Enlarged,
    /// First ping of its box, and the first one after it.
    pub pings: [usize; 2],
    /// Slant ranges of the edges of its box by the recorder's scale, port negative, metres.
    pub across_m: [f64; 2],
    /// Its place, metres east, north and up in the plane of the survey; `None` where it has none.
    pub place_m: Option<[f64; 3]>,
    /// Its longer side on the ground, metres.
    pub size_m: f64,
}

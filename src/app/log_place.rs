//! Defines a place in the survey, and the request to show a place.

use bathyscope_log::survey::Side;

/// A place in the survey, the same in all views.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LogPlace {
    /// Side-scan ping.
    pub ping: usize,
    /// Side of the boat; `None` for a place on the track.
    pub side: Option<Side>,
    /// Distance outward in u8 samples; `None` without a sample.
    pub sample: Option<f32>,
    /// Index of a point of the cloud; `None` without a point.
    pub point: Option<usize>,
}

impl LogPlace {
    /// Creates a place on the track.
    pub fn ping(ping: usize) -> Self {
        Self { ping, side: None, sample: None, point: None }
    }
}

/// A request to bring a place into view; views act when the serial number changes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reveal {
    /// The place.
    pub mark: LogPlace,
    /// Number that grows with each request.
    pub serial: u64,
    /// Object that the views enlarge; with `None` they only bring the place into view.
    pub close_up: Option<CloseUp>,
}

/// Scale at which an object is shown.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Enlarged {
    /// The object fills about a third of the view.
    Third,
    /// A sample of the picture is a point of the screen; an object that does not fit with its
    /// surroundings is drawn smaller. For the waterfall alone: the other views only bring the
    /// object into view.
    OneToOne,
    /// The scale stays; the waterfall moves the box to the middle if it is not well in view. For
    /// the waterfall alone, too.
    AsItIs,
}

/// An object that the views enlarge.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CloseUp {
    /// Scale at which the object is shown.
    pub enlarged: Enlarged,
    /// First ping of the object's box, and the first ping after it.
    pub pings: [usize; 2],
    /// Slant ranges of the edges of the object's box by the recorder's scale, port negative,
    /// metres.
    pub across_m: [f64; 2],
    /// Position of the object, metres east, north and up in the plane of the survey; `None` if it
    /// has none.
    pub place_m: Option<[f64; 3]>,
    /// Longer side of the object on the ground, metres.
    pub size_m: f64,
}

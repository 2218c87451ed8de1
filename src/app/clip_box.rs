//! Defines the box to which the 3D view is clipped.

/// A box along the axes of the survey's plane: the 3D view draws nothing outside it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClipBox {
    /// Ends in east, north and elevation, metres in the plane of the survey; infinite where the box
    /// has no end.
    pub ends_m: [[f64; 2]; 3],
}

impl ClipBox {
    /// The box without ends, which clips nothing.
    pub const WHOLE: Self = Self { ends_m: [[f64::NEG_INFINITY, f64::INFINITY]; 3] };
}

//! The part of the 3D view that is drawn.

/// A box along the axes of the survey's plane: what lies outside of it is not drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClipBox {
    /// Ends east, north and in elevation, metres in the plane of the survey; infinite where it goes
    /// on as far as there is anything.
    pub ends_m: [[f64; 2]; 3],
}

impl ClipBox {
    /// Everything.
    pub const WHOLE: Self = Self { ends_m: [[f64::NEG_INFINITY, f64::INFINITY]; 3] };
}

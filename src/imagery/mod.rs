//! Echoes as pictures: the waterfall, how it is shown, and the mosaic on the ground.
//!
//! In: a survey with first returns and calibration. Out: picture tiles, gain tables and mosaics. It uses `bottom`, `sonar`, `survey` and
//! `support`.

pub(crate) mod mosaic;
pub(crate) mod picture;
pub(crate) mod waterfall;

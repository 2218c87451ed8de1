//! Presents results in the same way in Bathyscope, in the report, in files and in the evaluation:
//! colours, numbers as text, round steps, the graticule and plots. Nothing here depends on a
//! widget, the GPU or a survey.
//!
//! In: plain numbers. Out: colours, texts, ticks and SVG.

pub mod colours;
pub mod graticule;
pub mod plot;
pub mod text;
pub mod ticks;
pub mod units;

//! Presentation of results, the same in Bathyscope, in the report, in files and in the evaluation:
//! colours, numbers in words, round steps, the graticule and plots. Nothing here depends on a
//! widget, the GPU or a survey.
//!
//! In: plain numbers. Out: colours, texts, ticks and SVG.

pub mod colours;
pub mod graticule;
pub mod plot;
pub mod text;
pub mod ticks;
pub mod units;

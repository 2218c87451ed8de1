//! Presents results in the same way in Bathyscope, in the report, in files and in the evaluation:
//! colours, numbers as text, round steps, the graticule, plots and pages. Nothing here depends on a
//! widget, the GPU or a survey.
//!
//! In: plain numbers and templates. Out: colours, texts, ticks, SVG and HTML.

pub mod colours;
pub mod graticule;
pub mod page;
pub mod plot;
pub mod text;
pub mod ticks;
pub mod units;

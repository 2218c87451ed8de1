//! How results are shown, the same in the window, in the report, in files and in the evaluation: colours, numbers in words,
//! round steps, the graticule and plots. Plain numbers in; nothing here knows a widget, the GPU or a survey.

pub mod colours;
pub mod graticule;
pub mod plot;
pub mod text;
pub mod ticks;
pub mod units;

//! How results are shown, the same in the window, in the report, in files and in the evaluation: colours, numbers in words,
//! round steps and the graticule. Plain numbers in; nothing here knows a widget, the GPU or a survey.

pub mod colours;
pub mod graticule;
pub mod text;
pub mod ticks;

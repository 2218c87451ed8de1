//! How results are shown, the same in the window, in the report, in files and in the evaluation: colours. Plain numbers in;
//! nothing here knows a widget, the GPU or a survey.

pub mod colours;

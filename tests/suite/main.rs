//! Tests of several crates together, of the window and of the program. Tests of one crate are in
//! that crate; what reads broken files is shared with the fuzzer (`tests/fuzz`).

#![allow(
    clippy::expect_used,
    clippy::unwrap_used,
    reason = "their failure is the failure of the test"
)]

// What holds for the repository: borders between modules, packages, tables in the manual and the
// README.
mod architecture;
mod formats_table;
mod manual;
#[cfg(unix)]
mod packaging;
mod program;

// The command line: names, columns, units and exit codes of the contract.
mod cli;
mod dataset;
mod log_copy;
mod outputs;
mod planning;
mod same_bytes;

// Whole runs: several logs, archives, projects, real recordings.
mod archive;
mod changed_log;
mod contradicted_logs;
mod many_logs;
mod many_logs_files;
mod new_survey;
mod residuals;
mod scaled_logs;
mod shifted_logs;
mod survey_run;
mod targets;

// Bad input: broken files, hostile names, logs that are lost, programs that are killed.
/// A file that is mapped cannot be cut, replaced or removed on Windows.
#[cfg(unix)]
mod failing_log;
#[allow(
    dead_code,
    unreachable_pub,
    reason = "the fuzzer, a program of its own, calls it from outside"
)]
#[path = "../fuzz/mod.rs"]
mod fuzz;
mod hostile;
mod killed_project;
mod untitled_project;

// The window as a whole: start, layout, keys, units, undo, printing.
mod calm_window;
mod conventions_window;
mod first_window;
mod history_window;
mod keyboard_window;
mod keys_window;
mod printing;
mod project_window;
mod real_window;
mod status_bar;
mod units_window;
mod window;
mod window_job;
mod window_layout;

// Views: waterfall, map, 3D, lists.
mod bottom_3d;
mod logs_window;
mod map_layers;
mod map_tools;
mod objects_window;
mod one_list;
mod passes_window;
mod space;
mod waterfall;
mod waterfall_measure;

// Work of the analyst in the window: bottom, calibration, corrections, exclusions, review.
mod bottom;
mod bottom_line;
mod calibration_window;
mod corrected;
mod depths;
mod exclusion_window;
mod following;
mod isobaths_window;
mod mounting;
mod planning_window;
mod point_attributes;
mod review;

// Helpers.
mod support;
#[allow(dead_code, reason = "tests of bathyscope-products use all of it")]
#[path = "../../src/products/tests/suite/truth.rs"]
mod truth;

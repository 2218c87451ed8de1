//! Tests of several crates together, of the window and of the program. `support` finds real
//! recordings and simulated surveys.

#![allow(
    clippy::expect_used,
    clippy::unwrap_used,
    reason = "their failure is the failure of the test"
)]

mod architecture;
mod archive;
mod base_map;
mod bathymetry;
mod bottom;
mod bottom_3d;
mod bottom_line;
mod calibration;
mod calibration_window;
mod calm_window;
mod changed_log;
mod cli;
mod cloud;
mod conventions_window;
mod corrected;
mod crs;
mod damage;
mod dataset;
mod depths;
mod detection_metrics;
mod detection_targets;
mod detector;
mod exclusion_window;
mod export;
/// A file that is mapped cannot be cut, replaced or removed on Windows.
#[cfg(unix)]
mod failing_log;
mod first_return;
mod first_window;
mod following;
mod formats;
#[allow(
    dead_code,
    unreachable_pub,
    reason = "the fuzzer, a program of its own, calls it from outside"
)]
#[path = "../fuzz/mod.rs"]
mod fuzz;
mod garbled;
mod golden;
mod history_window;
mod hostile;
mod isobaths_window;
mod keyboard_window;
mod keys_window;
mod killed_project;
mod large_boxes;
mod log_copy;
mod logs_window;
mod manual;
mod many_logs;
mod many_logs_files;
mod map_layers;
mod map_tools;
mod missions;
mod mosaic;
mod mosaic_gain;
mod mounting;
mod navigation;
mod new_survey;
mod objects_window;
mod offsets;
mod one_list;
mod outputs;
#[cfg(unix)]
mod packaging;
mod passes_window;
mod picture_log;
mod planning;
mod planning_window;
mod point_attributes;
mod point_classes;
mod printing;
mod program;
mod project_window;
mod real_window;
mod residuals;
mod review;
mod river;
mod same_bytes;
mod shifted_logs;
mod shipped_model;
mod simulation;
mod space;
mod status_bar;
mod support;
mod survey_run;
mod swath;
mod targets;
mod trusted_depths;
mod truth;
mod units_window;
mod waterfall;
mod waterfall_measure;
mod window;
mod window_job;
mod window_layout;

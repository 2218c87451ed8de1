//! The window and the commands of Bathyscope: from the log of a low-cost side-scan fish-finder to a
//! depth map and a 3D point cloud.
//!
//! Data flows one way, and so do the dependencies. Each crate uses those above it, and each module
//! of this crate too:
//!
//! ```text
//! bathyscope_log         bytes -> logs: pings, samples, track; and the files of other instruments
//! bathyscope_simulation  scenes of known truth, written as logs
//! bathyscope_bottom      -> first returns, calibration, points, surfaces, mosaics, pictures
//! bathyscope_objects     -> boxes, review, objects, shapes
//! bathyscope_products    runs the stages, keeps what is valid and what was decided, writes files
//! app                    what the analyst sees and decides: state, commands, undo; the manual
//! ui                     the window (egui); render draws on the GPU and knows no log
//! cli                    the program: arguments -> window or headless run
//! ```
//!
//! Every stage is a pure function `fn(&input, &settings, &Progress) -> Result<output>`; outputs are
//! immutable and shared as `Arc`. Coordinates inside are SI: metres east and north of the survey's
//! origin, radians clockwise from north, depth positive down (`depth_m`), elevation positive up
//! (`z_m`). Degrees and feet exist only at the edges.
//!
//! Without the feature `gui`, which is on by default, there is no `ui`, and no crate for windows
//! and GPUs.

// Their failure is the failure of the test.
#![cfg_attr(test, allow(clippy::expect_used, clippy::unwrap_used))]
#![cfg_attr(
    not(feature = "gui"),
    allow(
        dead_code,
        unused_imports,
        reason = "the program without a window uses a part of what the window uses"
    )
)]

pub mod app;
pub mod cli;
#[cfg(feature = "gui")]
pub mod ui;

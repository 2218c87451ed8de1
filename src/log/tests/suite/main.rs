//! Logs, base maps and coordinate systems as the crate reads them: real recordings, small logs
//! written byte by byte, and damaged ones.

#![allow(
    clippy::expect_used,
    clippy::unwrap_used,
    reason = "their failure is the failure of the test"
)]

mod base_map;
mod crs;
mod damage;
mod formats;

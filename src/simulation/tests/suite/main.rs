//! Tests simulated surveys against their truth.

#![allow(
    clippy::expect_used,
    clippy::unwrap_used,
    reason = "their failure is the failure of the test"
)]

mod simulation;

//! First returns of real recordings and simulated ponds, and the golden values of the geometry.

#![allow(
    clippy::expect_used,
    clippy::unwrap_used,
    reason = "their failure is the failure of the test"
)]

mod first_return;
mod golden;

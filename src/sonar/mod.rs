//! What is found in pings and samples: the first return of each side, and the scale from samples to metres.
//!
//! In: a [`Survey`](crate::survey::Survey). Out: first returns and a calibration. It uses `survey` and `support`.

pub(crate) mod calibration;
pub(crate) mod first_return;

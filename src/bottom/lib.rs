//! Finds the bottom in a side-scan log, and makes maps of it.
//!
//! [`first_return`] finds the first echo of the bottom in each ping on both sides, and
//! [`calibration`] the scale from samples to metres. [`cloud`] places first returns and soundings
//! on the ground, [`bathymetry`] makes surfaces, isobaths and comparisons of them, [`swath`]
//! computes depths between the lines from echo levels, and [`planning`] the lines to survey next.
//! [`waterfall`] and [`picture`] draw echoes by ping, [`mosaic`] draws them on the ground.
//! [`presentation`] provides the colours, units and texts in which all results are shown.
//!
//! # Find the first returns
//!
//! ```
//! use bathyscope_bottom::first_return::{FirstReturnSettings, ImageSettings, detect};
//! use bathyscope_log::formats::open;
//! use bathyscope_log::support::progress::Progress;
//! use bathyscope_log::survey::Side;
//!
//! let progress = Progress::new();
//! # let demo = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../assets/demo.sl2");
//! let survey = open(&demo, &progress)?;
//! let (image, settings) = (ImageSettings::default(), FirstReturnSettings::default());
//! let returns = detect(&survey, &image, &settings, &progress)?;
//! let found = returns.side(Side::Port).iter().filter(|pick| pick.is_some());
//! # assert!(found.clone().count() > 1000);
//! println!("{} pings have a first return to port", found.count());
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # Interpolate depths
//!
//! ```
//! use bathyscope_bottom::bathymetry::{DepthPoint, SurfaceSettings, surface};
//! use bathyscope_log::support::progress::Progress;
//!
//! let corners = [([0.0, 0.0], 1.0), ([10.0, 0.0], 2.0), ([0.0, 10.0], 3.0)];
//! let points = corners.map(|(place, depth_m)| DepthPoint::of_sounding(place, depth_m)).to_vec();
//! let settings = SurfaceSettings::default();
//! let surface = surface(points, &settings, &Progress::new())?.expect("three places");
//! let [shallowest_m, deepest_m] = surface.range_m();
//! assert!(1.0 <= shallowest_m && deepest_m <= 3.0);
//! # Ok::<(), bathyscope_log::support::progress::Cancelled>(())
//! ```

// A failed `expect` or `unwrap` fails the test.
#![cfg_attr(test, allow(clippy::expect_used, clippy::unwrap_used))]

pub mod bathymetry;
pub mod calibration;
pub mod cloud;
pub mod first_return;
pub mod mosaic;
mod nearest;
pub mod picture;
pub mod planning;
pub mod presentation;
mod sparse;
pub mod swath;
pub mod vectors;
pub mod waterfall;

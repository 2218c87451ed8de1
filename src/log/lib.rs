//! Opens the logs of fish-finders and side-scan sonars of many makers as one type, `Survey`.
//!
//! A log is recognised by its content: Lowrance SL2, SL3 and SLG, Garmin RSD, Humminbird folders,
//! XTF, EdgeTech JSF, Klein SDF, Cerulean svlog, NMEA 0183, tables of soundings, and waterfalls
//! that were exported as pictures. Every format is read into the same [`Survey`](survey::Survey):
//! pings of both sides with their samples, channels that look down, soundings and a track. Damaged
//! parts are skipped and listed with their place in the file; a log is never changed.
//!
//! Everything is in SI units: metres, seconds, radians clockwise from north, and depths that
//! count downward (`depth_m`). Samples stay in the file, which is mapped into memory.
//!
//! # Open a log
//!
//! ```
//! use bathyscope_log::formats::open;
//! use bathyscope_log::support::progress::Progress;
//!
//! # let demo = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../assets/demo.sl2");
//! let survey = open(&demo, &Progress::new())?;
//! println!("{} pings, {} soundings", survey.side_scan.len(), survey.soundings.len());
//! # assert!(survey.has_side_scan() && survey.soundings.len() > 100);
//! # Ok::<(), bathyscope_log::formats::OpenError>(())
//! ```
//!
//! # Read what belongs to a log
//!
//! [`formats`] also reads tracks of other receivers, water levels of gauges, areas of water, points
//! and rasters of depths.

// In a test, a failing `expect` or `unwrap` is a failing test.
#![cfg_attr(test, allow(clippy::expect_used, clippy::unwrap_used))]

pub mod formats;
pub mod support;
pub mod survey;

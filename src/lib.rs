//! Bathyscope: from the log of a low-cost side-scan fish-finder to a depth map and a 3D point cloud.
//!
//! Data flows one way, and so do the dependencies between the modules below (a test guards it). Each module uses only those above it:
//!
//! ```text
//! support      positions, colours, progress, statistics: serves all
//! survey       one log as it was recorded: pings, samples, track
//! formats      bytes -> Survey, and the files of other instruments
//! simulation   scenes of known truth, written as logs
//! sonar        Survey -> first returns, calibration
//! bottom       -> points, surfaces, isobaths, depths from echo levels, planned lines
//! imagery      -> waterfall, picture, mosaic
//! detection    -> boxes, review, objects, shapes
//! pipeline     runs the stages, keeps what is valid, knows what is out of date
//! products     results -> files, report, map tiles, archives of many logs
//! project      what was decided about a survey, on disk
//! app          what the analyst sees and decides: state, commands, undo; the manual
//! ui           the window (egui); render draws on the GPU and knows no survey
//! cli          the program: arguments -> window or headless run
//! ```
//!
//! # For other programs
//!
//! The program, its window and all files are made of these parts; they are what the crate offers. A [`Survey`] is opened, [`run`] makes
//! everything of one log, [`Derived`] what all logs of a survey give together, and [`write`] the files.
//!
//! Open a log:
//!
//! ```
//! use bathyscope::{Progress, open};
//! use std::path::Path;
//!
//! let survey = open(Path::new("assets/demo.sl2"), &Progress::new())?;
//! println!("{} pings, {} soundings", survey.side_scan.len(), survey.soundings.len());
//! # assert!(survey.has_side_scan() && survey.soundings.len() > 100);
//! # Ok::<(), bathyscope::OpenError>(())
//! ```
//!
//! Find the first return of each ping on both sides:
//!
//! ```
//! # use bathyscope::{Progress, open};
//! use bathyscope::{Settings, Side, first_returns};
//!
//! # let progress = Progress::new();
//! # let survey = open("assets/demo.sl2".as_ref(), &progress)?;
//! let settings = Settings::default();
//! let returns = first_returns(&survey, &settings.image, &settings.first_return, &progress)?;
//! let found = returns.side(Side::Port).iter().filter(|pick| pick.is_some());
//! # assert!(found.clone().count() > 1000);
//! println!("{} pings have a first return to port", found.count());
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! Run all stages on a log, and take its point cloud; later runs with other settings take over what these do not change:
//!
//! ```
//! # use bathyscope::{Progress, open};
//! use bathyscope::{Settings, run};
//!
//! # let progress = Progress::new();
//! # let survey = open("assets/demo.sl2".as_ref(), &progress)?;
//! let products = run(&survey, &Settings::default(), None, &progress, |_| ())?;
//! let deepest = products.cloud.points.iter().map(|point| point.z_m).fold(0.0, f64::min);
//! println!("{} points, the deepest at {deepest:.2} m", products.cloud.points.len());
//! # assert!((-3.5..-1.0).contains(&deepest));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! Make the depth map and the mosaic of all logs:
//!
//! ```
//! # use bathyscope::{Progress, Settings, open, run};
//! use bathyscope::{Derived, MosaicPlane, ProcessedLog};
//! use std::sync::Arc;
//!
//! # let progress = Progress::new();
//! # let survey = Arc::new(open("assets/demo.sl2".as_ref(), &progress)?);
//! # let products = run(&survey, &Settings::default(), None, &progress, |_| ())?;
//! let logs = [ProcessedLog { survey, products }];
//! let derived = Derived::default();
//! let depth_map = derived.depth_map(&logs, &progress)?.expect("the depths span a surface");
//! let [shallowest_m, deepest_m] = depth_map.surface.range_m();
//! # assert!(1.0 < shallowest_m && deepest_m < 3.0);
//! let mosaic = derived.mosaic(&logs, MosaicPlane::Survey, &progress)?.expect("side-scan with positions");
//! # let _ = mosaic;
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! Interpolate depths of your own:
//!
//! ```
//! use bathyscope::{DepthPoint, Progress, SurfaceSettings, surface};
//!
//! let corner = |east_m, north_m, depth_m| DepthPoint { east_m, north_m, depth_m, weight: 1.0, is_sounding: true };
//! let points = vec![corner(0.0, 0.0, 1.0), corner(10.0, 0.0, 2.0), corner(0.0, 10.0, 3.0)];
//! let surface = surface(points, &SurfaceSettings::default(), &Progress::new())?.expect("three places");
//! let [shallowest_m, deepest_m] = surface.range_m();
//! assert!(1.0 <= shallowest_m && deepest_m <= 3.0);
//! # Ok::<(), bathyscope::Cancelled>(())
//! ```
//!
//! Search a log for objects:
//!
//! ```no_run
//! # use bathyscope::{Progress, Settings, open, run};
//! use bathyscope::{DetectorSettings, Model, find_objects};
//!
//! # let progress = Progress::new();
//! # let survey = open("assets/demo.sl2".as_ref(), &progress)?;
//! # let products = run(&survey, &Settings::default(), None, &progress, |_| ())?;
//! let model = Model::load("assets/detector/default.onnx".as_ref())?;
//! let settings = DetectorSettings::default();
//! for object in find_objects(&survey, &products.navigation, &model, &settings, &progress, |_| ())? {
//!     println!("{:.2} at ping {}", object.score, object.mark.pings.start);
//! }
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! Write the files of a run, all of them or none:
//!
//! ```
//! # use bathyscope::{Derived, ProcessedLog, Progress, Settings, open, run};
//! use bathyscope::{Order, Product, RunFolder, SurveyReview, write};
//!
//! # let progress = Progress::new();
//! # let survey = std::sync::Arc::new(open("assets/demo.sl2".as_ref(), &progress)?);
//! # let products = run(&survey, &Settings::default(), None, &progress, |_| ())?;
//! # let logs = [ProcessedLog { survey, products }];
//! # let folder = tempfile::tempdir()?;
//! # let folder = folder.path();
//! let order = Order {
//!     logs: &logs,
//!     derived: &Derived::default(),
//!     requested: &[Product::Track],
//!     reference: None,
//!     search: None,
//!     review: &SurveyReview::default(),
//!     corrections: &[],
//! };
//! let written = write(&order, RunFolder::begin(folder)?, &progress, |_| ())?;
//! println!("{} files", written.file_count);
//! # assert!(folder.join("report.json").is_file());
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! Every stage is a pure function `fn(&input, &settings, &Progress) -> Result<output>`; outputs are immutable and shared
//! as `Arc`. Coordinates inside are SI: metres east and north of the survey's origin, radians clockwise from north,
//! depth positive down (`depth_m`), elevation positive up (`z_m`). Degrees and feet exist only at the edges.
//!
//! Without the feature `gui`, which is on by default, there is no `ui`, and no crate for windows and GPUs.

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
#[doc(hidden)]
pub mod cli;
#[cfg(feature = "gui")]
pub mod ui;

pub use bathyscope_bottom::bathymetry::{DepthPoint, Surface, SurfaceSettings, surface};
pub use bathyscope_bottom::calibration::Calibration;
pub use bathyscope_bottom::cloud::{CloudPoint, PointCloud};
pub use bathyscope_bottom::first_return::{FirstReturns, Pick, detect as first_returns};
pub use bathyscope_log::formats::{OpenError, open};
pub use bathyscope_log::support::progress::{Cancelled, Progress};
pub use bathyscope_log::survey::{Side, Survey};
pub use bathyscope_objects::objects::SurveyReview;
pub use bathyscope_objects::{Detection, DetectorSettings, Mark, Model, find as find_objects};
pub use bathyscope_products::outputs::{Order, Product, RunFolder, Written, write};
pub use bathyscope_products::pipeline::{
    DepthMap, Derived, Mosaic, MosaicPlane, Preset, ProcessedLog, Products, Settings, Stage, run,
};

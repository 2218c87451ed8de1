//! Computes results over all logs of a survey on demand.
//!
//! In: the results of logs, and settings. Out: the depth map, isobaths, the bottom in 3D, mosaic
//! and pictures, each made once.
//!
//! ```text
//! results of the logs --surface--> DepthMap (with its hill-shade) --lines--> Isobaths
//!                     |                                     '--colours--> Bottom
//!                     --layout--> GainTable of each log --> Mosaic
//!                     |                                 '--> LogPicture
//!                     '--layout--> MosaicLayout of each log, for the Mosaic on the screen and for passes
//! ```
//!
//! [`Derived`] has one node for each result, so that the map on the screen, the files and the
//! report share it: for equal inputs and settings a result is computed once. No other code computes
//! these results.

mod bottom;
mod depth_map;
mod isobaths;
mod mosaic;
mod node;
mod side_scan;

pub use bottom::{Bottom, BottomColour, BottomKey, CornerGround};
pub use depth_map::{DepthMap, DepthMapKey};
pub(crate) use isobaths::Contours;
pub use isobaths::{IsobathKey, Isobaths};
pub use mosaic::{FINEST, Mosaic, MosaicKey, MosaicPlane};
pub use side_scan::{Pass, PictureKey, mosaic_layout, mosaic_layout_by, passes_over, place_of};

use crate::pipeline::ProcessedLog;
use bathyscope_bottom::bathymetry::isobaths::{IsobathSettings, NoIsobaths};
use bathyscope_bottom::mosaic::{GainTable, MosaicLayout};
use bathyscope_bottom::picture::LogPicture;
use bathyscope_log::support::progress::{Cancelled, Progress};
use node::DerivedNode;
use side_scan::{GainKey, LayoutKey, made_gain, made_picture};
use std::sync::Arc;

/// Number of logs whose gain tables are kept; each table is small.
const GAIN_TABLES: usize = 32;
/// Number of pings whose layouts are kept: each takes some 100 bytes.
const LAID_OUT_PINGS: usize = 1_000_000;

/// Depth map, isobaths, mosaic and pictures of logs, each computed when it is first requested.
pub struct Derived {
    depth_map: DerivedNode<DepthMapKey, Option<Arc<DepthMap>>>,
    isobaths: DerivedNode<IsobathKey, Result<Arc<Isobaths>, NoIsobaths>>,
    gain: DerivedNode<GainKey, Option<Arc<GainTable>>>,
    layout: DerivedNode<LayoutKey, Arc<MosaicLayout>>,
    mosaic: DerivedNode<MosaicKey, Option<Arc<Mosaic>>>,
    picture: DerivedNode<PictureKey, Arc<LogPicture>>,
    bottom: DerivedNode<BottomKey, Arc<Bottom>>,
}

impl Default for Derived {
    fn default() -> Self {
        Self {
            depth_map: DerivedNode::keeping(1),
            isobaths: DerivedNode::keeping(1),
            gain: DerivedNode::keeping(GAIN_TABLES),
            layout: DerivedNode::weighing(LAID_OUT_PINGS, |layout| layout.len()),
            picture: DerivedNode::keeping(2),
            bottom: DerivedNode::keeping(1),
            // One in the plane of the survey for the screen, one in the plane of the map for files.
            mosaic: DerivedNode::keeping(2),
        }
    }
}

impl Derived {
    /// Returns the depth map of some logs; `None` if the depths span no surface.
    ///
    /// # Errors
    /// When the work was cancelled.
    pub fn depth_map(
        &self,
        logs: &[ProcessedLog],
        progress: &Progress,
    ) -> Result<Option<Arc<DepthMap>>, Cancelled> {
        self.depth_map.get(DepthMapKey::of(logs), progress, || {
            Ok(DepthMap::new(logs, progress)?.map(Arc::new))
        })
    }

    /// Returns the isobaths of a depth map; the inner error is the reason why the settings give
    /// none.
    ///
    /// # Errors
    /// When the work was cancelled.
    pub fn isobaths(
        &self,
        depth_map: &Arc<DepthMap>,
        settings: &IsobathSettings,
        progress: &Progress,
    ) -> Result<Result<Arc<Isobaths>, NoIsobaths>, Cancelled> {
        let key = IsobathKey::of(depth_map, settings);
        self.isobaths
            .get(key, progress, || Ok(Isobaths::new(depth_map, settings, progress)?.map(Arc::new)))
    }

    /// Returns the 3D bottom with at most `most_corners` corners; `None` if the depths span no
    /// surface.
    ///
    /// # Errors
    /// When the work was cancelled.
    pub fn bottom(
        &self,
        logs: &[ProcessedLog],
        colour: BottomColour,
        most_corners: usize,
        progress: &Progress,
    ) -> Result<Option<Arc<Bottom>>, Cancelled> {
        let Some(depth_map) = self.depth_map(logs, progress)? else {
            return Ok(None);
        };
        let key = BottomKey::of(&depth_map, logs, colour, most_corners);
        let made = self.bottom.get(key, progress, || {
            let made = Bottom::new(self, &depth_map, logs, colour, most_corners, progress)?;
            Ok(Arc::new(made))
        })?;
        Ok(Some(made))
    }

    /// Returns the mosaic of some logs in a plane; `None` if it would be empty.
    ///
    /// # Errors
    /// When the work was cancelled.
    pub fn mosaic(
        &self,
        logs: &[ProcessedLog],
        plane: MosaicPlane,
        progress: &Progress,
    ) -> Result<Option<Arc<Mosaic>>, Cancelled> {
        let key = MosaicKey::of(logs, plane.clone());
        self.mosaic
            .get(key, progress, || Ok(Mosaic::new(logs, &plane, self, progress)?.map(Arc::new)))
    }

    /// Returns the places of the echoes of a log in its own plane.
    ///
    /// # Errors
    /// When the work was cancelled.
    pub fn layout(
        &self,
        log: &ProcessedLog,
        progress: &Progress,
    ) -> Result<Arc<MosaicLayout>, Cancelled> {
        let make = || {
            progress.check()?;
            Ok(Arc::new(mosaic_layout_by(&log.survey, &log.products, |place| place)))
        };
        self.layout.get(LayoutKey::of(log), progress, make)
    }

    /// Returns the gain normalisation of a log; `None` if no part of its side-scan is known to be
    /// on the bottom.
    ///
    /// # Errors
    /// When the work was cancelled.
    pub fn gain(
        &self,
        log: &ProcessedLog,
        progress: &Progress,
    ) -> Result<Option<Arc<GainTable>>, Cancelled> {
        let make = || Ok(made_gain(log, progress)?.map(Arc::new));
        self.gain.get(GainKey::of(log), progress, make)
    }

    /// Returns the picture of a log: its scales, gain and stripe filter.
    ///
    /// # Errors
    /// When the work was cancelled.
    pub fn picture(
        &self,
        log: &ProcessedLog,
        progress: &Progress,
    ) -> Result<Arc<LogPicture>, Cancelled> {
        let key = PictureKey::of(log);
        let make = || {
            let gain = if key.is_normalised { self.gain(log, progress)? } else { None };
            Ok(Arc::new(made_picture(log, gain, key.is_even, progress)?))
        };
        self.picture.get(key.clone(), progress, make)
    }

    /// Returns the picture of a log as [`Derived::picture`] does, for a log that has grown since
    /// its last results `whole`: with the gain of those results, and without the stripe filter,
    /// which needs all pings.
    ///
    /// # Errors
    /// When the work was cancelled.
    pub fn growing_picture(
        &self,
        log: &ProcessedLog,
        whole: &ProcessedLog,
        progress: &Progress,
    ) -> Result<Arc<LogPicture>, Cancelled> {
        let gain =
            if PictureKey::of(log).is_normalised { self.gain(whole, progress)? } else { None };
        Ok(Arc::new(made_picture(log, gain, false, progress)?))
    }
}

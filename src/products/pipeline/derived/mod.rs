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
mod side_scan;

pub use bottom::{Bottom, BottomColour, BottomKey, CornerGround};
pub use depth_map::{DepthMap, DepthMapKey, clip_area};
pub(crate) use isobaths::Contours;
pub use isobaths::{IsobathKey, Isobaths};
pub use side_scan::{
    FINEST, Mosaic, MosaicKey, MosaicPlane, Pass, PictureKey, mosaic_layout, mosaic_layout_by,
    passes_over, place_of,
};

use crate::pipeline::ProcessedLog;
use bathyscope_bottom::bathymetry::isobaths::{IsobathSettings, NoIsobaths};
use bathyscope_bottom::mosaic::{GainTable, MosaicLayout};
use bathyscope_bottom::picture::LogPicture;
use bathyscope_log::support::progress::{Cancelled, Progress};
use side_scan::{GainKey, LayoutKey, made_gain, made_picture};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, TryLockError};
use std::time::Duration;

/// Number of logs whose gain tables are kept; each table is small.
const GAIN_TABLES: usize = 32;
/// Number of pings whose layouts are kept: each takes some 100 bytes.
const LAID_OUT_PINGS: usize = 1_000_000;
/// Poll interval while another thread makes a result.
const WAIT: Duration = Duration::from_millis(5);

/// Last results of one kind, each with its key: equal keys give equal results, so none is computed
/// twice. Two threads that request the same result at once share one computation.
struct DerivedNode<K, T> {
    kept: Mutex<Vec<(K, T)>>,
    /// Largest sum of the weights of all results.
    most: usize,
    weight: fn(&T) -> usize,
}

impl<K: PartialEq, T: Clone> DerivedNode<K, T> {
    /// Creates a cache of at most `most` results; the oldest are removed first.
    fn keeping(most: usize) -> Self {
        Self::weighing(most, |_| 1)
    }

    /// Creates a cache of results whose weights sum to at most `most`; the oldest are removed
    /// first. The newest stays, whatever its weight.
    fn weighing(most: usize, weight: fn(&T) -> usize) -> Self {
        Self { kept: Mutex::default(), most, weight }
    }

    /// Returns the result of a key; computes it with `make` if it is not kept.
    ///
    /// # Errors
    /// When the work, or the wait for another thread, was cancelled.
    fn get(
        &self,
        key: K,
        progress: &Progress,
        make: impl FnOnce() -> Result<T, Cancelled>,
    ) -> Result<T, Cancelled> {
        let mut kept = self.lock(progress)?;
        if let Some((_, made)) = kept.iter().find(|(of, _)| *of == key) {
            return Ok(made.clone());
        }
        let made = make()?;
        kept.push((key, made.clone()));
        let mut all = kept.iter().map(|(_, value)| (self.weight)(value)).sum::<usize>();
        while all > self.most && kept.len() > 1 {
            all -= (self.weight)(&kept.remove(0).1);
        }
        Ok(made)
    }

    /// Waits until no other thread computes a result here; returns an error if this work is
    /// cancelled meanwhile.
    fn lock(&self, progress: &Progress) -> Result<MutexGuard<'_, Vec<(K, T)>>, Cancelled> {
        loop {
            match self.kept.try_lock() {
                Ok(kept) => return Ok(kept),
                // A computation that panicked has stored nothing.
                Err(TryLockError::Poisoned(kept)) => return Ok(PoisonError::into_inner(kept)),
                Err(TryLockError::WouldBlock) => progress.check()?,
            }
            std::thread::sleep(WAIT);
        }
    }
}

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

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::atomic::{AtomicUsize, Ordering};

    #[test]
    fn a_result_is_made_once_and_the_oldest_goes() {
        let (node, progress) = (DerivedNode::keeping(2), Progress::new());
        let made = AtomicUsize::new(0);
        let ask = |key: u8| {
            let make = || {
                made.fetch_add(1, Ordering::Relaxed);
                Ok(10 * key)
            };
            node.get(key, &progress, make).expect("nobody cancels")
        };
        assert_eq!([ask(1), ask(2), ask(1)], [10, 20, 10]);
        assert_eq!(made.load(Ordering::Relaxed), 2);
        assert_eq!([ask(3), ask(2), ask(1)], [30, 20, 10]);
        assert_eq!(made.load(Ordering::Relaxed), 4, "1 had gone for 3");
    }

    #[test]
    fn results_go_by_their_weight_and_the_last_one_stays() {
        let node = DerivedNode::weighing(10, |made: &usize| *made);
        let kept = |asked: usize| {
            let made = node.get(asked, &Progress::new(), || Ok(asked));
            assert_eq!(made, Ok(asked));
            let kept = node.kept.lock().expect("nobody panicked");
            kept.iter().map(|(key, _)| *key).collect::<Vec<_>>()
        };
        assert_eq!([kept(4), kept(6)], [vec![4], vec![4, 6]]);
        assert_eq!(kept(3), [6, 3]);
        assert_eq!(kept(50), [50]);
        assert_eq!(kept(2), [2]);
    }

    #[test]
    fn two_who_ask_at_once_get_the_work_of_one() {
        let (node, made) = (DerivedNode::keeping(1), AtomicUsize::new(0));
        std::thread::scope(|scope| {
            for _ in 0..4 {
                scope.spawn(|| {
                    let make = || {
                        std::thread::sleep(10 * WAIT);
                        Ok(made.fetch_add(1, Ordering::Relaxed))
                    };
                    assert_eq!(node.get((), &Progress::new(), make), Ok(0));
                });
            }
        });
    }

    #[test]
    fn who_gives_up_does_not_wait_and_leaves_nothing() {
        let node = DerivedNode::keeping(1);
        let given_up = Progress::new();
        given_up.cancel();
        let inner = || {
            let waits = node.get((), &given_up, || Ok(1));
            assert_eq!(waits, Err(Cancelled));
            Err(Cancelled)
        };
        assert_eq!(node.get((), &Progress::new(), inner), Err(Cancelled));
        assert_eq!(node.get((), &Progress::new(), || Ok(2)), Ok(2));
    }
}

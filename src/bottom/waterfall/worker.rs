//! Runs the worker that makes tiles and lines in a background thread: requested tiles first, then
//! the store of the coarse levels.

use super::resample::{Coarse, resample, size};
use super::{Levels, PickLines, RangeAxis, RangeLine, Want, WaterfallTile, WaterfallTileKey};
use crate::first_return::FirstReturns;
use bathyscope_log::survey::Survey;
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError, mpsc};
use std::thread::JoinHandle;

/// Number of pings before the old end of a growing log whose tiles are made again.
const UNSETTLED: usize = 256;

/// Result of the worker.
pub enum Made {
    /// Extent of the picture; the first result. `None`, with no further result, when no side-scan
    /// ping has a usable range.
    Axis(Option<RangeAxis>),
    /// Levels of black and white for the survey; sent before the first tile, so that the picture
    /// does not change its tone.
    Levels(Levels),
    /// Tile.
    WaterfallTile(WaterfallTile),
    /// Extent of a log that has grown. The view must request again the tiles beyond `unchanged`, or
    /// all tiles where it is `None`.
    Grown {
        /// New extent.
        axis: RangeAxis,
        /// Number of pings from the start whose tiles stay valid; `None` where no tile does.
        unchanged: Option<usize>,
    },
    /// Lines of first returns.
    Picks(Arc<PickLines>),
    /// Line of recorded depths.
    Depth(RangeLine),
}

/// Maker of the tiles and lines of a waterfall, on a thread of its own that ends when this value is
/// dropped.
pub struct Tiler {
    shared: Arc<Shared>,
    made: mpsc::Receiver<Made>,
    thread: JoinHandle<()>,
}

#[derive(Default)]
struct Shared {
    orders: Mutex<Orders>,
    changed: Condvar,
}

#[derive(Default)]
struct Orders {
    tiles: Vec<Want>,
    making: Option<WaterfallTileKey>,
    picks: Option<Arc<FirstReturns>>,
    grown: Option<Arc<Survey>>,
    stop: bool,
}

impl Shared {
    fn lock(&self) -> MutexGuard<'_, Orders> {
        self.orders.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Tiler {
    /// Starts the worker. The worker calls `waker` whenever there is a result to poll.
    pub fn start(survey: Arc<Survey>, waker: impl Fn() + Send + 'static) -> Self {
        let shared = Arc::new(Shared::default());
        let (sender, made) = mpsc::channel();
        let orders = shared.clone();
        let thread = std::thread::spawn(move || {
            let out = Out { sender, waker };
            let axis = RangeAxis::of(&survey);
            out.send(Made::Axis(axis));
            if let Some(axis) = axis {
                out.send(Made::Levels(Levels::of(&survey)));
                out.send(Made::Depth(RangeLine::depth(&survey)));
                Work { coarse: Coarse::new(&axis), survey, axis }.run(&orders, &out);
            }
        });
        Self { shared, made, thread }
    }

    /// Returns true if the worker thread has ended: there was no picture to make, or it panicked.
    pub fn has_ended(&self) -> bool {
        self.thread.is_finished()
    }

    /// Replaces the list of requested tiles, most urgent first. Earlier requests that are not in
    /// the new list are dropped, so that fast scrolling leaves no queue behind.
    pub fn want(&self, mut tiles: Vec<Want>) {
        let mut orders = self.shared.lock();
        tiles.retain(|want| Some(want.key) != orders.making);
        if orders.tiles != tiles {
            orders.tiles = tiles;
            self.shared.changed.notify_one();
        }
    }

    /// Requests lines of these picks; only the newest request counts.
    pub fn want_picks(&self, returns: Arc<FirstReturns>) {
        self.shared.lock().picks = Some(returns);
        self.shared.changed.notify_one();
    }

    /// Replaces the log with a later state of it; only the newest state counts.
    pub fn grow(&self, survey: Arc<Survey>) {
        self.shared.lock().grown = Some(survey);
        self.shared.changed.notify_one();
    }

    /// Waits for the extent of the picture, which is the first result of the worker. The outer
    /// `None` means that the worker ended before; the inner `None` that there is no picture.
    pub fn wait_for_axis(&self) -> Option<Option<RangeAxis>> {
        match self.made.recv() {
            Ok(Made::Axis(axis)) => Some(axis),
            _ => None,
        }
    }

    /// Returns the next result; `None` when there is none yet.
    pub fn poll(&self) -> Option<Made> {
        self.made.try_recv().ok()
    }
}

impl Drop for Tiler {
    fn drop(&mut self) {
        self.shared.lock().stop = true;
        self.shared.changed.notify_one();
    }
}

struct Out<W> {
    sender: mpsc::Sender<Made>,
    waker: W,
}

impl<W: Fn()> Out<W> {
    fn send(&self, made: Made) {
        // A dropped receiver means that the view no longer exists; the stop flag ends the thread.
        self.sender.send(made).ok();
        (self.waker)();
    }
}

struct Work {
    survey: Arc<Survey>,
    axis: RangeAxis,
    coarse: Coarse,
}

/// Next task of the worker.
enum WorkerTask {
    Grow(Arc<Survey>),
    Picks(Arc<FirstReturns>),
    WaterfallTile(WaterfallTileKey),
    Store,
}

impl Work {
    fn run(mut self, shared: &Shared, out: &Out<impl Fn()>) {
        while let Some(task) = self.next_task(shared) {
            match task {
                WorkerTask::Grow(survey) => self.grow(survey, out),
                WorkerTask::Picks(returns) => {
                    let lines = PickLines::new(&self.survey, returns);
                    out.send(Made::Picks(Arc::new(lines)));
                }
                WorkerTask::WaterfallTile(key) => out.send(Made::WaterfallTile(self.tile(key))),
                WorkerTask::Store => self.coarse.build_next(&self.survey, &self.axis),
            }
        }
    }

    /// Replaces the log with a longer one. The finished parts of the store stay, as far as the new
    /// pings do not change them.
    fn grow(&mut self, survey: Arc<Survey>, out: &Out<impl Fn()>) {
        let Some(axis) = RangeAxis::of(&survey) else {
            return;
        };
        // A little before the old end, further sides of pings may have been recorded since.
        let unchanged = self.axis.pings.min(axis.pings).saturating_sub(UNSETTLED);
        let is_same_scale = axis.is_as_fine(&self.axis);
        if is_same_scale {
            self.coarse.grow(&axis, unchanged);
        } else {
            self.coarse = Coarse::new(&axis);
        }
        (self.survey, self.axis) = (survey, axis);
        let unchanged = Some(unchanged).filter(|_| is_same_scale);
        out.send(Made::Grown { axis, unchanged });
        out.send(Made::Depth(RangeLine::depth(&self.survey)));
    }

    /// Waits for the next task; `None` when the worker must stop.
    fn next_task(&self, shared: &Shared) -> Option<WorkerTask> {
        let mut orders = shared.lock();
        orders.making = None;
        loop {
            if orders.stop {
                return None;
            }
            if let Some(survey) = orders.grown.take() {
                // The view requests its tiles again when it has the new extent.
                orders.tiles.clear();
                return Some(WorkerTask::Grow(survey));
            }
            if let Some(returns) = orders.picks.take() {
                return Some(WorkerTask::Picks(returns));
            }
            if let Some(place) = orders.tiles.iter().position(|want| self.can_improve(want)) {
                let key = orders.tiles.remove(place).key;
                orders.making = Some(key);
                return Some(WorkerTask::WaterfallTile(key));
            }
            if !self.coarse.is_complete() {
                return Some(WorkerTask::Store);
            }
            orders = shared.changed.wait(orders).unwrap_or_else(PoisonError::into_inner);
        }
    }

    /// Returns true if making the tile now gives a more complete one than the view has.
    fn can_improve(&self, want: &Want) -> bool {
        let now = if self.is_from_samples(want.key) {
            WaterfallTile::COMPLETE
        } else {
            self.coarse.completeness()
        };
        want.have.map_or(now > 0, |have| now > have)
    }

    /// Returns true if the tile is made from the samples: always at levels finer than the store,
    /// and at other near levels until the store is complete.
    fn is_from_samples(&self, key: WaterfallTileKey) -> bool {
        let stored = self.axis.store.is_finer_or_equal(key.level);
        key.level.is_near() && !(stored && self.coarse.is_complete())
    }

    fn tile(&self, key: WaterfallTileKey) -> WaterfallTile {
        if !self.is_from_samples(key) {
            return self.coarse.tile(&self.axis, key);
        }
        let (width, height) = size(&self.axis, key);
        let first = key.first_ping();
        let pings = first..(first + height * key.level.pings()).min(self.axis.pings);
        let texels =
            resample(&self.survey, &self.axis, key.side, key.level, pings, key.first_bin(), width);
        WaterfallTile { key, width, height, texels, completeness: WaterfallTile::COMPLETE }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::waterfall::testing::even;
    use bathyscope_log::survey::Side;
    use std::time::{Duration, Instant};

    fn next_tile(tiler: &Tiler) -> WaterfallTile {
        let start = Instant::now();
        loop {
            if let Some(Made::WaterfallTile(tile)) = tiler.poll() {
                return tile;
            }
            assert!(start.elapsed() < bathyscope_test_support::PATIENCE, "no tile was made");
            std::thread::sleep(Duration::from_millis(1));
        }
    }

    #[test]
    fn far_out_tiles_grow_until_they_are_complete() {
        let tiler = Tiler::start(Arc::new(even(30_000, 64)), || ());
        let key = WaterfallTileKey::at_boat(Side::Port, [6, 3], 0);
        let mut have = None;
        let last = loop {
            tiler.want(vec![Want { key, have }]);
            let tile = next_tile(&tiler);
            assert!(have < Some(tile.completeness), "made again without gain");
            have = Some(tile.completeness);
            if have == Some(WaterfallTile::COMPLETE) {
                break tile;
            }
        };
        assert_eq!((last.width, last.height), (8, 30_000_usize.div_ceil(64)));
        assert!(last.texels.iter().all(|texel| texel[1] > 200), "maxima of 512 noisy samples");
    }

    #[test]
    fn tiles_of_a_log_that_grew_equal_those_of_the_whole_log() {
        let whole = even(9_000, 64);
        let mut shorter = whole.clone();
        shorter.side_scan = Arc::new(whole.side_scan[..5_000].to_vec());
        let tiler = Tiler::start(Arc::new(shorter), || ());
        let fresh = Tiler::start(Arc::new(whole.clone()), || ());
        let keys = [(0, 9), (2, 3), (5, 0)]
            .map(|(along, column)| WaterfallTileKey::at_boat(Side::Port, [along, 3], column));
        let tile = |tiler: &Tiler, key: WaterfallTileKey| {
            let mut have = None;
            loop {
                tiler.want(vec![Want { key, have }]);
                let tile = next_tile(tiler);
                if tile.key == key && tile.completeness == WaterfallTile::COMPLETE {
                    return tile;
                }
                have = (tile.key == key).then_some(tile.completeness).or(have);
            }
        };
        tile(&tiler, keys[2]);
        tiler.grow(Arc::new(whole));
        let start = Instant::now();
        loop {
            if let Some(Made::Grown { axis, unchanged }) = tiler.poll() {
                assert_eq!((axis.pings, unchanged), (9_000, Some(5_000 - UNSETTLED)));
                break;
            }
            assert!(start.elapsed() < bathyscope_test_support::PATIENCE, "it did not grow");
        }
        for key in keys {
            assert_eq!(tile(&tiler, key), tile(&fresh, key), "{key:?}");
        }
    }

    #[test]
    fn a_worker_that_dies_is_known_to_have_ended() {
        let alive = Tiler::start(Arc::new(even(100, 64)), || ());
        let dead = Tiler::start(Arc::new(even(100, 64)), || panic!("for the test"));
        while !dead.has_ended() {
            std::thread::sleep(Duration::from_millis(1));
        }
        assert!(matches!(dead.poll(), Some(Made::Axis(Some(_)))));
        assert!(dead.poll().is_none() && !alive.has_ended());
    }

    #[test]
    fn a_survey_without_usable_ranges_has_no_axis() {
        let tiler = Tiler::start(Arc::new(even(0, 64)), || ());
        let start = Instant::now();
        while start.elapsed() < bathyscope_test_support::PATIENCE {
            if let Some(made) = tiler.poll() {
                assert!(matches!(made, Made::Axis(None)));
                return;
            }
        }
        panic!("the worker said nothing");
    }
}

//! Opening a log off the window's thread.

use crate::formats;
use crate::progress::Progress;
use crate::survey::Survey;
use std::path::PathBuf;
use std::sync::{Arc, mpsc};

/// What is opened.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Origin {
    /// A file or folder.
    Path(PathBuf),
    /// The bundled demo survey.
    Demo,
}

impl Origin {
    /// What to call it.
    pub fn name(&self) -> String {
        match self {
            Origin::Path(path) => path.file_name().map_or_else(
                || path.display().to_string(),
                |name| name.to_string_lossy().into_owned(),
            ),
            Origin::Demo => "demo survey".to_owned(),
        }
    }

    fn open(&self, progress: &Progress) -> Result<Survey, formats::OpenError> {
        match self {
            Origin::Path(path) => formats::open(path, progress),
            Origin::Demo => {
                formats::open_bytes("demo.sl2", crate::app::state::DEMO.to_vec(), progress)
            }
        }
    }
}

/// What is being opened, for the status line.
#[derive(Clone, Debug, PartialEq)]
pub struct LoadStatus {
    /// Its name.
    pub name: String,
    /// Done share, 0 to 1.
    pub fraction: f32,
}

type Opened = Result<Survey, String>;

/// A log being opened.
pub(super) struct Loading {
    pub origin: Origin,
    progress: Progress,
    result: mpsc::Receiver<Opened>,
}

impl Loading {
    /// Starts opening; inside this call when `inline`.
    pub fn start(origin: Origin, inline: bool, waker: Arc<dyn Fn() + Send + Sync>) -> Self {
        let (sender, result) = mpsc::channel();
        let progress = Progress::new();
        let loading = Self {
            origin: origin.clone(),
            progress: progress.clone(),
            result,
        };
        let work = move || {
            let opened = origin.open(&progress).map_err(|error| error.to_string());
            // Nobody listens any more when another log was opened meanwhile.
            sender.send(opened).ok();
            waker();
        };
        if inline {
            work();
        } else {
            std::thread::spawn(work);
        }
        loading
    }

    /// The outcome, once.
    pub fn poll(&self) -> Option<Opened> {
        match self.result.try_recv() {
            Ok(opened) => Some(opened),
            Err(mpsc::TryRecvError::Empty) => None,
            Err(mpsc::TryRecvError::Disconnected) => Some(Err(format!(
                "opening failed unexpectedly: {}",
                self.origin.name()
            ))),
        }
    }

    pub fn status(&self) -> LoadStatus {
        LoadStatus {
            name: self.origin.name(),
            fraction: self.progress.fraction(),
        }
    }

    pub fn cancel(&self) {
        self.progress.cancel();
    }
}

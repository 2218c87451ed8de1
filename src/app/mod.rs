//! Holds the state, commands and undo of Bathyscope, without widgets and without drawing.
//!
//! The window reads [`App`] and sends [`Command`]s; [`App::apply`] is the only place that changes
//! state, with the answers of work in the background, which [`App::poll`] applies.

mod action;
mod apply;
mod bottom;
mod by_key;
mod calibrating;
mod command;
mod comparing;
pub(crate) mod crash_report;
mod crossings;
mod deriving;
mod error;
mod exclusions;
mod exporting;
mod figures;
mod following;
mod history;
mod jobs;
mod log_place;
mod logs;
pub mod manual;
mod map_layers;
mod measuring;
mod notices;
mod object_table;
mod objects;
mod open_log;
mod opening;
mod options;
mod passes;
mod planning;
mod print;
mod processing;
mod project;
mod reviewing;
mod source;
mod state;
pub(crate) mod system_words;
mod untitled;
mod watching;
mod work_step;

pub use action::{Action, KeyFocus, Keys, is_bare};
pub(crate) use action::{ActionGroup, WindowAction};
pub use bottom::{BottomStroke, Ink};
pub use command::{Command, FileToOpen, FileToWrite};
pub use comparing::ReferenceBy;
pub use crossings::FoundPositions;
pub use deriving::DrawnIsobaths;
pub use exclusions::{ExcludedExtent, ExclusionEdit, FoundExclusions};
pub(crate) use exporting::PrintText;
pub use figures::{AboveBottom, AboveStretch, Figures};
pub use following::FollowStatus;
pub(crate) use jobs::JobKey;
pub use log_place::{CloseUp, Enlarged, LogPlace, Reveal};
pub use logs::{OpenLogs, VisibleLog};
pub use map_layers::{LayerShown, LayerStack, MapLayer, Swipe, SwipeSide};
pub use measuring::{Measure, ProfileLine};
pub use notices::{Notice, Notices};
pub use object_table::ObjectTable;
pub use open_log::OpenLog;
pub(crate) use opening::LogOrigin;
pub(crate) use options::LayoutPreset;
pub use options::{
    ClipBox, CloudColour, CloudOptions, EchogramChannel, MapOptions, Orientation, PanelOptions,
    PanelShown, SideColours, SwathShown, ThemeChoice, View, ViewOptions, WaterfallOptions,
    WorkStep,
};
pub use passes::{LogPass, PassesFound, mark_of};
pub use planning::{PlanRequest, PlannedLines};
pub(crate) use print::Sheet;
pub use print::{Paper, PrintOptions};
pub use project::is_project;
pub use reviewing::{
    BoxEdge, LocatedObject, MistakeSort, Nudge, PIXEL_M, Reviewing, SearchStatus, Tool, border_m,
};
pub use source::Mountings;
pub use state::App;
pub(crate) use watching::LISTED_EVERY as CARDS_LISTED_EVERY;
pub(crate) use work_step::{Freshness, StepState};

pub use bathyscope_objects::objects::{LogBox, LogId, Object, ObjectColumn, ObjectState};
pub use bathyscope_products::pipeline::{Jobs, Task, TaskOutcome};

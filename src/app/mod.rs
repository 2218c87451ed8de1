//! What the analyst sees and decides: state, commands and undo. Knows no widget and draws nothing.
//!
//! The window reads [`App`] and pushes [`Command`]s; [`App::apply`] is the only place that changes state, and
//! [`App::poll`] collects what the workers finished.

mod above_bottom;
mod action;
mod apart;
mod apply;
mod available;
mod base_map;
mod bottom;
mod by_key;
mod calibrating;
mod clip_box;
mod command;
mod comparing;
mod deriving;
mod drawn_figure;
mod error;
mod exclusions;
mod exporting;
mod external;
mod figures;
mod following;
mod given;
mod heights;
mod history;
mod isobath_area;
mod key_scope;
mod loader;
mod logs;
mod logs_task;
pub mod manual;
mod map_layers;
mod mark;
mod measuring;
mod mounting;
mod notices;
mod object_table;
mod objects;
mod open_log;
mod options;
mod passes;
mod picture;
mod planning;
mod positions;
mod preview;
mod print;
mod print_text;
mod profile_line;
mod project;
mod reference_comparison;
mod reviewing;
mod saving_figure;
mod state;
mod step;
mod swipe;
mod work;

pub use above_bottom::{AboveBottom, AboveStretch};
pub use action::{Action, Keys};
pub use bottom::{BottomStroke, Ink};
pub use clip_box::ClipBox;
pub use command::Command;
pub use comparing::ReferenceBy;
pub use deriving::DrawnIsobaths;
pub use exclusions::{ExclusionEdit, Extent, FoundExclusions};
pub use figures::Figures;
pub use following::FollowStatus;
pub use given::GivenSettings;
pub use key_scope::{KeyFocus, is_bare};
pub use loader::{LoadStatus, Origin};
pub use logs::ShownLog;
pub use map_layers::{LayerShown, LayerStack, MapLayer};
pub use mark::{CloseUp, Enlarged, Mark, Reveal};
pub use measuring::{Measure, Measuring};
pub use mounting::Mountings;
pub use notices::Notice;
pub use object_table::{ObjectColumn, ObjectFilter, ObjectTable};
pub use open_log::OpenLog;
pub use options::{
    CloudColour, CloudOptions, ColourMap, EchogramChannel, LayoutPreset, MapOptions, Orientation,
    PanelOptions, PanelShown, SideColours, ThemeChoice, View, ViewOptions, WaterfallOptions,
};
pub use passes::{PassesFound, mark_of};
pub use planning::{PlanRequest, PlannedLines};
pub use positions::FoundPositions;
pub use print::{Paper, PrintOptions, Sheet};
pub use print_text::PrintText;
pub use profile_line::ProfileLine;
pub use project::is_project;
pub use reviewing::{
    BoxEdge, LocatedObject, MistakeSort, Nudge, PIXEL_M, Reviewing, SearchStatus, Tool, border_m,
};
pub use state::App;
pub use swipe::{Swipe, SwipeSide};

pub use crate::detection::objects::{LogBox, LogId, ObjectState, SurveyObject};
pub use crate::pipeline::{Jobs, Outcome, Task};
#[cfg(any(test, feature = "bench"))]
pub use passes::LogPass;

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
mod card_search;
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
mod file_watch;
mod following;
mod given;
mod heights;
mod history;
mod isobath_area;
mod key_scope;
mod loader;
mod log_place;
mod logs;
mod logs_task;
pub(crate) mod manual;
mod map_layers;
mod measuring;
mod mounting;
mod notices;
mod object_table;
mod objects;
mod open_log;
mod options;
mod outdated;
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

pub(crate) use above_bottom::{AboveBottom, AboveStretch};
pub(crate) use action::{Action, Keys};
pub(crate) use bottom::{BottomStroke, Ink};
pub(crate) use card_search::LISTED_EVERY as CARDS_LISTED_EVERY;
pub(crate) use clip_box::ClipBox;
pub(crate) use command::{Command, FileToOpen, FileToWrite};
pub(crate) use comparing::ReferenceBy;
pub(crate) use deriving::DrawnIsobaths;
pub(crate) use exclusions::{ExcludedExtent, ExclusionEdit, FoundExclusions};
pub(crate) use figures::Figures;
pub(crate) use following::FollowStatus;
pub(crate) use given::GivenSettings;
pub(crate) use key_scope::{KeyFocus, is_bare};
pub(crate) use loader::{LoadStatus, LogOrigin};
pub(crate) use log_place::{CloseUp, Enlarged, LogPlace, Reveal};
pub(crate) use logs::ShownLog;
pub(crate) use map_layers::{LayerShown, LayerStack, MapLayer};
pub(crate) use measuring::Measure;
pub(crate) use mounting::Mountings;
pub(crate) use notices::Notice;
pub(crate) use object_table::{ObjectColumn, ObjectFilter, ObjectTable};
pub(crate) use open_log::OpenLog;
pub(crate) use options::{
    CloudColour, CloudOptions, ColourMap, EchogramChannel, LayoutPreset, MapOptions, Orientation,
    PanelOptions, PanelShown, SideColours, SwathShown, ThemeChoice, View, ViewOptions,
    WaterfallOptions,
};
pub(crate) use passes::{PassesFound, mark_of};
pub(crate) use planning::{PlanRequest, PlannedLines};
pub(crate) use positions::FoundPositions;
pub(crate) use print::{Paper, PrintOptions, Sheet};
pub(crate) use print_text::PrintText;
pub(crate) use profile_line::ProfileLine;
pub(crate) use project::is_project;
pub(crate) use reviewing::{
    BoxEdge, LocatedObject, MistakeSort, Nudge, PIXEL_M, Reviewing, SearchStatus, Tool, border_m,
};
pub(crate) use state::App;
pub(crate) use swipe::{Swipe, SwipeSide};

pub(crate) use crate::detection::objects::{LogBox, LogId, ObjectState, SurveyObject};
pub(crate) use crate::pipeline::{Jobs, Task, TaskOutcome};
#[cfg(any(test, feature = "bench"))]
pub(crate) use passes::LogPass;

//! Arranges the views of the centre as tiles, with the view that has the keyboard and the view that
//! fills the centre.

use super::{Views, toolbar};
use crate::app::{Action, App, LayoutPreset, View, WorkStep};
use crate::ui::{ViewContext, theme};
use egui::{Color32, Stroke, Ui};
use egui_tiles::{
    Behavior, Container, EditAction, Linear, LinearDir, SimplificationOptions, TabState, Tabs,
    Tile, TileId, Tiles, Tree, UiResponse,
};
use serde::{Deserialize, Serialize};

/// Arrangement of the views; saved between runs.
#[derive(Clone, Serialize, Deserialize)]
pub(super) struct Layout {
    tree: Tree<View>,
    focus: View,
    maximised: Option<View>,
    /// True until the analyst arranges the views; until then the arrangement follows the step of
    /// the work and the size of the window.
    #[serde(default)]
    is_automatic: bool,
    /// The step that the arrangement is of.
    #[serde(default)]
    step: WorkStep,
    /// Arrangements that the analyst made in other steps.
    #[serde(default)]
    arranged: Vec<(WorkStep, Tree<View>)>,
}

/// Height of the centre from which three views are drawn beside each other, points; in a lower
/// centre each view fills it, and the views are chosen by their titles.
const ROOM: f32 = 400.0;

impl Default for Layout {
    fn default() -> Self {
        Self {
            tree: tree(LayoutPreset::Survey),
            focus: View::Waterfall,
            maximised: None,
            is_automatic: true,
            step: WorkStep::default(),
            arranged: Vec::new(),
        }
    }
}

/// Returns the views in front of their tiles.
fn in_front(tree: &Tree<View>) -> Vec<View> {
    let tiles = tree.active_tiles().into_iter();
    tiles.filter_map(|tile| tree.tiles.get_pane(&tile).copied()).collect()
}

/// Returns the arrangement with which a step begins.
fn preset_of(step: WorkStep) -> LayoutPreset {
    match step {
        WorkStep::Logs => LayoutPreset::Survey,
        WorkStep::Bottom | WorkStep::Correct => LayoutPreset::Review,
        WorkStep::Map | WorkStep::Export => LayoutPreset::Map,
        WorkStep::Objects => LayoutPreset::Objects,
    }
}

/// Adds a tile with a tab for each view, the first in front.
fn tabs(views: &[View], tiles: &mut Tiles<View>) -> TileId {
    let panes = views.iter().map(|view| tiles.insert_pane(*view)).collect();
    tiles.insert_tab_tile(panes)
}

/// Adds a tile with two others beside or below each other; the first has `share` of the length.
fn split(dir: LinearDir, two: [TileId; 2], share: f32, tiles: &mut Tiles<View>) -> TileId {
    let split = Linear::new_binary(dir, two, share);
    tiles.insert_container(Container::Linear(split))
}

fn tree(preset: LayoutPreset) -> Tree<View> {
    let mut tiles = Tiles::default();
    let root = match preset {
        LayoutPreset::Only(view) => tabs(&[view], &mut tiles),
        // The table is a tab beside the waterfall, and as wide.
        LayoutPreset::Survey => {
            let waterfall = tabs(&[View::Waterfall, View::Objects, View::Profile], &mut tiles);
            let map = tabs(&[View::Map], &mut tiles);
            let cloud = tabs(&[View::Cloud], &mut tiles);
            let below = split(LinearDir::Horizontal, [map, cloud], 0.5, &mut tiles);
            split(LinearDir::Vertical, [waterfall, below], 0.55, &mut tiles)
        }
        LayoutPreset::Review => {
            let waterfall = tabs(&[View::Waterfall, View::Objects], &mut tiles);
            let profile = tabs(&[View::Profile], &mut tiles);
            let map = tabs(&[View::Map, View::Cloud], &mut tiles);
            let below = split(LinearDir::Horizontal, [profile, map], 0.5, &mut tiles);
            split(LinearDir::Vertical, [waterfall, below], 0.7, &mut tiles)
        }
        LayoutPreset::Map => {
            let map = tabs(&[View::Map], &mut tiles);
            let waterfall = tabs(&[View::Waterfall, View::Objects, View::Profile], &mut tiles);
            let cloud = tabs(&[View::Cloud], &mut tiles);
            let beside = split(LinearDir::Vertical, [cloud, waterfall], 0.5, &mut tiles);
            split(LinearDir::Horizontal, [map, beside], 0.6, &mut tiles)
        }
        LayoutPreset::Objects => {
            let waterfall = tabs(&[View::Waterfall, View::Profile], &mut tiles);
            let objects = tabs(&[View::Objects], &mut tiles);
            let map = tabs(&[View::Map, View::Cloud], &mut tiles);
            let below = split(LinearDir::Horizontal, [objects, map], 0.62, &mut tiles);
            split(LinearDir::Vertical, [waterfall, below], 0.55, &mut tiles)
        }
    };
    Tree::new(egui::Id::unique("views"), root, tiles)
}

impl Layout {
    /// Replaces the arrangement by a preset.
    pub(super) fn arrange(&mut self, preset: LayoutPreset) {
        self.tree = tree(preset);
        self.maximised = None;
        self.is_automatic = false;
        if let LayoutPreset::Only(view) = preset {
            self.focus = view;
        }
    }

    /// Arranges the views for a step of the work: as the analyst arranged them in that step, or
    /// else as the step begins.
    pub(super) fn follow_step(&mut self, step: WorkStep) {
        if step == self.step {
            return;
        }
        self.arranged.retain(|(of, _)| *of != self.step);
        if !self.is_automatic {
            self.arranged.push((self.step, self.tree.clone()));
        }
        self.step = step;
        self.maximised = None;
        let kept = self.arranged.iter().find(|(of, _)| *of == step);
        self.is_automatic = kept.is_none();
        self.tree = kept.map_or_else(|| tree(preset_of(step)), |(_, kept)| kept.clone());
        self.bring_to_front(self.focus);
    }

    /// Gives a view the keyboard, and brings it to the front.
    pub(super) fn focus(&mut self, view: View) {
        self.focus = view;
        if self.maximised.is_some() {
            self.maximised = Some(view);
        } else if self.tree.tiles.find_pane(&view).is_none() {
            // An arrangement of one view, or of an earlier version, does not contain this view.
            self.add(view);
        } else {
            self.bring_to_front(view);
        }
    }

    fn bring_to_front(&mut self, view: View) {
        self.tree.make_active(|_, tile| matches!(tile, Tile::Pane(pane) if *pane == view));
    }

    /// Adds a view as a tab beside the waterfall, or else beside the first visible view.
    fn add(&mut self, view: View) {
        let beside = (self.tree.tiles.find_pane(&View::Waterfall)).or_else(|| {
            let mut active = self.tree.active_tiles().into_iter();
            active.find(|tile| self.tree.tiles.get_pane(tile).is_some())
        });
        let tabs = beside.and_then(|pane| self.tree.tiles.parent_of(pane));
        let pane = self.tree.tiles.insert_pane(view);
        match tabs.and_then(|tabs| self.tree.tiles.get_mut(tabs)) {
            Some(Tile::Container(Container::Tabs(tabs))) => {
                tabs.add_child(pane);
                self.bring_to_front(view);
            }
            // Each view is in tabs; a saved arrangement without them is replaced.
            _ => self.arrange(LayoutPreset::Only(view)),
        }
    }

    /// Lets a view fill the whole centre, or shows all views again.
    pub(super) fn toggle_maximised(&mut self, view: View) {
        self.focus = view;
        self.maximised = match self.maximised {
            Some(_) => None,
            None => Some(view),
        };
    }

    /// Returns the view in which keys act: the view that was clicked or chosen last, or the first
    /// visible view if that one is hidden behind another.
    pub(super) fn target(&self) -> View {
        let shown = self.shown();
        match shown.first() {
            Some(first) if !shown.contains(&self.focus) => *first,
            _ => self.focus,
        }
    }

    /// Returns the visible views.
    pub(super) fn shown(&self) -> Vec<View> {
        match self.maximised {
            Some(view) => vec![view],
            None => in_front(&self.tree),
        }
    }

    /// Arranges the views again if the window has become low or high, and the analyst has not
    /// arranged them.
    fn follow_window(&mut self, height: f32) {
        // Views that are all tabs of one tile have one of them in front.
        if !self.is_automatic || (in_front(&self.tree).len() == 1) == (height < ROOM) {
            return;
        }
        self.tree = if height < ROOM {
            Tree::new_tabs(egui::Id::unique("views"), View::ALL.to_vec())
        } else {
            tree(preset_of(self.step))
        };
        self.bring_to_front(self.focus);
    }

    /// Draws the views in their tiles.
    pub(super) fn ui(&mut self, ui: &mut Ui, views: &mut Views, context: &mut ViewContext<'_>) {
        self.follow_window(ui.available_height());
        let mut panes = Panes {
            views,
            context,
            focus: self.target(),
            pressed: None,
            maximise: None,
            is_edited: false,
        };
        match self.maximised {
            Some(view) => {
                let mut alone = Tree::new_tabs(egui::Id::unique("maximised view"), vec![view]);
                alone.ui(&mut panes, ui);
            }
            None => self.tree.ui(&mut panes, ui),
        }
        let (pressed, maximise) = (panes.pressed, panes.maximise);
        self.is_automatic &= !panes.is_edited;
        if let Some(view) = pressed {
            self.focus = view;
        }
        if let Some(view) = maximise {
            self.toggle_maximised(view);
        }
    }
}

/// Behaviour of the tiles for egui_tiles.
struct Panes<'a, 'c> {
    views: &'a mut Views,
    context: &'a mut ViewContext<'c>,
    focus: View,
    pressed: Option<View>,
    maximise: Option<View>,
    /// True if a view, or a border between two views, was moved.
    is_edited: bool,
}

/// Returns the state of the results of a view, for the title of its tab.
fn state_of(view: View, app: &App) -> &'static str {
    match view {
        View::Waterfall if app.is_following() => " (following)",
        View::Waterfall => "",
        _ if app.logs.shown.stale().is_none() => "",
        _ if app.is_stopped() => " (out of date)",
        _ => " (updating)",
    }
}

impl Behavior<View> for Panes<'_, '_> {
    fn pane_ui(&mut self, ui: &mut Ui, _: TileId, view: &mut View) -> UiResponse {
        let is_pressed = ui.input(|input| input.pointer.any_pressed());
        if is_pressed && ui.rect_contains_pointer(ui.max_rect()) {
            self.pressed = Some(*view);
        }
        self.views.ui(*view, ui, self.context);
        UiResponse::None
    }

    fn tab_title_for_pane(&mut self, view: &View) -> egui::WidgetText {
        format!("{}{}", view.title(), state_of(*view, self.context.app)).into()
    }

    fn on_tab_button(
        &mut self,
        tiles: &mut Tiles<View>,
        tile: TileId,
        response: egui::Response,
    ) -> egui::Response {
        if let Some(&view) = tiles.get_pane(&tile) {
            if view == self.focus {
                // The underline marks the view with the keyboard without relying on colour.
                let colour = theme::accent_colour(self.context.theme());
                let painter = response.ctx.layer_painter(response.layer_id);
                let line = response.rect.shrink(6.0);
                painter.hline(line.x_range(), response.rect.bottom() - 3.0, (1.5, colour));
            }
            if response.double_clicked() {
                self.maximise = Some(view);
            } else if response.clicked() {
                self.pressed = Some(view);
            }
        }
        response.on_hover_text(format!(
            "Drag to move the view; double-click to maximise it, or press {}.",
            Action::Maximise.key()
        ))
    }

    fn top_bar_right_ui(
        &mut self,
        tiles: &Tiles<View>,
        ui: &mut Ui,
        _: TileId,
        tabs: &Tabs,
        _: &mut f32,
    ) {
        let active = tabs.active.and_then(|tile| tiles.get_pane(&tile));
        if let Some(&view) = active {
            toolbar::ui(ui, view, self.context);
        }
    }

    fn on_edit(&mut self, action: EditAction) {
        self.is_edited |= action != EditAction::TabSelected;
    }

    fn simplification_options(&self) -> SimplificationOptions {
        SimplificationOptions { all_panes_must_have_tabs: true, ..SimplificationOptions::default() }
    }

    fn tab_bar_height(&self, _: &egui::Style) -> f32 {
        26.0
    }

    fn gap_width(&self, _: &egui::Style) -> f32 {
        3.0
    }

    fn min_size(&self) -> f32 {
        120.0
    }

    fn tab_bar_color(&self, _: &egui::Visuals) -> Color32 {
        Color32::TRANSPARENT
    }

    fn tab_bg_color(&self, _: &egui::Visuals, _: &Tiles<View>, _: TileId, _: &TabState) -> Color32 {
        Color32::TRANSPARENT
    }

    fn tab_outline_stroke(
        &self,
        _: &egui::Visuals,
        _: &Tiles<View>,
        _: TileId,
        _: &TabState,
    ) -> Stroke {
        Stroke::NONE
    }

    fn tab_bar_hline_stroke(&self, visuals: &egui::Visuals) -> Stroke {
        visuals.widgets.noninteractive.bg_stroke
    }

    fn tab_text_color(
        &self,
        visuals: &egui::Visuals,
        tiles: &Tiles<View>,
        tile: TileId,
        state: &TabState,
    ) -> Color32 {
        let focused = tiles.get_pane(&tile) == Some(&self.focus);
        match (state.active, focused) {
            (true, true) => theme::accent_colour(self.context.theme()),
            (true, false) => visuals.strong_text_color(),
            (false, _) => visuals.weak_text_color(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_layout_survives_saving() {
        let mut layout = Layout::default();
        layout.arrange(LayoutPreset::Only(View::Map));
        let text = serde_json::to_string(&layout).unwrap();
        let back: Layout = serde_json::from_str(&text).unwrap();
        assert!(back.tree.tiles.find_pane(&View::Map).is_some());
        assert!(back.tree.tiles.find_pane(&View::Cloud).is_none());
        assert_eq!(back.focus, View::Map);
    }

    #[test]
    fn focusing_a_view_that_is_not_there_brings_it() {
        let mut layout = Layout::default();
        layout.arrange(LayoutPreset::Only(View::Map));
        layout.focus(View::Cloud);
        assert_eq!(layout.shown(), [View::Cloud]);
        // The other view stays behind the map.
        layout.focus(View::Map);
        assert_eq!(layout.shown(), [View::Map]);
    }

    #[test]
    fn each_step_has_its_arrangement_and_keeps_that_of_the_analyst() {
        let mut layout = Layout::default();
        for step in WorkStep::ALL {
            layout.follow_step(step);
            for view in View::ALL {
                assert!(layout.tree.tiles.find_pane(&view).is_some(), "{step:?}: {view:?}");
            }
        }
        layout.arrange(LayoutPreset::Only(View::Cloud));
        layout.follow_step(WorkStep::Objects);
        let shown = layout.shown();
        // The view with the keyboard stays in front, here of the map.
        assert_eq!(shown, [View::Waterfall, View::Objects, View::Cloud]);
        layout.follow_step(WorkStep::Export);
        assert_eq!(layout.shown(), [View::Cloud]);
    }

    #[test]
    fn the_table_of_objects_joins_an_arrangement_that_was_saved_without_it() {
        let mut layout = Layout::default();
        let table = layout.tree.tiles.find_pane(&View::Objects).expect("a tab");
        layout.tree.remove_recursively(table);
        let text = serde_json::to_string(&layout).unwrap();
        let mut saved: Layout = serde_json::from_str(&text).unwrap();
        assert_eq!(saved.tree.tiles.find_pane(&View::Objects), None);
        saved.focus(View::Objects);
        // The table is in front of the waterfall; map and cloud stay where they are.
        let shown = saved.shown();
        assert_eq!(shown.len(), 3, "{shown:?}");
        assert!(shown.contains(&View::Objects) && !shown.contains(&View::Waterfall));
        saved.focus(View::Waterfall);
        assert!(saved.shown().contains(&View::Waterfall));
    }
}

//! Defines all colours and sizes of the window.

use crate::app::{SideColours, ThemeChoice, ViewOptions};
use bathyscope_log::survey::Side;
use bathyscope_objects::review::State;
use egui::{Color32, CornerRadius, FontId, Stroke, TextStyle, Visuals};

/// Returns the opaque colour of these parts.
pub(crate) fn rgb([r, g, b]: [u8; 3]) -> Color32 {
    Color32::from_rgb(r, g, b)
}

fn by_theme(theme: ThemeChoice, dark: [u8; 3], light: [u8; 3]) -> Color32 {
    rgb(match theme {
        ThemeChoice::Dark => dark,
        ThemeChoice::Light => light,
    })
}

/// Returns the colour of a side's first return and points.
pub(crate) fn side_colour(options: &ViewOptions, side: Side) -> Color32 {
    match (options.side_colours, side) {
        (SideColours::Paper, Side::Starboard) => Color32::from_rgb(235, 64, 52),
        (SideColours::Paper, Side::Port) => Color32::from_rgb(66, 135, 245),
        (SideColours::Maritime, Side::Starboard) => Color32::from_rgb(46, 176, 93),
        (SideColours::Maritime, Side::Port) => Color32::from_rgb(235, 64, 52),
    }
}

/// Returns the colour of down-scan points: black as in the paper, white on dark.
pub(crate) fn down_scan_colour(options: &ViewOptions) -> Color32 {
    by_theme(options.theme, [235, 235, 235], [20, 20, 20])
}

/// Colour of points across the track, those of a swath.
pub(crate) const SWATH_COLOUR: Color32 = Color32::from_rgb(178, 102, 255);

/// Colour of points that the outlier filter would remove.
pub(crate) const OUTLIER_COLOUR: Color32 = Color32::from_rgb(255, 190, 40);

/// Returns the colour of boxes on the waterfall, which is dark or coloured in any theme.
pub(crate) fn box_colour(state: State) -> Color32 {
    match state {
        State::Proposed => Color32::from_rgb(255, 214, 64),
        State::Accepted => Color32::from_rgb(96, 226, 110),
        State::Rejected => Color32::from_rgb(196, 132, 132),
        State::Added => Color32::from_rgb(120, 200, 255),
    }
}

/// Returns the colour of a box's state in words on a panel, and in marks on map and cloud.
pub(crate) fn box_colour_on_panel(theme: ThemeChoice, state: State) -> Color32 {
    match (theme, state) {
        (ThemeChoice::Dark, _) => box_colour(state),
        (ThemeChoice::Light, State::Proposed) => Color32::from_rgb(150, 104, 0),
        (ThemeChoice::Light, State::Accepted) => Color32::from_rgb(24, 122, 48),
        (ThemeChoice::Light, State::Rejected) => Color32::from_rgb(150, 62, 58),
        (ThemeChoice::Light, State::Added) => Color32::from_rgb(20, 100, 170),
    }
}

/// Colour of objects that no box has found, on the waterfall.
pub(crate) const MISSED_COLOUR: Color32 = Color32::from_rgb(206, 130, 255);

/// Returns the colour of objects that no box has found, for words on a panel.
pub(crate) fn missed_colour_on_panel(theme: ThemeChoice) -> Color32 {
    match theme {
        ThemeChoice::Dark => MISSED_COLOUR,
        ThemeChoice::Light => Color32::from_rgb(122, 40, 176),
    }
}

/// Colour of what is inferred and not measured: the shape of an object.
pub(crate) const INFERRED_COLOUR: Color32 = Color32::from_rgb(255, 122, 46);

/// Returns the background of waterfall, map and cloud.
pub(crate) fn canvas_colour(options: &ViewOptions) -> Color32 {
    by_theme(options.theme, [14, 17, 22], [247, 247, 245])
}

/// Colour of the cross-hairs of the place under the pointer in another view.
pub(crate) const HOVER_COLOUR: Color32 = Color32::from_rgb(255, 221, 87);

/// Colour of the mark of the selection.
pub(crate) const SELECTION_COLOUR: Color32 = Color32::from_rgb(90, 220, 220);

/// Returns the colour of text on waterfall, map and cloud.
pub(crate) fn canvas_text_colour(options: &ViewOptions) -> Color32 {
    by_theme(options.theme, [205, 210, 216], [48, 52, 58])
}

/// Returns the colour of grid lines on map and cloud.
pub(crate) fn grid_colour(options: &ViewOptions) -> Color32 {
    by_theme(options.theme, [42, 48, 56], [218, 220, 220])
}

/// Returns the colour of plates behind text on a picture.
pub(crate) fn plate_colour(options: &ViewOptions) -> Color32 {
    let [r, g, b, _] = canvas_colour(options).to_array();
    Color32::from_rgba_unmultiplied(r, g, b, 205)
}

/// Returns the colour of ranked flat stretches on the map.
pub(crate) fn flat_spot_colour(options: &ViewOptions) -> Color32 {
    by_theme(options.theme, [250, 250, 250], [30, 30, 30])
}

/// Colour of the stretch that the calibration was measured on.
pub(crate) const CALIBRATION_COLOUR: Color32 = Color32::from_rgb(255, 105, 180);

/// Colour of a stretch that is proposed for the calibration.
pub(crate) const PROPOSAL_COLOUR: Color32 = Color32::from_rgb(255, 196, 60);

/// Returns the colour of a proposed stretch on the background of a panel.
pub(crate) fn proposal_ink(options: &ViewOptions) -> Color32 {
    match options.theme {
        ThemeChoice::Dark => PROPOSAL_COLOUR,
        ThemeChoice::Light => Color32::from_rgb(176, 108, 0),
    }
}

/// Returns the colour of what is in progress or in use: numbers of steps, the focused view,
/// progress.
pub(crate) fn accent_colour(theme: ThemeChoice) -> Color32 {
    by_theme(theme, [72, 176, 176], [14, 120, 124])
}

/// Returns the colour of warnings and of a result that is older than its settings.
pub(crate) fn stale_colour(theme: ThemeChoice) -> Color32 {
    by_theme(theme, [226, 168, 62], [166, 104, 0])
}

/// Returns the colour of errors.
pub(crate) fn error_colour(theme: ThemeChoice) -> Color32 {
    by_theme(theme, [240, 112, 100], [186, 40, 30])
}

/// Returns the colour of the curve of the recorded depth in the time line.
pub(crate) fn depth_strip_colour(theme: ThemeChoice) -> Color32 {
    by_theme(theme, [96, 150, 190], [58, 112, 156])
}

/// Returns the colour of the curve of the speed in the time line.
pub(crate) fn speed_strip_colour(theme: ThemeChoice) -> Color32 {
    by_theme(theme, [134, 150, 110], [98, 118, 66])
}

/// Width of the panels left and right of the views, points.
pub(crate) const SIDE_PANEL_WIDTH: f32 = 300.0;
/// Size of a dialog's main button, points.
pub(crate) const DIALOG_BUTTON: egui::Vec2 = egui::vec2(96.0, 22.0);
/// Width of the names in front of controls and values, points.
pub(crate) const LABEL_WIDTH: f32 = 96.0;
/// Size of small print (hints, legends, section titles), points.
pub(crate) const SMALL: f32 = 11.0;

/// Greys of one theme, from the deepest background to the strongest text.
struct Greys {
    panel: Color32,
    well: Color32,
    control: Color32,
    hovered: Color32,
    pressed: Color32,
    line: Color32,
    text: Color32,
    strong: Color32,
}

impl Greys {
    fn of(theme: ThemeChoice) -> Self {
        let rgb = Color32::from_rgb;
        match theme {
            ThemeChoice::Dark => Self {
                panel: rgb(27, 31, 38),
                well: rgb(18, 21, 27),
                control: rgb(44, 50, 60),
                hovered: rgb(56, 64, 76),
                pressed: rgb(68, 78, 92),
                line: rgb(48, 55, 66),
                text: rgb(190, 198, 208),
                strong: rgb(238, 241, 245),
            },
            ThemeChoice::Light => Self {
                panel: rgb(240, 241, 243),
                well: rgb(255, 255, 255),
                control: rgb(221, 224, 229),
                hovered: rgb(208, 213, 220),
                pressed: rgb(190, 197, 206),
                line: rgb(204, 208, 214),
                text: rgb(58, 66, 76),
                strong: rgb(16, 20, 26),
            },
        }
    }
}

/// Returns the look of all widgets in a theme.
pub(crate) fn visuals(theme: ThemeChoice) -> Visuals {
    let greys = Greys::of(theme);
    let mut visuals = match theme {
        ThemeChoice::Dark => Visuals::dark(),
        ThemeChoice::Light => Visuals::light(),
    };
    visuals.panel_fill = greys.panel;
    visuals.window_fill = greys.panel;
    visuals.window_stroke = Stroke::new(1.0, greys.line);
    visuals.extreme_bg_color = greys.well;
    visuals.faint_bg_color = greys.control.gamma_multiply(0.35);
    visuals.code_bg_color = greys.control;
    visuals.warn_fg_color = stale_colour(theme);
    visuals.error_fg_color = error_colour(theme);
    visuals.hyperlink_color = accent_colour(theme);
    visuals.weak_text_color = Some(greys.text.gamma_multiply(0.72));
    visuals.selection.bg_fill = accent_colour(theme).gamma_multiply(0.45);
    visuals.selection.stroke = Stroke::new(1.0, greys.strong);
    visuals.slider_trailing_fill = true;
    visuals.window_corner_radius = CornerRadius::same(4);
    visuals.menu_corner_radius = CornerRadius::same(4);
    let widgets = &mut visuals.widgets;
    let states = [
        (&mut widgets.noninteractive, greys.panel, greys.text),
        (&mut widgets.inactive, greys.control, greys.text),
        (&mut widgets.hovered, greys.hovered, greys.strong),
        (&mut widgets.active, greys.pressed, greys.strong),
        (&mut widgets.open, greys.hovered, greys.strong),
    ];
    for (state, fill, text) in states {
        state.bg_fill = fill;
        state.weak_bg_fill = fill;
        state.bg_stroke = Stroke::NONE;
        state.fg_stroke = Stroke::new(1.0, text);
        state.corner_radius = CornerRadius::same(3);
        state.expansion = 0.0;
    }
    widgets.noninteractive.bg_stroke = Stroke::new(1.0, greys.line);
    visuals
}

/// Sets the theme of a context; the first call also sets the program's sizes and colours.
pub(crate) fn apply(ctx: &egui::Context, theme: ThemeChoice) {
    let styled = egui::Id::unique("bathyscope styled");
    if ctx.data(|data| data.get_temp::<bool>(styled)).is_none() {
        ctx.data_mut(|data| data.insert_temp(styled, true));
        ctx.set_visuals_of(egui::Theme::Dark, visuals(ThemeChoice::Dark));
        ctx.set_visuals_of(egui::Theme::Light, visuals(ThemeChoice::Light));
        ctx.all_styles_mut(sizes);
    }
    ctx.set_theme(match theme {
        ThemeChoice::Dark => egui::Theme::Dark,
        ThemeChoice::Light => egui::Theme::Light,
    });
}

fn sizes(style: &mut egui::Style) {
    style.text_styles = [
        (TextStyle::Heading, FontId::proportional(15.0)),
        (TextStyle::Body, FontId::proportional(13.0)),
        (TextStyle::Button, FontId::proportional(13.0)),
        (TextStyle::Small, FontId::proportional(SMALL)),
        (TextStyle::Monospace, FontId::monospace(12.0)),
    ]
    .into();
    let spacing = &mut style.spacing;
    spacing.item_spacing = egui::vec2(6.0, 3.0);
    spacing.button_padding = egui::vec2(6.0, 1.0);
    spacing.interact_size = egui::vec2(28.0, 18.0);
    spacing.slider_width = 104.0;
    spacing.combo_width = 120.0;
    spacing.icon_width = 14.0;
    spacing.icon_width_inner = 8.0;
    spacing.menu_margin = egui::Margin::same(6);
    spacing.scroll = egui::style::ScrollStyle::thin();
    style.interaction.tooltip_delay = 0.4;
}

/// Returns the colour of range lines and ticks on the waterfall.
pub(crate) fn picture_ink(options: &ViewOptions) -> Color32 {
    if options.waterfall.colour_map.is_light() {
        Color32::from_black_alpha(110)
    } else {
        Color32::from_white_alpha(70)
    }
}

/// Returns the colour of the recorder's track where another receiver's is in use: visible, but less
/// prominent than everything else.
pub(crate) fn recorded_track_colour(options: &ViewOptions) -> Color32 {
    canvas_text_colour(options).gamma_multiply(0.45)
}

/// Returns the colour of excluded stretches on the map and the time line.
pub(crate) fn excluded_colour(options: &ViewOptions) -> Color32 {
    canvas_text_colour(options).gamma_multiply(0.75)
}

/// Colour of measuring figures on the map, set off by a casing.
pub(crate) const MEASURE_COLOUR: Color32 = Color32::from_rgb(255, 150, 50);

/// Returns the colour of curves, axes and numbers of the profile.
pub(crate) fn plot_ink(options: &ViewOptions) -> Color32 {
    by_theme(options.theme, [205; 3], [60; 3])
}

/// Colour of bottom edits in the waterfall.
pub(crate) const HAND_COLOUR: Color32 = Color32::from_rgb(120, 255, 140);

/// Colour of the depth that the recorder itself found, on waterfall and profile.
pub(crate) const DEPTH_LINE_COLOUR: Color32 = Color32::from_rgb(225, 200, 60);

/// Makes a menu as wide as its longest entry: where there is less room, words would be broken.
pub(crate) fn whole_words(ui: &mut egui::Ui) {
    ui.style_mut().wrap_mode = Some(egui::TextWrapMode::Extend);
}

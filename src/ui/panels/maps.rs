//! How depth map, isobaths and mosaic are made: on the map and in the files.

use super::parts::{Choice, Knob, Section, choice, knob, section};
use crate::app::{Action, Command, MapLayer};
use crate::bathymetry::SurfaceMethod;
use crate::mosaic::{Colours, Gain, Overlap};
use crate::ui::ViewContext;
use egui::Ui;

const METHODS: &[Choice<SurfaceMethod>] = &[
    (
        SurfaceMethod::Linear,
        "triangles",
        "Linear on the planes of the Delaunay triangles between depths.",
    ),
    (
        SurfaceMethod::Natural,
        "natural neighbours",
        "Sibson's: smooth but at the depths themselves. Slower.",
    ),
    (
        SurfaceMethod::InverseDistance,
        "inverse distance",
        "Mean of the nearest depths by inverse distance squared: smooth, draws towards the mean.",
    ),
];

const OVERLAPS: &[Choice<Overlap>] = &[
    (
        Overlap::Later,
        "later on top",
        "The later pass lies over the earlier.",
    ),
    (
        Overlap::Brighter,
        "brighter on top",
        "The brighter echo counts: objects stay, shadows are lost.",
    ),
    (
        Overlap::Middle,
        "middle on top",
        "The pass in the middle of whose swath the ground lies: weak ends show only where there is nothing else.",
    ),
    (
        Overlap::Blend,
        "blend",
        "The mean, weighted towards the middle of each swath: objects and shadows fade.",
    ),
];

const GAINS: &[Choice<Gain>] = &[
    (
        Gain::Empirical,
        "evened",
        "Divided by the survey's own mean at that range and angle; shadows stay dark.",
    ),
    (Gain::Recorded, "as recorded", "The recorder's own levels."),
];

const COLOURS: &[Choice<Colours>] = &[
    (Colours::Grey, "grey", "Black to white."),
    (Colours::Copper, "copper", "Black to copper."),
];

const COLUMNS: &[Choice<bool>] = &[
    (
        false,
        "removed",
        "Slant ranges are turned into distances on the ground by the altitude.",
    ),
    (
        true,
        "kept",
        "Slant ranges are taken for distances on the ground.",
    ),
];

/// Draws the sections.
pub fn ui(ui: &mut Ui, context: &mut ViewContext<'_>) {
    let heading = |title| Section {
        number: None,
        title,
        stage: None,
    };
    section(ui, context, &heading("Depth map"), depth_map);
    section(ui, context, &heading("Mosaic"), mosaic);
}

/// Shows or hides a layer, and says which it is now.
fn layer_button(ui: &mut Ui, context: &mut ViewContext<'_>, layer: MapLayer, action: Action) {
    let shown = context.app.options.map.layers.is_visible(layer);
    let text = match shown {
        true => "Hide on the map",
        false => "Show on the map",
    };
    let button = ui.button(text).accessible_name(action.label());
    if button.on_hover_text(action.hint()).clicked() {
        context.push(Command::Do(action));
    }
}

fn depth_map(ui: &mut Ui, context: &mut ViewContext<'_>) {
    let surface = context.app.log.settings.surface.clone();
    choice(
        ui,
        context,
        "Between depths",
        "How the depth between soundings and side-scan points is found.",
        METHODS,
        surface.method,
        |settings, method| settings.surface.method = method,
    );
    let cell = Knob {
        name: "Cell",
        undo: "cell of the depth map",
        hint: "Side of a cell of the depth map; 0 chooses it from the spacing of the depths.",
        range: 0.0..=5.0,
        step: 0.1,
        decimals: 1,
        suffix: " m",
    };
    let now = surface.cell_m.unwrap_or(0.0);
    knob(ui, context, cell, now, |settings, cell_m| {
        settings.surface.cell_m = (cell_m > 0.0).then_some(cell_m);
    });
    let gap = Knob {
        name: "Gap",
        undo: "gap of the depth map",
        hint: "No value farther than this from a depth.",
        range: 1.0..=100.0,
        step: 1.0,
        decimals: 0,
        suffix: " m",
    };
    knob(ui, context, gap, surface.max_gap_m, |settings, gap_m| {
        settings.surface.max_gap_m = gap_m;
    });
    let weight = Knob {
        name: "Side-scan",
        undo: "weight of side-scan points",
        hint: "What a side-scan point counts where it meets a sounding, which counts 1; 0 leaves side-scan points out.",
        range: 0.0..=1.0,
        step: 0.05,
        decimals: 2,
        suffix: "",
    };
    let now = surface.side_scan_weight;
    knob(ui, context, weight, now, |settings, weight| {
        settings.surface.side_scan_weight = weight;
    });
    isobaths(ui, context);
}

fn isobaths(ui: &mut Ui, context: &mut ViewContext<'_>) {
    let isobaths = context.app.log.settings.isobaths.clone();
    let interval = Knob {
        name: "Isobaths",
        undo: "isobath interval",
        hint: "Metres from one isobath to the next; 0 chooses it from the depths. Every fifth is thick.",
        range: 0.0..=5.0,
        step: 0.05,
        decimals: 2,
        suffix: " m",
    };
    let now = isobaths.interval_m.unwrap_or(0.0);
    knob(ui, context, interval, now, |settings, interval_m| {
        settings.isobaths.interval_m = (interval_m > 0.0).then_some(interval_m);
    });
    let smooth = Knob {
        name: "Smoothing",
        undo: "isobath smoothing",
        hint: "How often the corners of isobaths are cut; 0 leaves them as measured.",
        range: 0.0..=4.0,
        step: 1.0,
        decimals: 0,
        suffix: "",
    };
    knob(
        ui,
        context,
        smooth,
        f64::from(isobaths.smooth),
        |settings, passes| {
            settings.isobaths.smooth = passes as u32;
        },
    );
}

fn mosaic(ui: &mut Ui, context: &mut ViewContext<'_>) {
    let mosaic = context.app.log.settings.mosaic.clone();
    layer_button(ui, context, MapLayer::Mosaic, Action::MosaicLayer);
    choice(
        ui,
        context,
        "Overlap",
        "What is shown where several passes saw the ground.",
        OVERLAPS,
        mosaic.overlap,
        |settings, overlap| settings.mosaic.overlap = overlap,
    );
    choice(
        ui,
        context,
        "Gain",
        "How levels are made even across the track.",
        GAINS,
        mosaic.gain,
        |settings, gain| settings.mosaic.gain = gain,
    );
    choice(
        ui,
        context,
        "Colours",
        "Colours of the mosaic, on the map and in the file.",
        COLOURS,
        mosaic.colours,
        |settings, colours| settings.mosaic.colours = colours,
    );
    choice(
        ui,
        context,
        "Water column",
        "What is heard before the bottom.",
        COLUMNS,
        mosaic.water_column,
        |settings, kept| settings.mosaic.water_column = kept,
    );
    let gap = Knob {
        name: "Nadir gap",
        undo: "nadir gap",
        hint: "Ground nearer than this angle from straight down is left out; 0 fills the gap under the boat.",
        range: 0.0..=60.0,
        step: 1.0,
        decimals: 0,
        suffix: "°",
    };
    knob(
        ui,
        context,
        gap,
        mosaic.nadir_gap_deg,
        |settings, gap_deg| {
            settings.mosaic.nadir_gap_deg = gap_deg;
        },
    );
    let turn = Knob {
        name: "Turns from",
        undo: "turn rate",
        hint: "Pings where the boat turns faster are left out: their far ends sweep over the ground.",
        range: 1.0..=45.0,
        step: 0.5,
        decimals: 1,
        suffix: " °/s",
    };
    knob(
        ui,
        context,
        turn,
        mosaic.most_turn_deg_s,
        |settings, turn_deg_s| {
            settings.mosaic.most_turn_deg_s = turn_deg_s;
        },
    );
    let cell = Knob {
        name: "File's cell",
        undo: "cell of the mosaic",
        hint: "Side of a cell of mosaic.tif; on the map the mosaic is as fine as the screen.",
        range: 0.02..=2.0,
        step: 0.01,
        decimals: 2,
        suffix: " m",
    };
    knob(ui, context, cell, mosaic.cell_m, |settings, cell_m| {
        settings.mosaic.cell_m = cell_m;
    });
}

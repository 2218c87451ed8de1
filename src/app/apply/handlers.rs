//! Functions that carry out the commands without arguments.

use crate::app::{Action, App, LogOrigin, MapLayer, Orientation, SideColours, ThemeChoice, Tool};
use bathyscope_bottom::presentation::units::{LengthUnit, SpeedUnit};
use bathyscope_log::support::geo::CoordinateFormat;
use bathyscope_objects::review::Edit;
use bathyscope_products::pipeline::Preset;
use bathyscope_products::project::MeasurementKind;

/// Carries out a command.
pub(super) type Handler = fn(&mut App);

/// Returns the function of a command; `None` for windows, dialogs, layout and cameras, which belong
/// to the shell.
pub(super) fn handler(action: Action) -> Option<Handler> {
    let mut all = SURVEY.iter().chain(SHOWN);
    all.find(|(of, _)| *of == action).map(|(_, handler)| *handler)
}

/// Commands that act on logs, results, decisions and tools.
const SURVEY: &[(Action, Handler)] = &[
    (Action::OpenDemo, |app| app.start_loading(LogOrigin::Demo)),
    (Action::FollowRecording, App::toggle_following),
    (Action::Undo, App::undo),
    (Action::Redo, App::redo),
    (Action::Update, App::update),
    (Action::NextLog, |app| app.step_log(1)),
    (Action::PreviousLog, |app| app.step_log(-1)),
    (Action::ShowTogether, App::show_together),
    (Action::CloseLog, |app| app.close_log(app.log.id)),
    (Action::Cancel, |app| {
        app.cancel();
    }),
    (Action::PreviousPing, |app| app.step(-1)),
    (Action::NextPing, |app| app.step(1)),
    (Action::Back25, |app| app.step(-25)),
    (Action::Forward25, |app| app.step(25)),
    (Action::FirstPing, |app| app.step(isize::MIN)),
    (Action::LastPing, |app| app.step(isize::MAX)),
    (Action::ThresholdDown, |app| app.nudge_threshold(-0.01)),
    (Action::ThresholdUp, |app| app.nudge_threshold(0.01)),
    (Action::LevelsReset, App::reset_picture),
    (Action::GainNormalised, App::toggle_gain),
    (Action::Despeckle, App::toggle_despeckle),
    (Action::StripeFilter, App::toggle_stripe_filter),
    (Action::FlipAlong, App::toggle_flip),
    (Action::StarboardFirst, App::toggle_starboard_first),
    (Action::SwapSides, App::swap_sides),
    (Action::ApplySoundingLag, App::apply_sounding_lag),
    (Action::UseMounting, App::use_mounting),
    (Action::ForgetMounting, App::forget_mounting),
    (Action::Boxes, App::toggle_boxes),
    (Action::CloseReference, App::leave_reference),
    (Action::RemoveIsobathArea, App::remove_isobath_area),
    (Action::RemoveWaterLevels, App::remove_water_levels),
    (Action::RemoveTrack, App::remove_track),
    (Action::CloseBaseMap, App::close_base_map),
    (Action::ApplyHeights, App::apply_heights),
    (Action::LeaveOutContradicted, App::leave_out_contradicted),
    (Action::ComparePositions, App::match_positions),
    (Action::ApplyPositions, App::apply_positions),
    (Action::Calibrate, App::take_calibration_tool),
    (Action::UseScale, App::use_scale),
    (Action::KeepRecordedRange, App::keep_recorded_range),
    (Action::DropProposal, App::drop_proposal),
    (Action::UseFlatterStretch, App::use_offered_stretch),
    (Action::NextPass, App::next_pass),
    (Action::Cut3d, App::toggle_cut),
    (Action::NextChannel, App::next_channel),
    (Action::PresetRecommended, |app| app.use_preset(Preset::Recommended)),
    (Action::PresetPublished, |app| app.use_preset(Preset::Published)),
    (Action::FindObjects, App::detect),
    (Action::ShippedModel, |app| app.use_model(None)),
    (Action::NextBox, |app| app.step_box(1)),
    (Action::PreviousBox, |app| app.step_box(-1)),
    (Action::AcceptBox, |app| app.decide(Edit::Accept)),
    (Action::RejectBox, |app| app.decide(Edit::Reject)),
    (Action::UndecideBox, |app| app.edit_selected(Edit::Undecide)),
    (Action::AcceptObject, |app| app.decide_object(Edit::Accept, "accept object")),
    (Action::RejectObject, |app| app.decide_object(Edit::Reject, "reject object")),
    (Action::UndecideObject, |app| {
        app.edit_object(Edit::Undecide, "mark object as undecided");
    }),
    (Action::NextSighting, App::step_sighting),
    (Action::FlyToBox, |app| match app.selected_log_box() {
        Some(id) => app.fly_to(id),
        None => app.ask_for_box(),
    }),
    (Action::ZoomToBoxes, App::toggle_zoom_to_boxes),
    (Action::SwapSide, |app| app.edit_selected(Edit::SwapSide)),
    (Action::RemoveBox, App::remove_box),
    (Action::EditBox, |app| app.take_tool(Tool::Edit)),
    (Action::NewBox, |app| app.take_tool(Tool::Draw)),
    (Action::NextEdge, App::next_edge),
    (Action::FindEdges, |app| app.edit_selected(Edit::FindEdges)),
    (Action::MarkTarget, App::point_tool),
    (Action::Exclude, |app| app.take_tool(Tool::Exclude)),
    (Action::IncludeAgain, App::include_again),
    (Action::TrustSoundings, App::trust_soundings),
    (Action::DrawBottom, |app| app.take_tool(Tool::Bottom)),
    (Action::AcceptBottom, |app| app.take_tool(Tool::Accept)),
    (Action::ForgetBottom, App::forget_bottom),
    (Action::MeasureDistance, |app| app.take_measuring_tool(MeasurementKind::Distance)),
    (Action::MeasureArea, |app| app.take_measuring_tool(MeasurementKind::Area)),
    (Action::DepthProfile, |app| app.take_measuring_tool(MeasurementKind::Profile)),
    (Action::UseShadow, App::use_shadow),
    (Action::HeightFromShadow, |app| app.take_measuring_tool(MeasurementKind::Height)),
    (Action::TakeCornerBack, App::take_corner_back),
    (Action::EndFigure, App::end_figure),
    (Action::RemoveFigure, App::remove_figure),
    (Action::PlanLines, App::plan_lines),
    (Action::RemoveLine, App::remove_line),
    (Action::RemovePlan, App::remove_plan),
    (Action::TakeUpUnsaved, App::take_up_unsaved),
    (Action::ForgetTruth, App::forget_truth),
    (Action::NextMistake, |app| app.step_mistake(1)),
    (Action::PreviousMistake, |app| app.step_mistake(-1)),
    (Action::LeaveTool, App::leave_current_tool),
];

/// Commands that change only how things are shown.
const SHOWN: &[(Action, Handler)] = &[
    (Action::FirstReturnLine, |app| {
        let waterfall = &mut app.view.options.waterfall;
        waterfall.first_return = !waterfall.first_return;
    }),
    (Action::DepthLine, |app| {
        let waterfall = &mut app.view.options.waterfall;
        waterfall.depth_line = !waterfall.depth_line;
    }),
    (Action::RangeLines, |app| {
        let waterfall = &mut app.view.options.waterfall;
        waterfall.range_lines = !waterfall.range_lines;
    }),
    (Action::DepthMapLayer, |app| app.view.options.map.layers.toggle(MapLayer::DepthMap)),
    (Action::HillShadeLayer, |app| app.view.options.map.layers.toggle(MapLayer::HillShade)),
    (Action::MosaicLayer, |app| app.view.options.map.layers.toggle(MapLayer::Mosaic)),
    (Action::IsobathLayer, |app| app.view.options.map.layers.toggle(MapLayer::Isobaths)),
    (Action::PointLayer, |app| app.view.options.map.layers.toggle(MapLayer::Points)),
    (Action::ResidualLayer, |app| app.view.options.map.layers.toggle(MapLayer::Residuals)),
    (Action::TrackLayer, |app| app.view.options.map.layers.toggle(MapLayer::Track)),
    (Action::BoxLayer, |app| app.view.options.map.layers.toggle(MapLayer::Boxes)),
    (Action::SideColours, |app| {
        app.view.options.side_colours = match app.view.options.side_colours {
            SideColours::Paper => SideColours::Maritime,
            SideColours::Maritime => SideColours::Paper,
        }
    }),
    (Action::BaseMapLayer, |app| app.view.options.map.layers.toggle(MapLayer::BaseMap)),
    (Action::Swipe, |app| app.view.options.map.swipe.toggle(&mut app.view.options.map.layers)),
    (Action::Graticule, |app| app.view.options.map.graticule = !app.view.options.map.graticule),
    (Action::CoordinatesDegrees, |app| app.view.options.coordinates = CoordinateFormat::Degrees),
    (Action::CoordinatesMinutes, |app| app.view.options.coordinates = CoordinateFormat::Minutes),
    (Action::CoordinatesSeconds, |app| app.view.options.coordinates = CoordinateFormat::Seconds),
    (Action::CoordinatesUtm, |app| app.view.options.coordinates = CoordinateFormat::Utm),
    (Action::UnitsMetres, |app| app.view.options.units.length = LengthUnit::Metres),
    (Action::UnitsFeet, |app| app.view.options.units.length = LengthUnit::Feet),
    (Action::UnitsFathoms, |app| app.view.options.units.length = LengthUnit::Fathoms),
    (Action::SpeedMetres, |app| app.view.options.units.speed = SpeedUnit::MetresPerSecond),
    (Action::SpeedKnots, |app| app.view.options.units.speed = SpeedUnit::Knots),
    (Action::OutlierPreview, |app| {
        app.view.options.cloud.outlier_preview = !app.view.options.cloud.outlier_preview;
    }),
    (Action::NextCloudColour, |app| {
        let has_several = app.log_count() > 1;
        app.view.options.cloud.colour = app.view.options.cloud.colour.next(has_several);
    }),
    (Action::Bottom3d, |app| app.view.options.cloud.bottom = !app.view.options.cloud.bottom),
    (Action::NextBottomColour, |app| {
        let cloud = &mut app.view.options.cloud;
        // What is not shown is shown as it was.
        if std::mem::replace(&mut cloud.bottom, true) {
            cloud.bottom_colour = cloud.bottom_colour.next();
        }
    }),
    (Action::BottomIsobaths, |app| {
        app.view.options.cloud.isobaths = !app.view.options.cloud.isobaths
    }),
    (Action::TurnLight, |app| app.view.options.cloud.turn_light()),
    (Action::ClipBox3d, |app| app.view.options.cloud.toggle_clip()),
    (Action::Water3d, |app| app.view.options.cloud.water = !app.view.options.cloud.water),
    (Action::Points3d, |app| app.view.options.cloud.points = !app.view.options.cloud.points),
    (Action::Theme, |app| {
        app.view.options.theme = match app.view.options.theme {
            ThemeChoice::Dark => ThemeChoice::Light,
            ThemeChoice::Light => ThemeChoice::Dark,
        }
    }),
    (Action::Orientation, |app| {
        let waterfall = &mut app.view.options.waterfall;
        waterfall.orientation = match waterfall.orientation {
            Orientation::Horizontal => Orientation::Vertical,
            Orientation::Vertical => Orientation::Horizontal,
        }
    }),
    (Action::GroundRange, |app| {
        let waterfall = &mut app.view.options.waterfall;
        waterfall.ground_range = !waterfall.ground_range;
    }),
    (Action::WaterColumn, |app| {
        let waterfall = &mut app.view.options.waterfall;
        waterfall.water_column = !waterfall.water_column;
    }),
    (Action::BottomBothSides, |app| {
        let both = &mut app.view.options.waterfall.bottom_both_sides;
        *both = !*both;
    }),
];

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::HashSet;

    #[test]
    fn a_command_is_handled_once() {
        let mut seen = HashSet::new();
        for (action, _) in SURVEY.iter().chain(SHOWN) {
            assert!(seen.insert(*action), "{action:?}");
        }
    }
}

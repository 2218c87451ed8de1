//! Determines which actions are available now: menus grey the others, and the palette leaves them
//! out.

use super::{Action, App};
use bathyscope_bottom::calibration::ScaleMode;

impl App {
    /// Returns `false` where an action would remove or leave something that is not there. All other
    /// actions say themselves what they lack.
    pub(crate) fn has_what_it_takes(&self, action: Action) -> bool {
        match action {
            Action::ShowTogether => self.logs().any(|log| log.apart.is_some()),
            Action::OpenExported => self.written_into.is_some(),
            Action::CloseBaseMap => self.map.base_map.is_some(),
            Action::RemoveIsobathArea => self.log.settings.isobaths.clip.is_some(),
            Action::RemoveWaterLevels => self.log.settings.water_level.file.is_some(),
            Action::RemoveTrack => self.log.settings.track.file.is_some(),
            Action::SwapSides | Action::UseMounting | Action::ExportLog | Action::ExportPings => {
                self.log.survey.is_some()
            }
            Action::ApplySoundingLag => self.log.sounding_lag().is_some(),
            Action::ForgetMounting => self.usual_mounting().is_some(),
            Action::CloseReference => self.map.comparing.reference.is_some(),
            Action::ForgetTruth => self.log.reviewing.judging.source().is_some(),
            Action::ForgetBottom => !self.log.settings.bottom.is_empty(),
            Action::RemoveFigure => self.map.measuring.figure.is_some(),
            Action::RemovePlan | Action::SavePlan => self.map.planning.lines.is_some(),
            Action::RemoveLine => self.map.planning.selected.is_some(),
            Action::ApplyHeights => self.height_offsets().is_some(),
            Action::LeaveOutContradicted => {
                self.height_offsets().is_some_and(super::heights::FoundHeights::is_contradicted)
            }
            Action::ApplyPositions => {
                (self.position_offsets()).is_some_and(super::FoundPositions::tells)
            }
            Action::UseScale | Action::DropProposal => self.log.proposed_stretch().is_some(),
            Action::KeepRecordedRange => {
                self.log.settings.calibration.mode == ScaleMode::FlatSpot
                    || self.log.proposed_stretch().is_some()
            }
            Action::UseFlatterStretch => (self.logs()).any(|log| log.calibrating.offered.is_some()),
            _ => true,
        }
    }
}

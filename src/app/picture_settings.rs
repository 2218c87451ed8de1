//! Changes the picture settings (`picture.*`) of the shown log by keys and menus.

use super::{App, EchogramChannel};
use bathyscope_bottom::mosaic::Gain;
use bathyscope_bottom::picture::PictureSettings;
use bathyscope_products::pipeline::Settings;

impl App {
    pub(super) fn reset_picture(&mut self) {
        self.change_picture("levels of the waterfall", |picture| *picture = picture.reset());
    }

    pub(super) fn toggle_gain(&mut self) {
        self.change_picture("gain of the waterfall", |picture| {
            picture.gain = match picture.gain {
                Gain::Recorded => Gain::Empirical,
                Gain::Empirical => Gain::Recorded,
            };
        });
    }

    pub(super) fn toggle_despeckle(&mut self) {
        self.change_picture("despeckling", |picture| picture.despeckle = !picture.despeckle);
    }

    pub(super) fn toggle_stripe_filter(&mut self) {
        self.change_picture("stripe filter", |picture| {
            picture.stripe_filter = !picture.stripe_filter;
        });
    }

    pub(super) fn toggle_flip(&mut self) {
        self.change_picture("direction of the waterfall", |picture| {
            picture.flip = !picture.flip;
        });
    }

    pub(super) fn toggle_starboard_first(&mut self) {
        self.change_picture("side that comes first", |picture| {
            picture.starboard_first = !picture.starboard_first;
        });
    }

    /// Shows side-scan, then each down-looking channel of the log, beside the side-scan and alone.
    pub(super) fn next_channel(&mut self) {
        let survey = self.logs.shown.survey.as_ref();
        let has = |channel: &EchogramChannel| {
            let has = |kind| survey.is_some_and(|survey| survey.has_echogram(kind));
            channel.kind().is_some_and(has)
        };
        let shown = &mut self.view.options.waterfall;
        let there = EchogramChannel::ALL.into_iter().filter(has);
        let each = there.flat_map(|channel| [(channel, false), (channel, true)]);
        let all: Vec<_> = [(EchogramChannel::None, false)].into_iter().chain(each).collect();
        let now = match shown.echogram {
            EchogramChannel::None => (EchogramChannel::None, false),
            channel => (channel, shown.echogram_alone),
        };
        let place = all.iter().position(|choice| *choice == now).unwrap_or(0);
        (shown.echogram, shown.echogram_alone) = all[(place + 1) % all.len()];
    }

    fn change_picture(&mut self, label: &'static str, change: impl FnOnce(&mut PictureSettings)) {
        let mut settings = Settings::clone(&self.logs.shown.settings);
        change(&mut settings.picture);
        self.change(settings, label, false);
    }
}

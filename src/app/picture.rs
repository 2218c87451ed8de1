//! How the picture of the shown log is to be shown: keys and menus for `picture.*`.

use super::App;
use crate::mosaic::Gain;
use crate::picture::PictureSettings;
use crate::pipeline::Settings;

impl App {
    pub(super) fn reset_picture(&mut self) {
        self.change_picture("levels of the waterfall", |picture| {
            *picture = picture.reset()
        });
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
        self.change_picture("despeckling", |picture| {
            picture.despeckle = !picture.despeckle
        });
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

    pub(super) fn toggle_swapped_sides(&mut self) {
        self.change_picture("sides of the waterfall", |picture| {
            picture.swap_sides = !picture.swap_sides;
        });
    }

    fn change_picture(&mut self, label: &'static str, change: impl FnOnce(&mut PictureSettings)) {
        let mut settings = Settings::clone(&self.log.settings);
        change(&mut settings.picture);
        self.change(settings, label, false);
    }
}

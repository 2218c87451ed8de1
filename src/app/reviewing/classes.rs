//! Changes and renames the classes of objects of a survey, each as one undo step.

use crate::app::App;
use bathyscope_objects::ReviewSettings;
use bathyscope_products::pipeline::Settings;
use std::sync::Arc;

impl App {
    /// Sets the list of classes of the survey.
    pub(in crate::app) fn set_classes(&mut self, review: ReviewSettings) {
        let settings = Settings { review, ..Settings::clone(&self.logs.shown.settings) };
        self.change(settings, "classes of objects", false);
    }

    /// Renames a class, in the list and for the boxes of all logs.
    pub(in crate::app) fn rename_class(&mut self, from: &str, to: &str) {
        let review = self.logs.shown.settings.review.renamed(from, to);
        if let Err(why) = review.check() {
            return self.notices.warn(why.to_owned());
        }
        let before = self.step_now();
        for log in self.logs.all_mut() {
            if let Some(after) = log.reviewing.review.with_class_renamed(from, to) {
                log.reviewing.set(Arc::new(after));
            }
        }
        // The change of the list belongs to the same undo step.
        self.record_step(&before, "name of class", true);
        let settings = Settings { review, ..Settings::clone(&self.logs.shown.settings) };
        self.change(settings, "name of class", false);
    }
}

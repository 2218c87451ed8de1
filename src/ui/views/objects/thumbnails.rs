//! The pictures of rows: made in the background for the rows in sight, and kept while they are of
//! use.

use super::super::chip::{BoxChip, ChipKey};
use crate::app::{App, LogBox, Object};
use bathyscope_products::pipeline::Background;
use std::collections::HashMap;

/// Pictures that are kept; beyond, those out of sight are made again when they come back.
const MOST: usize = 600;

/// A box to draw, and what its picture is made of.
type WantedThumbnail = (LogBox, ChipKey);

#[derive(Default)]
pub(super) struct Thumbnails {
    known: HashMap<LogBox, (ChipKey, BoxChip)>,
    making: Background<Vec<WantedThumbnail>, Vec<(WantedThumbnail, BoxChip)>>,
}

impl Thumbnails {
    /// Returns true if pictures are being made.
    pub(super) fn is_running(&self) -> bool {
        self.making.is_running()
    }

    /// The picture of a box, as it was made last.
    pub(super) fn of(&self, id: LogBox) -> Option<&BoxChip> {
        self.known.get(&id).map(|(_, chip)| chip)
    }

    /// Has the pictures made that the objects in sight lack.
    pub(super) fn ask<'a>(
        &mut self,
        app: &App,
        ctx: &egui::Context,
        in_sight: impl Iterator<Item = &'a Object>,
    ) {
        let wanted = |object: &Object| -> Option<WantedThumbnail> {
            let id = app.best_box(object)?;
            let mark = &app.log_box(id)?.mark;
            let key = ChipKey::of(app.open_log(id.log)?, mark, &app.view.options.waterfall)?;
            Some((id, key))
        };
        let wanted: Vec<WantedThumbnail> = in_sight.filter_map(wanted).collect();
        if self.known.len() > MOST {
            let is_wanted = |id: &LogBox| wanted.iter().any(|(other, _)| other == id);
            self.known.retain(|id, _| is_wanted(id));
        }
        let is_missing =
            |(id, key): &WantedThumbnail| self.known.get(id).is_none_or(|(of, _)| of != key);
        let missing: Vec<WantedThumbnail> = wanted.into_iter().filter(is_missing).collect();
        if missing.is_empty() {
            return;
        }
        let (of, ctx) = (missing.clone(), ctx.clone());
        self.making.ask(missing, app.jobs(), move |progress| {
            let mut made = Vec::with_capacity(of.len());
            for wanted in of {
                progress.check().ok()?;
                made.extend(BoxChip::new(&wanted.1, &ctx).map(|chip| (wanted, chip)));
            }
            Some(made)
        });
        for ((id, key), chip) in self.making.result().into_iter().flatten() {
            self.known.insert(*id, (key.clone(), chip.clone()));
        }
    }
}

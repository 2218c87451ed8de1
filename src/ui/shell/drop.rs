//! Opens logs, base maps, reference points and tables of other instruments that are dropped on the
//! window.

use crate::app::{Command, FileToOpen};
use bathyscope_log::formats::points::is_named_as_elevations;
use bathyscope_log::formats::{FileRole, role_by_name};
use egui::Ui;
use std::path::{Path, PathBuf};

/// Opens dropped files; logs are added to the open ones. Tables and points belong to a log: if none
/// is open, they are opened as logs, which some of them are.
pub(super) fn collect(ui: &Ui, has_log: bool, commands: &mut Vec<Command>) {
    let dropped: Vec<PathBuf> = ui.input(|input| {
        let files = input.raw.dropped_files.iter();
        files.map(|file| file.path().to_owned()).collect()
    });
    // A table with the name of a dropped picture is part of the log of that picture.
    let is_of_picture = |table: &PathBuf| {
        let is_its = |path: &PathBuf| {
            role_by_name(path) == Some(FileRole::Paired)
                && path.with_extension("") == table.with_extension("")
        };
        is_named(table, &["csv"]) && dropped.iter().any(is_its)
    };
    let dropped: Vec<PathBuf> =
        (dropped.iter()).filter(|path| !is_of_picture(path)).cloned().collect();
    let (maps, others): (Vec<_>, Vec<_>) =
        dropped.into_iter().partition(|path| is_named(path, &["tif", "tiff"]));
    let (tables, logs): (Vec<_>, Vec<_>) =
        others.into_iter().partition(|path| has_log && is_named(path, &["csv", "gpx"]));
    if let Some(map) = maps.into_iter().next_back() {
        commands.push(Command::OpenFile(FileToOpen::BaseMap(map)));
    }
    if let Some(table) = tables.into_iter().next_back() {
        commands.push(Command::OpenFile(FileToOpen::Table(table)));
    }
    let named = |path: &PathBuf| has_log && is_named_as_elevations(path);
    let (points, logs): (Vec<_>, Vec<_>) = logs.into_iter().partition(named);
    if let Some(points) = points.into_iter().next_back() {
        commands.push(Command::CompareWith(points));
    }
    if !logs.is_empty() {
        commands.push(if has_log { Command::Add(logs) } else { Command::OpenAll(logs) });
    }
}

/// Returns true if the name of a file has one of these endings.
fn is_named(path: &Path, endings: &[&str]) -> bool {
    let extension = path.extension().unwrap_or_default();
    endings.iter().any(|ending| extension.eq_ignore_ascii_case(ending))
}

/// Describes the effect of a drop while files are dragged over the window.
pub(super) fn overlay(ui: &Ui) {
    let Some(name) = ui.input(|input| {
        let file = input.raw.hovered_files.first()?;
        let path = file.path.as_ref()?;
        Some(path.file_name()?.to_string_lossy().into_owned())
    }) else {
        return;
    };
    let layer = egui::LayerId::new(egui::Order::Foreground, egui::Id::unique("drop"));
    let painter = ui.ctx().layer_painter(layer);
    let rect = ui.ctx().content_rect();
    painter.rect_filled(rect, 0.0, egui::Color32::from_black_alpha(160));
    painter.text(
        rect.center(),
        egui::Align2::CENTER_CENTER,
        format!("Drop to open {name}"),
        egui::FontId::proportional(22.0),
        egui::Color32::WHITE,
    );
}

//! Turns keys of the command table into commands, and opens logs, base maps, reference points and
//! tables of other instruments that are dropped on the window.

use crate::app::{Action, App, Command, FileToOpen, KeyFocus, Keys, Nudge, Tool, View, is_bare};
use bathyscope_log::formats::points::is_named_as_elevations;
use bathyscope_log::formats::{FileRole, role_by_name};
use bathyscope_objects::review::Edit;
use egui::{Event, FocusDirection, Key, KeyboardShortcut, Modifiers, Ui};
use std::path::{Path, PathBuf};
use std::sync::LazyLock;

/// A key of the command table, and its action.
struct Bound {
    /// Key in the notation of the table.
    keys: Keys,
    shortcut: KeyboardShortcut,
    action: Action,
}

/// All keys, those with most modifiers first: `Z` with Ctrl would otherwise also match `Z` with
/// Ctrl and Shift.
static BOUND: LazyLock<Vec<Bound>> = LazyLock::new(|| {
    let of = |action: Action| {
        let bound = move |keys| Some(Bound { keys, shortcut: parse(keys)?, action });
        action.all_keys().filter_map(bound)
    };
    let mut bound: Vec<_> = Action::ALL.iter().copied().flat_map(of).collect();
    bound.sort_by_key(|binding| {
        let held = binding.shortcut.modifiers;
        let held = [held.command, held.shift, held.alt];
        std::cmp::Reverse(held.iter().filter(|on| **on).count())
    });
    bound
});

/// Parses a key of the table as a shortcut: `Ctrl+Shift+Z`, `[`, `F11`, `+`.
fn parse(keys: &str) -> Option<KeyboardShortcut> {
    let (held, key) = match keys.rfind('+') {
        Some(last) if last > 0 && last + 1 < keys.len() => keys.split_at(last + 1),
        _ => ("", keys),
    };
    let mut modifiers = Modifiers::NONE;
    for name in held.split('+').filter(|name| !name.is_empty()) {
        modifiers = match name {
            "Ctrl" => modifiers | Modifiers::COMMAND,
            "Shift" => modifiers | Modifiers::SHIFT,
            "Alt" => modifiers | Modifiers::ALT,
            _ => return None,
        };
    }
    Some(KeyboardShortcut::new(modifiers, Key::from_name(key)?))
}

/// Returns true if a held key acts repeatedly: an arrow, or the key of an action that repeats.
fn may_repeat(key: Key, held: Modifiers) -> bool {
    let arrows = [Key::ArrowLeft, Key::ArrowRight, Key::ArrowUp, Key::ArrowDown];
    let is_of = |binding: &Bound| {
        binding.shortcut.logical_key == key
            && held.matches_logically(binding.shortcut.modifiers)
            && binding.action.repeats()
    };
    arrows.contains(&key) || BOUND.iter().any(is_of)
}

/// Removes repeated presses of a held key if its action acts once a press. This includes a focused
/// button, which Space and Enter press.
fn drop_repeats(ui: &Ui) {
    take_presses(ui, |key, held, repeat| repeat && !may_repeat(key, held));
}

/// Pushes a command for each pressed key of the table, after those for the keys of the selected
/// box. A bare key counts only if it has a meaning for `focus`, the part of the window with the
/// keyboard; `None` while a field, a dialog or a list has the keyboard.
pub(super) fn collect_keys(
    ui: &mut Ui,
    app: &App,
    focus: Option<KeyFocus>,
    commands: &mut Vec<Command>,
) {
    if asks_for_palette(ui) {
        // Text that is typed after this key in the same frame, on a busy machine, belongs to the
        // field of the palette.
        return commands.push(Command::Do(Action::Palette));
    }
    let typing = ui.text_edit_focused();
    // A focused slider or button uses the arrows and Space itself.
    let control_focused = ui.memory(|memory| memory.focused().is_some());
    if !typing {
        drop_repeats(ui);
    }
    if let Some(focus) = focus {
        let mut by_key = |keys: Keys, command: Command| {
            let command = Box::new(command);
            commands.push(Command::ByKey { keys, command, focus });
        };
        name_box(ui, app, &mut by_key);
        if focus == KeyFocus::View(View::Waterfall) {
            move_box(ui, app, &mut by_key);
            move_bottom(ui, app, &mut by_key);
        }
    }
    for Bound { keys, shortcut, action } in BOUND.iter() {
        // A text field uses the keys of these actions itself, to undo typing.
        if typing && matches!(action, Action::Undo | Action::Redo) {
            continue;
        }
        let is_bare = is_bare(keys);
        let focus = focus.filter(|focus| {
            let scope = action.key_scope();
            scope.is_some_and(|scope| scope.holds(*focus))
                && !(control_focused && is_control_key(shortcut))
        });
        if is_bare && focus.is_none() || !has_meaning(app, *action, control_focused) {
            continue;
        }
        let presses = consume(ui, shortcut);
        for _ in 0..presses {
            let command = Command::Do(*action);
            commands.push(match focus.filter(|_| is_bare) {
                Some(focus) => Command::ByKey { keys, command: Box::new(command), focus },
                None => command,
            });
        }
        if presses > 0 && shortcut.logical_key == Key::Tab {
            // egui also handles the key, and would move to the next control.
            ui.memory_mut(|memory| memory.move_focus(FocusDirection::None));
        }
    }
    if !control_focused && focus.is_some() && leaves_full_screen(ui) {
        commands.push(Command::Do(Action::FullScreen));
    }
}

/// Counts and removes the presses of a key since the last frame; there can be several if frames are
/// slow. A letter with Shift is another key than the letter alone: one of them must not act for the
/// other. Whether a sign needs Shift depends on the keyboard.
fn consume(ui: &Ui, shortcut: &KeyboardShortcut) -> usize {
    let name = shortcut.logical_key.name();
    let is_letter =
        name.len() == 1 && name.starts_with(|letter: char| letter.is_ascii_alphabetic());
    if !is_letter {
        return ui.input_mut(|input| {
            input.count_and_consume_key(shortcut.modifiers, shortcut.logical_key)
        });
    }
    take_presses(ui, |key, held, _| {
        key == shortcut.logical_key
            && held.shift == shortcut.modifiers.shift
            && held.matches_logically(shortcut.modifiers)
    })
}

/// Removes the presses for which `is_it` is true, given the key, the modifiers, and whether the
/// press is a repetition; returns their number.
fn take_presses(ui: &Ui, is_it: impl Fn(Key, Modifiers, bool) -> bool) -> usize {
    let is_it = |event: &Event| match *event {
        Event::Key { key, pressed: true, modifiers, repeat, .. } => is_it(key, modifiers, repeat),
        _ => false,
    };
    ui.input_mut(|input| {
        let before = input.events.len();
        input.events.retain(|event| !is_it(event));
        before - input.events.len()
    })
}

/// Returns true if Escape, which no tool, field or menu uses now, ends full screen.
fn leaves_full_screen(ui: &Ui) -> bool {
    let is_full = ui.input(|input| input.viewport().fullscreen == Some(true));
    is_full && ui.input_mut(|input| input.consume_key(Modifiers::NONE, Key::Escape))
}

/// Returns true if the key of the palette was pressed without other modifiers: keys with more
/// modifiers use its letter, too.
fn asks_for_palette(ui: &Ui) -> bool {
    let shortcuts: Vec<_> = Action::Palette.all_keys().filter_map(parse).collect();
    let presses = take_presses(ui, |key, held, _| {
        let is_it = |shortcut: &KeyboardShortcut| {
            key == shortcut.logical_key && held.matches_exact(shortcut.modifiers)
        };
        shortcuts.iter().any(is_it)
    });
    presses > 0
}

/// Returns true if a key that is also used otherwise acts as a command now: Tab steps through the
/// controls while there are no boxes, or while a control has the keyboard.
fn has_meaning(app: &App, action: Action, control_focused: bool) -> bool {
    let reviewing = &app.logs.shown.reviewing;
    match action {
        Action::NextBox | Action::PreviousBox => app.logs.has_boxes() && !control_focused,
        Action::LeaveTool => {
            let drawn = app.map.measuring.tool.is_some() || app.map.measuring.figure.is_some();
            let is_in_use = reviewing.is_in_use() || app.logs.shown.proposed_stretch().is_some();
            is_in_use || drawn || app.view.selection.is_some()
        }
        Action::SetCorner | Action::EndFigure => app.map.measuring.tool.is_some(),
        Action::TakeCornerBack => {
            app.map.measuring.tool.is_some() && app.map.measuring.figure.is_some()
        }
        // With a tool for corners or targets the arrows move its cross.
        Action::PreviousPing | Action::NextPing | Action::Back25 | Action::Forward25 => {
            app.map.measuring.tool.is_none() && reviewing.tool != Tool::Point
        }
        _ => true,
    }
}

const DIGITS: [Key; 9] = [
    Key::Num1,
    Key::Num2,
    Key::Num3,
    Key::Num4,
    Key::Num5,
    Key::Num6,
    Key::Num7,
    Key::Num8,
    Key::Num9,
];

/// Makes the digits choose the class of the selected box, instead of a view.
fn name_box(ui: &mut Ui, app: &App, push: &mut impl FnMut(Keys, Command)) {
    let Some(id) = app.logs.shown.reviewing.selected else {
        return;
    };
    let classes = app.logs.class_names();
    for (class, key) in DIGITS.into_iter().enumerate() {
        // With Alt the digits open the steps of the work.
        let opens_step = ui.input(|input| input.modifiers.alt);
        let pressed = !opens_step && ui.input_mut(|input| input.consume_key(Modifiers::NONE, key));
        if let Some(name) = classes.get(class).filter(|_| pressed) {
            let edit = Edit::Classify(id, (*name).to_owned());
            push(key.name(), Command::Edit { edit, live: false });
        }
    }
}

/// Makes the arrows move the edited box, instead of the selected ping.
fn move_box(ui: &mut Ui, app: &App, push: &mut impl FnMut(Keys, Command)) {
    if app.logs.shown.reviewing.tool != Tool::Edit || app.logs.shown.reviewing.selected.is_none() {
        return;
    }
    let arrows = [
        (Key::ArrowLeft, -1, 0),
        (Key::ArrowRight, 1, 0),
        (Key::ArrowUp, 0, -1),
        (Key::ArrowDown, 0, 1),
    ];
    // The most modifiers come first: a plain arrow would match with Shift held, too.
    let held = [
        (Modifiers::COMMAND | Modifiers::SHIFT, 10, true),
        (Modifiers::COMMAND, 1, true),
        (Modifiers::SHIFT, 10, false),
        (Modifiers::NONE, 1, false),
    ];
    for (key, right, down) in arrows {
        for (modifiers, steps, resize) in held {
            if consume_arrow(ui, modifiers, key) {
                let nudge = Nudge { right: right * steps, down: down * steps, resize };
                push(key.name(), Command::Nudge(nudge));
            }
        }
    }
}

/// Makes Up and Down draw the bottom shallower and deeper at the selected ping.
fn move_bottom(ui: &mut Ui, app: &App, push: &mut impl FnMut(Keys, Command)) {
    if app.logs.shown.reviewing.tool != Tool::Bottom {
        return;
    }
    for (key, outward) in [(Key::ArrowUp, -1), (Key::ArrowDown, 1)] {
        for (modifiers, samples) in [(Modifiers::SHIFT, 10), (Modifiers::NONE, 1)] {
            if consume_arrow(ui, modifiers, key) {
                push(key.name(), Command::NudgeBottom(outward * samples));
            }
        }
    }
}

/// Removes a press of an arrow key; returns true if there was one.
fn consume_arrow(ui: &Ui, modifiers: Modifiers, key: Key) -> bool {
    let is_pressed = ui.input_mut(|input| input.consume_key(modifiers, key));
    if is_pressed {
        // egui also handles the key, and would move to a control.
        ui.memory_mut(|memory| memory.move_focus(FocusDirection::None));
    }
    is_pressed
}

fn is_control_key(shortcut: &KeyboardShortcut) -> bool {
    matches!(
        shortcut.logical_key,
        Key::ArrowLeft | Key::ArrowRight | Key::Home | Key::End | Key::Space | Key::Enter
    )
}

/// Opens dropped files; logs are added to the open ones. Tables and points belong to a log: if none
/// is open, they are opened as logs, which some of them are.
pub(super) fn collect_dropped(ui: &Ui, has_log: bool, commands: &mut Vec<Command>) {
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
pub(super) fn drop_overlay(ui: &Ui) {
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_key_of_the_table_is_understood() {
        for action in Action::ALL {
            for keys in action.all_keys() {
                assert!(parse(keys).is_some(), "{keys} of {}", action.label());
            }
        }
        assert_eq!(
            parse("Ctrl+Shift+Z"),
            Some(KeyboardShortcut::new(Modifiers::COMMAND | Modifiers::SHIFT, Key::Z))
        );
        assert_eq!(parse("+").map(|keys| keys.logical_key), Some(Key::Plus));
        assert_eq!(parse("Hyper+Q"), None);
    }

    #[test]
    fn no_two_actions_share_a_shortcut() {
        let mut seen = std::collections::HashMap::new();
        for binding in BOUND.iter() {
            let (label, keys) = (binding.action.label(), binding.keys);
            let other = seen.insert(binding.shortcut, label);
            assert_eq!(other, None, "{keys} is {label} too");
        }
    }

    #[test]
    fn a_held_key_steps_on_but_decides_once() {
        assert!(may_repeat(Key::ArrowRight, Modifiers::SHIFT));
        assert!(may_repeat(Key::CloseBracket, Modifiers::NONE));
        assert!(may_repeat(Key::Z, Modifiers::COMMAND));
        for key in [Key::A, Key::R, Key::U, Key::Delete, Key::Num1, Key::Space, Key::Enter] {
            assert!(!may_repeat(key, Modifiers::NONE), "{key:?}");
        }
    }

    #[test]
    fn more_modifiers_come_first() {
        let place =
            |requested: Action| BOUND.iter().position(|binding| binding.action == requested);
        assert!(place(Action::Redo) < place(Action::Undo));
        assert!(place(Action::Forward25) < place(Action::NextPing));
    }
}

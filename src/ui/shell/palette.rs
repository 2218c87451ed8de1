//! Draws the command palette: a few letters of a name find any command, any setting of the panels,
//! or a recent log.

use crate::app::{Action, Command};
use crate::ui::panels::find_setting::{self, ControlPlace};
use crate::ui::{ViewContext, take_typed};
use bathyscope_products::pipeline::settings::SettingRow;
use egui::text::{CCursor, CCursorRange};
use egui::{Key, Modal, RichText, ScrollArea, TextEdit, Ui};

/// The command palette; closed at the start.
#[derive(Default)]
pub(super) struct CommandPalette {
    open: bool,
    query: String,
    chosen: usize,
    /// True if its field has the keyboard; before that, the palette reads the typed text itself.
    has_keyboard: bool,
}

/// Entry of the palette: a command to run, or a setting to go to.
struct Item {
    label: String,
    /// Another name by which the entry is found.
    alias: &'static str,
    /// Key of the command, or value of the setting.
    aside: String,
    hint: String,
    command: Command,
}

impl CommandPalette {
    /// Shows the palette with an empty field.
    pub(super) fn open(&mut self) {
        *self = Self { open: true, ..Self::default() };
    }

    /// Returns true if the palette is shown.
    pub(super) fn is_open(&self) -> bool {
        self.open
    }

    /// Draws the palette while it is open.
    pub(super) fn ui(&mut self, ctx: &egui::Context, context: &mut ViewContext<'_>) {
        if !self.open {
            return;
        }
        let id = egui::Id::unique("command palette");
        let top = (0.06 * ctx.content_rect().height()).min(60.0);
        let area = Modal::default_area(id).anchor(egui::Align2::CENTER_TOP, [0.0, top]);
        let modal = Modal::new(id).area(area).show(ctx, |ui| {
            ui.set_width((ctx.content_rect().width() - 40.0).min(520.0));
            self.contents(ui, context)
        });
        if modal.inner || modal.should_close() {
            self.open = false;
        }
    }

    /// Draws the field and the list; returns true if an entry was chosen.
    fn contents(&mut self, ui: &mut Ui, context: &mut ViewContext<'_>) -> bool {
        let down = ui.input_mut(|input| input.consume_key(Default::default(), Key::ArrowDown));
        let up = ui.input_mut(|input| input.consume_key(Default::default(), Key::ArrowUp));
        let enter = ui.input(|input| input.key_pressed(Key::Enter));
        let id = egui::Id::unique("field of the command palette");
        if !self.has_keyboard {
            // The field reads no text in the frame in which it appears.
            self.query += &take_typed(ui);
            // The focus is requested before the field is drawn, so that the field has it in this
            // frame.
            ui.memory_mut(|memory| memory.request_focus(id));
        }
        let mut field = TextEdit::singleline(&mut self.query)
            .id(id)
            .hint_text("Command or setting")
            .desired_width(f32::INFINITY)
            .show(ui);
        if !self.has_keyboard {
            let end = CCursor::new(self.query.chars().count());
            let cursor = &mut field.state.cursor;
            cursor.set_char_range(Some(CCursorRange::one(end)));
            field.state.store(ui.ctx(), id);
        }
        let field = field.response.response.accessible_name("Command");
        self.has_keyboard |= field.has_focus();
        field.request_focus();
        if field.changed() {
            self.chosen = 0;
        }
        let found = search(items(context), &self.query);
        let last = found.len().saturating_sub(1);
        self.chosen = (self.chosen + usize::from(down)).saturating_sub(usize::from(up)).min(last);
        ui.add_space(4.0);
        if found.is_empty() {
            ui.label(RichText::new("No command or setting has these letters.").weak());
        }
        let mut run = None;
        let height = (ui.content_rect().height() - 140.0).clamp(80.0, 360.0);
        ScrollArea::vertical().max_height(height).show(ui, |ui| {
            for (index, item) in found.into_iter().enumerate() {
                let chosen = index == self.chosen;
                if line(ui, &item, chosen, down || up) || (chosen && enter) {
                    run = Some(item.command);
                }
            }
        });
        let ran = run.is_some();
        if let Some(command) = run {
            context.push(command);
        }
        ran
    }
}

fn line(ui: &mut Ui, item: &Item, chosen: bool, moved: bool) -> bool {
    let button = egui::Button::selectable(chosen, item.label.as_str())
        .shortcut_text(item.aside.as_str())
        .min_size(egui::vec2(ui.available_width(), 22.0));
    let response = ui.add(button);
    if chosen && moved {
        response.scroll_to_me(None);
    }
    response.on_hover_text(&item.hint).clicked()
}

fn items(context: &ViewContext<'_>) -> Vec<Item> {
    let actions = Action::ALL.iter();
    let actions = actions.filter(|action| context.app.is_available(**action));
    let actions = actions.map(|&action| Item {
        label: action.label().to_owned(),
        alias: "",
        aside: action.key().to_owned(),
        hint: action.hint().to_owned(),
        command: Command::Do(action),
    });
    let recent = context.app.recent.iter().map(|path| Item {
        label: format!("Open {}", path.display()),
        alias: "",
        aside: String::new(),
        hint: "Opens this log again.".to_owned(),
        command: Command::Open(path.clone()),
    });
    actions.chain(settings(context)).chain(recent).collect()
}

/// Returns the settings that have a control, with their values; none while no log is open, because
/// no panel has controls then.
fn settings(context: &ViewContext<'_>) -> Vec<Item> {
    let app = context.app;
    if app.logs.shown.survey.is_none() {
        return Vec::new();
    }
    let units = app.view.options.units;
    let item = |place: ControlPlace, row: &'static SettingRow| Item {
        label: format!("{}: {}", place.name(), row.name),
        alias: row.label,
        aside: row.value_in_words(&app.logs.shown.settings, units),
        hint: format!("{} Goes to its control.", units.sentence(row.hint)),
        command: Command::ShowSetting(row.key),
    };
    let places = find_setting::CONTROLS.iter();
    let all = places.flat_map(|(place, rows)| rows.iter().map(|row| item(*place, row)));
    all.collect()
}

/// Returns the items whose labels contain the letters of the query in order, best first; without a
/// query, all items in the order of the table.
fn search(items: Vec<Item>, query: &str) -> Vec<Item> {
    if query.trim().is_empty() {
        return items;
    }
    let mut found: Vec<(i32, Item)> = items
        .into_iter()
        .filter_map(|item| {
            let scores = [score(&item.label, query), score(item.alias, query)];
            Some((scores.into_iter().flatten().max()?, item))
        })
        .collect();
    found.sort_by_key(|(score, _)| std::cmp::Reverse(*score));
    found.into_iter().map(|(_, item)| item).collect()
}

/// Returns the score of the letters of `query` in `label`, in order: letters that start a word or
/// follow each other count more, and most if the label begins with all of them. `None` if the label
/// does not contain them.
fn score(label: &str, query: &str) -> Option<i32> {
    let label = label.to_lowercase();
    let letters: Vec<char> = label.chars().collect();
    let requested = query.trim().to_lowercase();
    if label.starts_with(&requested) {
        return Some(900 * requested.chars().count() as i32 - letters.len() as i32);
    }
    let mut total = 0;
    let mut from = 0;
    let mut last = None;
    for letter in requested.chars().filter(|letter| !letter.is_whitespace()) {
        let follows = last.map(|last: usize| last + 1);
        let starts_word = |at: usize| at == 0 || !letters[at - 1].is_alphanumeric();
        let places = || (from..letters.len()).filter(|&at| letters[at] == letter);
        let at = places()
            .find(|&at| Some(at) == follows)
            .or_else(|| places().find(|&at| starts_word(at)))
            .or_else(|| places().next())?;
        total += if Some(at) == follows {
            5
        } else if starts_word(at) {
            8
        } else {
            1
        };
        from = at + 1;
        last = Some(at);
    }
    Some(total * 100 - letters.len() as i32)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::app::{App, Jobs};
    use crate::ui::Shell;
    use egui::Event;
    use egui_kittest::Harness;

    /// Settings whose controls are drawn only if another setting differs from its value in a new
    /// survey.
    const DEPEND: [&str; 10] = [
        "calibration.ppd",
        "cloud.alpha2_deg",
        "excluded.min_duration_s",
        "picture.black",
        "picture.white",
        "source.crs",
        "sound_speed.recorder_m_s",
        "sound_speed.salinity_psu",
        "sound_speed.temperature_c",
        "track.offset_s",
    ];

    fn demo_window() -> Harness<'static, Shell> {
        let mut window = Harness::builder()
            .with_size([1400.0, 900.0])
            .with_max_steps(32)
            .build_eframe(|_| Shell::new(App::new(Jobs::Inline)));
        window.state_mut().app.apply(Command::OpenDemo);
        window.run();
        window
    }

    fn press(window: &mut Harness<'static, Shell>, held: egui::Modifiers, key: Key) {
        window.key_press_modifiers(held, key);
        window.run();
    }

    #[test]
    fn every_setting_of_the_panels_is_gone_to_and_gets_the_keyboard() {
        let mut window = demo_window();
        let ctx = window.ctx.clone();
        for row in find_setting::CONTROLS.iter().flat_map(|(_, rows)| *rows) {
            window.state_mut().app.notices.clear();
            window.state_mut().carry_out(&ctx, Command::ShowSetting(row.key));
            window.run();
            let notices = &window.state().app.notices.shown();
            let said = notices.last().map(|notice| notice.text.clone());
            if DEPEND.contains(&row.key) {
                let said = said.expect(row.key);
                assert!(said.contains("has no control now"), "{}: {said}", row.key);
                continue;
            }
            assert_eq!(said, None, "{}", row.key);
            assert_eq!(find_setting::marked(&ctx).as_deref(), Some(row.key));
            let focused = ctx.memory(|memory| memory.focused()).expect(row.key);
            let control = ctx.read_response(focused).expect(row.key);
            let screen = ctx.content_rect();
            assert!(screen.contains_rect(control.rect), "{}: {control:?}", row.key);
            press(&mut window, egui::Modifiers::NONE, Key::Escape);
        }
    }

    #[test]
    fn a_few_letters_lead_to_a_setting_and_its_value_is_changed_by_keys() {
        let mut window = demo_window();
        for (typed, key) in [
            ("scale", "calibration.mode"),
            ("draft", "draft_m"),
            ("mosaic", "mosaic.gain"),
            ("threshold", "first_return.threshold"),
        ] {
            press(&mut window, egui::Modifiers::COMMAND, Key::P);
            window.event(Event::Text(typed.to_owned()));
            window.run();
            let mut found = search(
                items(&ViewContext {
                    app: &window.state().app,
                    render_state: None,
                    target: crate::app::View::Waterfall,
                    commands: &mut Vec::new(),
                }),
                typed,
            );
            let leads = |item: &Item| item.command == Command::ShowSetting(key);
            found.truncate(8);
            assert!(found.iter().any(leads), "{typed}");
            if leads(&found[0]) {
                press(&mut window, egui::Modifiers::NONE, Key::Enter);
                let marked = find_setting::marked(&window.ctx);
                assert_eq!(marked.as_deref(), Some(key));
            }
            press(&mut window, egui::Modifiers::NONE, Key::Escape);
        }
        let ctx = window.ctx.clone();
        let before = window.state().app.logs.shown.settings.calibration.offset;
        let show = Command::ShowSetting("calibration.offset");
        window.state_mut().carry_out(&ctx, show);
        window.run();
        for key in [Key::ArrowDown, Key::ArrowDown, Key::Enter] {
            press(&mut window, egui::Modifiers::NONE, key);
        }
        let after = window.state().app.logs.shown.settings.calibration.offset;
        assert_ne!(before, after);
    }

    #[test]
    fn a_setting_that_is_gone_to_takes_the_digits_that_are_typed() {
        let mut window = demo_window();
        let ctx = window.ctx.clone();
        // A slider with its number, and a number alone.
        for key in ["draft_m", "water_level_m"] {
            window.state_mut().carry_out(&ctx, Command::ShowSetting(key));
            window.run();
            press(&mut window, egui::Modifiers::COMMAND, Key::A);
            window.event(Event::Text("0,45".to_owned()));
            press(&mut window, egui::Modifiers::NONE, Key::Enter);
        }
        let settings = &window.state().app.logs.shown.settings;
        assert_eq!([settings.draft_m, settings.water_level_m], [0.45, 0.45]);
    }

    fn best(query: &str) -> &'static str {
        let scored = Action::ALL
            .iter()
            .filter_map(|action| Some((score(action.label(), query)?, action.label())));
        scored.max_by_key(|(score, _)| *score).unwrap().1
    }

    #[test]
    fn every_command_is_found_first_by_its_own_name() {
        for action in Action::ALL {
            assert_eq!(best(action.label()), action.label());
        }
    }

    #[test]
    fn letters_in_order_find_a_command() {
        assert_eq!(best("outl"), "Outlier preview");
        assert_eq!(best("preset pub"), "Preset: published");
        assert_eq!(best("lcl"), "Layout: 3D cloud only");
        assert_eq!(best("redo"), "Redo", "not Recorded depth on or off");
        assert_eq!(score("Undo", "xyz"), None);
        assert!(score("Undo", "").is_some());
    }
}

//! Draws the manual: a list of pages, the chosen page, and a search of all of them.

use crate::app::manual::{PageBlock, Span, Topic, blocks, sections};
use crate::ui::theme;
use egui::text::LayoutJob;
use egui::{
    Align, Color32, FontId, Grid, Label, Layout, RichText, ScrollArea, TextEdit, TextFormat, Ui,
    Window,
};

const SIZE: [f32; 2] = [900.0, 620.0];
const LIST_WIDTH: f32 = 210.0;
const TEXT_SIZE: f32 = 13.0;
const CODE_SIZE: f32 = 12.0;
/// Width of each column of a table, points; the last column gets the remaining width.
const COLUMN_WIDTH: f32 = 210.0;

/// The window of the manual; closed at the start.
pub(super) struct Manual {
    /// True if the manual is shown.
    pub open: bool,
    topic: Topic,
    query: String,
    /// The pages, read when the manual is first opened.
    pages: Vec<(Topic, Vec<PageBlock>)>,
}

impl Default for Manual {
    fn default() -> Self {
        Self { open: false, topic: Topic::Keys, query: String::new(), pages: Vec::new() }
    }
}

impl Manual {
    /// Draws the manual while it is open.
    pub(super) fn ui(&mut self, ctx: &egui::Context) {
        if self.open && ctx.input(|input| input.key_pressed(egui::Key::Escape)) {
            self.open = false;
        }
        if !self.open {
            return;
        }
        if self.pages.is_empty() {
            let pages = Topic::ALL.into_iter();
            self.pages = pages.map(|topic| (topic, blocks(&topic.text()))).collect();
        }
        let mut open = true;
        Window::new("Manual")
            .open(&mut open)
            .collapsible(false)
            .default_size(SIZE)
            .anchor(egui::Align2::CENTER_CENTER, [0.0, 0.0])
            .show(ctx, |ui| {
                ui.horizontal_top(|ui| {
                    ui.allocate_ui_with_layout(
                        egui::vec2(LIST_WIDTH, ui.available_height()),
                        Layout::top_down(Align::Min),
                        |ui| self.contents(ui),
                    );
                    ui.separator();
                    ui.vertical(|ui| self.page(ui));
                });
            });
        self.open = open;
    }

    /// Draws the search field and the list of pages.
    fn contents(&mut self, ui: &mut Ui) {
        ui.set_width(LIST_WIDTH);
        ui.label(concat!("Bathyscope ", env!("CARGO_PKG_VERSION")));
        let field =
            TextEdit::singleline(&mut self.query).hint_text("Search").desired_width(f32::INFINITY);
        ui.add(field).on_hover_text("Search the manual");
        ui.add_space(4.0);
        for topic in Topic::ALL {
            let is_shown = self.query.trim().is_empty() && topic == self.topic;
            if ui.selectable_label(is_shown, topic.title()).clicked() {
                self.topic = topic;
                self.query.clear();
            }
        }
    }

    /// Draws the chosen page, or the sections of all pages in which all words of the search occur.
    fn page(&self, ui: &mut Ui) {
        let words = words_of(&self.query);
        let area = ScrollArea::vertical().auto_shrink([false, false]);
        // Another page is shown from its top.
        let area = area.id_salt((self.topic, &self.query));
        area.show(ui, |ui| {
            if words.is_empty() {
                let chosen = self.pages.iter().filter(|(topic, _)| *topic == self.topic);
                chosen.for_each(|(_, page)| {
                    page.iter().for_each(|page_block| block(ui, page_block, &words))
                });
                return;
            }
            let mut found = 0;
            for (topic, page) in &self.pages {
                for section in sections(page) {
                    if matches(section, &words) {
                        found += 1;
                        let title = RichText::new(topic.title()).weak().size(theme::SMALL);
                        ui.label(title);
                        section.iter().for_each(|page_block| match page_block {
                            // Only the rows of a table that match are shown.
                            PageBlock::Table(rows) => {
                                table(ui, &matching_rows(rows, &words), &words)
                            }
                            other => block(ui, other, &words),
                        });
                        ui.separator();
                    }
                }
            }
            if found == 0 {
                ui.label("No section holds all of these words.");
            }
        });
    }
}

fn words_of(query: &str) -> Vec<String> {
    let query = query.to_lowercase();
    query.split_whitespace().map(str::to_owned).collect()
}

/// Returns true if every word occurs in a section.
fn matches(section: &[PageBlock], words: &[String]) -> bool {
    let text: Vec<String> = section.iter().map(PageBlock::plain).collect();
    let text = text.join(" ").to_lowercase();
    words.iter().all(|word| text.contains(word))
}

/// Returns the head of a table and the rows that contain every word; all rows if none does.
fn matching_rows(rows: &[Vec<Vec<Span>>], words: &[String]) -> Vec<Vec<Vec<Span>>> {
    let holds = |row: &&Vec<Vec<Span>>| {
        let row = PageBlock::Table(vec![(*row).clone()]);
        matches(std::slice::from_ref(&row), words)
    };
    let found: Vec<_> = rows.iter().skip(1).filter(holds).cloned().collect();
    if found.is_empty() {
        rows.to_vec()
    } else {
        rows.iter().take(1).cloned().chain(found).collect()
    }
}

fn block(ui: &mut Ui, block: &PageBlock, words: &[String]) {
    match block {
        PageBlock::Heading(level, text) => {
            ui.add_space(if *level == 1 { 0.0 } else { 6.0 });
            let size = if *level == 1 { 19.0 } else { 15.0 };
            ui.label(RichText::new(text).size(size).strong());
        }
        PageBlock::Paragraph(spans) => {
            ui.add(Label::new(job(ui, spans, words)).wrap());
            ui.add_space(4.0);
        }
        PageBlock::Item(spans) => {
            ui.horizontal_top(|ui| {
                ui.label("•");
                ui.add(Label::new(job(ui, spans, words)).wrap());
            });
        }
        PageBlock::Code(text) => {
            egui::Frame::new()
                .fill(ui.visuals().extreme_bg_color)
                .inner_margin(egui::Margin::symmetric(6, 4))
                .show(ui, |ui| {
                    let text = RichText::new(text).font(FontId::monospace(CODE_SIZE));
                    ScrollArea::horizontal().show(ui, |ui| ui.add(Label::new(text).extend()));
                });
            ui.add_space(4.0);
        }
        PageBlock::Table(rows) => table(ui, rows, words),
    }
}

fn table(ui: &mut Ui, rows: &[Vec<Vec<Span>>], words: &[String]) {
    let columns = rows.first().map_or(0, Vec::len);
    let free = ui.available_width() - COLUMN_WIDTH * columns.saturating_sub(1) as f32 - 40.0;
    Grid::new(ui.next_auto_id()).num_columns(columns).striped(true).spacing([14.0, 3.0]).show(
        ui,
        |ui| {
            for (index, row) in rows.iter().enumerate() {
                for (column, cell) in row.iter().enumerate() {
                    let is_last = column + 1 == columns;
                    let width = if is_last { free.max(COLUMN_WIDTH) } else { COLUMN_WIDTH };
                    let mut text = job(ui, cell, words);
                    text.wrap.max_width = width;
                    if index == 0 {
                        let strong = ui.visuals().strong_text_color();
                        for section in &mut text.sections {
                            section.format.color = strong;
                        }
                    }
                    // The text is laid out here, because a grid would not wrap it.
                    let text = ui.painter().layout_job(text);
                    ui.add(Label::new(text));
                }
                ui.end_row();
            }
        },
    );
    ui.add_space(6.0);
}

/// Lays out spans as one text: code in a fixed width, the words of the search on a coloured
/// background.
fn job(ui: &Ui, spans: &[Span], words: &[String]) -> LayoutJob {
    let mut job = LayoutJob::default();
    let (ink, mark) = (ui.visuals().text_color(), ui.visuals().selection.bg_fill);
    for span in spans {
        let font = if span.is_code {
            FontId::monospace(CODE_SIZE)
        } else {
            FontId::proportional(TEXT_SIZE)
        };
        for (piece, is_sought) in pieces(&span.text, words) {
            let background = if is_sought { mark } else { Color32::TRANSPARENT };
            let format = TextFormat {
                font_id: font.clone(),
                color: ink,
                background,
                ..TextFormat::default()
            };
            job.append(piece, 0.0, format);
        }
    }
    job
}

/// Cuts a text before and after each word of the search; true marks these words.
fn pieces<'a>(text: &'a str, words: &[String]) -> Vec<(&'a str, bool)> {
    let lower = text.to_lowercase();
    let mut found = Vec::new();
    let mut rest = 0;
    // Lower case has other lengths in some scripts: such a text is shown without marks.
    while lower.len() == text.len() {
        let next = words
            .iter()
            .filter_map(|word| Some((rest + lower[rest..].find(word)?, word.len())))
            .min();
        let Some((at, length)) = next else {
            break;
        };
        let parts = text.get(rest..at).zip(text.get(at..at + length));
        let Some((before, word)) = parts else {
            break;
        };
        found.push((before, false));
        found.push((word, true));
        rest = at + length;
    }
    found.push((&text[rest..], false));
    found.retain(|(piece, _)| !piece.is_empty());
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sought_words_are_marked() {
        let words = words_of("Depth MAP");
        assert_eq!(
            pieces("A depth map.", &words),
            [("A ", false), ("depth", true), (" ", false), ("map", true), (".", false)]
        );
        assert_eq!(pieces("none", &words), [("none", false)]);
        assert_eq!(pieces("36° depth", &words), [("36° ", false), ("depth", true)]);
    }

    #[test]
    fn a_section_matches_when_it_holds_every_word() {
        let page = blocks("# Isobaths\n\nLines of equal depth.\n");
        assert!(matches(&page, &words_of("depth iso")));
        assert!(!matches(&page, &words_of("depth mosaic")));
    }

    #[test]
    fn of_a_table_the_rows_that_match_are_left() {
        let page = blocks("| key | does |\n|---|---|\n| `A` | accepts |\n| `R` | rejects |\n");
        let [PageBlock::Table(rows)] = page.as_slice() else {
            panic!("a table");
        };
        assert_eq!(matching_rows(rows, &words_of("reject")).len(), 2);
        assert_eq!(matching_rows(rows, &words_of("key")).len(), 3);
    }
}

//! Contains the manual: pages of Markdown that are compiled in, with tables that are derived from
//! the program. `bathyscope manual` prints the pages, F1 shows them. Parses the part of Markdown
//! that they use: headings, paragraphs, lists, fenced code, tables, and code within text.

use super::action::{Action, KeyScope};
use bathyscope_objects::objects::OBJECT_COLUMNS;
use bathyscope_products::outputs::{OUTPUT_FILES, When};
use bathyscope_products::pipeline::settings;
use std::fmt::Write as _;

bathyscope_log::listed! {
    /// All pages, in the order of the manual.
    const ALL;

    /// A page of the manual.
    #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, clap::ValueEnum)]
    pub enum Topic {
        /// The desktop program and its panels
        Window,
        /// Gain, levels, ranges and channels of the waterfall
        Waterfall,
        /// Many logs in one survey
        Survey,
        /// An archive of many logs: one map of all of them, kept up to date in a folder
        #[value(alias = "lake")]
        Archive,
        /// The project file
        Project,
        /// Layers, coordinates, measuring, printing
        Map,
        /// First return, bottom edits, calibration, presets
        Bottom,
        /// Depth maps, corrections, residuals, comparison
        Depth,
        /// Planning of survey lines
        Plan,
        /// The side-scan mosaic
        Mosaic,
        /// Detector, review, a YOLO of your own
        Objects,
        /// The command line
        Commands,
        /// All settings
        Settings,
        /// All files that are written
        Files,
        /// Accuracy, speed and memory
        Accuracy,
        /// Limits of the program
        Limits,
        /// Mouse, keys and commands
        Keys,
    }
}

impl Topic {
    fn source(self) -> &'static str {
        match self {
            Topic::Window => include_str!("../../assets/manual/window.md"),
            Topic::Waterfall => include_str!("../../assets/manual/waterfall.md"),
            Topic::Survey => include_str!("../../assets/manual/survey.md"),
            Topic::Archive => include_str!("../../assets/manual/archive.md"),
            Topic::Project => include_str!("../../assets/manual/project.md"),
            Topic::Map => include_str!("../../assets/manual/map.md"),
            Topic::Bottom => include_str!("../../assets/manual/bottom.md"),
            Topic::Depth => include_str!("../../assets/manual/depth.md"),
            Topic::Plan => include_str!("../../assets/manual/plan.md"),
            Topic::Mosaic => include_str!("../../assets/manual/mosaic.md"),
            Topic::Objects => include_str!("../../assets/manual/objects.md"),
            Topic::Commands => include_str!("../../assets/manual/commands.md"),
            Topic::Settings => include_str!("../../assets/manual/settings.md"),
            Topic::Files => include_str!("../../assets/manual/files.md"),
            Topic::Accuracy => include_str!("../../assets/manual/accuracy.md"),
            Topic::Limits => include_str!("../../assets/manual/limits.md"),
            Topic::Keys => include_str!("../../assets/manual/keys.md"),
        }
    }

    /// Returns the title of the page.
    pub fn title(self) -> &'static str {
        let first = self.source().lines().next().unwrap_or_default();
        first.trim_start_matches('#').trim()
    }

    /// Returns the page as Markdown with its tables.
    pub fn text(self) -> String {
        self.source()
            .replace("{{keys}}", &key_table())
            .replace("{{settings}}", &settings::markdown())
            .replace("{{files}}", &file_table())
            .replace("{{object_columns}}", &column_table())
    }
}

/// Returns all pages as one text of Markdown.
pub fn whole() -> String {
    let pages: Vec<String> = Topic::ALL.into_iter().map(Topic::text).collect();
    pages.join("\n")
}

/// Returns the table of all commands of the window with their keys.
fn key_table() -> String {
    let mut table = String::from("| command | key | acts in | does |\n|---|---|---|---|\n");
    for action in Action::ALL {
        let keys: Vec<String> = action.all_keys().map(|keys| format!("`{keys}`")).collect();
        let keys = keys.join(" or ");
        let (label, hint) = (action.label(), action.hint());
        let scope = action.key_scope().map_or("", KeyScope::name);
        // Writing to a string cannot fail.
        writeln!(table, "| {label} | {keys} | {scope} | {hint} |").ok();
    }
    table
}

/// Returns the table of all columns of the table of objects.
fn column_table() -> String {
    let mut table = String::from("| column | what it is |\n|---|---|\n");
    for column in OBJECT_COLUMNS {
        writeln!(table, "| `{}` | {} |", column.name, column.meaning).ok();
    }
    table
}

/// Returns the table of all files of a run: when each is written, and what it contains.
fn file_table() -> String {
    let mut table = String::from("| file | written | what it is |\n|---|---|---|\n");
    for row in OUTPUT_FILES {
        let when = match row.when {
            When::Always => "always".to_owned(),
            When::Chosen(product) => format!("with `--products {}`", product.name()),
            When::Compared => "with a reference".to_owned(),
            When::Searched => "with a search for objects".to_owned(),
            When::Listed => "with a search for objects or a review".to_owned(),
        };
        writeln!(table, "| `{}` | {when} | {} |", row.name, row.brief).ok();
    }
    table
}

/// A piece of text in one style.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Span {
    /// Text without marks.
    pub text: String,
    /// True for a key, a setting, a file or a command, which is set in a fixed width.
    pub is_code: bool,
}

/// A block of a page.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum PageBlock {
    /// A heading, with its level from 1.
    Heading(usize, String),
    /// A paragraph of text.
    Paragraph(Vec<Span>),
    /// An entry of a list.
    Item(Vec<Span>),
    /// Lines that keep their form.
    Code(String),
    /// Rows of cells; the first row is the head.
    Table(Vec<Vec<Vec<Span>>>),
}

impl PageBlock {
    /// Returns the text of the block without marks.
    pub fn plain(&self) -> String {
        match self {
            PageBlock::Heading(_, text) | PageBlock::Code(text) => text.clone(),
            PageBlock::Paragraph(spans) | PageBlock::Item(spans) => plain(spans),
            PageBlock::Table(rows) => {
                let cells = rows.iter().flatten().map(|cell| plain(cell));
                cells.collect::<Vec<_>>().join(" ")
            }
        }
    }
}

/// Returns the text of spans without marks.
pub fn plain(spans: &[Span]) -> String {
    spans.iter().map(|span| span.text.as_str()).collect()
}

/// Parses the blocks of a page.
pub fn blocks(text: &str) -> Vec<PageBlock> {
    let mut found = Vec::new();
    let mut lines = text.lines().peekable();
    while let Some(line) = lines.next() {
        if line.trim().is_empty() {
            continue;
        }
        if line.starts_with("```") {
            let code: Vec<&str> =
                lines.by_ref().take_while(|line| !line.starts_with("```")).collect();
            found.push(PageBlock::Code(code.join("\n")));
        } else if line.starts_with('#') {
            let level = line.chars().take_while(|sign| *sign == '#').count();
            found.push(PageBlock::Heading(level, line[level..].trim().replace('`', "")));
        } else if line.starts_with('|') {
            let mut rows = vec![cells(line)];
            while let Some(next) = lines.next_if(|next| next.starts_with('|')) {
                if !is_rule(next) {
                    rows.push(cells(next));
                }
            }
            found.push(PageBlock::Table(rows));
        } else {
            let item = line.strip_prefix("- ");
            let mut joined = item.unwrap_or(line).trim().to_owned();
            while let Some(next) = lines.next_if(|next| goes_on(next)) {
                joined.push(' ');
                joined.push_str(next.trim());
            }
            let spans = spans(&joined);
            found.push(match item {
                Some(_) => PageBlock::Item(spans),
                None => PageBlock::Paragraph(spans),
            });
        }
    }
    found
}

/// Returns the blocks of each heading, the heading first.
pub fn sections(blocks: &[PageBlock]) -> Vec<&[PageBlock]> {
    let starts = |block: &PageBlock| matches!(block, PageBlock::Heading(..));
    let mut cuts: Vec<usize> = (0..blocks.len()).filter(|at| starts(&blocks[*at])).collect();
    if cuts.first() != Some(&0) {
        cuts.insert(0, 0);
    }
    cuts.push(blocks.len());
    let found = cuts.windows(2).map(|pair| &blocks[pair[0]..pair[1]]);
    found.filter(|section| !section.is_empty()).collect()
}

/// Returns true if a line continues the paragraph or the list entry before it.
fn goes_on(line: &str) -> bool {
    let starts_anew = ["#", "|", "- ", "```"].iter().any(|sign| line.starts_with(sign));
    !line.trim().is_empty() && !starts_anew
}

fn is_rule(line: &str) -> bool {
    line.chars().all(|sign| "|-: ".contains(sign))
}

fn cells(line: &str) -> Vec<Vec<Span>> {
    let inner = line.trim().trim_start_matches('|').trim_end_matches('|');
    // A bar within a cell is escaped.
    let inner = inner.replace("\\|", "\u{0}");
    let cells = inner.split('|').map(|cell| cell.trim().replace('\u{0}', "|"));
    cells.map(|cell| spans(&cell)).collect()
}

/// Parses the spans of a text; text between backticks is code. The asterisks of strong text are
/// removed: the window and the terminal have one weight of type.
fn spans(text: &str) -> Vec<Span> {
    let span = |(index, piece): (usize, &str)| {
        let is_code = index % 2 == 1;
        let text = if is_code { piece.to_owned() } else { piece.replace("**", "") };
        Span { text, is_code }
    };
    let spans = text.split('`').enumerate().map(span);
    spans.filter(|span| !span.text.is_empty()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_page_becomes_blocks() {
        let found = blocks(
            "# Title\n\nOne **line**\nand `code`.\n\n- an entry\n  goes on\n- another\n\n```sh\na  b\n```\n| x | `y` |\n|---|---|\n| 1 | 2\\|3 |\n",
        );
        let code = |text: &str| Span { text: text.to_owned(), is_code: true };
        let text = |text: &str| Span { text: text.to_owned(), is_code: false };
        assert_eq!(
            found,
            [
                PageBlock::Heading(1, "Title".to_owned()),
                PageBlock::Paragraph(vec![text("One line and "), code("code"), text(".")]),
                PageBlock::Item(vec![text("an entry goes on")]),
                PageBlock::Item(vec![text("another")]),
                PageBlock::Code("a  b".to_owned()),
                PageBlock::Table(vec![
                    vec![vec![text("x")], vec![code("y")]],
                    vec![vec![text("1")], vec![text("2|3")]],
                ]),
            ]
        );
    }

    #[test]
    fn sections_begin_at_headings() {
        let page = blocks("before\n\n# A\n\none\n\n## B\n\ntwo\n\nthree\n");
        let lengths: Vec<usize> = sections(&page).iter().map(|section| section.len()).collect();
        assert_eq!(lengths, [1, 2, 3]);
        assert!(sections(&[]).is_empty());
    }
}

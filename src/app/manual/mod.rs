//! Contains the manual: pages of Markdown that are compiled in, with tables that are derived from
//! the program. `bathyscope manual` prints the pages, F1 shows them; `markdown` parses the part of
//! Markdown that they use, `tables` makes the tables.

pub mod markdown;
mod tables;

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
            Topic::Window => include_str!("../../../assets/manual/window.md"),
            Topic::Waterfall => include_str!("../../../assets/manual/waterfall.md"),
            Topic::Survey => include_str!("../../../assets/manual/survey.md"),
            Topic::Archive => include_str!("../../../assets/manual/archive.md"),
            Topic::Project => include_str!("../../../assets/manual/project.md"),
            Topic::Map => include_str!("../../../assets/manual/map.md"),
            Topic::Bottom => include_str!("../../../assets/manual/bottom.md"),
            Topic::Depth => include_str!("../../../assets/manual/depth.md"),
            Topic::Plan => include_str!("../../../assets/manual/plan.md"),
            Topic::Mosaic => include_str!("../../../assets/manual/mosaic.md"),
            Topic::Objects => include_str!("../../../assets/manual/objects.md"),
            Topic::Commands => include_str!("../../../assets/manual/commands.md"),
            Topic::Settings => include_str!("../../../assets/manual/settings.md"),
            Topic::Files => include_str!("../../../assets/manual/files.md"),
            Topic::Accuracy => include_str!("../../../assets/manual/accuracy.md"),
            Topic::Limits => include_str!("../../../assets/manual/limits.md"),
            Topic::Keys => include_str!("../../../assets/manual/keys.md"),
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
            .replace("{{keys}}", &tables::keys())
            .replace("{{settings}}", &tables::settings())
            .replace("{{files}}", &tables::files())
            .replace("{{object_columns}}", &tables::object_columns())
    }
}

/// Returns all pages as one text of Markdown.
pub fn whole() -> String {
    let pages: Vec<String> = Topic::ALL.into_iter().map(Topic::text).collect();
    pages.join("\n")
}

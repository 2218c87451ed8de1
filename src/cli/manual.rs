//! `bathyscope manual`: prints the manual, or one page of it, as Markdown.

use super::{Failure, output};
use crate::app::manual::{self, Topic};

/// `bathyscope manual [TOPIC]`.
#[derive(Debug, clap::Args)]
pub(super) struct ManualArgs {
    /// The page to print; all pages without it
    topic: Option<Topic>,
}

/// Prints the manual on stdout.
///
/// # Errors
/// Returns an error if stdout cannot be written.
pub(super) fn run(args: ManualArgs) -> Result<(), Failure> {
    let text = args.topic.map_or_else(manual::whole, Topic::text);
    output::results(text.trim_end())
}

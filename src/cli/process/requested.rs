//! Products that `--products` can name.

use bathyscope_products::outputs::Product;
use clap::ValueEnum;
use clap::builder::PossibleValue;

/// A group of files of a run, or the rows of an archive, which are no files of a run: many logs
/// share their folder.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Requested {
    /// Files of a run.
    Files(Product),
    /// Rows of an archive.
    Tiles,
}

/// All groups of files, and the tiles.
const ALL: [Requested; Product::ALL.len() + 1] = {
    let mut all = [Requested::Tiles; Product::ALL.len() + 1];
    let mut index = 0;
    while index < Product::ALL.len() {
        all[index] = Requested::Files(Product::ALL[index]);
        index += 1;
    }
    all
};

impl ValueEnum for Requested {
    fn value_variants<'a>() -> &'a [Self] {
        &ALL
    }

    fn to_possible_value(&self) -> Option<PossibleValue> {
        match self {
            Self::Files(product) => product.to_possible_value(),
            Self::Tiles => Some(PossibleValue::new("tiles").help(
                "alone, into an archive: points and pings of each log by tile, points/*/*.parquet; pings/*/*.parquet",
            )),
        }
    }
}

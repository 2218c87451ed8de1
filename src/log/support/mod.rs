//! Positions and planes, times, progress, statistics, files and their faults: plain values that all
//! crates use, and that know nothing of logs.

pub mod calendar;
pub mod catch_panic;
pub mod file_error;
pub mod geo;
pub mod mapped_file;
pub mod outline;
pub mod picture_file;
pub mod printable;
pub mod progress;
pub mod regular_file;
pub mod statistics;
pub mod versions;

/// Names the variants of an enum: gives it `ALL`, in the order of the list, and `name`. The doc
/// comment is that of `ALL`.
#[macro_export]
macro_rules! named {
    ($(#[$doc:meta])* $vis:vis $kind:ident { $($variant:ident: $name:literal,)+ }) => {
        impl $kind {
            $(#[$doc])*
            $vis const ALL: [Self; [$($name),+].len()] = [$(Self::$variant),+];

            /// Its name, in words and in files.
            $vis fn name(self) -> &'static str {
                match self {
                    $(Self::$variant => $name,)+
                }
            }
        }
    };
}

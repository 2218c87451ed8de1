//! Provides positions and planes, times, progress, statistics, files and their faults to all
//! crates, independent of logs.

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

/// Adds `ALL`, the variants of an enum, to the enum. The first doc comment becomes that of `ALL`.
///
/// With the enum itself, after `const ALL;`, the variants are in the order of their declaration.
/// With a list of names, they are in the order of the list; a list that lacks one does not compile.
#[macro_export]
macro_rules! listed {
    (
        $(#[$doc:meta])* const ALL;
        $(#[$attr:meta])* $vis:vis enum $kind:ident { $($(#[$of:meta])* $variant:ident,)+ }
    ) => {
        $(#[$attr])*
        $vis enum $kind {
            $($(#[$of])* $variant,)+
        }

        impl $kind {
            $(#[$doc])*
            $vis const ALL: [Self; [$(stringify!($variant)),+].len()] = [$(Self::$variant),+];
        }
    };
    ($(#[$doc:meta])* $vis:vis $kind:ident { $($variant:ident),+ $(,)? }) => {
        impl $kind {
            $(#[$doc])*
            $vis const ALL: [Self; [$(stringify!($variant)),+].len()] = [$(Self::$variant),+];
        }

        const _: fn($kind) = |variant| match variant {
            $($kind::$variant)|+ => {}
        };
    };
}

/// Adds `ALL`, the variants in the order of the list, and `name` to an enum. The doc comment
/// becomes that of `ALL`.
#[macro_export]
macro_rules! named {
    ($(#[$doc:meta])* $vis:vis $kind:ident { $($variant:ident: $name:literal,)+ }) => {
        $crate::listed! { $(#[$doc])* $vis $kind { $($variant),+ } }

        impl $kind {
            /// Returns the name, as shown to users and written to files.
            $vis fn name(self) -> &'static str {
                match self {
                    $(Self::$variant => $name,)+
                }
            }
        }
    };
}

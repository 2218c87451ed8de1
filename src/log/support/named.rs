//! Names of the variants of an enum.

/// Gives an enum `ALL`, in the order of the list, and `name`. The doc comment is that of `ALL`.
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

//! A macro for enums with names.

/// Declares an enum whose variants have names, in groups. A group is a constant list of its variants.
macro_rules! named {
    (
        $(#[$about:meta])*
        pub enum $name:ident { $($(#[$why:meta])* $group:ident { $($(#[$doc:meta])* $variant:ident = $text:literal,)* })* }
    ) => {
        $(#[$about])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, serde::Serialize, serde::Deserialize)]
        pub enum $name { $($($(#[$doc])* #[serde(rename = $text)] $variant,)*)* }

        impl $name {
            $($(#[$why])* pub const $group: [Self; [$($text),*].len()] = [$(Self::$variant),*];)*

            /// Returns the name.
            pub fn name(self) -> &'static str {
                match self { $($(Self::$variant => $text,)*)* }
            }

            /// Returns the variant of a name.
            pub fn named(name: &str) -> Option<Self> {
                match name { $($($text => Some(Self::$variant),)*)* _ => None }
            }
        }
    };
}

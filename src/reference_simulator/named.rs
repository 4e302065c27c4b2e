//! A macro for enums of effects and their identifiers.

/// Declares an enum of effects with their identifiers, in three groups. A diagnosis should name the `LISTED` effects; the `UNLISTED` ones
/// are outside its library.
macro_rules! named_effects {
    (
        $(#[$about:meta])* pub enum $name:ident
        LISTED { $($(#[$l:meta])* $listed:ident = $listed_id:literal,)* }
        OTHERS { $($(#[$x:meta])* $other:ident = $other_id:literal,)* }
        UNLISTED { $($(#[$o:meta])* $unlisted:ident = $unlisted_id:literal,)* }
    ) => {
        $(#[$about])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, serde::Serialize, serde::Deserialize)]
        #[serde(rename_all = "kebab-case")]
        pub enum $name { $($(#[$l])* $listed,)* $($(#[$x])* $other,)* $($(#[$o])* $unlisted,)* }

        impl $name {
            /// Effects that a diagnosis should name.
            pub const LISTED: [Self; [$($listed_id),*].len()] = [$(Self::$listed),*];
            /// Effects outside the library of the diagnosis.
            pub const UNLISTED: [Self; [$($unlisted_id),*].len()] = [$(Self::$unlisted),*];

            /// Returns the identifier.
            pub fn id(self) -> &'static str {
                match self {
                    $(Self::$listed => $listed_id,)*
                    $(Self::$other => $other_id,)*
                    $(Self::$unlisted => $unlisted_id,)*
                }
            }
        }
    };
}
pub(crate) use named_effects;

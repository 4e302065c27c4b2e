//! One list for all that is said of an effect by name.

/// An enum of effects with their identifiers; those that a diagnosis is expected to know (`LISTED`), others, and those outside every list (`OUTSIDE`).
macro_rules! named_effects {
    (
        $(#[$about:meta])* pub enum $name:ident
        LISTED { $($(#[$l:meta])* $listed:ident = $listed_id:literal,)* }
        OTHERS { $($(#[$x:meta])* $other:ident = $other_id:literal,)* }
        OUTSIDE { $($(#[$o:meta])* $outside:ident = $outside_id:literal,)* }
    ) => {
        $(#[$about])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, serde::Serialize, serde::Deserialize)]
        #[serde(rename_all = "kebab-case")]
        pub enum $name { $($(#[$l])* $listed,)* $($(#[$x])* $other,)* $($(#[$o])* $outside,)* }

        impl $name {
            /// Effects that a diagnosis is expected to know by name.
            pub const LISTED: [Self; [$($listed_id),*].len()] = [$(Self::$listed),*];
            /// Effects outside every list.
            pub const OUTSIDE: [Self; [$($outside_id),*].len()] = [$(Self::$outside),*];

            /// Identifier.
            pub fn id(self) -> &'static str {
                match self {
                    $(Self::$listed => $listed_id,)*
                    $(Self::$other => $other_id,)*
                    $(Self::$outside => $outside_id,)*
                }
            }
        }
    };
}
pub(crate) use named_effects;

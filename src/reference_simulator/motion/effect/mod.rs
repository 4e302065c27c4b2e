//! Effects that may be missing from the engineer's model.

mod apply;
mod kind;

pub use apply::Effect;
pub use kind::Effect as EffectKind;

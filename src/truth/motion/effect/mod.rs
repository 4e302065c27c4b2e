//! What may be missing from the engineer's model.

mod apply;
mod kind;

pub use kind::Effect as EffectKind;
pub use apply::Effect;

//! Combinations of effects.

use std::fmt;

/// Ids of effects that act together, in the order in which they were added. A released parameter counts with
/// its own id.
///
/// Its text, as documents and messages state it, joins the ids with `+`.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct EffectIds(Vec<String>);

impl EffectIds {
    /// Creates the combination of one effect.
    pub fn single(id: impl Into<String>) -> Self {
        EffectIds(vec![id.into()])
    }

    /// Returns the combination with an effect added as its last.
    #[must_use]
    pub fn with(&self, id: impl Into<String>) -> Self {
        let mut all = self.clone();
        all.push(id);
        all
    }

    /// Adds an effect as the last.
    pub fn push(&mut self, id: impl Into<String>) {
        self.0.push(id.into());
    }

    /// Removes the effect at an index.
    pub fn remove(&mut self, at: usize) {
        self.0.remove(at);
    }

    /// Returns the ids.
    pub fn as_slice(&self) -> &[String] {
        &self.0
    }

    /// Returns the ids one after another.
    pub fn iter(&self) -> impl Iterator<Item = &str> {
        self.0.iter().map(String::as_str)
    }

    /// Returns the effect that was added first.
    pub fn first(&self) -> Option<&str> {
        self.0.first().map(String::as_str)
    }

    /// Returns the effect that was added last.
    pub fn last(&self) -> Option<&str> {
        self.0.last().map(String::as_str)
    }

    /// Returns the effects after the first.
    pub fn after_first(&self) -> &[String] {
        self.0.get(1..).unwrap_or(&[])
    }

    /// Returns the number of effects.
    pub fn len(&self) -> usize {
        self.0.len()
    }

    /// Whether there is no effect.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// Whether an effect is among them.
    pub fn contains(&self, id: &str) -> bool {
        self.iter().any(|own| own == id)
    }

    /// Whether it consists of one effect alone.
    pub fn is_only(&self, id: &str) -> bool {
        matches!(&self.0[..], [own] if own == id)
    }
}

impl fmt::Display for EffectIds {
    fn fmt(&self, to: &mut fmt::Formatter<'_>) -> fmt::Result {
        to.write_str(&self.0.join("+"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_combination_keeps_the_order_of_its_effects() {
        let both = EffectIds::single("rotor-hold").with("backlash");
        assert_eq!(both.to_string(), "rotor-hold+backlash");
        assert_eq!((both.first(), both.last(), both.len()), (Some("rotor-hold"), Some("backlash"), 2));
        assert!(
            both.contains("backlash")
                && !both.is_only("rotor-hold")
                && EffectIds::single("rotor-hold").is_only("rotor-hold")
        );
        assert!(EffectIds::default().is_empty() && EffectIds::default().after_first().is_empty());
    }
}

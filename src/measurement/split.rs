//! What is fitted and what is held out, as two types that cannot be mixed up.

use super::{MeasurementError, MeasurementSet};

/// Positions (by index) whose data may be fitted.
#[derive(Debug, Clone, PartialEq)]
pub struct FitSet<'s> {
    /// The set.
    pub set: &'s MeasurementSet,
    /// Indices of the positions.
    pub positions: Vec<usize>,
}

/// Positions (by index) kept for the final figure.
#[derive(Debug, Clone, PartialEq)]
pub struct HoldOutSet<'s> {
    /// The set.
    pub set: &'s MeasurementSet,
    /// Indices of the positions.
    pub positions: Vec<usize>,
}

impl MeasurementSet {
    /// Indices of positions by name.
    ///
    /// # Errors  a name is unknown (the message lists those there are) or stands twice.
    pub fn positions_named(&self, names: &[String]) -> Result<Vec<usize>, MeasurementError> {
        let mut indices = Vec::new();
        for name in names.iter().map(|n| n.trim()) {
            let index = self.positions.iter().position(|p| p.name == *name).ok_or_else(|| {
                let known: Vec<&str> = self.positions.iter().map(|p| p.name.as_str()).collect();
                let known = if known.is_empty() { "it has none".into() } else { format!("it has {}", known.join(", ")) };
                MeasurementError::file(&self.path, format!("the set has no position «{name}»; {known}"))
            })?;
            if indices.contains(&index) {
                return Err(MeasurementError::file(&self.path, format!("position «{name}» is named twice; name it once")));
            }
            indices.push(index);
        }
        Ok(indices)
    }

    /// Splits the positions: those named, else the set's `[split]`, else all are fitted; the others are held out.
    ///
    /// # Errors  as [`MeasurementSet::positions_named`].
    pub fn split(&self, named: Option<&[String]>) -> Result<(FitSet<'_>, HoldOutSet<'_>), MeasurementError> {
        let fit = match (named, &self.split) {
            (Some(names), _) => self.positions_named(names)?,
            (None, Some(names)) => self.positions_named(names)?,
            (None, None) => (0..self.positions.len()).collect(),
        };
        let held_out = (0..self.positions.len()).filter(|i| !fit.contains(i)).collect();
        Ok((FitSet { set: self, positions: fit }, HoldOutSet { set: self, positions: held_out }))
    }
}

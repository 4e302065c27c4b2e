//! Split of a set into fitted and held-out data, as two types that cannot be mixed up.

use super::{Frf, MeasurementError, MeasurementSet};

/// Positions and FRFs (by index) whose data may be fitted.
#[derive(Debug, Clone, PartialEq)]
pub struct FitSet<'s> {
    /// The set.
    pub set: &'s MeasurementSet,
    /// Indices of the positions.
    pub positions: Vec<usize>,
    /// Indices of the FRFs.
    pub frfs: Vec<usize>,
}

/// Positions and FRFs (by index) held out for validation.
#[derive(Debug, Clone, PartialEq)]
pub struct HoldOutSet<'s> {
    /// The set.
    pub set: &'s MeasurementSet,
    /// Indices of the positions.
    pub positions: Vec<usize>,
    /// Indices of the FRFs.
    pub frfs: Vec<usize>,
}

impl<'s> FitSet<'s> {
    /// Returns the folds of leave-one-out cross-validation: fitted and held-out data of each.
    ///
    /// For modes, a fold holds out one position with observed modes. For whole FRFs, it holds out all FRFs of one position, or of one record where
    /// FRFs have no position.
    pub fn leave_one_out(&self, whole_frfs: bool) -> Vec<(FitSet<'s>, HoldOutSet<'s>)> {
        let observed = |p: &usize| self.set.modes.as_ref().is_some_and(|m| m.positions[*p].iter().any(|mode| mode.frequency_hz.is_some()));
        let groups: Vec<(Vec<usize>, Vec<usize>)> = if whole_frfs {
            self.groups().into_iter().map(|frfs| (self.set.frfs[frfs[0]].position.into_iter().collect(), frfs)).collect()
        } else {
            self.positions.iter().copied().filter(observed).map(|p| (vec![p], Vec::new())).collect()
        };
        let without = |all: &[usize], left: &[usize]| all.iter().copied().filter(|i| !left.contains(i)).collect();
        let fold = |(positions, frfs): (Vec<usize>, Vec<usize>)| {
            let kept = FitSet { set: self.set, positions: without(&self.positions, &positions), frfs: without(&self.frfs, &frfs) };
            (kept, HoldOutSet { set: self.set, positions, frfs })
        };
        groups.into_iter().map(fold).collect()
    }

    /// Returns its FRFs (by index), grouped by position, or by record where they have no position.
    pub fn groups(&self) -> Vec<Vec<usize>> {
        let same = |a: &Frf, b: &Frf| a.position == b.position && (a.position.is_some() || a.record == b.record);
        let mut groups: Vec<Vec<usize>> = Vec::new();
        for &i in &self.frfs {
            match groups.iter_mut().find(|g| same(&self.set.frfs[g[0]], &self.set.frfs[i])) {
                Some(group) => group.push(i),
                None => groups.push(vec![i]),
            }
        }
        groups
    }
}

impl MeasurementSet {
    /// Returns the indices of positions by name.
    ///
    /// # Errors  a name is unknown (the message lists the known ones) or is given twice.
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

    /// Splits the set into fitted and held-out data.
    ///
    /// The positions and records in `named` are fitted, else those of the set's `[split]`, else all. The others and those in `hold_out` are held out.
    ///
    /// # Errors  a name is neither a position nor a record (the message lists the known ones), or is given twice; nothing is left to fit.
    pub fn split(&self, named: Option<&[String]>, hold_out: &[String]) -> Result<(FitSet<'_>, HoldOutSet<'_>), MeasurementError> {
        let named = named.or(self.split.as_deref()).map(|names| self.resolve(names)).transpose()?;
        let excluded = self.resolve(hold_out)?;
        let is_record = |list: &[Name], frf: &Frf| list.iter().any(|n| matches!(n, Name::Record(r) if frf.record.as_ref() == Some(r)));
        let is_position = |list: &[Name], at: usize| list.contains(&Name::Position(at));
        let position_fits = |at: usize| !is_position(&excluded, at) && named.as_ref().is_none_or(|list| is_position(list, at));
        let frf_fits = |frf: &Frf| {
            let at = |list: &[Name]| is_record(list, frf) || frf.position.is_some_and(|p| is_position(list, p));
            !at(&excluded) && named.as_ref().is_none_or(|list| at(list))
        };
        let (positions, other_positions): (Vec<usize>, Vec<usize>) = (0..self.positions.len()).partition(|i| position_fits(*i));
        let (frfs, other_frfs): (Vec<usize>, Vec<usize>) = (0..self.frfs.len()).partition(|i| frf_fits(&self.frfs[*i]));
        if positions.is_empty() && frfs.is_empty() {
            return Err(MeasurementError::file(&self.path, "nothing is left to fit; name fewer records to hold out, or others to fit"));
        }
        Ok((FitSet { set: self, positions, frfs }, HoldOutSet { set: self, positions: other_positions, frfs: other_frfs }))
    }

    /// Splits the time records (by index) into fitted and held-out ones.
    ///
    /// The records in `named` are fitted, else those of the set's `[split]`, else all. The others and those in `hold_out` are held out.
    ///
    /// # Errors  a name is not a record, or is given twice; nothing is left to fit.
    pub fn split_motions(&self, named: Option<&[String]>, hold_out: &[String]) -> Result<(Vec<usize>, Vec<usize>), MeasurementError> {
        let named = named.or(self.split.as_deref()).map(|names| self.resolve(names)).transpose()?;
        let excluded = self.resolve(hold_out)?;
        let among = |list: &[Name], at: usize| list.contains(&Name::Record(self.motions[at].name.clone()));
        let fits = |at: &usize| !among(&excluded, *at) && named.as_ref().is_none_or(|list| among(list, *at));
        let (fit, held_out): (Vec<usize>, Vec<usize>) = (0..self.motions.len()).partition(fits);
        if fit.is_empty() {
            return Err(MeasurementError::file(
                &self.path,
                "no [[motion]] record is left to fit; name fewer to hold out, or others to fit",
            ));
        }
        Ok((fit, held_out))
    }

    /// Resolves names to positions and records.
    fn resolve(&self, names: &[String]) -> Result<Vec<Name>, MeasurementError> {
        let mut found: Vec<Name> = Vec::new();
        for name in names.iter().map(|n| n.trim()) {
            let position = self.positions.iter().position(|p| p.name == *name).map(Name::Position);
            let is_record = self.frfs.iter().any(|f| f.record.as_deref() == Some(name)) || self.motions.iter().any(|m| m.name == name);
            let this = position.or_else(|| is_record.then(|| Name::Record(name.to_string())));
            let this = this.ok_or_else(|| {
                let mut known: Vec<&str> = self.positions.iter().map(|p| p.name.as_str()).collect();
                for record in self.frfs.iter().filter_map(|f| f.record.as_deref()).chain(self.motions.iter().map(|m| m.name.as_str())) {
                    if !known.contains(&record) {
                        known.push(record);
                    }
                }
                let known = if known.is_empty() { "it has none".into() } else { format!("it has {}", known.join(", ")) };
                MeasurementError::file(&self.path, format!("the set has no position or record «{name}»; {known}"))
            })?;
            if found.contains(&this) {
                return Err(MeasurementError::file(&self.path, format!("«{name}» is named twice; name it once")));
            }
            found.push(this);
        }
        Ok(found)
    }
}

/// Data that a name in a split refers to.
#[derive(Debug, Clone, PartialEq)]
enum Name {
    Position(usize),
    Record(String),
}

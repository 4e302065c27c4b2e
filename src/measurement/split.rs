//! Split of a set into fitted and held-out data, as two types that cannot be mixed up.

use std::marker::PhantomData;

use super::{Frf, MeasurementError, MeasurementSet};

/// Data that may be fitted.
///
/// Only [`MeasurementSet::split`] makes one, and a part of one is again data to fit. Nothing turns held-out
/// data into data to fit: the fields are private.
///
/// ```
/// # fn of(set: &jointid_measurement::MeasurementSet) -> Result<(), jointid_measurement::MeasurementError> {
/// let (fit, held_out) = set.split(None, &[])?;
/// assert!(held_out.positions().iter().all(|p| !fit.positions().contains(p)));
/// # Ok(())
/// # }
/// ```
///
/// It cannot be built from the parts of held-out data:
///
/// ```compile_fail,E0451
/// fn fit_of<'s>(held_out: &jointid_measurement::HoldOutSet<'s>) -> jointid_measurement::FitSet<'s> {
///     jointid_measurement::FitSet {
///         set: held_out.set(),
///         positions: held_out.positions().to_vec(),
///         frfs: held_out.frfs().to_vec(),
///         role: std::marker::PhantomData,
///     }
/// }
/// ```
///
/// Nor does held-out data pass for data to fit:
///
/// ```compile_fail,E0308
/// fn fit_of<'s>(held_out: jointid_measurement::HoldOutSet<'s>) -> jointid_measurement::FitSet<'s> {
///     held_out
/// }
/// ```
pub type FitSet<'s> = DataPart<'s, Fitted>;

/// Data to predict: those held out for validation, or data chosen for a prediction alone.
pub type HoldOutSet<'s> = DataPart<'s, HeldOut>;

/// Marks data that may be fitted.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Fitted {}

/// Marks data to predict.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum HeldOut {}

/// Positions and FRFs of a set (by index) in one role.
#[derive(Debug, Clone, PartialEq)]
pub struct DataPart<'s, Role> {
    set: &'s MeasurementSet,
    positions: Vec<usize>,
    frfs: Vec<usize>,
    role: PhantomData<Role>,
}

impl<'s, Role> DataPart<'s, Role> {
    fn new(set: &'s MeasurementSet, positions: Vec<usize>, frfs: Vec<usize>) -> Self {
        Self { set, positions, frfs, role: PhantomData }
    }

    /// Returns the set.
    pub fn set(&self) -> &'s MeasurementSet {
        self.set
    }

    /// Returns the indices of the positions.
    pub fn positions(&self) -> &[usize] {
        &self.positions
    }

    /// Returns the indices of the FRFs.
    pub fn frfs(&self) -> &[usize] {
        &self.frfs
    }

    /// Whether it has neither positions nor FRFs.
    pub fn is_empty(&self) -> bool {
        self.positions.is_empty() && self.frfs.is_empty()
    }

    /// Returns the same positions and FRFs of another version of the set: simulated, or with corrected data.
    #[must_use]
    pub fn in_version<'o>(&self, set: &'o MeasurementSet) -> DataPart<'o, Role> {
        DataPart::new(set, self.positions.clone(), self.frfs.clone())
    }

    /// Returns its positions with only those FRFs whose index satisfies a condition.
    #[must_use]
    pub fn with_frfs(&self, keep: impl Fn(usize) -> bool) -> Self {
        Self::new(
            self.set,
            self.positions.clone(),
            self.frfs.iter().copied().filter(|frf| keep(*frf)).collect(),
        )
    }
}

impl<'s> FitSet<'s> {
    /// Returns its FRFs with only those positions whose index satisfies a condition.
    #[must_use]
    pub fn with_positions(&self, keep: impl Fn(usize) -> bool) -> FitSet<'s> {
        FitSet::new(
            self.set,
            self.positions.iter().copied().filter(|position| keep(*position)).collect(),
            self.frfs.clone(),
        )
    }

    /// Returns the fitted data themselves as data to predict: the residuals of a fit.
    #[must_use]
    pub fn to_predict(&self) -> HoldOutSet<'s> {
        HoldOutSet::new(self.set, self.positions.clone(), self.frfs.clone())
    }

    /// Returns fitted and held-out data, in this order, as data to predict: a map of residuals over all data.
    #[must_use]
    pub fn both(&self, held_out: &HoldOutSet<'s>) -> HoldOutSet<'s> {
        let joined = |own: &[usize], other: &[usize]| [own, other].concat();
        HoldOutSet::new(
            self.set,
            joined(&self.positions, &held_out.positions),
            joined(&self.frfs, &held_out.frfs),
        )
    }

    /// Returns the folds of leave-one-out cross-validation: data to fit and to predict of each, see
    /// [`FitSet::blocks`].
    pub fn leave_one_out(&self, whole_frfs: bool) -> Vec<(FitSet<'s>, HoldOutSet<'s>)> {
        self.blocks(whole_frfs).into_iter().map(|(kept, left)| (kept, left.to_predict())).collect()
    }

    /// Returns the folds of leave-one-out cross-validation within the data to fit: retained and left-out data
    /// of each. Both are data to fit.
    ///
    /// For modes, a fold leaves out one position with observed modes. For whole FRFs, it leaves out all FRFs
    /// of one position, or of one record where FRFs have no position.
    pub fn blocks(&self, whole_frfs: bool) -> Vec<(FitSet<'s>, FitSet<'s>)> {
        let observed = |p: &usize| {
            self.set
                .modes
                .as_ref()
                .is_some_and(|m| m.positions[*p].iter().any(|mode| mode.frequency_hz.is_some()))
        };
        let groups: Vec<(Vec<usize>, Vec<usize>)> = if whole_frfs {
            self.groups()
                .into_iter()
                .map(|frfs| (self.set.frfs[frfs[0]].position.into_iter().collect(), frfs))
                .collect()
        } else {
            self.positions.iter().copied().filter(observed).map(|p| (vec![p], Vec::new())).collect()
        };
        let without =
            |all: &[usize], left: &[usize]| all.iter().copied().filter(|i| !left.contains(i)).collect();
        let fold = |(positions, frfs): (Vec<usize>, Vec<usize>)| {
            let kept =
                FitSet::new(self.set, without(&self.positions, &positions), without(&self.frfs, &frfs));
            (kept, FitSet::new(self.set, positions, frfs))
        };
        groups.into_iter().map(fold).collect()
    }

    /// Returns its FRFs (by index), grouped by position, or by record where they have no position.
    pub fn groups(&self) -> Vec<Vec<usize>> {
        let same =
            |a: &Frf, b: &Frf| a.position == b.position && (a.position.is_some() || a.record == b.record);
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
    /// Returns the index of a position by its name.
    ///
    /// # Errors  the name is unknown; the message lists the known ones.
    pub fn position_named(&self, name: &str) -> Result<usize, MeasurementError> {
        let name = name.trim();
        self.positions.iter().position(|p| p.name == name).ok_or_else(|| {
            let known: Vec<&str> = self.positions.iter().map(|p| p.name.as_str()).collect();
            self.unknown_name("position", name, &known)
        })
    }

    /// Creates the fault of a name that the set does not have.
    fn unknown_name(&self, of: &str, name: &str, known: &[&str]) -> MeasurementError {
        let known =
            if known.is_empty() { "it has none".into() } else { format!("it has {}", known.join(", ")) };
        MeasurementError::file(&self.path, format!("the set has no {of} «{name}»; {known}"))
    }

    /// Splits the set into fitted and held-out data.
    ///
    /// The positions and records in `named` are fitted, else those of the set's `[split]`, else all. The
    /// others and those in `hold_out` are held out.
    ///
    /// # Errors  a name is neither a position nor a record (the message lists the known ones), or is given
    ///   twice; nothing is left to fit.
    pub fn split(
        &self,
        named: Option<&[String]>,
        hold_out: &[String],
    ) -> Result<(FitSet<'_>, HoldOutSet<'_>), MeasurementError> {
        let named = named.or(self.split.as_deref()).map(|names| self.resolve(names)).transpose()?;
        let excluded = self.resolve(hold_out)?;
        let is_record = |list: &[Name], frf: &Frf| {
            list.iter().any(|n| matches!(n, Name::Record(r) if frf.record.as_ref() == Some(r)))
        };
        let is_position = |list: &[Name], at: usize| list.contains(&Name::Position(at));
        let position_fits = |at: usize| {
            !is_position(&excluded, at) && named.as_ref().is_none_or(|list| is_position(list, at))
        };
        let frf_fits = |frf: &Frf| {
            let at =
                |list: &[Name]| is_record(list, frf) || frf.position.is_some_and(|p| is_position(list, p));
            !at(&excluded) && named.as_ref().is_none_or(|list| at(list))
        };
        let (positions, other_positions): (Vec<usize>, Vec<usize>) =
            (0..self.positions.len()).partition(|i| position_fits(*i));
        let (frfs, other_frfs): (Vec<usize>, Vec<usize>) =
            (0..self.frfs.len()).partition(|i| frf_fits(&self.frfs[*i]));
        if positions.is_empty() && frfs.is_empty() {
            return Err(MeasurementError::file(
                &self.path,
                "nothing is left to fit; name fewer records to hold out, or others to fit",
            ));
        }
        Ok((FitSet::new(self, positions, frfs), HoldOutSet::new(self, other_positions, other_frfs)))
    }

    /// Returns all positions and FRFs of the set as data to predict: to draw them, or to check a model that
    /// was fitted to another set.
    pub fn everything_to_predict(&self) -> HoldOutSet<'_> {
        HoldOutSet::new(self, (0..self.positions.len()).collect(), (0..self.frfs.len()).collect())
    }

    /// Returns the named positions and records as data to predict.
    ///
    /// # Errors  as [`MeasurementSet::split`].
    pub fn to_predict(&self, names: &[String]) -> Result<HoldOutSet<'_>, MeasurementError> {
        Ok(self.split(Some(names), &[])?.0.to_predict())
    }

    /// Splits the time records into fitted and held-out ones (by index).
    ///
    /// The records in `named` are fitted, else those of the set's `[split]`, else all. The others and those
    /// in `hold_out` are held out.
    ///
    /// # Errors  a name is not a record, or is given twice; nothing is left to fit.
    pub fn split_motions(
        &self,
        named: Option<&[String]>,
        hold_out: &[String],
    ) -> Result<(Vec<usize>, Vec<usize>), MeasurementError> {
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
            let is_record = self.frfs.iter().any(|f| f.record.as_deref() == Some(name))
                || self.motions.iter().any(|m| m.name == name);
            let this = position.or_else(|| is_record.then(|| Name::Record(name.to_string())));
            let this = this.ok_or_else(|| {
                let mut known: Vec<&str> = self.positions.iter().map(|p| p.name.as_str()).collect();
                for record in self
                    .frfs
                    .iter()
                    .filter_map(|f| f.record.as_deref())
                    .chain(self.motions.iter().map(|m| m.name.as_str()))
                {
                    if !known.contains(&record) {
                        known.push(record);
                    }
                }
                self.unknown_name("position or record", name, &known)
            })?;
            if found.contains(&this) {
                return Err(MeasurementError::file(
                    &self.path,
                    format!("«{name}» is named twice; name it once"),
                ));
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

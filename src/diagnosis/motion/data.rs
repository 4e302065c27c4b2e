//! The records of a diagnosis: what is fitted, cut into parts that are left out one after another.

use nalgebra::{DMatrix, DVector};

use dynamics::inverse_dynamics::{ExtraChannel, MotionSignal, recorded};

/// Parts of the records that are left out one after another, and pieces of each in a record, between which lie pieces of the others.
const PARTS: usize = 12;
const SLICES: usize = 5;

/// Records to fit.
pub struct MotionData<'m> {
    /// Their motions.
    pub motions: Vec<&'m MotionSignal>,
    /// Recorded force, thinned, and the transmission error of further points, record after record.
    pub y: DVector<f64>,
    /// Columns of further points, each once.
    pub columns: Vec<String>,
    /// Samples in the order of the parts they belong to.
    pub order: Vec<usize>,
    /// Where each part begins in that order, and where the last ends.
    begins: Vec<usize>,
}

impl<'m> MotionData<'m> {
    /// Cuts records into twelve parts, each of five pieces of every record: of the time, or where the command repeats of its period, so that what is
    /// left out is left out of every period. Between pieces lies motion like theirs, so that what is foretold is no other place or speed.
    pub fn new(motions: Vec<&'m MotionSignal>) -> Self {
        let mut part = Vec::new();
        for motion in &motions {
            // All channels of a time are left out together.
            for (samples, period) in motion.channels() {
                let cycle = period.unwrap_or(samples);
                part.extend((0..samples).map(|i| (i % cycle) * PARTS * SLICES / cycle % PARTS));
            }
        }
        let mut columns: Vec<String> = motions.iter().flat_map(|m| &m.further).map(|f| f.column.clone()).collect();
        columns.sort();
        columns.dedup();
        let begins = (0..=PARTS).map(|p| part.iter().filter(|own| **own < p).count()).collect();
        let mut order: Vec<usize> = (0..part.len()).collect();
        order.sort_by_key(|row| part[*row]);
        MotionData { y: recorded(&motions), columns, order, begins, motions }
    }

    /// Whether loops tell of a further point where the encoder is.
    pub fn is_identifiable(&self) -> bool {
        self.motions.iter().flat_map(|m| &m.further).any(ExtraChannel::is_identifiable)
    }

    /// Number of parts.
    pub fn parts(&self) -> usize {
        self.begins.len() - 1
    }

    /// Where a part begins in the order of the parts, and its samples.
    pub fn rows_of(&self, part: usize) -> (usize, usize) {
        (self.begins[part], self.begins[part + 1] - self.begins[part])
    }

    /// Samples.
    pub fn samples(&self) -> usize {
        self.y.len()
    }

    /// A column of force made record by record, thinned, with what it does to points that loops tell of.
    pub fn column(&self, of: impl Fn(&MotionSignal) -> Vec<f64>) -> DVector<f64> {
        self.channel(None, of)
    }

    /// The same of the recorded force alone.
    pub fn recorded_force(&self, of: impl Fn(&MotionSignal) -> Vec<f64>) -> DVector<f64> {
        self.made(of, true, |_, _, _| None)
    }

    /// The same of one channel, the force or a column of a further point, the latter nothing in the others.
    pub fn channel(&self, column: Option<&str>, of: impl Fn(&MotionSignal) -> Vec<f64>) -> DVector<f64> {
        self.made(of, column.is_none(), |further, m, made| match column {
            None => further.thinned(m, &further.told.as_ref()?.behind(made, m)),
            Some(column) => (column == further.column).then(|| further.thinned(m, made))?,
        })
    }

    /// What is made record by record, in the force's channel or not, and in those of further points as they say.
    fn made(
        &self,
        of: impl Fn(&MotionSignal) -> Vec<f64>,
        force: bool,
        further: impl Fn(&ExtraChannel, &MotionSignal, &[f64]) -> Option<Vec<f64>>,
    ) -> DVector<f64> {
        let mut all = Vec::with_capacity(self.samples());
        for m in &self.motions {
            let made = of(m);
            let own = if force { m.thinned(&made) } else { None };
            for channel in std::iter::once(own).chain(m.further.iter().map(|f| further(f, m, &made))) {
                all.extend(channel.unwrap_or_else(|| vec![0.0; m.load.len()]));
            }
        }
        DVector::from_vec(all)
    }

    /// All channels: the force, and columns of further points.
    pub fn channels(&self) -> impl Iterator<Item = Option<&str>> {
        std::iter::once(None).chain(self.columns.iter().map(|c| Some(c.as_str())))
    }

    /// Lengths and periods of the records' channels, in thinned samples.
    pub fn records(&self) -> Vec<(usize, Option<usize>)> {
        self.motions.iter().flat_map(|m| m.channels()).collect()
    }
}

/// Columns beside one another.
pub(super) fn beside(parts: &[&DMatrix<f64>]) -> DMatrix<f64> {
    let rows = parts[0].nrows();
    let columns: usize = parts.iter().map(|p| p.ncols()).sum();
    let mut all = DMatrix::zeros(rows, columns);
    let mut at = 0;
    for part in parts {
        all.columns_mut(at, part.ncols()).copy_from(*part);
        at += part.ncols();
    }
    all
}

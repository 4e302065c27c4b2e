//! Fitted records of a diagnosis, cut into parts that are left out one after another.

use nalgebra::{DMatrix, DVector};

use dynamics::inverse_dynamics::{ExtraChannel, MotionSignal, recorded};

/// Number of parts that are left out one after another, and slices of each part in a record, alternating with
/// those of the other parts.
const PARTS: usize = 12;
const SLICES: usize = 5;

/// Records to fit.
pub struct MotionData<'m> {
    /// Their motions.
    pub motions: Vec<&'m MotionSignal>,
    /// Recorded force and transmission errors of extra channels, thinned, record after record.
    pub y: DVector<f64>,
    /// Names of the extra channels, each once.
    pub columns: Vec<String>,
    /// Samples in the order of their parts.
    pub order: Vec<usize>,
    /// Start of each part in that order, and the end of the last.
    begins: Vec<usize>,
}

impl<'m> MotionData<'m> {
    /// Cuts records into twelve parts, each of five slices of every record: of its time, or of the period of
    /// a repeating command. Thus a part is left out of every period. Slices of other parts lie in between:
    /// predicted and fitted samples cover the same positions and speeds.
    pub fn new(motions: Vec<&'m MotionSignal>) -> Self {
        let mut part = Vec::new();
        for motion in &motions {
            // All channels of a time belong to the same part.
            for (samples, period) in motion.channels() {
                let cycle = period.unwrap_or(samples);
                part.extend((0..samples).map(|i| (i % cycle) * PARTS * SLICES / cycle % PARTS));
            }
        }
        let mut columns: Vec<String> =
            motions.iter().flat_map(|m| &m.extra_channels).map(|f| f.column.clone()).collect();
        columns.sort();
        columns.dedup();
        let begins = (0..=PARTS).map(|p| part.iter().filter(|own| **own < p).count()).collect();
        let mut order: Vec<usize> = (0..part.len()).collect();
        order.sort_by_key(|row| part[*row]);
        MotionData { y: recorded(&motions), columns, order, begins, motions }
    }

    /// Whether an extra channel's encoder side is estimated from the control loop.
    pub fn is_identifiable(&self) -> bool {
        self.motions.iter().flat_map(|m| &m.extra_channels).any(ExtraChannel::is_identifiable)
    }

    /// Returns the number of parts.
    pub fn parts(&self) -> usize {
        self.begins.len() - 1
    }

    /// Returns the first sample of a part, in the order of the parts, and its number of samples.
    pub fn rows_of(&self, part: usize) -> (usize, usize) {
        (self.begins[part], self.begins[part + 1] - self.begins[part])
    }

    /// Returns the number of samples.
    pub fn samples(&self) -> usize {
        self.y.len()
    }

    /// Returns a column of force computed record by record, thinned, with its influence on extra channels
    /// estimated from the control loop.
    pub fn column(&self, of: impl Fn(&MotionSignal) -> Vec<f64>) -> DVector<f64> {
        self.channel(None, of)
    }

    /// Returns the same column in the recorded force alone.
    pub fn recorded_force(&self, of: impl Fn(&MotionSignal) -> Vec<f64>) -> DVector<f64> {
        self.column_of(of, true, |_, _, _| None)
    }

    /// Returns the same column in one channel, the force or an extra channel; zero in the others.
    pub fn channel(&self, column: Option<&str>, of: impl Fn(&MotionSignal) -> Vec<f64>) -> DVector<f64> {
        self.column_of(of, column.is_none(), |further, m, computed| match column {
            None => further.thinned(m, &further.encoder_estimate.as_ref()?.reading_change(computed, m)),
            Some(column) => (column == further.column).then(|| further.thinned(m, computed))?,
        })
    }

    /// Computes a column record by record: in the force if `force`, and in extra channels by `further`.
    fn column_of(
        &self,
        of: impl Fn(&MotionSignal) -> Vec<f64>,
        force: bool,
        further: impl Fn(&ExtraChannel, &MotionSignal, &[f64]) -> Option<Vec<f64>>,
    ) -> DVector<f64> {
        let mut all = Vec::with_capacity(self.samples());
        for m in &self.motions {
            let computed = of(m);
            let own = if force { m.thinned(&computed) } else { None };
            for channel in
                std::iter::once(own).chain(m.extra_channels.iter().map(|f| further(f, m, &computed)))
            {
                all.extend(channel.unwrap_or_else(|| vec![0.0; m.load.len()]));
            }
        }
        DVector::from_vec(all)
    }

    /// Returns all channels: the force, then the extra channels.
    pub fn channels(&self) -> impl Iterator<Item = Option<&str>> {
        std::iter::once(None).chain(self.columns.iter().map(|c| Some(c.as_str())))
    }

    /// Returns lengths and periods of the records' channels, in thinned samples.
    pub fn records(&self) -> Vec<(usize, Option<usize>)> {
        self.motions.iter().flat_map(|m| m.channels()).collect()
    }
}

/// Concatenates columns of several matrices.
pub(super) fn side_by_side(parts: &[&DMatrix<f64>]) -> DMatrix<f64> {
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

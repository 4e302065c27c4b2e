//! Preprocesses motion records.

use crate::{Study, StudyError, StudyResult};
use dynamics::inverse_dynamics::{MotionSignal, Rigid};
use identification::objective::point_named;

impl Study {
    /// Adds the extra channels of the set's records to their preprocessed motions. Returns them with the rigid machine and the warnings about their
    /// columns.
    pub(crate) fn add_channels(&self, made: Vec<MotionSignal>) -> StudyResult<(Vec<MotionSignal>, Rigid, Vec<String>)> {
        let (machine, set) = (&self.config.machine, &self.set);
        let rigid = self.rigid_model()?;
        made.iter().try_for_each(|m| rigid.check(machine, m))?;
        let named = |name: &String| point_named(machine, &set.path, "response", name);
        let response = set.response.as_ref().map(named).transpose()?;
        let (mut motions, mut warnings) = (Vec::new(), Vec::new());
        for (motion, record) in made.into_iter().zip(&set.motions) {
            let (motion, column_warnings) = motion.with_points(record, machine, &rigid)?;
            motions.push(motion.with_reconstructed_encoder(response, record, machine, &rigid)?);
            warnings.extend(column_warnings);
        }
        Ok((motions, rigid, warnings))
    }

    /// Builds the rigid-body model of the machine.
    pub(crate) fn rigid_model(&self) -> StudyResult<Rigid> {
        let machine = &self.config.machine;
        Rigid::new(machine, &machine.start()).map_err(|e| StudyError::input(&self.config.path, e.to_string()))
    }
}

//! Checks of studies whose FRFs have the command of the position loop as their excitation.

use crate::simulation::describe_pole;
use crate::{Study, StudyError, StudyResult};
use dynamics::motion::{LinearLoops, SimulationSettings};
use identification::objective::{COMMAND, operating};

impl Study {
    /// Whether an FRF of the set has the command of the position loop as its excitation.
    pub(crate) fn is_commanded(&self) -> bool {
        self.config.machine.point(COMMAND).is_none()
            && self.set.frfs.iter().any(|frf| frf.excitation == COMMAND)
    }

    /// Checks the loops that closed-loop FRFs need, at the start values, and warns of what these FRFs ignore.
    ///
    /// # Errors  the loops are unstable at a position of the set, or their poles cannot be computed.
    pub(crate) fn check_commanded(&self) -> StudyResult<Vec<String>> {
        let machine = &self.config.machine;
        if !self.is_commanded() || machine.drive.is_none() {
            return Ok(Vec::new());
        }
        for frf in self.set.frfs.iter().filter(|frf| frf.excitation == COMMAND) {
            let settings =
                SimulationSettings { operating: operating(&self.set, frf), ..SimulationSettings::default() };
            let loops =
                LinearLoops::new(machine, &machine.start(), &settings).map_err(StudyError::impossible)?;
            if let Some(pole) = loops.unstable() {
                let fault = format!(
                    "[drive]: the loops are unstable at the start values, so that no FRF can be measured: {}",
                    describe_pole(&pole)
                );
                return Err(StudyError::input(&self.config.path, fault));
            }
        }
        let ignored = machine.joints_ignored_by_frequency_responses().join(", ");
        let warning = format!(
            "closed-loop FRFs are linear: friction and backlash of {ignored} are ignored; measure with an amplitude at which the axis slides \
             throughout"
        );
        Ok((!ignored.is_empty()).then_some(warning).into_iter().collect())
    }
}

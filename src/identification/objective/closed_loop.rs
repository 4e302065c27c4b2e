//! Closed-loop FRFs: position of a point per command of the position loop.

use std::sync::Arc;

use num_complex::Complex64;

use super::ObjectiveError;
use super::setup::point_named;
use dynamics::model::{
    ABREAST, AssembledModel, Complexes, Frequencies, FrequencyGrid, LANES, Reals, RodModel, Sensitivity,
    Structure, Workspace,
};
use dynamics::motion::ServoImpedance;
use machine::{Drive, Machine, Operating, ParameterValues, PointMotion};
use measurement::MeasurementSet;

/// Excitation that is the command of the position loop, and no point of the machine.
pub const COMMAND: &str = "command";
/// Step of a parameter of the drive in its central difference, relative to its value or range (1).
const STEP: f64 = 1e-5;

/// Excitation of an FRF.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Excitation {
    /// A force on a point (index).
    Point(usize),
    /// The command of the position loop; its loops are closed.
    Command,
}

impl Excitation {
    /// Finds the excitation that a measurement names.
    ///
    /// # Errors  it names no point of the machine, or the command of a machine without loops.
    pub fn named(machine: &Machine, source: &str, name: &str) -> Result<Self, ObjectiveError> {
        if name == COMMAND && machine.point(name).is_none() {
            require_drive(machine, source)?;
            return Ok(Excitation::Command);
        }
        point_named(machine, source, "excitation", name).map(Excitation::Point)
    }

    /// Compiles the receptance that its FRF needs, and for the command the closed loop.
    ///
    /// # Errors  a point is fixed; the machine has no loops.
    pub(super) fn structure(
        self,
        machine: &Machine,
        source: &str,
        response: usize,
        rods: RodModel,
    ) -> Result<(Structure, Option<ClosedLoop>), ObjectiveError> {
        match self {
            Excitation::Point(point) => Ok((Structure::new(machine, response, point, rods)?, None)),
            Excitation::Command => ClosedLoop::new(machine, source, response, rods)
                .map(|(structure, closed)| (structure, Some(closed))),
        }
    }

    /// Returns the name that a measurement gives it.
    pub fn name(self, machine: &Machine) -> &str {
        match self {
            Excitation::Point(point) => &machine.points[point].name,
            Excitation::Command => COMMAND,
        }
    }
}

/// Returns whether each parameter belongs to the loops and FRFs depend on it: none where no FRF has the
/// command as its excitation.
pub(crate) fn loop_parameters(machine: &Machine, set: &MeasurementSet, frfs: &[usize]) -> Vec<bool> {
    let command = |index: &usize| {
        matches!(Excitation::named(machine, "", &set.frfs[*index].excitation), Ok(Excitation::Command))
    };
    if frfs.iter().any(command) {
        machine.closed_loop_parameters()
    } else {
        vec![false; machine.parameters.len()]
    }
}

fn require_drive<'m>(machine: &'m Machine, source: &str) -> Result<&'m Drive, ObjectiveError> {
    machine.drive.as_ref().ok_or_else(|| {
        ObjectiveError::Data(format!(
            "{source}: excitation = \"{COMMAND}\" is a closed-loop FRF, but the machine has no loops; describe them as [drive], or name the point \
             that was struck"
        ))
    })
}

/// The parts of a machine that a closed-loop FRF needs beside the receptance from the driven point to the
/// response.
pub(super) struct ClosedLoop {
    /// Points (index) that the loops read, and their receptances under a force on the driven point.
    encoders: Vec<(usize, Arc<Structure>)>,
    /// Reading of the response per unit of its coordinate: lead/2π for a rotation in a drive that positions
    /// in m, else 1.
    travel: f64,
}

/// Working memory of the receptances of the encoders.
pub(super) struct EncoderScratch {
    pub(super) network: AssembledModel,
    pub(super) work: Workspace,
    pub(super) row: Vec<Complexes>,
}

impl ClosedLoop {
    /// Compiles the receptances from the driven point to the response, and to the encoders.
    ///
    /// # Errors  the machine has no loops; a point is fixed.
    pub(super) fn new(
        machine: &Machine,
        source: &str,
        response: usize,
        rods: RodModel,
    ) -> Result<(Structure, Self), ObjectiveError> {
        let drive = require_drive(machine, source)?;
        let mut points = vec![drive.position.encoder.at, drive.velocity.encoder.at, drive.on];
        points.sort_unstable();
        points.dedup();
        let encoders =
            points.into_iter().map(|at| Ok((at, Arc::new(Structure::new(machine, at, drive.on, rods)?))));
        let encoders = encoders.collect::<Result<_, ObjectiveError>>()?;
        let travel = if machine.points[response].motion == PointMotion::Rotation {
            drive.position.encoder.travel
        } else {
            1.0
        };
        Ok((Structure::new(machine, response, drive.on, rods)?, ClosedLoop { encoders, travel }))
    }

    /// Checks that frequencies (Hz) lie below half the sampling rate of the loops.
    ///
    /// # Errors  one lies above it.
    pub(super) fn check(machine: &Machine, source: &str, highest_hz: f64) -> Result<(), ObjectiveError> {
        let period_s = require_drive(machine, source)?.position.period_s;
        let limit_hz = 0.5 / period_s;
        if highest_hz > limit_hz {
            return Err(ObjectiveError::Data(format!(
                "{source}: has lines up to {highest_hz} Hz, but closed-loop FRFs are predicted up to {limit_hz} Hz, half the sampling rate of the \
                 position loop (drive.position.period_s = {period_s}); restrict the frequency band (band)"
            )));
        }
        Ok(())
    }

    pub(super) fn scratch(&self) -> Vec<EncoderScratch> {
        let of = |(_, structure): &(usize, Arc<Structure>)| EncoderScratch {
            network: structure.empty_model(),
            work: structure.workspace(),
            row: Vec::new(),
        };
        self.encoders.iter().map(of).collect()
    }

    /// Computes the closed-loop response of one group of frequencies.
    fn follow(
        &self,
        servo: &ServoImpedance,
        omega_rad_s: Reals,
        response: Complexes,
        encoders: &[Complexes],
    ) -> Complexes {
        let (omegas, response) = (omega_rad_s.to_array(), response.lanes());
        Complexes::each(|lane| {
            let open = |point| self.encoder(point).map_or(Complex64::ZERO, |at| encoders[at].lanes()[lane]);
            servo.follow(omegas[lane], response[lane] * self.travel, open)
        })
    }

    fn encoder(&self, point: usize) -> Option<usize> {
        self.encoders.iter().position(|(at, _)| *at == point)
    }
}

/// The loops of one evaluation.
pub(super) struct Loops<'o> {
    closed: &'o ClosedLoop,
    servo: ServoImpedance,
    /// Columns of parameters of the drive: step, and the loops below and above.
    by_drive: Vec<(usize, f64, [ServoImpedance; 2])>,
}

/// A machine with values at an operating condition, and the parameters on which its drive depends.
pub(super) struct Evaluation<'e> {
    pub(super) machine: &'e Machine,
    pub(super) of_drive: &'e [bool],
    pub(super) values: &'e ParameterValues,
    pub(super) operating: Operating,
}

impl<'o> Loops<'o> {
    /// Computes the impedance of the loops, and updates the receptances of their encoders; `None` for an FRF
    /// of force.
    ///
    /// `columns` holds the column of each free parameter, for derivatives.
    pub(super) fn new(
        closed: Option<&'o ClosedLoop>,
        at: &Evaluation<'_>,
        encoders: &mut [EncoderScratch],
        columns: &[Option<usize>],
    ) -> Option<Self> {
        let closed = closed?;
        let servo = |values: &[f64]| ServoImpedance::new(at.machine, values, &at.operating).ok();
        for of in encoders {
            of.network.update(at.machine, at.values, &at.operating);
        }
        let by_drive = columns.iter().enumerate().filter_map(|(parameter, column)| {
            let column = (*column).filter(|_| at.of_drive[parameter])?;
            let (value, of) = (at.values[parameter], &at.machine.parameters[parameter]);
            let step = STEP * if value == 0.0 { of.upper - of.lower } else { value.abs() };
            let shifted = |by: f64| {
                let mut values = at.values.clone();
                values[parameter] += by;
                servo(&values)
            };
            Some((column, 2.0 * step, [shifted(-step)?, shifted(step)?]))
        });
        Some(Loops { closed, servo: servo(at.values)?, by_drive: by_drive.collect() })
    }

    /// Returns the closed-loop responses on some groups of a frequency grid from the receptances of the
    /// response, in `followed`.
    pub(super) fn close<'f>(
        &self,
        grid: &FrequencyGrid,
        groups: std::ops::Range<usize>,
        encoders: &mut [EncoderScratch],
        response: &[Complexes],
        followed: &'f mut [Complexes; ABREAST],
    ) -> &'f [Complexes] {
        let omegas = &grid.omega_rad_s()[groups.clone()];
        let open: Vec<Vec<Complexes>> = encoders
            .iter_mut()
            .map(|of| of.network.receptances_on(grid, groups.clone(), &mut of.work).to_vec())
            .collect();
        for (w, ((followed, response), omega)) in followed.iter_mut().zip(response).zip(omegas).enumerate() {
            let here: Vec<Complexes> = open.iter().map(|of| of[w]).collect();
            *followed = self.closed.follow(&self.servo, *omega, *response, &here);
        }
        &followed[..omegas.len()]
    }

    /// As [`Loops::close`], also of the derivatives: those of the receptances, column c of group w at
    /// c·groups + w, become those of the closed loop.
    ///
    /// ```text
    /// T = W·H_r/N,  N = 1 + Σ Z_a·H_a,        dT = T·(dH_r/H_r − Σ (Z_a/N)·dH_a)
    /// ```
    ///
    /// Parameters of the drive are differenced.
    pub(super) fn close_with_slopes(
        &self,
        omegas: &[Reals],
        encoders: &[EncoderScratch],
        open: &[Vec<Complexes>],
        response: &mut [Complexes],
        row: &mut [Complexes],
    ) {
        let abreast = omegas.len();
        for (w, omega) in omegas.iter().enumerate() {
            let here: Vec<Complexes> = open.iter().map(|of| of[w]).collect();
            let receptance = response[w];
            let followed = self.closed.follow(&self.servo, *omega, receptance, &here);
            let (by_response, shares) = (receptance.inverse(), self.shares(*omega, &here));
            for (column, slope) in row[w..].iter_mut().step_by(abreast).enumerate() {
                let by_encoders =
                    encoders.iter().zip(&shares).map(|(of, share)| of.row[column * abreast + w] * *share);
                *slope = by_encoders.fold(*slope * by_response, |sum, by| sum - by) * followed;
            }
            for (column, width, sides) in &self.by_drive {
                let [low, high] =
                    sides.each_ref().map(|servo| self.closed.follow(servo, *omega, receptance, &here));
                row[column * abreast + w] += (high - low) * (1.0 / width);
            }
            response[w] = followed;
        }
    }

    /// Returns Z_a/N of each encoder for one group of frequencies.
    fn shares(&self, omega_rad_s: Reals, open: &[Complexes]) -> Vec<Complexes> {
        let mut shares = vec![[Complex64::ZERO; LANES]; open.len()];
        for (lane, omega) in omega_rad_s.to_array().into_iter().enumerate() {
            let mut denominator = Complex64::ONE;
            for (point, z) in self.servo.stiffness(omega) {
                if let Some(at) = self.closed.encoder(point) {
                    denominator += z * open[at].lanes()[lane];
                    shares[at][lane] += z;
                }
            }
            shares.iter_mut().for_each(|share| share[lane] /= denominator);
        }
        shares.into_iter().map(|share| Complexes::each(|lane| share[lane])).collect()
    }
}

/// Computes the receptances of the encoders at some frequencies, and their derivatives in the scratch.
pub(super) fn encoder_gradients(
    encoders: &mut [EncoderScratch],
    at: Frequencies<'_>,
    sensitivities: &[Sensitivity],
    dimension: usize,
) -> Vec<Vec<Complexes>> {
    let of = |(of, sensitivity): (&mut EncoderScratch, &Sensitivity)| {
        of.row.clear();
        of.row.resize(dimension * at.groups(), Complexes::ZERO);
        of.network.gradient(at, sensitivity, &mut of.work, &mut of.row).to_vec()
    };
    encoders.iter_mut().zip(sensitivities).map(of).collect()
}

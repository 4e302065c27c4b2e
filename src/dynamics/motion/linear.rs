//! The loops of a drive as a linear map between samples of the position loop, computed without simulation.

use std::f64::consts::TAU;

use nalgebra::{Complex, DMatrix, DVector, RowDVector, Schur};

use super::plant::Plant;
use super::run::periods;
use super::{MotionError, SimulationSettings};
use machine::{Drive, Friction, LeadError, Machine, Tachometry, Value, Wave};

/// A linear model of a drive with its machine: friction slides without a level, backlash is closed, no
/// rounding and no limits.
///
/// Each sample of the position loop maps the state z and the command r to z⁺ = A·z + B·r. The state holds
/// coordinates, rates, currents, integrals, readings and delayed outputs. At each sample of the velocity loop
/// in between, the output is C_j·z + D_j·r.
///
/// # Source  Franklin, Powell and Workman, Digital Control of Dynamic Systems (1998), section 11.1 (loops of
///   several rates, lifted to the
///   slowest)
#[derive(Debug, Clone)]
pub struct LinearLoops {
    a: DMatrix<f64>,
    b: DVector<f64>,
    /// Rows on (z, r) at each sample of the velocity loop: coordinates, then the reading of the position
    /// encoder.
    outputs: Vec<DMatrix<f64>>,
    /// Rows of the coordinates at each sample of the innermost loop.
    coordinates: Vec<DMatrix<f64>>,
    /// Period of the position loop (s).
    pub period_s: f64,
    /// Names of the coordinates.
    pub names: Vec<String>,
    mass: Vec<f64>,
    /// Eigenvalues of A.
    eigenvalues: Vec<Complex<f64>>,
}

/// Largest number of states: the eigenvalues take a tenth of a second with 200, and grow with the third
/// power.
const MOST_STATES: usize = 200;
/// Largest number of sweeps for the eigenvalues; well-scaled matrices need about three per state.
const MOST_SWEEPS: usize = 100 * MOST_STATES;

/// A pole of the closed loops.
#[derive(Debug, Clone, PartialEq)]
pub struct Pole {
    /// Frequency (Hz).
    pub frequency_hz: f64,
    /// Growth exponent (1/s); positive if the pole is unstable.
    pub growth_per_s: f64,
    /// Point with the largest share of the kinetic energy.
    pub point: String,
}

impl Pole {
    /// Returns the damping ratio, negative for an unstable pole.
    pub fn damping_ratio(&self) -> f64 {
        -self.growth_per_s / self.growth_per_s.hypot(TAU * self.frequency_hz)
    }
}

/// Returns the machine without its nonlinearities: friction, backlash, periodic lead error, ripple.
pub fn smooth(machine: &Machine) -> Machine {
    let mut smooth = machine.clone();
    for joint in &mut smooth.joints {
        joint.friction = Friction::default();
        joint.gap = Value::number(0.0);
        joint.lead_error = LeadError { wave: Wave::default(), ..joint.lead_error.clone() };
    }
    if let Some(drive) = &mut smooth.drive {
        drive.ripple = Wave::default();
    }
    smooth
}

/// Rows over (z, r): each signal as a linear combination of state and command at the last sample of the
/// position loop.
struct Rows {
    plant: DMatrix<f64>,
    speed: RowDVector<f64>,
    currents: RowDVector<f64>,
    readings: Vec<RowDVector<f64>>,
    inputs: Vec<RowDVector<f64>>,
    command: RowDVector<f64>,
    rate: RowDVector<f64>,
}

impl Rows {
    /// Stacks all rows of z in order.
    fn stacked(&self) -> DMatrix<f64> {
        let rest = [&self.speed, &self.currents, &self.command, &self.rate];
        let rows: Vec<&RowDVector<f64>> =
            rest.into_iter().chain(&self.readings).chain(&self.inputs).collect();
        let columns = self.plant.ncols();
        let mut all = DMatrix::zeros(self.plant.nrows() + rows.len(), columns);
        all.rows_mut(0, self.plant.nrows()).copy_from(&self.plant);
        rows.iter().enumerate().for_each(|(at, row)| all.row_mut(self.plant.nrows() + at).copy_from(row));
        all
    }

    /// Creates the identity for z, with r as the last column.
    fn unit(plant: usize, readings: usize, inputs: usize) -> Self {
        let count = plant + 4 + readings + inputs;
        let one = |at: usize| RowDVector::from_fn(count + 1, |_, j| f64::from(u8::from(at == j)));
        Rows {
            plant: DMatrix::from_fn(plant, count + 1, |i, j| f64::from(u8::from(i == j))),
            speed: one(plant),
            currents: one(plant + 1),
            command: one(plant + 2),
            rate: one(plant + 3),
            readings: (0..readings).map(|i| one(plant + 4 + i)).collect(),
            inputs: (0..inputs).map(|i| one(plant + 4 + readings + i)).collect(),
        }
    }

    /// Returns the row of a state of the plant.
    fn of(&self, state: usize) -> RowDVector<f64> {
        self.plant.row(state).into_owned()
    }

    /// Returns the velocity that the velocity loop reads, and keeps its reading of the encoder.
    fn next_velocity(&mut self, drive: &Drive, plant: &Plant) -> RowDVector<f64> {
        match drive.velocity.tachometry {
            Tachometry::Direct => self.of(plant.size + plant.velocity.at) * plant.velocity.travel,
            Tachometry::Difference(periods) => {
                let now = self.of(plant.velocity.at) * plant.velocity.travel;
                self.readings.push(now.clone());
                (now - self.readings.remove(0)) / (periods as f64 * drive.velocity.period_s)
            }
        }
    }
}

/// Builds ẋ = A·x + B·u of the plant: coordinates, rates, relaxing forces and the current along q.
fn equations(plant: &Plant) -> (DMatrix<f64>, DVector<f64>) {
    let (n, s) = (plant.size, plant.states);
    let mut a = DMatrix::zeros(s, s);
    let mut b = DVector::zeros(s);
    for i in 0..n {
        a[(i, n + i)] = 1.0;
        for j in 0..n {
            a[(n + i, j)] = -plant.stiffness[i * n + j] / plant.mass[i];
            a[(n + i, n + j)] = -plant.damping[i * n + j] / plant.mass[i];
        }
    }
    for relaxing in &plant.relaxing {
        a[(relaxing.at, relaxing.at)] = -relaxing.stiffness / relaxing.damping;
        for &(j, c) in &relaxing.along {
            a[(n + j, relaxing.at)] -= c / plant.mass[j];
            a[(relaxing.at, n + j)] += c * relaxing.stiffness;
        }
    }
    let driven = n + plant.drive;
    match &plant.winding {
        None => b[driven] = 1.0 / plant.mass[plant.drive],
        Some(w) => {
            a[(driven, w.q)] = w.constant / plant.mass[plant.drive];
            a[(w.q, w.q)] = -w.resistance / w.inductance_q;
            a[(w.q, driven)] = -w.induced() / w.inductance_q;
            b[w.q] = 1.0 / w.inductance_q;
            if let Some(d) = w.d {
                a[(d, d)] = -w.resistance / w.inductance_d;
            }
        }
    }
    (a, b)
}

/// Computes Φ and the input column for a constant input over a time; `None` if they overflow.
fn zero_order_hold(a: &DMatrix<f64>, b: &DVector<f64>, time_s: f64) -> Option<(DMatrix<f64>, DVector<f64>)> {
    let s = a.nrows();
    let mut whole = DMatrix::zeros(s + 1, s + 1);
    whole.view_mut((0, 0), (s, s)).copy_from(&(a * time_s));
    whole.view_mut((0, s), (s, 1)).copy_from(&(b * time_s));
    // The exponential is scaled by the logarithm of its norm, which has to be a number.
    let norm: f64 = whole.iter().map(|x| x.abs()).sum();
    let exp = norm.is_finite().then(|| whole.exp())?;
    Some((exp.view((0, 0), (s, s)).into(), exp.view((0, s), (s, 1)).column(0).into()))
}

/// Refuses loops with more states than those of which poles are computed.
fn too_many_states(states: usize, delayed: usize, readings: usize) -> MotionError {
    MotionError::Input(format!(
        "the loops have {states} states, {delayed} of them for drive.delay_s and {readings} for drive.velocity.over_s, more than the {MOST_STATES} for \
         which poles are computed; shorten these times"
    ))
}

impl LinearLoops {
    /// Builds the loops of a machine with the given parameters.
    ///
    /// # Errors  as [`super::simulate`] where plant and drive do not fit together; too many delayed samples;
    ///   poles that cannot be computed.
    pub fn new(
        machine: &Machine,
        values: &[f64],
        settings: &SimulationSettings,
    ) -> Result<Self, MotionError> {
        let smooth = smooth(machine);
        let drive = smooth.drive.as_ref().ok_or(MotionError::NoDrive)?;
        let plant = Plant::new(&smooth, values, settings)?;
        let at = |value: &Value| value.at(values, &settings.operating);
        let times = |outer: f64, inner: f64| ((outer / inner).round() as usize).max(1);
        let (velocity_s, position_s) = (drive.velocity.period_s, drive.position.period_s);
        let in_velocity = times(velocity_s, drive.period_s());
        let in_position = in_velocity * times(position_s, velocity_s);
        let tick_s = position_s / in_position as f64;
        let (a, b) = equations(&plant);
        let delay = periods(at(&drive.delay_s), tick_s);
        let whole_delay = delay.floor() as usize;
        let delay_rest_s = delay.fract() * tick_s;
        let unsolved = || {
            MotionError::Input("the poles of the loops cannot be computed: their gains and times differ by too much; check them".into())
        };
        let held = |time_s: f64| zero_order_hold(&a, &b, time_s).ok_or_else(unsolved);
        let (before, after) = (held(delay_rest_s)?, held(tick_s - delay_rest_s)?);
        let readings = match drive.velocity.tachometry {
            Tachometry::Difference(periods) => periods,
            Tachometry::Direct => 0,
        };
        let states = plant.states + readings + whole_delay;
        if states > MOST_STATES {
            return Err(too_many_states(states, whole_delay, readings));
        }
        let mut rows = Rows::unit(plant.states, readings, whole_delay + 1);
        let columns = rows.plant.ncols();
        let command = RowDVector::from_fn(columns, |_, j| f64::from(u8::from(j + 1 == columns)));
        let (mut outputs, mut coordinates) = (Vec::new(), Vec::new());
        let mut reference = RowDVector::zeros(columns);
        let (mut acceleration, mut signal) = (reference.clone(), reference.clone());
        let scale = input_scale(drive, &at);
        for tick in 0..in_position {
            let position = rows.of(plant.position.at) * plant.position.travel;
            if tick == 0 {
                let rate = (&command - &rows.command) / position_s;
                acceleration =
                    (&rate - &rows.rate) / position_s * at(&drive.velocity.acceleration_feed_forward);
                reference = (&command - &position) * at(&drive.position.gain_per_s)
                    + &rate * at(&drive.position.feed_forward);
                (rows.command, rows.rate) = (command.clone(), rate);
            }
            coordinates.push(rows.plant.rows(0, plant.size).into());
            if tick % in_velocity == 0 {
                let mut output = DMatrix::zeros(plant.size + 1, columns);
                output.rows_mut(0, plant.size).copy_from(&rows.plant.rows(0, plant.size));
                output.row_mut(plant.size).copy_from(&position);
                outputs.push(output);
                let error = &reference - rows.next_velocity(drive, &plant);
                signal = (&error + &rows.speed) * at(&drive.velocity.gain) + &acceleration;
                rows.speed += error * (velocity_s / at(&drive.velocity.integral_time_s));
            }
            let input = match &drive.current {
                None => &signal * scale,
                Some(current) => {
                    let q = plant.winding.map_or(0, |w| w.q);
                    let error = &signal - rows.of(q);
                    let given = (&error + &rows.currents) * at(&current.gain);
                    rows.currents += error * (tick_s / at(&current.integral_time_s));
                    given
                }
            };
            rows.inputs.insert(0, input);
            let (old, new) = (rows.inputs[whole_delay + 1].clone(), rows.inputs[whole_delay].clone());
            rows.inputs.truncate(whole_delay + 1);
            let halfway = &before.0 * &rows.plant + &before.1 * old;
            rows.plant = &after.0 * halfway + &after.1 * new;
        }
        // An integral with infinite time constant is no state.
        if at(&drive.velocity.integral_time_s).is_infinite() {
            rows.speed.fill(0.0);
        }
        if drive.current.as_ref().is_none_or(|c| at(&c.integral_time_s).is_infinite()) {
            rows.currents.fill(0.0);
        }
        let all = rows.stacked();
        let count = all.nrows();
        let a: DMatrix<f64> = all.columns(0, count).into();
        let finite = a.iter().all(|x| x.is_finite()).then(|| a.clone());
        let schur = finite.and_then(|a| Schur::try_new(a, f64::EPSILON, MOST_SWEEPS)).ok_or_else(unsolved)?;
        Ok(LinearLoops {
            a,
            eigenvalues: schur.complex_eigenvalues().iter().copied().collect(),
            b: all.column(count).into(),
            outputs,
            coordinates,
            period_s: position_s,
            names: plant.names.clone(),
            mass: plant.mass.clone(),
        })
    }

    /// Computes the response to a command that is a sine at the samples of the position loop. It is the
    /// component of the output at the sine's frequency, sampled by the velocity loop. The output is a
    /// coordinate, or the reading of the position encoder.
    ///
    /// # Units      Hz; output per unit of command
    pub fn response(&self, frequency_hz: f64, coordinate: Option<usize>) -> Complex<f64> {
        let count = self.a.nrows();
        let advance = Complex::from_polar(1.0, TAU * frequency_hz * self.period_s);
        let system = DMatrix::from_fn(count, count, |i, j| {
            if i == j { advance - self.a[(i, j)] } else { Complex::from(-self.a[(i, j)]) }
        });
        let right = self.b.map(Complex::from);
        let Some(z) = system.lu().solve(&right) else { return Complex::new(f64::NAN, f64::NAN) };
        let row = coordinate.unwrap_or(self.names.len());
        let samples = self.outputs.len() as f64;
        let at = |(j, output): (usize, &DMatrix<f64>)| {
            let value: Complex<f64> =
                (0..count).map(|i| z[i] * output[(row, i)]).sum::<Complex<f64>>() + output[(row, count)];
            value
                * Complex::from_polar(1.0 / samples, -TAU * frequency_hz * self.period_s * j as f64 / samples)
        };
        self.outputs.iter().enumerate().map(at).sum()
    }

    /// Computes the oscillating and the unstable poles of the closed loops, the fastest growing first.
    pub fn poles(&self) -> Vec<Pole> {
        let values = self.eigenvalues.iter().filter(|l| l.im >= 0.0 && l.norm() > 1e-9);
        let mut poles: Vec<Pole> = values.filter_map(|l| self.pole(*l)).collect();
        poles.sort_by(|a, b| b.growth_per_s.total_cmp(&a.growth_per_s));
        poles
    }

    /// Returns the fastest growing unstable pole.
    pub fn unstable(&self) -> Option<Pole> {
        let growing = self.eigenvalues.iter().filter(|l| l.im >= 0.0 && l.norm().ln() > 1e-6);
        growing.max_by(|a, b| a.norm().total_cmp(&b.norm())).and_then(|l| self.pole(*l))
    }

    /// Computes frequency and location of a pole. Its value leaves whole turns of phase within a period open;
    /// they are counted between samples of the innermost loop.
    fn pole(&self, value: Complex<f64>) -> Option<Pole> {
        let count = self.a.nrows();
        // Inverse iteration close to the value.
        let near = value * (1.0 + 1e-7) + Complex::new(1e-12, 1e-12);
        let system = DMatrix::from_fn(count, count, |i, j| {
            Complex::from(self.a[(i, j)]) - if i == j { near } else { Complex::from(0.0) }
        });
        let lu = system.lu();
        let mut z = DVector::from_fn(count, |i, _| Complex::new(1.0, 0.1 * i as f64 / count as f64));
        for _ in 0..3 {
            z = lu.solve(&z)?;
            let size = z.norm();
            if !(size > 0.0 && size.is_finite()) {
                return None;
            }
            z /= Complex::from(size);
        }
        let moves: Vec<Vec<Complex<f64>>> = self
            .coordinates
            .iter()
            .map(|rows| {
                (0..rows.nrows()).map(|row| (0..count).map(|i| z[i] * rows[(row, i)]).sum()).collect()
            })
            .collect();
        let energy = |i: usize| self.mass[i] * moves[0][i].norm_sqr();
        let largest = (0..self.names.len()).max_by(|a, b| energy(*a).total_cmp(&energy(*b)))?;
        let path: Vec<Complex<f64>> =
            moves.iter().map(|m| m[largest]).chain([moves[0][largest] * value]).collect();
        let phase_advance: f64 = path.windows(2).map(|w| (w[1] / w[0]).arg()).sum();
        Some(Pole {
            frequency_hz: phase_advance.abs() / (TAU * self.period_s),
            growth_per_s: value.norm().ln() / self.period_s,
            point: self.names[largest].clone(),
        })
    }
}

/// Returns the plant's input per unit of the velocity loop's output without a current loop: force or voltage.
fn input_scale(drive: &Drive, at: &impl Fn(&Value) -> f64) -> f64 {
    if drive.motor.is_some() { 1.0 } else { at(&drive.constant) * at(&drive.force_factor) }
}

//! One step of a plant in one mode: exact for a linear mode, with a parabola for the nonlinear forces
//! otherwise.

use std::collections::HashMap;

use super::force_element::{Input, combine};
use super::plant::Plant;
use super::state::{ContactMode, StatePart};
use super::state_transition::{Square, StateTransition, add_columns, add_product, columns};

/// Iterations after which the step is too long.
const ITERATIONS: usize = 12;

/// Change of a state in one iteration, relative to its scale, below which the parabola has converged.
const CONVERGED: f64 = 1e-10;

/// Linear equations of a mode, ẏ = A·y + constant + drive·input, and the constraints of its sticking
/// frictions.
#[derive(Debug, Clone)]
struct Equations {
    a: Vec<f64>,
    constant: Vec<f64>,
    drive: [Vec<f64>; 2],
    /// Sticking frictions, and the rows that give the holding force of each from the forces on the
    /// coordinates.
    sticking: Vec<usize>,
    holding: Vec<f64>,
    /// Steps by unit and level: [`step_index`].
    steps: Vec<Option<Step>>,
}

#[derive(Debug, Clone)]
struct Step {
    /// Φ and P₁, P₂, P₃ by columns.
    phi: Square,
    forced: [Square; 3],
    constant: Vec<f64>,
    drive: [Vec<f64>; 2],
}

/// Number of levels stored per unit.
const LEVELS: usize = 40;

fn step_index(unit: u8, level: u8) -> usize {
    usize::from(unit) * LEVELS + usize::from(level)
}

/// A plant with the equations of every mode that has occurred.
#[derive(Debug)]
pub struct Stepper {
    pub plant: Plant,
    modes: HashMap<ContactMode, usize>,
    equations: Vec<Equations>,
    /// Lengths (s) of the units whose halvings are the steps.
    pub units_s: Vec<f64>,
    linear: bool,
    force: Vec<f64>,
    scratch: [Vec<f64>; 8],
    pub half: Vec<f64>,
    pub end: Vec<f64>,
}

impl Stepper {
    pub fn new(plant: Plant, units_s: Vec<f64>) -> Self {
        let (n, s) = (plant.size, plant.states);
        Stepper {
            linear: plant.is_linear(),
            modes: HashMap::new(),
            equations: Vec::new(),
            units_s,
            force: vec![0.0; n],
            scratch: std::array::from_fn(|_| vec![0.0; s]),
            half: vec![0.0; s],
            end: vec![0.0; s],
            plant,
        }
    }

    /// Returns the index of a mode's equations and creates them if necessary.
    pub fn mode(&mut self, mode: &ContactMode) -> usize {
        if let Some(at) = self.modes.get(mode) {
            return *at;
        }
        let equations = self.equations_of(mode);
        self.equations.push(equations);
        self.modes.insert(mode.clone(), self.equations.len() - 1);
        self.equations.len() - 1
    }

    fn equations_of(&self, mode: &ContactMode) -> Equations {
        let (n, s) = (self.plant.size, self.plant.states);
        let sticking: Vec<usize> = (0..mode.frictions.len())
            .filter(|i| mode.frictions[*i] == 0 && self.plant.frictions[*i].bristle.is_none())
            .collect();
        let mut equations = Equations {
            a: vec![0.0; s * s],
            constant: Vec::new(),
            drive: [Vec::new(), Vec::new()],
            holding: self.holding(&sticking),
            sticking,
            steps: Vec::new(),
        };
        let mut force = vec![0.0; n];
        let mut at = |y: &[f64], input: Input| {
            let mut rate = vec![0.0; s];
            self.rate_of(&equations, mode, y, input, StatePart::Linear, &mut force, &mut rate);
            rate
        };
        let mut y = vec![0.0; s];
        let constant = at(&y, [0.0; 2]);
        let drive = [[1.0, 0.0], [0.0, 1.0]]
            .map(|one| at(&y, one).iter().zip(&constant).map(|(a, b)| a - b).collect());
        let mut a = vec![0.0; s * s];
        for j in 0..s {
            y[j] = 1.0;
            for (i, (x, c)) in at(&y, [0.0; 2]).iter().zip(&constant).enumerate() {
                a[i * s + j] = x - c;
            }
            y[j] = 0.0;
        }
        (equations.a, equations.constant, equations.drive) = (a, constant, drive);
        equations
    }

    /// Computes −(C·M⁻¹·Cᵀ)⁻¹·C·M⁻¹, which maps the forces on the coordinates to the holding forces.
    fn holding(&self, sticking: &[usize]) -> Vec<f64> {
        let (n, m) = (self.plant.size, sticking.len());
        if m == 0 {
            return Vec::new();
        }
        let row = |i: usize| {
            let mut row = vec![0.0; n];
            self.plant.frictions[sticking[i]].along.iter().for_each(|&(j, c)| row[j] = c);
            row
        };
        let rows: Vec<Vec<f64>> = (0..m).map(row).collect();
        let inverse = |j: usize| 1.0 / self.plant.mass[j];
        let gram = nalgebra::DMatrix::from_fn(m, m, |a, b| {
            (0..n).map(|j| rows[a][j] * inverse(j) * rows[b][j]).sum()
        });
        let right = nalgebra::DMatrix::from_fn(m, n, |a, j| -rows[a][j] * inverse(j));
        // The matrix is regular, since no two frictions act on the same motion.
        let solved = gram.clone().lu().solve(&right).unwrap_or(right);
        solved.transpose().as_slice().to_vec()
    }

    /// Computes ẏ of a mode.
    #[expect(clippy::too_many_arguments, reason = "state, mode and buffers of the result")]
    fn rate_of(
        &self,
        equations: &Equations,
        mode: &ContactMode,
        y: &[f64],
        input: Input,
        part: StatePart,
        force: &mut [f64],
        rate: &mut [f64],
    ) {
        let n = self.plant.size;
        self.plant.forces(mode, y, input, part, force, rate);
        if !equations.sticking.is_empty() {
            let rows = equations.holding.chunks_exact(n.max(1));
            let holding: Vec<f64> =
                rows.map(|row| row.iter().zip(force.iter()).map(|(r, f)| r * f).sum()).collect();
            for (at, holding) in equations.sticking.iter().zip(holding) {
                self.plant.frictions[*at].along.iter().for_each(|&(j, c)| force[j] += c * holding);
            }
        }
        for i in 0..n {
            rate[i] = if part == StatePart::Nonlinear { 0.0 } else { y[n + i] };
            rate[n + i] = force[i] / self.plant.mass[i];
        }
    }

    /// Computes the holding force of each sticking friction.
    pub fn sticking_forces(
        &mut self,
        number: usize,
        mode: &ContactMode,
        y: &[f64],
        input: Input,
    ) -> Vec<(usize, f64)> {
        if self.equations[number].sticking.is_empty() {
            return Vec::new();
        }
        let (force, rate) = (&mut self.force, &mut self.scratch[0]);
        self.plant.forces(mode, y, input, StatePart::All, force, rate);
        let equations = &self.equations[number];
        let rows = equations.holding.chunks_exact(self.plant.size.max(1));
        let holding = rows.map(|row| -row.iter().zip(&*force).map(|(r, f)| r * f).sum::<f64>());
        equations.sticking.iter().copied().zip(holding).collect()
    }

    /// Removes the rates of sticking frictions from a state.
    pub fn stop_sticking(&mut self, number: usize, y: &mut [f64]) {
        let n = self.plant.size;
        let momentum: Vec<f64> = (0..n).map(|i| self.plant.mass[i] * y[n + i]).collect();
        let equations = &self.equations[number];
        for (at, row) in equations.sticking.iter().zip(equations.holding.chunks_exact(n.max(1))) {
            let impulse: f64 = row.iter().zip(&momentum).map(|(r, p)| r * p).sum();
            self.plant.frictions[*at]
                .along
                .iter()
                .for_each(|&(j, c)| y[n + j] += c * impulse / self.plant.mass[j]);
        }
    }

    fn prepare(&mut self, number: usize, unit: u8, level: u8) {
        let (s, tau) = (self.plant.states, self.units_s[usize::from(unit)] * 0.5_f64.powi(i32::from(level)));
        let equations = &mut self.equations[number];
        let at = step_index(unit, level);
        if equations.steps.len() <= at {
            equations.steps.resize(at + 1, None);
        }
        if equations.steps[at].is_none() {
            let transition = StateTransition::new(&equations.a, s, tau);
            let by = |x: &[f64]| {
                let mut y = vec![0.0; s];
                add_product(&transition.forced[0], x, &mut y);
                y
            };
            let (constant, drive) =
                (by(&equations.constant), [by(&equations.drive[0]), by(&equations.drive[1])]);
            let forced = transition.forced.each_ref().map(|p| columns(p, s));
            equations.steps[at] = Some(Step { phi: columns(&transition.phi, s), forced, constant, drive });
        }
    }

    /// Steps over 2^−level of a unit; leaves the middle in `half` and the end in `end`. Returns the error
    /// estimate of the parabola relative to `scale`, and the state of the largest error; infinite if it does
    /// not converge.
    pub fn step(
        &mut self,
        number: usize,
        mode: &ContactMode,
        y: &[f64],
        input: Input,
        (unit, level): (u8, u8),
        scale: &[f64],
    ) -> (f64, usize) {
        self.prepare(number, unit, level);
        self.prepare(number, unit, level + 1);
        let equations = &self.equations[number];
        let (Some(whole), Some(part)) =
            (&equations.steps[step_index(unit, level)], &equations.steps[step_index(unit, level + 1)])
        else {
            return (f64::INFINITY, 0);
        };
        let (mut half, mut end) = (std::mem::take(&mut self.half), std::mem::take(&mut self.end));
        let linear_step = |step: &Step, from: &[f64], to: &mut [f64]| {
            let forced = step.drive[0].iter().zip(&step.drive[1]).map(|(a, b)| a * input[0] + b * input[1]);
            to.iter_mut().zip(step.constant.iter().zip(forced)).for_each(|(y, (c, d))| *y = c + d);
            add_columns(&step.phi, from, to);
        };
        linear_step(part, y, &mut half);
        if self.linear {
            linear_step(part, &half, &mut end);
            (self.half, self.end) = (half, end);
            return (0.0, 0);
        }
        linear_step(whole, y, &mut end);
        let tau = self.units_s[usize::from(unit)] * 0.5_f64.powi(i32::from(level));
        let mut force = std::mem::take(&mut self.force);
        let mut scratch = std::mem::take(&mut self.scratch);
        let [start, middle, last, next, f1, f2, base_half, base_end] = &mut scratch;
        let mut nonlinear = |y: &[f64], into: &mut Vec<f64>| {
            self.rate_of(equations, mode, y, input, StatePart::Nonlinear, &mut force, into)
        };
        nonlinear(y, start);
        // The contribution of the initial force stays; the first guess keeps the force constant.
        add_columns(&part.forced[0], start, &mut half);
        add_columns(&whole.forced[0], start, &mut end);
        base_half.copy_from_slice(&half);
        base_end.copy_from_slice(&end);
        let (mut error, mut state) = (f64::INFINITY, 0);
        for _ in 0..ITERATIONS {
            nonlinear(&half, middle);
            nonlinear(&end, last);
            // f = f₀ + f₁·t + f₂·t²/2 through start, middle and last.
            for i in 0..start.len() {
                f1[i] = (4.0 * middle[i] - 3.0 * start[i] - last[i]) / tau;
                f2[i] = 4.0 * (start[i] - 2.0 * middle[i] + last[i]) / (tau * tau);
            }
            let mut moved: f64 = 0.0;
            let largest = |of: &mut dyn Iterator<Item = f64>| {
                of.enumerate().fold((0.0_f64, 0), |m, (i, x)| if x > m.0 { (x, i) } else { m })
            };
            for (step, base, to) in [(part, &*base_half, &mut half), (whole, &*base_end, &mut end)] {
                next.copy_from_slice(base);
                add_columns(&step.forced[1], f1, next);
                add_columns(&step.forced[2], f2, next);
                let (most, at) =
                    largest(&mut next.iter().zip(to.iter()).zip(scale).map(|((a, b), s)| (a - b).abs() / s));
                (moved, state) = (moved.max(most), at);
                to.copy_from_slice(next);
            }
            if !moved.is_finite() {
                break;
            }
            if moved < CONVERGED {
                next.fill(0.0);
                add_columns(&whole.forced[2], f2, next);
                (error, state) = largest(&mut next.iter().zip(scale).map(|(x, s)| x.abs() / s));
                break;
            }
        }
        (self.half, self.end, self.force, self.scratch) = (half, end, force, scratch);
        (error, state)
    }

    /// Computes the rate of each sliding friction in its direction of sliding.
    pub fn sliding_rates(&self, mode: &ContactMode, y: &[f64]) -> impl Iterator<Item = (usize, f64)> {
        let sliding =
            self.plant.frictions.iter().zip(&mode.frictions).enumerate().filter(|(_, (_, sign))| **sign != 0);
        sliding.map(|(at, (friction, sign))| {
            (at, f64::from(*sign) * combine(&friction.along, &y[self.plant.size..]))
        })
    }

    /// Computes the margin of each backlash to the end of its mode: depth of contact, or distance to the
    /// nearer side.
    pub fn gap_margins(&self, mode: &ContactMode, y: &[f64]) -> impl Iterator<Item = (usize, f64)> {
        self.plant.gaps.iter().zip(&mode.gaps).enumerate().map(|(at, (gap, side))| {
            let stretch = gap.stretch(&y[..self.plant.size]);
            (at, if *side == 0 { gap.half - stretch.abs() } else { f64::from(*side) * stretch - gap.half })
        })
    }
}

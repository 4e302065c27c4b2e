//! Machines without effects: they differ from their description only within the stated tolerances.

use std::collections::BTreeMap;

use num_complex::Complex64;

use super::channel_set::Quantity;
use super::fit::fitted_of;
use super::record::{Case, Position, Record, Scatter};
use super::subject::axis;
use crate::draw::Draw;
use crate::hammer::series::Line;
use crate::machine::assembly::Assembly;
use crate::machine::catalogue::{Dimensions, DrawnMachine, bench, round_to, sized};
use crate::machine::nuisance::{Nuisance, Spread};
use crate::machine::number::Machine;
use crate::machine::point::{Channel, Point};
use crate::{Result, SimulatorError};

/// Frequency (Hz) and amplitude of each peak at one position.
pub type Peaks = Vec<(f64, f64)>;

/// A machine without effects, with six measured FRFs and their true values.
#[derive(Clone, Debug, PartialEq)]
pub struct Ordinary {
    /// Published case.
    pub case: Case,
    /// True joint values by parameter; stiffnesses at 100 Hz.
    pub truth: BTreeMap<String, f64>,
    /// Size class: `short`, `bench` or `gantry`.
    pub size: &'static str,
    /// Share of dispersion of the losses.
    pub loss_dispersion: f64,
    /// Damping of the guide over the table mass, 1/s; 0 without a guide.
    pub guide_per_s: f64,
    /// Peaks of the noise-free FRF at each position, at the nearest line: frequency (Hz) and amplitude.
    pub peaks: Vec<Peaks>,
    /// Noise-free receptances of the machine at each position, without gain and delay of the measurement.
    pub noise_free: Vec<Vec<Complex64>>,
    /// Peaks of these receptances between the lines: frequency (Hz) and amplitude.
    pub natural: Vec<Peaks>,
    /// Line spacing (Hz).
    pub step_hz: f64,
}

/// Branch of the random numbers of a second measurement.
const AGAIN: u64 = 7;
/// Lines of each FRF.
const LINES: usize = 1300;
/// Number of averaged blows.
const AVERAGES: usize = 8;
/// Relative noise of a line, and noise floor over the median level of the mobility.
const NOISE: (f64, f64) = (0.011, 0.004);

/// Generates the machine without effects of a seed and number. Sizes and kinds of losses alternate with the
/// number.
///
/// # Errors  As the receptances of [`Assembly`].
pub fn ordinary(seed: u64, number: usize) -> Result<Ordinary> {
    simulated(seed, number, (false, None))
}

/// Measures the machine of [`ordinary`] again: other noise, nut positions, gain and delay. `nut_stiffness` is
/// the factor by which the stiffness of its nut has changed since.
///
/// # Errors  as [`ordinary`].
pub fn measured_again(seed: u64, number: usize, nut_stiffness: f64) -> Result<Ordinary> {
    simulated(seed, number, (false, Some(nut_stiffness)))
}

/// As [`ordinary`], on a guide with viscous damping that the description lacks: table mass times 0.5 to 5
/// s⁻¹.
///
/// # Errors  As [`ordinary`].
pub fn ordinary_on_guide(seed: u64, number: usize) -> Result<Ordinary> {
    simulated(seed, number, (true, None))
}

/// Generates a machine, perhaps on a guide, and its measurement: the first, or a later one with a factor on
/// the stiffness of the nut.
fn simulated(seed: u64, number: usize, (has_guide, again): (bool, Option<f64>)) -> Result<Ordinary> {
    let draw = &mut Draw::new(seed).branch(number as u64);
    let (size, mut drawn) = match number % 3 {
        0 => {
            let table_kg = round_to(draw.log_between(50.0, 180.0), 2);
            let lead_mm = [5.0, 10.0, 16.0][draw.index(3)];
            ("short", sized(Dimensions { diameter_mm: 32.0, lead_mm, length_m: 1.1, table_kg }, true, draw))
        }
        1 => ("bench", bench(true, draw)),
        _ => {
            let table_kg = round_to(draw.log_between(600.0, 1800.0), 2);
            let lead_mm = [20.0, 40.0][draw.index(2)];
            ("gantry", sized(Dimensions { diameter_mm: 63.0, lead_mm, length_m: 4.2, table_kg }, true, draw))
        }
    };
    let loss_dispersion = match (number / 3) % 3 {
        0 => 0.0,
        1 => 1.0,
        _ => draw.unit(),
    };
    drawn.description.spread = Spread::USUAL;
    let mut nuisance = usual(&drawn, loss_dispersion, draw);
    nuisance.diameter = 0.002 * draw.normal();
    nuisance.joint_losses = std::array::from_fn(|_| (0.01 * draw.normal().exp()).clamp(1e-3, 0.07));
    if has_guide {
        nuisance.guide_per_s = draw.log_between(0.5, 5.0);
    }
    let mut machine = nuisance.applied(drawn.with_true_joints());
    let mut truth = drawn.joints.clone();
    if let Some(factor) = again {
        machine.nut.joint.stiffness *= factor;
        truth.entry("k_n".into()).and_modify(|k| *k *= factor);
        *draw = Draw::new(seed).branch(number as u64).branch(AGAIN);
        nuisance = Nuisance { offsets_m: offsets(&drawn, draw), channels: channels(draw), ..nuisance };
    }
    let truth = nuisance.effective(truth);
    let case = Case {
        name: format!("ordinary-{seed}-{number}"),
        positions: Position::all(&drawn.nut_m),
        description: drawn.description.clone(),
        fit: fitted_of(drawn.nut_m.len()).into_iter().map(Position::name_of).collect(),
        scatter: Scatter::Coherence,
        quantity: Quantity::Receptance,
        averages: AVERAGES,
        records: Vec::new(),
        freeze: Vec::new(),
        follow_up: None,
    };
    let mut ordinary = Ordinary {
        case,
        truth,
        size,
        loss_dispersion,
        guide_per_s: machine.guide_damping_ns_per_m / machine.table_mass_kg,
        peaks: Vec::new(),
        noise_free: Vec::new(),
        natural: Vec::new(),
        step_hz: 0.0,
    };
    ordinary.measure(&drawn, &nuisance, &machine, draw)?;
    Ok(ordinary)
}

/// Draws the nuisance parameters from normal distributions with the spread of the description.
fn usual(drawn: &DrawnMachine, loss_dispersion: f64, draw: &mut Draw) -> Nuisance {
    let Spread { modulus, mass, .. } = Spread::USUAL;
    let diameters = drawn.description.diameter_m / drawn.description.length_m;
    Nuisance {
        youngs: modulus * draw.normal(),
        shear: modulus * draw.normal(),
        screw_loss: draw.log_between(3e-4, 3e-3),
        loss_dispersion,
        left_ratio: draw.between(0.85, 0.95),
        right_ratio: draw.between(0.85, 0.95),
        journal_share: diameters * draw.between(1.0, 2.5),
        turns: draw.between(2.0, 4.0),
        contacts: 3 + draw.index(3),
        skew: draw.within(0.3),
        masses: [mass * draw.normal(), 0.02 * draw.normal(), 0.0, 0.0, 0.0],
        integral_per_s: draw.between(0.0, 2.0),
        offsets_m: offsets(drawn, draw),
        channels: channels(draw),
        ..Nuisance::default()
    }
}

/// Draws how far each nut position lies from the stated one (m).
fn offsets(drawn: &DrawnMachine, draw: &mut Draw) -> Vec<f64> {
    drawn.nut_m.iter().map(|_| Spread::USUAL.nut_m * draw.normal()).collect()
}

/// Draws gain and delay of the channel.
fn channels(draw: &mut Draw) -> BTreeMap<Channel, (f64, f64)> {
    let Spread { gain, delay_s, .. } = Spread::USUAL;
    BTreeMap::from([(Channel::direct(Point::Table), (gain * draw.normal(), delay_s * draw.normal()))])
}

impl Ordinary {
    /// Simulates the table FRFs at all positions. Each line has noise and the coherence of so many blows.
    fn measure(
        &mut self,
        drawn: &DrawnMachine,
        nuisance: &Nuisance,
        machine: &Machine,
        draw: &mut Draw,
    ) -> Result<()> {
        let channel = Channel::direct(Point::Table);
        let (gain, delay_s) = nuisance.channel(channel);
        let lowest_hz = drawn.band_hz / 130.0;
        let step_hz = (drawn.band_hz - lowest_hz) / (LINES - 1) as f64;
        let lines_hz: Vec<f64> = (0..LINES).map(|at| lowest_hz + step_hz * at as f64).collect();
        let lines_s = axis(&lines_hz);
        self.step_hz = lines_hz[1] - lines_hz[0];
        for (at, nut_m) in drawn.nut_m.iter().enumerate() {
            let assembly = Assembly::new(machine, &[], nut_m + nuisance.offsets_m[at], 1.0);
            let mut exact = assembly.structure.receptances(&[assembly.port(channel)], &lines_s)?.remove(0);
            self.noise_free.push(exact.clone());
            self.natural.push(refined(&assembly, channel, &lines_hz, &exact)?);
            exact.iter_mut().zip(&lines_s).for_each(|(h, s)| *h *= (-s * delay_s).exp() * (1.0 + gain));
            self.peaks.push(peaks_of(&lines_hz, &exact));
            let mut levels: Vec<f64> = exact.iter().zip(&lines_s).map(|(h, s)| (h * s).norm()).collect();
            levels.sort_by(f64::total_cmp);
            let floor = NOISE.1 * levels[LINES / 2];
            let lines = exact.iter().zip(&lines_s).zip(&lines_hz).map(|((h, s), hz)| {
                let sd = NOISE.0.hypot(floor / (h * s).norm());
                let noise = Complex64::new(sd * draw.normal(), sd * draw.normal());
                // The coherence follows from a sample variance over the averaged blows.
                let freedom = 2 * (AVERAGES - 1);
                let seen =
                    sd * sd * (0..freedom).map(|_| draw.normal().powi(2)).sum::<f64>() / freedom as f64;
                Line {
                    frequency_hz: *hz,
                    response: h * (1.0 + noise),
                    coherence: 1.0 / (1.0 + 2.0 * AVERAGES as f64 * seen),
                }
            });
            let (position, lines) = (Position::name_of(at), lines.collect());
            self.case.records.push(Record { position, channel, name: None, force_n: None, lines });
        }
        Ok(())
    }
}

/// Refines the peaks of a receptance between the adjacent lines by golden-section search.
fn refined(assembly: &Assembly, channel: Channel, lines_hz: &[f64], exact: &[Complex64]) -> Result<Peaks> {
    let port = [assembly.port(channel)];
    let magnitude = |hz: f64| {
        Ok::<f64, SimulatorError>(assembly.structure.receptances(&port, &axis(&[hz]))?[0][0].norm())
    };
    let step_hz = lines_hz[1] - lines_hz[0];
    let ratio = 0.5 * (5.0_f64.sqrt() - 1.0);
    let mut found = Vec::new();
    for (hz, _) in peaks_of(lines_hz, exact) {
        let (mut low, mut high) = (hz - step_hz, hz + step_hz);
        // Each step leaves 62 % of the interval: 40 steps reach 1e-8 of it.
        for _ in 0..40 {
            let (a, b) = (high - ratio * (high - low), low + ratio * (high - low));
            if magnitude(a)? > magnitude(b)? { high = b } else { low = a }
        }
        let top_hz = 0.5 * (low + high);
        found.push((top_hz, magnitude(top_hz)?));
    }
    Ok(found)
}

/// Least ratio of a peak to the higher of the two adjacent minima.
pub const PROMINENCE: f64 = 1.25;

/// Returns the peaks of sufficient prominence.
fn peaks_of(lines_hz: &[f64], curve: &[Complex64]) -> Peaks {
    let magnitude: Vec<f64> = curve.iter().map(|h| h.norm()).collect();
    let top = |at: &usize| magnitude[*at] > magnitude[at - 1] && magnitude[*at] >= magnitude[at + 1];
    let tops: Vec<usize> = (1..magnitude.len() - 1).filter(top).collect();
    let least = |from: usize, to: usize| magnitude[from..=to].iter().copied().fold(f64::INFINITY, f64::min);
    let stands_out = |at: &usize| {
        let higher = |other: &&usize| magnitude[**other] > magnitude[*at];
        let left = tops.iter().rev().filter(|o| *o < at).find(higher).map_or(0, |o| *o);
        let right = tops.iter().filter(|o| *o > at).find(higher).map_or(magnitude.len() - 1, |o| *o);
        magnitude[*at] >= PROMINENCE * least(left, *at).max(least(*at, right))
    };
    tops.iter().filter(|at| stands_out(at)).map(|at| (lines_hz[*at], magnitude[*at])).collect()
}

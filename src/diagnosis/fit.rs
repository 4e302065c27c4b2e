//! Hypotheses fitted jointly with the nominal parameters and the nuisances.

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::evidence::{Domain, DomainObjective, PartialGap, gaps};
use super::hypothesis::Hypothesis;
use identification::objective::{ObjectiveError, operating};
use identification::{ToleranceEstimate, tolerances_at};
use machine::{OperatingVariable, Parameter};
use measurement::{FitSet, HoldOutSet};
use numeric::halton::halton_point;
use optimizer::{Control, least_squares_within};

/// A fitted hypothesis: a place for each parameter of its machine, and for what belongs to the data (gain, nut positions).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Fitted {
    /// Place of every parameter of the hypothesis's machine in its unit interval.
    pub units: Vec<f64>,
    /// Places of an unknown gain, of nut positions, and of the channels' gains and delays.
    pub tail: Vec<f64>,
    /// Least χ².
    pub chi_square: f64,
    /// Best starts end in the same χ²; false where a search has several ends.
    pub agrees: bool,
}

/// Best starts that are followed down, so many and so many more for each added parameter; how far apart they must be in the unit interval of some
/// parameter, and how far a linear step is believed there.
const FOLLOWED: (usize, usize) = (2, 2);
const ASUNDER: f64 = 0.045;
const PROMISE: f64 = 0.1;
/// Lines of all FRFs on which starts are tried, and most and fewest of one.
const COARSE: (usize, usize, usize) = (800, 40, 80);
/// Steps on few lines and on all.
const COARSE_STEPS: u64 = 40;
const STEPS: u64 = 40;
/// Relative gain of χ² at which a descent ends.
const TOLERANCE: f64 = 1e-4;
/// Starts all over the ranges, and how many of them go on from where a few steps on few lines have led them; so many for each position left out.
pub(super) const SCATTERED: (usize, usize) = (32, 6);
pub(super) const SCATTERED_WITHOUT_ONE: (usize, usize) = (16, 3);
const SCATTER_LINES: (usize, usize, usize) = (300, 16, 60);
const SCATTER_STEPS: u64 = 8;

/// A part of the method that can be left out, to see what it is worth.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Ablation {
    /// Thresholds of χ² tables instead of simulated nulls.
    ChiSquare,
    /// Candidates fitted alone, with the nominal parameters kept where the nominal fit left them.
    FrozenNominal,
    /// Nothing that is ordinarily a little wrong is fitted along.
    NoNuisances,
    /// Candidates ranked by the positions they were fitted to.
    InSample,
}

/// What hypotheses are fitted to.
#[derive(Debug, Clone)]
pub struct Fitter<'s> {
    /// Data to fit.
    pub fit: FitSet<'s>,
    /// FRFs or modes, their weights and band.
    pub domain: Domain,
    /// Parameters that keep their start values.
    pub frozen: Vec<String>,
    /// Parts of the method that are left out.
    pub ablated: Vec<Ablation>,
}

impl<'s> Fitter<'s> {
    /// Lines of one FRF, where so many are looked at in all, and so many of one at least and at most.
    fn lines_of_one(&self, (all, least, most): (usize, usize, usize)) -> usize {
        (all / self.fit.frfs.len().max(1)).clamp(least, most)
    }

    /// Whether a part of the method is left out.
    pub fn lacks(&self, part: Ablation) -> bool {
        self.ablated.contains(&part)
    }

    /// Whether the data to fit were taken under more than one of a circumstance.
    pub fn varies(&self, circumstance: OperatingVariable) -> bool {
        let Domain::Frf(_) = self.domain else { return false };
        let set = self.fit.set;
        let sizes = self.fit.frfs.iter().map(|at| circumstance.size(&operating(set, &set.frfs[*at])));
        let (low, high) = sizes.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| (low.min(x), high.max(x)));
        high - low > 1e-3
    }

    /// The same without what is ordinarily a little wrong: nut positions, gains and delays as they are stated.
    #[must_use]
    pub(super) fn without_nuisances(&self) -> Self {
        let domain = match self.domain {
            Domain::Frf(settings) if self.has_nuisances() => Domain::Frf(settings.as_stated()),
            same => same,
        };
        Fitter { domain, ..self.clone() }
    }

    /// Whether what is ordinarily a little wrong is fitted along: modes are too few for it.
    pub(super) fn has_nuisances(&self) -> bool {
        matches!(self.domain, Domain::Frf(_)) && !self.lacks(Ablation::NoNuisances)
    }

    /// The same for other data of the set.
    #[must_use]
    pub fn on(&self, fit: FitSet<'s>) -> Self {
        Fitter { fit, ..self.clone() }
    }

    /// Positions (or records) that are left out one after another: what is kept, and what is left out.
    pub fn blocks(&self) -> Vec<(FitSet<'s>, FitSet<'s>)> {
        let parts = self.fit.leave_one_out(matches!(self.domain, Domain::Frf(_)));
        parts.into_iter().map(|(kept, left)| (kept, FitSet { set: left.set, positions: left.positions, frfs: left.frfs })).collect()
    }

    /// The objective of a hypothesis. A parameter it releases is not frozen.
    ///
    /// # Errors  as [`DomainObjective::new`].
    pub fn objective<'h>(&self, hypothesis: &'h Hypothesis) -> Result<DomainObjective<'h>, ObjectiveError> {
        let released: Vec<&String> = hypothesis.added.iter().map(|i| &hypothesis.machine.parameters[*i].id).collect();
        let frozen: Vec<String> = self.frozen.iter().filter(|id| !released.contains(id)).cloned().collect();
        DomainObjective::new(hypothesis, &self.fit, self.domain, &frozen)
    }

    /// Follows χ² down from a place.
    pub fn descend(&self, objective: &DomainObjective<'_>, from: &Fitted, steps: u64, control: &Control) -> Fitted {
        self.descend_to(objective, from, (steps, TOLERANCE), control)
    }

    /// The same until a step gains less than this share of χ²: valleys of joints in series are long.
    pub(super) fn descend_to(&self, objective: &DomainObjective<'_>, from: &Fitted, end: (u64, f64), control: &Control) -> Fitted {
        let place = place_of(objective, from);
        let polished = objective.squares(|squares| least_squares_within(squares, &place, &[], end, control.stop()));
        read_back(objective, from, &polished.place, polished.normal.chi_square)
    }

    /// Fits a hypothesis from fits of the nominal machine: amplitudes over their whole range are tried, the best followed down on few lines, and the
    /// best of those on all. Nested: from the first base with the effect at nothing χ² can only fall.
    ///
    /// # Errors  as [`DomainObjective::new`].
    pub fn fit(&self, hypothesis: &Hypothesis, bases: &[Fitted], control: &Control) -> Result<Fitted, ObjectiveError> {
        control.kept_or_failed(&self.piece("fit", hypothesis, bases), || self.fit_anew(hypothesis, bases, control))
    }

    /// The name of a piece of work on these data.
    pub(super) fn piece(&self, what: &str, hypothesis: &Hypothesis, bases: &[Fitted]) -> String {
        format!("{what} {} {:?} {:?} {bases:?}", hypothesis.id, self.fit.positions, self.fit.frfs)
    }

    fn fit_anew(&self, hypothesis: &Hypothesis, bases: &[Fitted], control: &Control) -> Result<Fitted, ObjectiveError> {
        if control.stopped() {
            return Err(ObjectiveError::Data("stopped before its turn".into()));
        }
        let objective = self.objective(hypothesis)?;
        let coarse = objective.coarse(self.lines_of_one(COARSE));
        let few = coarse.as_ref().unwrap_or(&objective);
        let linear = coarse.is_some();
        let mut starts: Vec<(f64, Fitted)> = bases
            .iter()
            .flat_map(|base| amplitudes(hypothesis).into_iter().map(move |added| start_of(hypothesis, base, &added)))
            .map(|start| {
                let place = place_of(few, &start);
                // One linear step where derivatives are cheap; χ² as it is where they are not.
                let cost = few
                    .squares(|squares| if linear { squares.normal(&place).cost_after_step(PROMISE) } else { squares.chi_square(&place) });
                (cost, start)
            })
            .collect();
        let nothing = starts.remove(0).1;
        starts.sort_by(|a, b| a.0.total_cmp(&b.0));
        // Neighbours end in one place.
        let most = FOLLOWED.0 + FOLLOWED.1 * hypothesis.added.len();
        let mut followed: Vec<Fitted> = Vec::new();
        for (_, start) in starts {
            let asunder = |other: &Fitted| other.units.iter().zip(&start.units).any(|(a, b)| (a - b).abs() > ASUNDER);
            if followed.iter().all(asunder) {
                followed.push(start);
            }
            if followed.len() == most {
                break;
            }
        }
        let mut ends: Vec<Fitted> = followed.iter().map(|start| self.descend(few, start, COARSE_STEPS, control)).collect();
        ends.sort_by(|a, b| a.chi_square.total_cmp(&b.chi_square));
        let agrees = ends.len() < 2 || ends[1].chi_square <= ends[0].chi_square * 1.01 + 1.0;
        let near = self.descend(few, &nothing, COARSE_STEPS, control);
        let mut best = match ends.into_iter().next() {
            Some(end) if end.chi_square < near.chi_square => end,
            _ => near,
        };
        if linear {
            best = self.descend(&objective, &best, STEPS, control);
            if best.chi_square > bases[0].chi_square {
                let near = self.descend(&objective, &nothing, STEPS, control);
                best = if near.chi_square < best.chi_square { near } else { best };
            }
        }
        Ok(Fitted { agrees, ..best })
    }

    /// Fits a hypothesis from places all over the ranges of its parameters and around a fit: where what is missing has led the joints into a wrong
    /// basin, no path leads out of it.
    ///
    /// # Errors  as [`DomainObjective::new`].
    pub fn scatter(&self, hypothesis: &Hypothesis, base: &Fitted, control: &Control) -> Result<Fitted, ObjectiveError> {
        let piece = self.piece("scatter", hypothesis, std::slice::from_ref(base));
        control.kept_or_failed(&piece, || self.scatter_anew(hypothesis, base, SCATTERED, control))
    }

    /// As [`Fitter::scatter`] from so many starts, without a look into the journal: for data whose piece of work would be called like that of others.
    ///
    /// # Errors  as [`Fitter::scatter`].
    pub(super) fn scatter_anew(
        &self,
        hypothesis: &Hypothesis,
        base: &Fitted,
        starts: (usize, usize),
        control: &Control,
    ) -> Result<Fitted, ObjectiveError> {
        let objective = self.objective(hypothesis)?;
        let ends = self.scattered(&objective, hypothesis, base, starts, control);
        let best = ends.iter().min_by(|a, b| a.chi_square.total_cmp(&b.chi_square));
        Ok(best.map_or_else(|| start_of(hypothesis, base, &[]), |end| self.descend(&objective, end, STEPS, control)))
    }

    /// Where some starts all over the ranges end on few lines, the best of them.
    pub(super) fn scattered(
        &self,
        objective: &DomainObjective<'_>,
        hypothesis: &Hypothesis,
        base: &Fitted,
        (scattered, followed): (usize, usize),
        control: &Control,
    ) -> Vec<Fitted> {
        let centre = start_of(hypothesis, base, &[]);
        if control.stopped() {
            return Vec::new();
        }
        let coarse = objective.coarse(self.lines_of_one(SCATTER_LINES));
        let few = coarse.as_ref().unwrap_or(objective);
        let described = &hypothesis.machine.parameters;
        let varied = objective.free().iter().filter(|i| hypothesis.added.contains(i) || !described[**i].is_tolerance());
        let varied: Vec<usize> = varied.copied().collect();
        let start = |index: usize| {
            let mut start = centre.clone();
            for (place, &parameter) in halton_point(index, varied.len()).into_iter().zip(&varied) {
                let near = index % 2 == 1 && !hypothesis.added.contains(&parameter);
                start.units[parameter] = if near { (centre.units[parameter] + 0.5 * (place - 0.5)).clamp(0.0, 1.0) } else { place };
            }
            start
        };
        let mut ends: Vec<Fitted> =
            (1..=scattered).into_par_iter().map(|index| self.descend(few, &start(index), SCATTER_STEPS, control)).collect();
        ends.sort_by(|a, b| a.chi_square.total_cmp(&b.chi_square));
        ends.truncate(followed);
        ends.par_iter().map(|end| self.descend(few, end, COARSE_STEPS, control)).collect()
    }

    /// The least χ² that one linear step from any amplitude promises, on few lines.
    ///
    /// # Errors  as [`DomainObjective::new`].
    pub fn promise(&self, hypothesis: &Hypothesis, bases: &[Fitted], control: &Control) -> Result<f64, ObjectiveError> {
        let objective = self.objective(hypothesis)?;
        let coarse = objective.coarse(self.lines_of_one(COARSE));
        let few = coarse.as_ref().unwrap_or(&objective);
        let starts = bases.iter().flat_map(|base| amplitudes(hypothesis).into_iter().map(move |added| start_of(hypothesis, base, &added)));
        let cost = |start: Fitted| few.squares(|squares| squares.normal(&place_of(few, &start)).cost_after_step(PROMISE));
        Ok(starts.take_while(|_| !control.stopped()).map(cost).fold(f64::INFINITY, f64::min))
    }

    /// χ² of other data of the set with the parameters of a fit, nut positions as stated.
    ///
    /// # Errors  as [`DomainObjective::new`].
    pub fn loss(&self, hypothesis: &Hypothesis, fitted: &Fitted) -> Result<f64, ObjectiveError> {
        let objective = self.objective(hypothesis)?;
        let mut place = place_of(&objective, fitted);
        place[objective.nut_coordinates()].iter_mut().for_each(|u| *u = 0.5);
        Ok(objective.residuals(&place).norm_squared())
    }

    /// Tolerances as a fit has them; none where they are held.
    ///
    /// # Errors  as [`DomainObjective::new`].
    pub fn tolerances(&self, hypothesis: &Hypothesis, fitted: &Fitted) -> Result<Vec<ToleranceEstimate>, ObjectiveError> {
        let objective = self.objective(hypothesis)?;
        let place = place_of(&objective, fitted);
        Ok(match &objective {
            DomainObjective::Frf(objective) if self.has_nuisances() => tolerances_at(objective, self.fit.set, &place),
            _ => Vec::new(),
        })
    }

    /// Gaps of data with the parameters of a fit.
    ///
    /// # Errors  as [`gaps`].
    pub fn gaps(&self, hypothesis: &Hypothesis, fitted: &Fitted, data: &HoldOutSet<'_>) -> Result<Vec<PartialGap>, ObjectiveError> {
        let own = self.objective(hypothesis)?;
        let gain = own.gain(&place_of(&own, fitted));
        gaps(hypothesis, &values_of(hypothesis, fitted), gain, data, self.domain)
    }
}

/// Parameter values of a fit.
pub fn values_of(hypothesis: &Hypothesis, fitted: &Fitted) -> Vec<f64> {
    hypothesis.machine.parameters.iter().zip(&fitted.units).map(|(p, u)| p.from_unit(*u)).collect()
}

/// A fit that stands at the start values of a machine.
pub fn at_start(hypothesis: &Hypothesis) -> Fitted {
    let units = hypothesis.machine.parameters.iter().map(|p| p.to_unit(p.start)).collect();
    Fitted { units, tail: Vec::new(), chi_square: f64::INFINITY, agrees: true }
}

/// The place of a fit in the unit cube of an objective. The data may be others than those of the fit: gain and channels are kept, nut positions
/// begin as stated. The best gain where none is known yet.
pub fn place_of(objective: &DomainObjective<'_>, fitted: &Fitted) -> Vec<f64> {
    let place: Vec<f64> = objective.free().iter().map(|i| fitted.units[*i]).collect();
    if fitted.tail.is_empty() {
        return objective.extended(&place);
    }
    let nuts = objective.nut_coordinates();
    let rest = objective.dimension() - nuts.end;
    let gain = nuts.start - place.len();
    let same_data = fitted.tail.len() == gain + nuts.len() + rest;
    let mut place = place;
    place.extend(fitted.tail.iter().take(gain));
    if same_data {
        place.extend(fitted.tail.iter().skip(gain));
    } else {
        place.extend(std::iter::repeat_n(0.5, nuts.len()));
        place.extend(fitted.tail.iter().skip(fitted.tail.len().saturating_sub(rest)));
    }
    place
}

fn read_back(objective: &DomainObjective<'_>, from: &Fitted, place: &[f64], chi_square: f64) -> Fitted {
    let mut units = from.units.clone();
    for (&index, &u) in objective.free().iter().zip(place) {
        units[index] = u;
    }
    Fitted { units, tail: place[objective.free().len()..].to_vec(), chi_square, agrees: from.agrees }
}

/// Frequencies (Hz) at which a resonance is looked for, lowest and highest, and how many.
const RESONANCES_HZ: (f64, f64, u32) = (8.0, 1600.0, 26);
/// Places of a mass in its range at which it is looked for.
const SHARES: [f64; 3] = [0.3, 0.6, 0.85];
/// Where the frequency itself is a parameter it is looked for all along its range, at so many places, with masses at these places of theirs and a loss that is
/// wide enough for none to be missed between two.
const NATURAL_COUNT: u32 = 60;
const NATURAL: ([f64; 2], f64) = ([0.55, 0.75], 0.1);
/// Pairs of numbers without unit at which it is looked for, where it has such: arms on which it is felt and struck, to either side.
const ARMS: [[f64; 2]; 5] = [[0.0, 0.0], [1.0, 1.0], [1.0, -1.0], [-1.0, 1.0], [-1.0, -1.0]];

/// Places of masses that resonate all over the band, each alone and both where there are two, with a spring and a damper or a loss factor, or with the
/// frequency itself among the parameters, or with two arms beside: the ranges together hold mostly resonances where nothing is measured. `None` where the
/// parameters are no such ones.
fn resonances(described: &[&Parameter]) -> Option<Vec<Vec<f64>>> {
    let of = |units: &[&str]| (0..described.len()).filter(|at| units.contains(&described[*at].unit.as_str())).collect::<Vec<usize>>();
    let (masses, springs, dampers) = (of(&["kg", "kg*m^2"]), of(&["N/m", "N*m/rad"]), of(&["N*s/m", "N*m*s/rad"]));
    let natural = of(&["Hz"]);
    let clamped = |at: usize, x: f64| described[at].to_unit(x.clamp(described[at].lower, described[at].upper));
    let (low, high, count) = RESONANCES_HZ;
    let start: Vec<f64> = described.iter().map(|p| p.to_unit(p.start)).collect();
    let frequencies = (0..count).map(|at| low * (high / low).powf(f64::from(at) / f64::from(count - 1)));
    let tried = frequencies.flat_map(|hz| SHARES.map(|share| (hz, share)));
    let plain = of(&["1"]);
    let resonant = |mass: usize, spring: usize, (hz, share): (f64, f64)| {
        let (m, omega) = (described[mass].from_unit(share), std::f64::consts::TAU * hz);
        let mut place = start.clone();
        place[mass] = share;
        place[spring] = clamped(spring, m * omega * omega);
        (place, m * omega)
    };
    match (masses.as_slice(), springs.as_slice(), dampers.as_slice(), natural.as_slice()) {
        (&[mass], &[spring], &[damper], []) if described.len() == 3 + plain.len() && [0, 2].contains(&plain.len()) => {
            let arms = if plain.is_empty() { &ARMS[..1] } else { &ARMS };
            let place = |(resonance, arms): ((f64, f64), [f64; 2])| {
                let (mut place, impedance) = resonant(mass, spring, resonance);
                place[damper] = clamped(damper, 2.0 * 0.03 * impedance);
                plain.iter().zip(arms).for_each(|(at, arm)| place[*at] = clamped(*at, arm));
                place
            };
            Some(tried.flat_map(|resonance| arms.iter().map(move |some| (resonance, *some))).map(place).collect())
        }
        // A mass behind a spring with a loss factor, which stays where it starts.
        (&[mass], &[spring], [], []) if described.len() == 3 && plain.len() == 1 => {
            Some(tried.map(|resonance| resonant(mass, spring, resonance).0).collect())
        }
        (masses, [], [], natural) if !masses.is_empty() && !natural.is_empty() => {
            let each: Vec<&[usize]> = masses.iter().map(std::slice::from_ref).chain((masses.len() > 1).then_some(masses)).collect();
            let (shares, loss) = NATURAL;
            let place = |along: f64, share: f64, some: &[usize]| {
                let mut place = start.clone();
                natural.iter().for_each(|at| place[*at] = along);
                plain.iter().for_each(|at| place[*at] = clamped(*at, loss));
                some.iter().for_each(|mass| place[*mass] = share);
                place
            };
            let along = (0..NATURAL_COUNT).map(|at| (f64::from(at) + 0.5) / f64::from(NATURAL_COUNT));
            let tried = along.flat_map(|along| shares.map(|share| (along, share)));
            Some(
                tried
                    .flat_map(|(along, share)| each.iter().map(move |some| (along, share, *some)))
                    .map(|(along, share, some)| place(along, share, some))
                    .collect(),
            )
        }
        _ => None,
    }
}

/// A nominal fit with the added parameters at given places.
pub fn start_of(hypothesis: &Hypothesis, base: &Fitted, added: &[f64]) -> Fitted {
    let described = &hypothesis.machine.parameters;
    let mut units: Vec<f64> = base.units.clone();
    units.extend(described.iter().skip(base.units.len()).map(|p| p.to_unit(p.start)));
    for (&index, &u) in hypothesis.added.iter().zip(added) {
        units[index] = u;
    }
    Fitted { units, tail: base.tail.clone(), chi_square: f64::INFINITY, agrees: true }
}

/// Places of the added parameters to try: their start, and a lattice over the unit cube (Halton's sequence).
pub fn amplitudes(hypothesis: &Hypothesis) -> Vec<Vec<f64>> {
    let described: Vec<_> = hypothesis.added.iter().map(|i| &hypothesis.machine.parameters[*i]).collect();
    let start: Vec<f64> = described.iter().map(|p| p.to_unit(p.start)).collect();
    if let Some(resonances) = resonances(&described) {
        return std::iter::once(start).chain(resonances).collect();
    }
    let count = match described.len() {
        0 => return vec![Vec::new()],
        1 => 25,
        2 => 20,
        _ => 40,
    };
    let lattice = (1..=count).map(|index| halton_point(index, described.len()));
    std::iter::once(start).chain(lattice).collect()
}

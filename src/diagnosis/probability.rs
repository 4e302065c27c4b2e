//! Probabilities of what may explain the data, by Bayesian evidence from the fits that exist. They stand beside the
//! verdict, which they do not decide.

use super::facts::{Facts, Model, of};
use super::policy::{PRIOR, SHARE, TEMPERATURE};
use super::verdict::{Verdict, VerdictKind};
use machine::EffectIds;
use numeric::statistics::log_sum_exp;

/// What may explain the data.
#[derive(Debug, Clone, PartialEq)]
pub struct Explanation {
    /// `none`, the id of an effect, ids joined by `+`, `measurement:` with a fault or `unknown:` with an interface.
    pub id: String,
    /// Points, joints and shafts where it is.
    pub places: Vec<String>,
    /// Its probability.
    pub probability: f64,
}

/// Id of the machine as described, and first parts of other ids.
pub const NONE: &str = "none";
const UNKNOWN: &str = "unknown:";
const MEASUREMENT: &str = "measurement:";

/// A hypothesis with its prior probability.
struct Hypothesis {
    id: String,
    places: Vec<String>,
    prior: f64,
    /// ln of the evidence.
    evidence: f64,
}

/// Returns a model with its χ² and number of added parameters.
type Fit = (Model, f64, usize);

/// Returns all models that may explain the data, with what explains them.
fn models(facts: &Facts) -> Vec<(Fit, String, Vec<String>, f64)> {
    let fitted = |count: usize, prior: f64| if count == 0 { 0.0 } else { prior / count as f64 };
    let singles = facts.candidates.iter().enumerate().filter(|(_, c)| c.chi_square.is_some());
    let share = fitted(singles.clone().count(), PRIOR.effect);
    let single = singles.map(|(at, c)| {
        ((Model::Candidate(at), c.chi_square(), c.added), c.id.clone(), c.places.clone(), share)
    });
    let impedance = facts.impedances.iter().enumerate().map(|(at, c)| {
        let share = fitted(facts.impedances_tried.max(facts.impedances.len()), PRIOR.unknown);
        let id = format!("{UNKNOWN}{}", c.interface);
        ((Model::Impedance(at), c.chi_square, c.parameters), id, vec![c.interface.clone()], share)
    });
    let combination = facts.beside.iter().enumerate().flat_map(|(search, beside)| {
        let found = beside.candidates.iter().enumerate().filter(|(_, c)| c.chi_square.is_some());
        let share = fitted(found.clone().count() * facts.beside.len(), PRIOR.combination);
        found.map(move |(at, c)| {
            let fit = (Model::With(search, at), c.chi_square(), c.added);
            (fit, c.names.join("+"), c.places.clone(), share)
        })
    });
    single.chain(impedance).chain(combination).collect()
}

/// Returns the models whose fits may have a probability: their evidence by the fitted data is not beyond any that
/// held-out data could make up for. Their Occam factors are known.
pub(super) fn within_reach(facts: &Facts) -> Vec<Model> {
    const REACH: f64 = 50.0;
    let scale = scale(facts);
    let fits: Vec<Fit> = std::iter::once((Model::Nominal, facts.chi_square, 0))
        .chain(models(facts).into_iter().map(|(fit, ..)| fit))
        .collect();
    let evidence = |fit: &Fit| evidence_of_fit(facts, *fit, scale);
    let best = fits.iter().filter_map(evidence).fold(f64::NEG_INFINITY, f64::max);
    let is_near = |fit: &&Fit| fit.0 == Model::Nominal || evidence(fit).is_some_and(|own| own > best - REACH);
    fits.iter().filter(is_near).map(|fit| fit.0).collect()
}

/// Returns all models.
pub(super) fn all_models(facts: &Facts) -> Vec<Model> {
    std::iter::once(Model::Nominal).chain(models(facts).into_iter().map(|((model, ..), ..)| model)).collect()
}

/// Returns the misfit over null simulations of the model that fits best: the variance of residuals for all models.
fn scale(facts: &Facts) -> f64 {
    let all = models(facts).into_iter().map(|((_, chi_square, _), ..)| chi_square);
    facts.excess(all.fold(facts.chi_square, f64::min))
}

/// Computes ln of the evidence of a model by the fitted data; `None` where its Occam factor is unknown.
fn evidence_of_fit(facts: &Facts, (model, chi_square, added): Fit, scale: f64) -> Option<f64> {
    // Occam factors are those of the weights of the lines: intervals of the added parameters widen by √scale.
    let occam = of(&facts.log_occam, model)? + 0.5 * added as f64 * scale.ln();
    Some(-0.5 * chi_square / scale + occam)
}

/// Computes the probabilities of what may explain the data, the largest first; `None` where the facts lack Occam
/// factors: those of modes, whose weights are a model error that is hardly known, and of motion records.
///
/// ln of the evidence of a model is −χ²/2 at its fit, plus ln of its Occam factor, plus ln of its predictive density
/// of held-out data. Each model contains the nominal one as the limit of an effect too small to be seen: what it has
/// beyond that counts for it.
///
/// # Source  MacKay, Information Theory, Inference, and Learning Algorithms, chapter 28. The temperature, by which
///   evidences are divided, is calibrated: Guo et al., On Calibration of Modern Neural Networks, ICML 2017.
pub fn explanations(facts: &Facts) -> Option<Vec<Explanation>> {
    let scale = scale(facts);
    let evidence = |fit: Fit| {
        let held_out = match facts.holds_out {
            true => *of(&facts.held_out_loss, fit.0)?,
            false => 0.0,
        };
        Some(evidence_of_fit(facts, fit, scale)? - 0.5 * held_out / scale)
    };
    let nominal = evidence((Model::Nominal, facts.chi_square, 0))?;
    let beyond = |evidence: f64| {
        let more = (evidence - nominal) / TEMPERATURE;
        if more > 0.0 { more + (-(-more).exp()).ln_1p() } else { f64::NEG_INFINITY }
    };
    let mut hypotheses: Vec<Hypothesis> = models(facts)
        .into_iter()
        .filter_map(|(fit, id, places, prior)| {
            Some(Hypothesis { id, places, prior, evidence: beyond(evidence(fit)?) })
        })
        .collect();
    hypotheses.extend(facts.chain.as_ref().and_then(|answer| answer.found.as_ref()).map(|fault| {
        // The records are corrected, the held-out ones, too: those of the fit alone are compared.
        let price = 0.5 * fault.parameters as f64 * facts.count.ln();
        let more = 0.5 * (facts.chi_square - fault.chi_square) / scale - price;
        let id = format!("{MEASUREMENT}{}", fault.id);
        let places = vec!["measurement".to_string()];
        Hypothesis { id, places, prior: PRIOR.fault, evidence: beyond(nominal + more) }
    }));
    let none = Hypothesis { id: NONE.into(), places: Vec::new(), prior: PRIOR.none, evidence: 0.0 };
    hypotheses.push(none);
    let weights: Vec<f64> = hypotheses.iter().map(|h| h.prior.ln() + h.evidence).collect();
    let total = log_sum_exp(&weights);
    let mut found: Vec<Explanation> = Vec::new();
    for (Hypothesis { id, places, .. }, weight) in hypotheses.into_iter().zip(weights) {
        let probability = (weight - total).exp();
        match found.iter_mut().find(|known| known.id == id) {
            Some(known) => known.probability += probability,
            None => found.push(Explanation { id, places, probability }),
        }
    }
    found.sort_by(|a, b| b.probability.total_cmp(&a.probability));
    Some(found)
}

/// Returns the smallest set of places that holds what is missing with a probability of 0.9, given that something is;
/// those of the likeliest explanation first.
pub fn places(found: &[Explanation]) -> Vec<String> {
    let missing = || found.iter().filter(|explanation| explanation.id != NONE);
    let all: f64 = missing().map(|explanation| explanation.probability).sum();
    let (mut places, mut held): (Vec<String>, f64) = (Vec::new(), 0.0);
    for explanation in missing() {
        if held >= SHARE * all {
            break;
        }
        held += explanation.probability;
        let more: Vec<&String> = explanation.places.iter().filter(|place| !places.contains(place)).collect();
        places.extend(more.into_iter().cloned());
    }
    places
}

/// Returns the verdict that probabilities alone would give: what has 0.9, alone or in the smallest set.
/// `None` where the facts lack Occam factors.
pub fn verdict_by_evidence(facts: &Facts) -> Option<Verdict> {
    const LARGEST_SET: usize = 4;
    let all = explanations(facts)?;
    let mut kinds: Vec<(&str, f64)> = Vec::new();
    for Explanation { id, probability, .. } in &all {
        let kind = if id.starts_with(UNKNOWN) { UNKNOWN } else { id };
        match kinds.iter_mut().find(|(known, _)| *known == kind) {
            Some(known) => known.1 += probability,
            None => kinds.push((kind, *probability)),
        }
    }
    kinds.sort_by(|a, b| b.1.total_cmp(&a.1));
    let mut held = 0.0;
    let set: Vec<&str> = kinds
        .into_iter()
        .take_while(|(_, probability)| {
            let is_needed = held < SHARE;
            held += probability;
            is_needed
        })
        .map(|(kind, _)| kind)
        .collect();
    let of = |kind| Verdict::new(kind, "by evidence".into(), None);
    let faults: Vec<String> =
        set.iter().filter_map(|id| id.strip_prefix(MEASUREMENT)).map(String::from).collect();
    Some(if set.contains(&NONE) {
        of(VerdictKind::None)
    } else if set.contains(&UNKNOWN) || set.len() > LARGEST_SET {
        of(VerdictKind::Unknown)
    } else if !faults.is_empty() {
        Verdict { faults, ..of(VerdictKind::Measurement) }
    } else {
        let effects = set.iter().map(|id| id.split('+').fold(EffectIds::default(), |all, id| all.with(id)));
        Verdict::naming(effects.collect(), "by evidence".into(), None)
    })
}

//! Judgement of facts by the table of rules.

use super::case::{Case, Chosen, Need};
use super::data_kind::DataKind;
use super::facts::{Facts, Model};
use super::finding::Finding::{Fails, Holds};
use super::policy::Policy;
use super::probability::{all_models, within_reach};
use super::ranking::Ranked;
use super::rules::Act::{Decides, Overrides};
use super::rules::{RULES, Rule};
use super::verdict::{Verdict, VerdictKind};

/// A rule and what came of it.
#[derive(Debug, Clone, PartialEq)]
pub struct Trial {
    /// Name of the rule.
    pub rule: String,
    /// Its condition in words.
    pub when: String,
    /// Whether it held; null where a rule before it had decided, or where none had that it could override.
    pub held: Option<bool>,
    /// Figures that it compared where it did not hold.
    pub figures: String,
}

/// A judged case.
#[derive(Debug, Clone, PartialEq)]
pub struct Judgement {
    /// The verdict.
    pub verdict: Verdict,
    /// Name of the rule that gave it last.
    pub rule: &'static str,
    /// The chosen model.
    pub chosen: Chosen,
    /// Fitted candidates, best first.
    pub ranked: Vec<Ranked>,
    /// All rules, in their order.
    pub trials: Vec<Trial>,
}

/// Data of a kind, their fits and simulations, which answer what rules ask for.
pub(super) trait Answers {
    /// What may go wrong.
    type Error;

    /// Adds what was asked for to the facts.
    ///
    /// # Errors  those of the fits.
    fn answer(&mut self, need: &Need, facts: &mut Facts) -> Result<(), Self::Error>;

    /// Judges facts, which grow by what rules ask for.
    ///
    /// # Errors  as [`Answers::answer`].
    fn judge(&mut self, facts: &mut Facts) -> Result<Judgement, Self::Error> {
        let policy = Policy::of(facts.data);
        loop {
            match judge(facts, policy) {
                Ok(judgement) => return Ok(judgement),
                Err(need) => self.answer(&need, facts)?,
            }
        }
    }

    /// Adds what probabilities rest on to the facts: those of FRFs, whose weights null simulations calibrate.
    ///
    /// # Errors  as [`Answers::answer`].
    fn gather_evidence(&mut self, facts: &mut Facts) -> Result<(), Self::Error> {
        if facts.data != DataKind::Frf {
            return Ok(());
        }
        self.answer(&Need::Occam(all_models(facts)), facts)?;
        let models = within_reach(facts);
        if facts.holds_out { self.answer(&Need::HeldOut(models), facts) } else { Ok(()) }
    }

    /// Adds what rules with other numbers may ask for to the facts: figures of all candidates and generic
    /// impedances.
    ///
    /// # Errors  as [`Answers::answer`].
    fn gather_more(&mut self, facts: &mut Facts) -> Result<(), Self::Error> {
        let fitted = (0..facts.candidates.len()).filter(|at| facts.candidates[*at].chi_square.is_some());
        let mut all: Vec<Model> = fitted.map(Model::Candidate).collect();
        all.push(Model::Nominal);
        for model in &all {
            self.answer(&Need::Farthest(*model), facts)?;
            self.answer(&Need::Closed(*model), facts)?;
        }
        all.extend((0..facts.impedances.len()).map(Model::Impedance));
        self.answer(&Need::LeftOut(all.clone()), facts)?;
        if facts.holds_out { self.answer(&Need::HeldOut(all), facts) } else { Ok(()) }
    }
}

/// Judges facts by all rules in their order.
///
/// # Errors  facts that a rule needs and that were not gathered.
pub fn judge(facts: &Facts, policy: &Policy) -> Result<Judgement, Need> {
    judge_by(facts, policy, &RULES.each_ref())
}

/// Judges facts by all rules but some, given by their names.
///
/// # Errors  as [`judge`].
pub fn judge_without(facts: &Facts, policy: &Policy, left_out: &[String]) -> Result<Judgement, Need> {
    let others: Vec<&Rule> =
        RULES.iter().filter(|(name, ..)| !left_out.iter().any(|other| other == name)).collect();
    judge_by(facts, policy, &others)
}

/// Returns the names of all rules, in their order.
pub fn rules() -> impl Iterator<Item = &'static str> {
    RULES.iter().map(|(name, ..)| *name)
}

fn judge_by(facts: &Facts, policy: &Policy, rules: &[&Rule]) -> Result<Judgement, Need> {
    let case = Case::new(facts, policy)?;
    let mut decided: Option<(&'static str, Verdict, Chosen)> = None;
    let mut trials = Vec::new();
    for (rule, when, act) in rules {
        let found = match (act, &decided) {
            (Decides(check), None) => Some(check(&case)?),
            (Overrides(check), Some((_, verdict, chosen))) => Some(check(&case, (verdict, chosen))?),
            _ => None,
        };
        let held = found.as_ref().map(|found| matches!(found, Holds(..)));
        let mut figures = String::new();
        match found {
            Some(Fails(compared)) => figures = compared,
            Some(Holds(mut verdict, chosen)) => {
                if decided.is_none() && verdict.kind.explains() {
                    let found = case.confirmed(&verdict, &chosen)?;
                    verdict.confirmed = found.map(|found| case.is_certain(found));
                }
                decided = Some((rule, verdict, chosen));
            }
            None => {}
        }
        trials.push(Trial { rule: (*rule).into(), when: (*when).into(), held, figures });
    }
    let (rule, verdict, chosen) = decided.unwrap_or_else(|| {
        let reason = "no rule decides".to_string();
        ("", Verdict::new(VerdictKind::Unknown, reason, None), Chosen::nominal(facts))
    });
    Ok(Judgement { verdict, rule, chosen, ranked: case.ranking.tried, trials })
}

//! Judgement of facts by the table of rules.

use super::case::{Case, Chosen, Need};
use super::facts::Facts;
use super::policy::Policy;
use super::ranking::Ranked;
use super::rules::Act::{Decides, Overrides};
use super::rules::Finding::{Fails, Holds};
use super::rules::RULES;
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

/// Judges facts by all rules in their order.
///
/// # Errors  facts that a rule needs and that were not gathered.
pub fn judge(facts: &Facts, policy: &Policy) -> Result<Judgement, Need> {
    let case = Case::new(facts, policy)?;
    let mut decided: Option<(&'static str, Verdict, Chosen)> = None;
    let mut trials = Vec::new();
    for (rule, when, act) in &RULES {
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

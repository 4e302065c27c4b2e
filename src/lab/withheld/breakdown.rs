//! Scores by the size of effects, by effect, by the layout of machines, and by the kind of outside causes.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use reference_simulator::Kind;

use super::judge::Judgement;
use super::proportion::{Proportion, share};

/// Answers to cases with one effect: of one range of sizes, or with the same effect.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct SingleScore {
    /// A discrepancy is reported.
    pub reported: Proportion,
    /// The one true effect is named alone.
    pub exact: Proportion,
    /// A named set contains it.
    pub class: Proportion,
    /// Only other effects are named.
    pub misnamed: Proportion,
    /// Right: named alone, and below the visible size also «none».
    pub right: Proportion,
}

/// Answers on one layout.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct LayoutScore {
    /// First measurements.
    pub cases: usize,
    /// No diagnosis.
    pub failed: Proportion,
    /// Ordinary nulls with a named effect, among answered ones.
    pub false_name: Proportion,
    /// Single effects from the visible size: named alone.
    pub exact: Proportion,
    /// The same: a named set contains the effect.
    pub class: Proportion,
    /// Verdicts that name one effect, and are right.
    pub selective: Proportion,
    /// Outside causes with a named effect of the library.
    pub outside_misnamed: Proportion,
}

/// Answers to one kind of outside cause. Cases that an effect of the library imitates within noise and
/// tolerances count only as such.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct OutsideKind {
    /// Cases that an effect of the library imitates.
    pub imitated: Proportion,
    /// Of the others: verdict «unknown».
    pub unknown: Proportion,
    /// Of the others: an effect of the library is named.
    pub misnamed: Proportion,
}

/// Answers to outside causes. The kind is the unit: cases of one kind are alike, and a library's effect that
/// resembles one resembles most.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct OutsideScore {
    /// Kinds of which no case gets the name of a library's effect, among kinds with a case that no such
    /// effect imitates.
    pub kinds_never_misnamed: Proportion,
    /// By kind.
    pub by_kind: BTreeMap<String, OutsideKind>,
}

/// Ranges of sizes by their upper ends; the first ends at the visible size.
const RANGES: [(f64, &str); 4] =
    [(reference_simulator::VISIBLE, "0-20"), (50.0, "20-50"), (200.0, "50-200"), (f64::INFINITY, "from 200")];

/// Groups judgements by a key; those without one are left out.
pub fn groups<'a>(
    of: &[&'a Judgement],
    key: impl Fn(&Judgement) -> Option<String>,
) -> BTreeMap<String, Vec<&'a Judgement>> {
    let mut groups: BTreeMap<String, Vec<&'a Judgement>> = BTreeMap::new();
    for judged in of {
        if let Some(key) = key(judged) {
            groups.entry(key).or_default().push(judged);
        }
    }
    groups
}

impl SingleScore {
    fn of(group: &[&Judgement]) -> Self {
        let of = |counted: &dyn Fn(&Judgement) -> bool| share(group.iter().copied(), counted);
        Self {
            reported: of(&|j| j.claims),
            exact: of(&|j| j.exact),
            class: of(&|j| j.class),
            misnamed: of(&|j| j.names > 0 && !j.class),
            right: of(&|j| j.right),
        }
    }
}

/// Scores each effect, on cases with it alone whose data show it.
pub fn by_effect(known: &[&Judgement]) -> BTreeMap<String, SingleScore> {
    let effect = |judged: &Judgement| judged.truth.first().filter(|_| !judged.may_be_none).cloned();
    groups(known, effect).into_iter().map(|(effect, group)| (effect, SingleScore::of(&group))).collect()
}

/// Scores single effects in each range of sizes.
pub fn by_size(singles: &[&Judgement]) -> BTreeMap<String, SingleScore> {
    let range = |judged: &Judgement| {
        let size = judged.size?;
        RANGES.iter().find(|(end, _)| size < *end).map(|(_, name)| (*name).to_owned())
    };
    groups(singles, range).into_iter().map(|(range, group)| (range, SingleScore::of(&group))).collect()
}

/// Scores each layout.
pub fn by_layout(first: &[&Judgement]) -> BTreeMap<String, LayoutScore> {
    let score = |group: Vec<&Judgement>| {
        let of = |kind: Kind| group.iter().copied().filter(move |j| j.kind == kind);
        let visible = || of(Kind::Single).filter(|j| !j.may_be_none);
        LayoutScore {
            cases: group.len(),
            failed: share(group.iter().copied(), |j| !j.answered),
            false_name: share(of(Kind::Null).filter(|j| j.answered), |j| j.names > 0),
            exact: share(visible(), |j| j.exact),
            class: share(visible(), |j| j.class),
            selective: share(group.iter().copied().filter(|j| j.single_right.is_some()), |j| {
                j.single_right == Some(true)
            }),
            outside_misnamed: share(of(Kind::Unknown).filter(|j| !j.imitated), |j| j.names > 0),
        }
    };
    groups(first, |j| j.layout.clone()).into_iter().map(|(layout, group)| (layout, score(group))).collect()
}

impl OutsideScore {
    /// Scores outside causes by kind.
    pub fn of(unknowns: &[&Judgement]) -> Self {
        let score = |group: &[&Judgement]| {
            let others = || group.iter().copied().filter(|j| !j.imitated);
            OutsideKind {
                imitated: share(group.iter().copied(), |j| j.imitated),
                unknown: share(others(), |j| j.right),
                misnamed: share(others(), |j| j.names > 0),
            }
        };
        let by_kind: BTreeMap<String, OutsideKind> = groups(unknowns, |j| j.truth.first().cloned())
            .into_iter()
            .map(|(kind, group)| (kind, score(&group)))
            .collect();
        let judged = || by_kind.values().filter(|kind| kind.misnamed.of > 0);
        let never = judged().filter(|kind| kind.misnamed.count == 0).count();
        Self { kinds_never_misnamed: Proportion::new(never, judged().count()), by_kind }
    }
}

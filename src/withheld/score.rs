//! Scores over all cases.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::Serialize;

use numeric::distribution::clopper_pearson;
use numeric::statistics::{median, quantile};
use reference_simulator::{Kind, Strength};

use super::judge::Judgement;

/// A count of cases with the exact 95 % interval of its share.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
pub struct Proportion {
    /// Cases counted.
    pub count: usize,
    /// Of so many.
    pub of: usize,
    /// Share; absent for none.
    pub share: Option<f64>,
    /// Clopper–Pearson interval; absent for none.
    pub interval95: Option<[f64; 2]>,
}

impl Proportion {
    /// So many of so many.
    pub fn new(count: usize, of: usize) -> Self {
        Self { count, of, share: (of > 0).then(|| count as f64 / of as f64), interval95: clopper_pearson(count, of, 0.95) }
    }
}

/// Median and extremes of a quantity.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
pub struct Spread {
    /// Values.
    pub of: usize,
    /// 10 % quantile.
    pub low10: Option<f64>,
    /// Median.
    pub median: Option<f64>,
    /// Largest.
    pub max: Option<f64>,
}

impl Spread {
    /// Of values.
    pub fn of(values: &[f64]) -> Self {
        Self {
            of: values.len(),
            low10: quantile(values.iter().copied(), 0.1),
            median: median(values.iter().copied()),
            max: values.iter().copied().reduce(f64::max),
        }
    }
}

/// Right names at one range of strengths: single effects, abstentions and failures counted as wrong.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct Naming {
    /// The one effect named.
    pub exact: Proportion,
    /// A set named that holds it.
    pub class: Proportion,
    /// It is among the first three of the ranked list.
    pub top3: Proportion,
    /// Effects that a verdict names that names any: mean.
    pub mean_set: Option<f64>,
}

/// Where something was found.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct LocationScore {
    /// The place is one of the right ones, of all cases: failures and empty lists are wrong.
    pub interface: Proportion,
    /// The phase is one of the right ones, of all cases in motion.
    pub phase: Proportion,
    /// Overlap of bands over their union, on the logarithmic axis, where both state one.
    pub band_overlap: Spread,
    /// Bands that overlap at all, of these.
    pub band_touches: Proportion,
}

/// What named effects close, for right verdicts that name one.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct Closing {
    /// Share closed.
    pub closed: Spread,
    /// Distance from what the truth can close, in motion from what the chosen model closes without noise.
    pub error: Spread,
    /// Intervals that hold that.
    pub covered: Proportion,
}

/// Rows are what is true, columns the first effect named or else the kind of verdict.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct Confusion {
    /// Counts by truth and answer.
    pub rows: BTreeMap<String, BTreeMap<String, usize>>,
}

/// All scores.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct Scores {
    /// Cases without a diagnosis, second measurements included.
    pub failed: Proportion,
    /// The verdict that the case calls for, by kind of case.
    pub right_by_kind: BTreeMap<String, Proportion>,
    /// Ordinary nulls on which something is claimed, of those answered.
    pub false_alarm_ordinary: Proportion,
    /// Ordinary nulls on which a library's effect is named, of those answered.
    pub false_name_ordinary: Proportion,
    /// Hard nulls on which more is claimed than what was done to them, of those answered.
    pub false_alarm_hard: Proportion,
    /// Wrong parameters called wrong or nothing.
    pub wrong_parameter: Proportion,
    /// Wrong parameters that the case freezes, called wrong.
    pub wrong_parameter_frozen: Proportion,
    /// Bad channels called a matter of the measurement.
    pub bad_channel: Proportion,
    /// Something claimed where there is an effect, by kind of case.
    pub detection_by_kind: BTreeMap<String, Proportion>,
    /// The same for single effects by strength.
    pub detection_by_strength: BTreeMap<String, Proportion>,
    /// The same for single effects by non-centrality.
    pub detection_by_noncentrality: BTreeMap<String, Proportion>,
    /// Single effects of all strengths.
    pub naming: Naming,
    /// Single effects made with a non-centrality of 25 or more.
    pub naming_from_25: Naming,
    /// Right verdicts among those that name one effect, all kinds of cases.
    pub selective: Proportion,
    /// Verdicts that name one effect among single effects of a non-centrality of 25 or more.
    pub selective_coverage: Proportion,
    /// Unknown effects called unknown.
    pub unknown: Proportion,
    /// Unknown effects given a library's name.
    pub unknown_misnamed: Proportion,
    /// Single effects and look-alikes called unknown.
    pub known_called_unknown: Proportion,
    /// Place and band, single effects (of a non-centrality of 25 or more) and look-alikes.
    pub location: LocationScore,
    /// Place and band, unknown effects.
    pub location_unknown: LocationScore,
    /// Shares closed.
    pub closing: Closing,
    /// Look-alikes: the set holds the truth.
    pub look_alike_class: Proportion,
    /// Look-alikes: exact already by the first measurement.
    pub look_alike_exact: Proportion,
    /// Look-alikes: exact by the second measurement.
    pub look_alike_resolved: Proportion,
    /// Doubles: both named.
    pub double_both: Proportion,
    /// Doubles: the dominant one named.
    pub double_dominant: Proportion,
    /// Seconds for each diagnosis.
    pub seconds: Spread,
    /// First measurements: truth against answer.
    pub confusion: Confusion,
}

/// Name of a value in its document.
fn word<T: Serialize>(value: &T) -> String {
    serde_json::to_value(value).ok().and_then(|v| v.as_str().map(str::to_owned)).unwrap_or_default()
}

fn share<'a>(of: impl IntoIterator<Item = &'a Judgement>, counted: impl Fn(&Judgement) -> bool) -> Proportion {
    let (count, all) = of.into_iter().fold((0, 0), |(c, n), judged| (c + usize::from(counted(judged)), n + 1));
    Proportion::new(count, all)
}

fn by<'a>(
    of: &[&'a Judgement],
    key: impl Fn(&Judgement) -> Option<String>,
    counted: impl Fn(&Judgement) -> bool,
) -> BTreeMap<String, Proportion> {
    let mut groups: BTreeMap<String, Vec<&'a Judgement>> = BTreeMap::new();
    for judged in of {
        if let Some(key) = key(judged) {
            groups.entry(key).or_default().push(judged);
        }
    }
    groups.into_iter().map(|(key, group)| (key, share(group, &counted))).collect()
}

/// Range of a non-centrality in words, in rising order.
fn range(noncentrality: f64) -> &'static str {
    match noncentrality {
        d if d < 16.0 => "0-16",
        d if d < 50.0 => "16-50",
        d if d < 200.0 => "50-200",
        _ => "from 200",
    }
}

/// Counts all that can be counted.
pub fn scores(judged: &[Judgement]) -> Scores {
    let first: Vec<&Judgement> = judged.iter().filter(|j| !j.follow_up).collect();
    let of = |kinds: &[Kind]| -> Vec<&Judgement> { first.iter().copied().filter(|j| kinds.contains(&j.kind)).collect() };
    let answered = |all: Vec<&'_ Judgement>| -> Vec<Judgement> { all.into_iter().filter(|j| j.answered).cloned().collect() };
    let nulls = answered(of(&[Kind::Null]));
    let hard = answered(of(&[Kind::HardNullWrongParameter, Kind::HardNullBadChannel]));
    let wrong = of(&[Kind::HardNullWrongParameter]);
    let singles = of(&[Kind::Single]);
    let from_25: Vec<&Judgement> = singles.iter().copied().filter(|j| j.strength != Some(Strength::Faint)).collect();
    let unknowns = of(&[Kind::Unknown]);
    let alike = of(&[Kind::LookAlike]);
    let doubles = of(&[Kind::Double]);
    let planted = of(&[Kind::Single, Kind::LookAlike, Kind::Double, Kind::Unknown]);
    let known: Vec<&Judgement> = singles.iter().chain(&alike).copied().collect();
    let placed: Vec<&Judgement> = from_25.iter().chain(&alike).copied().collect();
    let says = |kind: &'static str| move |j: &Judgement| j.verdict.kind == kind;
    let seconds: Vec<f64> = judged.iter().map(|j| j.seconds).collect();
    Scores {
        failed: share(judged, |j| !j.answered),
        right_by_kind: by(&first, |j| Some(word(&j.kind)), |j| j.right),
        false_alarm_ordinary: share(&nulls, |j| j.claims),
        false_name_ordinary: share(&nulls, |j| j.names > 0),
        false_alarm_hard: share(&hard, |j| j.claims && !j.right),
        wrong_parameter: share(wrong.iter().copied(), |j| j.right),
        wrong_parameter_frozen: share(wrong.iter().copied().filter(|j| j.frozen), says("wrong-parameter")),
        bad_channel: share(of(&[Kind::HardNullBadChannel]), |j| j.right),
        detection_by_kind: by(&planted, |j| Some(word(&j.kind)), |j| j.claims),
        detection_by_strength: by(&singles, |j| j.strength.map(|s| word(&s)), |j| j.claims),
        detection_by_noncentrality: by(&singles, |j| j.noncentrality.map(|d| range(d).into()), |j| j.claims),
        naming: naming(&singles),
        naming_from_25: naming(&from_25),
        selective: share(first.iter().copied().filter(|j| j.verdict.single().is_some()), |j| j.single_right == Some(true)),
        selective_coverage: share(from_25.iter().copied(), |j| j.verdict.single().is_some()),
        unknown: share(unknowns.iter().copied(), |j| j.right),
        unknown_misnamed: share(unknowns.iter().copied(), |j| j.names > 0),
        known_called_unknown: share(known.iter().copied(), says("unknown")),
        location: location(&placed),
        location_unknown: location(&unknowns),
        closing: closing(&known),
        look_alike_class: share(alike.iter().copied(), |j| j.class),
        look_alike_exact: share(alike.iter().copied(), |j| j.exact),
        look_alike_resolved: share(judged.iter().filter(|j| j.follow_up && j.kind == Kind::LookAlike), |j| j.exact),
        double_both: share(doubles.iter().copied(), |j| j.all_named),
        double_dominant: share(doubles.iter().copied(), |j| j.class),
        seconds: Spread::of(&seconds),
        confusion: confusion(&first),
    }
}

fn naming(of: &[&Judgement]) -> Naming {
    let sets: Vec<usize> = of.iter().map(|j| j.names).filter(|&n| n > 0).collect();
    Naming {
        exact: share(of.iter().copied(), |j| j.exact),
        class: share(of.iter().copied(), |j| j.class),
        top3: share(of.iter().copied(), |j| j.top3),
        mean_set: (!sets.is_empty()).then(|| sets.iter().sum::<usize>() as f64 / sets.len() as f64),
    }
}

fn location(of: &[&Judgement]) -> LocationScore {
    let overlaps: Vec<f64> = of.iter().filter_map(|j| j.band_overlap).collect();
    LocationScore {
        interface: share(of.iter().copied(), |j| j.place_right),
        phase: share(of.iter().copied().filter(|j| j.phase_right.is_some()), |j| j.phase_right == Some(true)),
        band_touches: Proportion::new(overlaps.iter().filter(|o| **o > 0.0).count(), overlaps.len()),
        band_overlap: Spread::of(&overlaps),
    }
}

fn closing(of: &[&Judgement]) -> Closing {
    let right: Vec<&Judgement> = of.iter().copied().filter(|j| j.exact).collect();
    let closed: Vec<f64> = right.iter().filter_map(|j| j.closed).collect();
    let error: Vec<f64> = right.iter().filter_map(|j| Some((j.closed? - j.closed_truth?).abs())).collect();
    let held: Vec<bool> = right.iter().filter_map(|j| Some((j.closed95?, j.closed_truth?))).map(|([a, b], t)| a <= t && t <= b).collect();
    Closing {
        closed: Spread::of(&closed),
        error: Spread::of(&error),
        covered: Proportion::new(held.iter().filter(|h| **h).count(), held.len()),
    }
}

/// Doubles and what lies outside the list have rows of their own; single effects and look-alikes share theirs.
fn confusion(of: &[&Judgement]) -> Confusion {
    let mut rows: BTreeMap<String, BTreeMap<String, usize>> = BTreeMap::new();
    for judged in of {
        let truth = match (judged.kind, judged.truth.first()) {
            (Kind::Single | Kind::LookAlike, Some(id)) => id.clone(),
            _ => format!("({})", word(&judged.kind)),
        };
        *rows.entry(truth).or_default().entry(judged.first().to_owned()).or_default() += 1;
    }
    Confusion { rows }
}

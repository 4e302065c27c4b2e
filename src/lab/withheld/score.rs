//! Scores over all cases.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use numeric::statistics::{median, quantile};
use reference_simulator::{Kind, Strength};

use super::breakdown::{LayoutScore, OutsideScore, SingleScore, by_effect, by_layout, by_size, groups};
use super::judge::Judgement;
use super::proportion::{Proportion, share};

/// Quantiles of a quantity.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Spread {
    /// Number of values.
    pub of: usize,
    /// 10 % quantile.
    pub low10: Option<f64>,
    /// Median.
    pub median: Option<f64>,
    /// Largest value.
    pub max: Option<f64>,
}

impl Spread {
    /// Computes the quantiles of values.
    pub fn of(values: &[f64]) -> Self {
        Self {
            of: values.len(),
            low10: quantile(values.iter().copied(), 0.1),
            median: median(values.iter().copied()),
            max: values.iter().copied().reduce(f64::max),
        }
    }
}

/// Correct names in one range of strengths: single effects, abstentions and failures counted as wrong.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Naming {
    /// The one true effect is named alone.
    pub exact: Proportion,
    /// A named set contains it.
    pub class: Proportion,
    /// It is among the first three of the ranked list.
    pub top3: Proportion,
    /// Mean number of named effects, over verdicts that name any.
    pub mean_set: Option<f64>,
}

/// Correct locations.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct LocationScore {
    /// Correct interfaces, of all cases: failures and empty lists count as wrong.
    pub interface: Proportion,
    /// Stated sets of places that hold a true one, of all stated ones.
    pub places_hold: Proportion,
    /// Number of places of a set.
    pub places: Spread,
    /// Correct phases, of all cases in motion.
    pub phase: Proportion,
    /// Intersection over union of bands on the logarithmic axis, where both are stated.
    pub band_overlap: Spread,
    /// Bands that overlap at all, among these.
    pub band_touches: Proportion,
}

/// Shares of the gap closed by named effects, over correct verdicts that name one.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Closing {
    /// Closed share.
    pub closed: Spread,
    /// Error of the closed share: difference from that of the true effects; for motion, from that of the
    /// chosen model without noise.
    pub error: Spread,
    /// Intervals that contain the true share.
    pub covered: Proportion,
}

/// Confusion matrix: rows are truths, columns the first named effect, else the kind of verdict.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Confusion {
    /// Counts by truth and answer.
    pub rows: BTreeMap<String, BTreeMap<String, usize>>,
}

/// All scores.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Scores {
    /// Cases without a diagnosis, second measurements included.
    pub failed: Proportion,
    /// Correct verdicts, by kind of case.
    pub right_by_kind: BTreeMap<String, Proportion>,
    /// Ordinary nulls with a reported discrepancy, among answered ones.
    pub false_alarm_ordinary: Proportion,
    /// Ordinary nulls with a named effect of the library, among answered ones.
    pub false_name_ordinary: Proportion,
    /// Hard nulls with an incorrect discrepancy, among answered ones.
    pub false_alarm_hard: Proportion,
    /// Wrong parameters with the verdict «wrong-parameter» or «none».
    pub wrong_parameter: Proportion,
    /// Wrong parameters frozen by the case, with the verdict «wrong-parameter».
    pub wrong_parameter_frozen: Proportion,
    /// Bad channels with the verdict «measurement».
    pub bad_channel: Proportion,
    /// Reported discrepancies where an effect is missing, by kind of case.
    pub detection_by_kind: BTreeMap<String, Proportion>,
    /// The same for single effects, by strength.
    pub detection_by_strength: BTreeMap<String, Proportion>,
    /// The same for single effects, by non-centrality.
    pub detection_by_noncentrality: BTreeMap<String, Proportion>,
    /// Names of single effects of all strengths.
    pub naming: Naming,
    /// Names of single effects with a specified non-centrality of at least 25.
    pub naming_from_25: Naming,
    /// Correct verdicts among those that name one effect, all kinds of cases.
    pub selective: Proportion,
    /// Verdicts that name one effect, among single effects of a non-centrality of at least 25.
    pub selective_coverage: Proportion,
    /// Unknown effects with the verdict «unknown».
    pub unknown: Proportion,
    /// Unknown effects with a named effect of the library.
    pub unknown_misnamed: Proportion,
    /// Single effects and look-alikes with the verdict «unknown».
    pub known_called_unknown: Proportion,
    /// Location and band of single effects (of a non-centrality of at least 25) and look-alikes.
    pub location: LocationScore,
    /// Location and band of unknown effects.
    pub location_unknown: LocationScore,
    /// Closed shares.
    pub closing: Closing,
    /// Look-alikes: a named set contains the truth.
    pub look_alike_class: Proportion,
    /// Look-alikes: exact with the first measurement.
    pub look_alike_exact: Proportion,
    /// Look-alikes: exact with the second measurement.
    pub look_alike_resolved: Proportion,
    /// Doubles: both effects named.
    pub double_both: Proportion,
    /// Doubles: the dominant effect named.
    pub double_dominant: Proportion,
    /// Single effects by fitted non-centrality.
    pub by_size: BTreeMap<String, SingleScore>,
    /// By effect: cases with one effect from the visible size, look-alikes included.
    pub by_effect: BTreeMap<String, SingleScore>,
    /// Scores by layout; empty for machines of the catalogue.
    pub by_layout: BTreeMap<String, LayoutScore>,
    /// Outside causes by kind.
    pub outside: OutsideScore,
    /// Duration of each diagnosis (s).
    pub seconds: Spread,
    /// Confusion matrix of first measurements.
    pub confusion: Confusion,
}

/// Returns the name of a value in its document.
fn word<T: Serialize>(value: &T) -> String {
    serde_json::to_value(value).ok().and_then(|v| v.as_str().map(str::to_owned)).unwrap_or_default()
}

fn by(
    of: &[&Judgement],
    key: impl Fn(&Judgement) -> Option<String>,
    counted: impl Fn(&Judgement) -> bool,
) -> BTreeMap<String, Proportion> {
    groups(of, key).into_iter().map(|(key, group)| (key, share(group, &counted))).collect()
}

/// Returns the range of a non-centrality.
fn range(noncentrality: f64) -> &'static str {
    match noncentrality {
        d if d < 16.0 => "0-16",
        d if d < 50.0 => "16-50",
        d if d < 200.0 => "50-200",
        _ => "from 200",
    }
}

/// Computes all scores.
pub fn scores(judged: &[Judgement]) -> Scores {
    let first: Vec<&Judgement> = judged.iter().filter(|j| !j.follow_up).collect();
    let of = |kinds: &[Kind]| -> Vec<&Judgement> {
        first.iter().copied().filter(|j| kinds.contains(&j.kind)).collect()
    };
    let answered = |all: Vec<&'_ Judgement>| -> Vec<Judgement> {
        all.into_iter().filter(|j| j.answered).cloned().collect()
    };
    let nulls = answered(of(&[Kind::Null]));
    let hard = answered(of(&[Kind::HardNullWrongParameter, Kind::HardNullBadChannel]));
    let wrong = of(&[Kind::HardNullWrongParameter]);
    let singles = of(&[Kind::Single]);
    let from_25: Vec<&Judgement> =
        singles.iter().copied().filter(|j| j.strength != Some(Strength::Faint)).collect();
    let unknowns = of(&[Kind::Unknown]);
    let alike = of(&[Kind::LookAlike]);
    let doubles = of(&[Kind::Double]);
    let planted = of(&[Kind::Single, Kind::LookAlike, Kind::Double, Kind::Unknown]);
    let known: Vec<&Judgement> = singles.iter().chain(&alike).copied().collect();
    let placed: Vec<&Judgement> = from_25.iter().chain(&alike).copied().collect();
    let verdict_is = |kind: &'static str| move |j: &Judgement| j.verdict.kind == kind;
    let seconds: Vec<f64> = judged.iter().map(|j| j.seconds).collect();
    Scores {
        failed: share(judged, |j| !j.answered),
        right_by_kind: by(&first, |j| Some(word(&j.kind)), |j| j.right),
        false_alarm_ordinary: share(&nulls, |j| j.claims),
        false_name_ordinary: share(&nulls, |j| j.names > 0),
        false_alarm_hard: share(&hard, |j| j.claims && !j.right),
        wrong_parameter: share(wrong.iter().copied(), |j| j.right),
        wrong_parameter_frozen: share(
            wrong.iter().copied().filter(|j| j.frozen),
            verdict_is("wrong-parameter"),
        ),
        bad_channel: share(of(&[Kind::HardNullBadChannel]), |j| j.right),
        detection_by_kind: by(&planted, |j| Some(word(&j.kind)), |j| j.claims),
        detection_by_strength: by(&singles, |j| j.strength.map(|s| word(&s)), |j| j.claims),
        detection_by_noncentrality: by(&singles, |j| j.noncentrality.map(|d| range(d).into()), |j| j.claims),
        naming: naming(&singles),
        naming_from_25: naming(&from_25),
        selective: share(first.iter().copied().filter(|j| j.verdict.single().is_some()), |j| {
            j.single_right == Some(true)
        }),
        selective_coverage: share(from_25.iter().copied(), |j| j.verdict.single().is_some()),
        unknown: share(unknowns.iter().copied(), |j| j.right),
        unknown_misnamed: share(unknowns.iter().copied(), |j| j.names > 0),
        known_called_unknown: share(known.iter().copied(), verdict_is("unknown")),
        location: location(&placed),
        location_unknown: location(&unknowns),
        closing: closing(&known),
        look_alike_class: share(alike.iter().copied(), |j| j.class),
        look_alike_exact: share(alike.iter().copied(), |j| j.exact),
        look_alike_resolved: share(judged.iter().filter(|j| j.follow_up && j.kind == Kind::LookAlike), |j| {
            j.exact
        }),
        double_both: share(doubles.iter().copied(), |j| j.all_named),
        double_dominant: share(doubles.iter().copied(), |j| j.class),
        by_size: by_size(&singles),
        by_effect: by_effect(&known),
        by_layout: by_layout(&first),
        outside: OutsideScore::of(&unknowns),
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
    let sets = || of.iter().filter_map(|j| j.places_hold);
    LocationScore {
        places_hold: Proportion::new(sets().filter(|set| set.hold).count(), sets().count()),
        places: Spread::of(&sets().map(|set| set.count as f64).collect::<Vec<f64>>()),
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
    let held: Vec<bool> = right
        .iter()
        .filter_map(|j| Some((j.closed95?, j.closed_truth?)))
        .map(|([a, b], t)| a <= t && t <= b)
        .collect();
    Closing {
        closed: Spread::of(&closed),
        error: Spread::of(&error),
        covered: Proportion::new(held.iter().filter(|h| **h).count(), held.len()),
    }
}

/// Counts the confusion matrix. Doubles and effects outside the library have rows by kind; single effects and
/// look-alikes share rows by effect.
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

//! One answer against one label.

use reference_simulator::{Kind, Label, Strength};

use super::answer::{Answer, DiagnosisAnswer, VerdictAnswer};

/// What one answer is worth. A question that a case does not ask, or that only an answer could settle and there is none, is absent.
#[derive(Debug, Clone, PartialEq)]
pub struct Judgement {
    /// Kind of the case.
    pub kind: Kind,
    /// Whether it is the second measurement of a case.
    pub follow_up: bool,
    /// Strength asked for.
    pub strength: Option<Strength>,
    /// Non-centrality of the dominant effect.
    pub noncentrality: Option<f64>,
    /// Effects, the dominant one first.
    pub truth: Vec<String>,
    /// Parameters declared known.
    pub frozen: bool,
    /// The verdict, or a failure in its place.
    pub verdict: VerdictAnswer,
    /// A diagnosis was given.
    pub answered: bool,
    /// It claims that something is amiss.
    pub claims: bool,
    /// The verdict is what the case calls for.
    pub right: bool,
    /// It names the one effect, and nothing else.
    pub exact: bool,
    /// It names a set that holds the dominant effect.
    pub class: bool,
    /// The dominant effect is among the first three of the ranked list.
    pub top3: bool,
    /// One answer of its names holds all effects of the case.
    pub all_named: bool,
    /// Effects it names.
    pub names: usize,
    /// It names one effect: whether that is one of the case.
    pub single_right: Option<bool>,
    /// The place it states is one where an effect of the case sits.
    pub place_right: bool,
    /// The phase it states is one in which the effects of the case show; absent for data without phases.
    pub phase_right: Option<bool>,
    /// Overlap of bands over their union, on the logarithmic axis, where both are known.
    pub band_overlap: Option<f64>,
    /// What the truth can close; in motion what the chosen model closes without noise.
    pub closed_truth: Option<f64>,
    /// What the named effect closes.
    pub closed: Option<f64>,
    /// Its interval.
    pub closed95: Option<[f64; 2]>,
    /// Seconds.
    pub seconds: f64,
}

/// Judges an answer.
pub fn judge(label: &Label, follow_up: bool, answer: &Answer) -> Judgement {
    let diagnosis = answer.diagnosis.as_ref().ok();
    let verdict = match &answer.diagnosis {
        Ok(diagnosis) => diagnosis.verdict.clone(),
        Err(reason) => VerdictAnswer::failed(reason),
    };
    let named: Vec<&str> = verdict.named();
    let dominant = label.effects.first().map(String::as_str);
    let holds = |names: &[&str]| !label.effects.is_empty() && label.effects.iter().all(|id| names.contains(&id.as_str()));
    let class = dominant.is_some_and(|id| named.contains(&id));
    let exact = verdict.single().is_some_and(|id| label.effects.len() == 1 && Some(id) == dominant);
    // Alternatives of an ambiguous verdict each stand for themselves; the ids of the other kind explain together.
    let all_named = match verdict.kind.as_str() {
        "ambiguous" => verdict.effects.iter().any(|entry| holds(&entry.split('+').map(str::trim).collect::<Vec<_>>())),
        _ => holds(&named),
    };
    let kind = verdict.kind.as_str();
    let right = match label.kind {
        Kind::Null => kind == "none",
        Kind::HardNullWrongParameter => ["none", "wrong-parameter"].contains(&kind),
        Kind::HardNullBadChannel => kind == "measurement",
        Kind::Single => exact,
        Kind::LookAlike => class,
        Kind::Double => all_named,
        Kind::Unknown => kind == "unknown",
    };
    let chosen = diagnosis.and_then(|d| chosen(d, &named));
    Judgement {
        kind: label.kind,
        follow_up,
        strength: label.strength,
        noncentrality: label.noncentrality.first().copied(),
        truth: label.effects.clone(),
        frozen: !label.frozen.is_empty(),
        answered: diagnosis.is_some(),
        claims: !["none", "insufficient", "failed"].contains(&kind),
        right,
        exact,
        class,
        top3: dominant.is_some_and(|id| diagnosis.is_some_and(|d| first_three(d).contains(&id))),
        all_named,
        names: named.len(),
        single_right: verdict.single().map(|id| label.effects.iter().any(|effect| effect == id)),
        place_right: diagnosis
            .and_then(stated_place)
            .is_some_and(|place| label.places.iter().any(|truth| truth.accepted.iter().any(|name| name.eq_ignore_ascii_case(place)))),
        phase_right: (!label.phases.is_empty()).then(|| {
            let stated = diagnosis.and_then(stated_phase).map(plain);
            stated.is_some_and(|phase| label.phases.iter().any(|truth| plain(truth) == phase))
        }),
        band_overlap: verdict.band_hz.zip(label.band_hz).and_then(|(a, b)| overlap(a, b)),
        closed_truth: label.gap.closed,
        closed: chosen.and_then(|(closed, _)| closed),
        closed95: chosen.and_then(|(_, closed95)| closed95),
        seconds: answer.seconds,
        verdict,
    }
}

impl Judgement {
    /// The first effect it names, or the kind of its verdict.
    pub fn first(&self) -> &str {
        self.verdict.named().first().copied().unwrap_or(&self.verdict.kind)
    }
}

/// The first three different effects of the ranked list that were tried.
fn first_three(diagnosis: &DiagnosisAnswer) -> Vec<&str> {
    let mut ids = Vec::new();
    let tried = diagnosis.effects.iter().filter(|row| !["failed", "not-applicable"].contains(&row.status.as_str()));
    for id in tried.flat_map(|row| row.id.split('+')).map(str::trim) {
        if !ids.contains(&id) {
            ids.push(id);
        }
    }
    ids.truncate(3);
    ids
}

/// What the effects that the verdict names close, and its interval: all of them together, as a row of the list or as the model chosen, else the first.
fn chosen(diagnosis: &DiagnosisAnswer, named: &[&str]) -> Option<(Option<f64>, Option<[f64; 2]>)> {
    let is = |id: &str, names: &[&str]| {
        let ids: Vec<&str> = id.split('+').map(str::trim).collect();
        ids.len() == names.len() && names.iter().all(|name| ids.contains(name))
    };
    let row_of = |names: &[&str]| diagnosis.effects.iter().find(|row| is(&row.id, names)).map(|row| (row.closed, row.closed95));
    let model = || is(&diagnosis.chosen.id, named).then_some((diagnosis.chosen.closed, diagnosis.chosen.closed95));
    row_of(named).or_else(model).or_else(|| row_of(named.get(..1)?))
}

/// The place that the verdict states, else the first of the list.
fn stated_place(diagnosis: &DiagnosisAnswer) -> Option<&str> {
    let listed = || diagnosis.places.first().and_then(|place| place.interface.as_deref());
    diagnosis.verdict.interface.as_deref().or_else(listed)
}

/// The phase that the verdict states, else that of the first place that has one, else the one of the largest gap.
fn stated_phase(diagnosis: &DiagnosisAnswer) -> Option<&str> {
    let listed = || diagnosis.places.iter().find_map(|place| place.phase.as_deref());
    let gaps = diagnosis.gap.by_phase.iter().filter_map(|(phase, gap)| gap.map(|gap| (phase.as_str(), gap)));
    let largest = || gaps.max_by(|(_, a), (_, b)| a.total_cmp(b)).map(|(phase, _)| phase);
    diagnosis.verdict.phase.as_deref().or_else(listed).or_else(largest)
}

/// A name in one spelling: constant_speed and constant speed are constant-speed.
fn plain(name: &str) -> String {
    name.to_ascii_lowercase().replace(['_', ' '], "-")
}

/// Intersection over union of two bands on the logarithmic axis.
fn overlap([a, b]: [f64; 2], [c, d]: [f64; 2]) -> Option<f64> {
    if !(a > 0.0 && b > a && c > 0.0 && d > c) {
        return None;
    }
    let both = (b.min(d) / a.max(c)).ln().max(0.0);
    Some(both / ((b / a).ln() + (d / c).ln() - both))
}

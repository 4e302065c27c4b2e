//! Judgement of one answer against one label.

use reference_simulator::{Kind, Label, Strength, VISIBLE};

use report::diagnosis::effect_ids;

use super::answer::{Answer, DiagnosisAnswer, VerdictAnswer};

/// Judgement of one answer. A field that does not apply to the case, or that needs an answer where there is
/// none, is absent.
#[derive(Debug, Clone, PartialEq)]
pub struct Judgement {
    /// Kind of the case.
    pub kind: Kind,
    /// Whether it is the second measurement of a case.
    pub follow_up: bool,
    /// Specified strength.
    pub strength: Option<Strength>,
    /// Non-centrality of the dominant effect.
    pub noncentrality: Option<f64>,
    /// Non-centrality of the dominant effect at the given positions after a fit of joints and tolerances;
    /// where the label has none, that of the whole test.
    pub size: Option<f64>,
    /// Whether the dominant effect is so small that «none» is right, too.
    pub may_be_none: bool,
    /// Layout of the machine.
    pub layout: Option<String>,
    /// Whether an effect of the library imitates the outside cause within noise and tolerances.
    pub imitated: bool,
    /// Effects, the dominant one first.
    pub truth: Vec<String>,
    /// Whether the user declares parameters known.
    pub frozen: bool,
    /// The verdict, or a failure in its place.
    pub verdict: VerdictAnswer,
    /// Whether there is a diagnosis.
    pub answered: bool,
    /// Whether the verdict reports a discrepancy.
    pub claims: bool,
    /// Whether the verdict is correct for this kind of case.
    pub right: bool,
    /// Whether it names the one true effect and no other.
    pub exact: bool,
    /// Whether it names a set that contains the dominant effect.
    pub class: bool,
    /// Whether the dominant effect is among the first three of the ranked list.
    pub top3: bool,
    /// Whether one of its alternatives contains all effects of the case.
    pub all_named: bool,
    /// Number of named effects.
    pub names: usize,
    /// Whether the effect is one of the case, for a verdict that names exactly one.
    pub single_right: Option<bool>,
    /// Whether the stated location is that of an effect of the case.
    pub place_right: bool,
    /// The stated set of places; absent without one, or where nothing is missing.
    pub places_hold: Option<PlacesHold>,
    /// Whether the stated phase is one in which the effects of the case show; absent for data without phases.
    pub phase_right: Option<bool>,
    /// Intersection over union of the bands on the logarithmic axis, where both are known.
    pub band_overlap: Option<f64>,
    /// Share of the gap closed by the true effects; for motion, by the chosen model without noise.
    pub closed_truth: Option<f64>,
    /// Share of the gap closed by the named effect.
    pub closed: Option<f64>,
    /// 95 % interval of that share.
    pub closed95: Option<[f64; 2]>,
    /// Duration (s).
    pub seconds: f64,
}

/// Judges an answer against the label of its case.
pub fn judge(label: &Label, follow_up: bool, answer: &Answer) -> Judgement {
    let diagnosis = answer.diagnosis.as_ref().ok();
    let verdict = match &answer.diagnosis {
        Ok(diagnosis) => diagnosis.verdict.clone(),
        Err(failure) => VerdictAnswer::failed(&failure.to_string()),
    };
    let named: Vec<&str> = verdict.named();
    let dominant = label.effects.first().map(String::as_str);
    let holds = |names: &[&str]| {
        !label.effects.is_empty() && label.effects.iter().all(|id| names.contains(&id.as_str()))
    };
    let class = dominant.is_some_and(|id| named.contains(&id));
    let exact = verdict.single().is_some_and(|id| label.effects.len() == 1 && Some(id) == dominant);
    // Each alternative of an ambiguous verdict stands for itself; the ids of other verdicts act together.
    let all_named = match verdict.kind.as_str() {
        "ambiguous" => verdict.effects.iter().any(|entry| holds(&effect_ids(entry).collect::<Vec<_>>())),
        _ => holds(&named),
    };
    let kind = verdict.kind.as_str();
    let fitted = label.fitted_noncentrality.first().copied();
    let may_be_none = fitted.is_some_and(|size| size < VISIBLE);
    // Sensors pass no constant: a statement of that is true, though the machine lacks nothing.
    let has_high_pass = label.hammer.is_some_and(|test| test.high_pass_hz.is_some());
    let is_sensor = label.kind == Kind::Null && has_high_pass && verdict.faults == ["high-pass"];
    let right = match label.kind {
        Kind::Null => kind == "none" || is_sensor,
        Kind::HardNullWrongParameter => ["none", "wrong-parameter"].contains(&kind),
        Kind::HardNullBadChannel => kind == "measurement",
        Kind::Single => exact || may_be_none && kind == "none",
        Kind::LookAlike => class,
        Kind::Double => all_named,
        Kind::Unknown => kind == "unknown",
    };
    let chosen = diagnosis.and_then(|d| chosen(d, &named));
    let is_place = |place: &str| {
        let accepted = label.places.iter().flat_map(|truth| &truth.accepted);
        accepted.into_iter().any(|name| name.eq_ignore_ascii_case(place))
    };
    Judgement {
        kind: label.kind,
        follow_up,
        strength: label.strength,
        noncentrality: label.noncentrality.first().copied(),
        size: fitted.or(label.noncentrality.first().copied()),
        may_be_none,
        layout: label.layout.clone(),
        imitated: label.imitation.as_ref().is_some_and(|closest| closest.noncentrality < VISIBLE),
        truth: label.effects.clone(),
        frozen: !label.frozen.is_empty(),
        answered: diagnosis.is_some(),
        claims: !(["none", "insufficient", "failed"].contains(&kind) || is_sensor),
        right,
        exact,
        class,
        top3: dominant.is_some_and(|id| diagnosis.is_some_and(|d| first_three(d).contains(&id))),
        all_named,
        names: named.len(),
        single_right: verdict.single().map(|id| label.effects.iter().any(|effect| effect == id)),
        place_right: diagnosis.and_then(stated_place).is_some_and(is_place),
        places_hold: (!verdict.places.is_empty() && !label.places.is_empty()).then(|| PlacesHold {
            hold: verdict.places.iter().any(|place| is_place(place)),
            count: verdict.places.len(),
        }),
        phase_right: (!label.phases.is_empty()).then(|| {
            let stated = diagnosis.and_then(stated_phase).map(normalised);
            stated.is_some_and(|phase| label.phases.iter().any(|truth| normalised(truth) == phase))
        }),
        band_overlap: verdict.band_hz.zip(label.band_hz).and_then(|(a, b)| overlap(a, b)),
        // The label's gaps are those of the first measurement.
        closed_truth: label.gap.closed.filter(|_| !follow_up),
        closed: chosen.and_then(|(closed, _)| closed),
        closed95: chosen.and_then(|(_, closed95)| closed95),
        seconds: answer.seconds,
        verdict,
    }
}

/// A stated set of places, compared with the truth.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PlacesHold {
    /// Whether a true place is among them.
    pub hold: bool,
    /// Their number.
    pub count: usize,
}

impl Judgement {
    /// Returns the first named effect, or the kind of the verdict.
    pub fn first(&self) -> &str {
        self.verdict.named().first().copied().unwrap_or(&self.verdict.kind)
    }
}

/// Returns the first three different effects of the ranked list that were fitted.
fn first_three(diagnosis: &DiagnosisAnswer) -> Vec<&str> {
    let mut ids = Vec::new();
    let tried =
        diagnosis.effects.iter().filter(|row| !["failed", "not-applicable"].contains(&row.status.as_str()));
    for id in tried.flat_map(|row| effect_ids(&row.id)) {
        if !ids.contains(&id) {
            ids.push(id);
        }
    }
    ids.truncate(3);
    ids
}

/// Returns the closed share of the effects named by the verdict, and its interval: jointly, from the ranked
/// list or the chosen model, else of the first.
fn chosen(diagnosis: &DiagnosisAnswer, named: &[&str]) -> Option<(Option<f64>, Option<[f64; 2]>)> {
    let is = |id: &str, names: &[&str]| {
        let ids: Vec<&str> = effect_ids(id).collect();
        ids.len() == names.len() && names.iter().all(|name| ids.contains(name))
    };
    let row_of = |names: &[&str]| {
        diagnosis.effects.iter().find(|row| is(&row.id, names)).map(|row| (row.closed, row.closed95))
    };
    let model =
        || is(&diagnosis.chosen.id, named).then_some((diagnosis.chosen.closed, diagnosis.chosen.closed95));
    row_of(named).or_else(model).or_else(|| row_of(named.get(..1)?))
}

/// Returns the location stated by the verdict, else the first of the list.
fn stated_place(diagnosis: &DiagnosisAnswer) -> Option<&str> {
    let listed = || diagnosis.places.first().and_then(|place| place.interface.as_deref());
    diagnosis.verdict.interface.as_deref().or_else(listed)
}

/// Returns the phase stated by the verdict, else that of the first location with one, else the one with the
/// largest gap.
fn stated_phase(diagnosis: &DiagnosisAnswer) -> Option<&str> {
    let listed = || diagnosis.places.iter().find_map(|place| place.phase.as_deref());
    let gaps = diagnosis.gap.by_phase.iter().filter_map(|(phase, gap)| gap.map(|gap| (phase.as_str(), gap)));
    let largest = || gaps.max_by(|(_, a), (_, b)| a.total_cmp(b)).map(|(phase, _)| phase);
    diagnosis.verdict.phase.as_deref().or_else(listed).or_else(largest)
}

/// Normalises the spelling of a name: constant_speed and constant speed become constant-speed.
fn normalised(name: &str) -> String {
    name.to_ascii_lowercase().replace(['_', ' '], "-")
}

/// Returns intersection over union of two bands on the logarithmic axis.
fn overlap([a, b]: [f64; 2], [c, d]: [f64; 2]) -> Option<f64> {
    if !(a > 0.0 && b > a && c > 0.0 && d > c) {
        return None;
    }
    let both = (b.min(d) / a.max(c)).ln().max(0.0);
    Some(both / ((b / a).ln() + (d / c).ln() - both))
}

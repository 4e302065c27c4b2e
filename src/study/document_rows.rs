//! Results of the library as rows of documents.

use std::collections::BTreeMap;

use crate::Study;
use identification::objective::{FrfGap, GAIN_RANGE, MISSING, PositionPrediction};
use identification::{
    Combination, CombinationKind, Coordinate, Doubt, Drawn, Estimate, Identification, ModeResidual,
    Posterior, ToleranceEstimate,
};
use machine::{Machine, Prior};
use measurement::{Frf, MeasurementSet, NoiseSource};
use numeric::statistics::{median, root_mean_square, root_mean_square_of_parts, root_sum_square};
use report::certainty::{
    BasinRow, BootstrapRow, CombinationRow, CoordinateRow, PosteriorRow, PriorRow, ResidualRow, ToleranceRow,
};
use report::document::{FrfRow, LonePeak, OrderRow, ParameterRow, PositionRow};
use report::vocabulary::{PriorKind, Role};

/// Returns parameters by id, with the gain where amplitudes are compared and the values printed for a fit to
/// the same positions.
pub(crate) fn parameters(
    study: &Study,
    found: &Identification,
    fit_positions: &[String],
) -> BTreeMap<String, ParameterRow> {
    let machine = &study.config.machine;
    let printed = study.set.published.parameters(fit_positions);
    let mut rows: BTreeMap<String, ParameterRow> = found
        .estimates
        .iter()
        .map(|e| {
            let id = &machine.parameters[e.parameter].id;
            let published = printed.and_then(|values| values.get(id).copied());
            let (described, fitted) = (&machine.parameters[e.parameter], found.free.contains(&e.parameter));
            let prior = described.prior.filter(|_| fitted).map(|prior| prior_row(prior, described.start));
            let row = parameter_row(machine, (e, &found.doubts), fitted);
            (id.clone(), ParameterRow { published, prior, ..row })
        })
        .collect();
    if found.gain.count > 0 {
        let depends = found.gain_interval95.is_some() && found.gain_identifiable.is_none();
        let row = ParameterRow {
            value: found.gain.gain,
            unit: "1".into(),
            lower: GAIN_RANGE.0,
            upper: GAIN_RANGE.1,
            interval95: found.gain_interval95.map(|(a, b)| [a, b]),
            intervals95: Vec::new(),
            identifiable: found.gain_identifiable,
            depends_on_discrepancy: depends,
            depends_on: found.doubts.iter().filter(|_| depends).map(Doubt::to_string).collect(),
            fitted: found.gain_interval95.is_some(),
            prior: None,
            description: "gain of the measuring chain: measured over predicted amplitude".into(),
            published: None,
        };
        rows.insert("gain".into(), row);
    }
    rows
}

/// Returns the row of one parameter.
pub(crate) fn parameter_row(
    machine: &Machine,
    (estimate, doubts): (&Estimate, &[Doubt]),
    fitted: bool,
) -> ParameterRow {
    let p = &machine.parameters[estimate.parameter];
    let parts = || estimate.intervals95.iter().map(|(a, b)| [*a, *b]).collect();
    ParameterRow {
        value: estimate.value,
        unit: p.unit.clone(),
        lower: p.lower,
        upper: p.upper,
        interval95: estimate.interval95.map(|(a, b)| [a, b]),
        intervals95: if estimate.intervals95.len() > 1 { parts() } else { Vec::new() },
        identifiable: estimate.identifiable,
        depends_on_discrepancy: estimate.depends,
        depends_on: doubts.iter().filter(|_| estimate.depends).map(Doubt::to_string).collect(),
        fitted,
        prior: None,
        description: machine.description_of(estimate.parameter),
        published: None,
    }
}

/// Returns a prior of a quantity with a start value.
fn prior_row(prior: Prior, start: f64) -> PriorRow {
    let kind = match prior {
        Prior::Normal(_) => PriorKind::Normal,
        Prior::LogNormal(_) | Prior::Catalogue(..) => PriorKind::LogNormal,
    };
    PriorRow { mean: prior.value(start, 0.0), sd: prior.sd(), kind }
}

/// Returns tolerances by name.
pub(crate) fn tolerances(estimates: &[ToleranceEstimate]) -> BTreeMap<String, ToleranceRow> {
    let row = |t: &ToleranceEstimate| {
        let prior = prior_row(t.prior, t.mean);
        (t.name.clone(), ToleranceRow { unit: t.unit.clone(), prior, value: t.value, sd: t.sd })
    };
    estimates.iter().map(row).collect()
}

/// Returns a posterior: minima, and the lower triangle of the covariance to nine digits.
pub(crate) fn posterior(posterior: &Posterior) -> PosteriorRow {
    let coordinate = |c: &Coordinate| CoordinateRow {
        name: c.name.clone(),
        of_machine: c.of_machine,
        prior: c.prior.map(|(sd, at)| [at, sd]),
    };
    let rounded = |x: f64| format!("{x:.8e}").parse().unwrap_or(x);
    let row = |at: usize| (0..=at).map(|column| rounded(posterior.covariance[(at, column)])).collect();
    let residual = |r: &ModeResidual| ResidualRow {
        position: r.position.clone(),
        nut_m: r.nut_m,
        order: r.order,
        model_sd: r.model_sd,
        scatter_sd: r.scatter_sd,
        scatter_stated: r.is_scatter_stated,
        deviations: r.deviations.iter().copied().map(rounded).collect(),
        slopes: r.slopes.iter().copied().map(rounded).collect(),
    };
    PosteriorRow {
        residuals: posterior.residuals.iter().map(residual).collect(),
        coordinates: posterior.coordinates.iter().map(coordinate).collect(),
        minima: posterior.minima.iter().map(|place| place.0.clone()).collect(),
        covariance: (0..posterior.coordinates.len()).map(row).collect(),
        variance: posterior.variance,
    }
}

/// Returns the minima that the data do not distinguish from the lowest, where there are several.
pub(crate) fn basins(found: &Identification) -> Vec<BasinRow> {
    if found.basins.len() < 2 {
        return Vec::new();
    }
    let values = |place: &[f64]| {
        let own = found.free.iter().zip(place);
        own.map(|(index, u)| {
            (found.machine.parameters[*index].id.clone(), found.machine.parameters[*index].from_unit(*u))
        })
        .collect()
    };
    found
        .basins
        .iter()
        .map(|b| BasinRow { cost: b.cost, count: b.starts, values: values(&b.place) })
        .collect()
}

/// Returns the root of the summed squares of relative errors. `None` where a measured order is not predicted:
/// a model without that mode must not look better for it.
pub(crate) fn overall<'o>(
    orders: impl IntoIterator<Item = &'o OrderRow>,
    predicted: impl Fn(&OrderRow) -> Option<f64>,
) -> Option<f64> {
    let measured = orders.into_iter().filter(|o| o.measured_hz.is_some());
    let errors: Option<Vec<f64>> = measured.map(|o| Some(predicted(o)? / o.measured_hz? - 1.0)).collect();
    root_sum_square(errors?)
}

/// Returns the row of one position.
pub(crate) fn position(
    set: &MeasurementSet,
    prediction: &PositionPrediction,
    role: Role,
    gain: Option<f64>,
    fit_positions: &[String],
) -> PositionRow {
    let name = &set.positions[prediction.position].name;
    let mut orders: Vec<OrderRow> = Vec::new();
    let mut lone_peaks = Vec::new();
    for deviation in &prediction.deviations {
        let peak = deviation.pair().map(|(_, peak)| peak);
        match (deviation.observed, deviation.predicted) {
            (Some(observed), _) => orders.push(OrderRow {
                order: observed.order,
                measured_hz: observed.frequency_hz,
                predicted_hz: peak.map(|p| p.frequency_hz),
                relative_error: peak.and_then(|p| Some(p.frequency_hz / observed.frequency_hz? - 1.0)),
                measured_amplitude: observed.amplitude,
                predicted_amplitude: peak.and_then(|p| Some(gain? * p.amplitude)),
                published_hz: set.published.predicted_hz(fit_positions, name, observed.order),
            }),
            (None, Some(peak)) => lone_peaks.push(LonePeak {
                frequency_hz: peak.frequency_hz,
                prominence: peak.prominence,
                unexpected: deviation.is_unexpected(),
            }),
            (None, None) => {}
        }
    }
    if let Some(table) = &set.modes {
        for unseen in table.positions[prediction.position].iter().filter(|m| m.frequency_hz.is_none()) {
            orders.push(OrderRow { order: unseen.order, ..OrderRow::default() });
        }
    }
    orders.sort_by_key(|o| o.order);
    let step = set.modes.as_ref().and_then(|t| t.resolution_hz);
    let rounded = |x: f64| step.map(|s| (x / s).round() * s);
    PositionRow {
        overall_error: overall(&orders, |o| o.predicted_hz),
        overall_error_rounded: overall(&orders, |o| o.predicted_hz.and_then(rounded)),
        overall_error_published: overall(&orders, |o| o.published_hz),
        orders,
        lone_peaks,
        ..PositionRow::of_gap(role, None, None)
    }
}

/// Returns FRFs as rows.
pub(crate) fn frfs(set: &MeasurementSet, gaps: &[FrfGap], role: Role) -> Vec<FrfRow> {
    gaps.iter()
        .map(|gap| {
            let frf = &set.frfs[gap.frf];
            FrfRow {
                position: frf.position.map(|p| set.positions[p].name.clone()),
                record: frf.record.clone(),
                response: frf.response.clone(),
                excitation: frf.excitation.clone(),
                role,
                gap: gap.gap,
                noise_floor: gap.noise_floor,
                noise_source: noise_word(frf.noise_source()).into(),
                lines: gap.lines,
                accepted_share: frf.lines.len() as f64 / (frf.lines.len() + frf.rejected.len()) as f64,
            }
        })
        .collect()
}

/// Returns the name of the origin of an FRF's noise, as documents state it.
fn noise_word(source: NoiseSource) -> &'static str {
    match source {
        NoiseSource::Coherence => "coherence",
        NoiseSource::RelativeSd => "relative_sd",
        NoiseSource::Repeats => "repeats",
        NoiseSource::Neighbours => "neighbouring lines",
        NoiseSource::Unknown => "unknown",
    }
}

/// Returns warnings about FRFs whose noise is not stated: how it was estimated, its size, and what to
/// measure.
pub(crate) fn noise_warnings(set: &MeasurementSet) -> Vec<String> {
    let sd = |frf: &Frf| median(frf.component_sds().into_iter().flatten()).unwrap_or(0.0);
    let of = |source: NoiseSource| -> Vec<&Frf> {
        set.frfs.iter().filter(|f| f.noise_source() == source).collect()
    };
    let warning = |source: NoiseSource| {
        let frfs = of(source);
        let names = frfs.iter().map(|f| f.source.as_str()).collect::<Vec<_>>().join(", ");
        let (least, most) = frfs
            .iter()
            .map(|f| 100.0 * sd(f))
            .fold((f64::INFINITY, 0.0_f64), |(a, b), x| (a.min(x), b.max(x)));
        let estimate = match source {
            NoiseSource::Unknown => {
                "unknown: they have too few lines to estimate it, and intervals count the model error alone"
                    .to_string()
            }
            _ => format!(
                "estimated from {}: {least:.2} to {most:.2} % of |H| (median line of each)",
                noise_word(source)
            ),
        };
        let remedy = "measure several blows and state coherence and averages";
        (!frfs.is_empty()).then(|| {
            format!("the noise of {} FRFs is not stated; it is {estimate}; {remedy}: {names}", frfs.len())
        })
    };
    [NoiseSource::Repeats, NoiseSource::Neighbours, NoiseSource::Unknown]
        .into_iter()
        .filter_map(warning)
        .collect()
}

/// Returns the names of one side of a split: positions; for whole FRFs a position with all of its FRFs on
/// that side, else single records.
pub(crate) fn names(
    set: &MeasurementSet,
    positions: &[usize],
    frfs: &[usize],
    whole_frfs: bool,
) -> Vec<String> {
    if !whole_frfs {
        return positions.iter().map(|i| set.positions[*i].name.clone()).collect();
    }
    let mut names: Vec<String> = Vec::new();
    for &i in frfs {
        let frf = &set.frfs[i];
        let whole =
            |p: usize| set.frfs.iter().enumerate().all(|(j, f)| f.position != Some(p) || frfs.contains(&j));
        let name = match (frf.position, &frf.record) {
            (Some(p), _) if whole(p) => set.positions[p].name.clone(),
            (_, Some(record)) => record.clone(),
            (Some(p), None) => set.positions[p].name.clone(),
            (None, None) => frf.source.clone(),
        };
        if !names.contains(&name) {
            names.push(name);
        }
    }
    names
}

/// Groups FRFs by position, or by record where there is no position or where the records of a position have
/// different roles.
pub(crate) fn gathered(frfs: &[FrfRow]) -> BTreeMap<String, PositionRow> {
    let mixed = |name: &String| {
        frfs.iter().any(|a| a.position.as_ref() == Some(name) && a.role != frfs[0].role)
            && frfs.iter().any(|a| a.position.as_ref() == Some(name) && a.role == frfs[0].role)
    };
    let name = |row: &FrfRow| match (&row.position, &row.record) {
        (Some(position), Some(record)) if mixed(position) => format!("{position} {record}"),
        (Some(position), _) => position.clone(),
        (None, Some(record)) => record.clone(),
        (None, None) => "all".into(),
    };
    let mut groups: BTreeMap<String, Vec<&FrfRow>> = BTreeMap::new();
    for row in frfs {
        groups.entry(name(row)).or_default().push(row);
    }
    let mean = |rows: &[&FrfRow], pick: &dyn Fn(&FrfRow) -> Option<f64>| -> Option<f64> {
        let parts: Option<Vec<(f64, usize)>> = rows.iter().map(|r| Some((pick(r)?, r.lines))).collect();
        root_mean_square_of_parts(parts?)
    };
    groups
        .into_iter()
        .map(|(name, rows)| {
            (
                name,
                PositionRow::of_gap(
                    rows[0].role,
                    mean(&rows, &|r| Some(r.gap)),
                    mean(&rows, &|r| r.noise_floor),
                ),
            )
        })
        .collect()
}

/// Returns the gap over several positions: root mean square over their lines.
pub(crate) fn gap_over<'r>(frfs: impl Iterator<Item = &'r FrfRow>) -> Option<f64> {
    root_mean_square_of_parts(frfs.map(|r| (r.gap, r.lines)))
}

/// Returns warnings about driving points that are not passive.
pub(crate) fn passivity_warnings(machine: &Machine, set: &MeasurementSet) -> Vec<String> {
    let remedy = if machine.effects.iter().any(|e| e == "measurement-delay") {
        "the machine contains measurement-delay, which accounts for a delay"
    } else {
        "if it is a delay, add the effect measurement-delay to the machine"
    };
    let mut shown: Vec<String> = Vec::new();
    for frf in &set.frfs {
        if let Some(activity) = frf.activity().filter(|activity| activity.is_active()) {
            shown.push(format!("{} ({:.0} %)", frf.source, 100.0 * activity.lines));
        }
    }
    if shown.is_empty() {
        return Vec::new();
    }
    vec![format!(
        "Im(receptance) of a driving point is positive at a share of the lines, which a delay, a wrong sign or a wrong quantity causes ({remedy}): {}",
        shown.join(", ")
    )]
}

/// Returns combinations as rows.
pub(crate) fn combinations(machine: &Machine, found: &Identification) -> Vec<CombinationRow> {
    let id = |index: usize| machine.parameters[index].id.clone();
    let word = |kind| match kind {
        CombinationKind::Series => "series",
        CombinationKind::Parallel => "parallel",
        CombinationKind::Ratio => "ratio",
        CombinationKind::Opposite => "opposite",
    };
    let row = |c: &Combination| CombinationRow {
        parameters: [id(c.parameters.0), id(c.parameters.1)],
        kind: word(c.kind).into(),
        correlation: c.correlation,
        relative_sd: c.sd,
        description: c.text.clone(),
    };
    found.combinations.iter().map(row).collect()
}

/// Returns bootstraps as rows.
pub(crate) fn bootstraps(machine: &Machine, found: &Identification) -> Vec<BootstrapRow> {
    found
        .bootstraps
        .iter()
        .map(|b| {
            let of = |(&parameter, ends): (&usize, &(f64, f64))| {
                let p = &machine.parameters[parameter];
                (p.id.clone(), [p.from_unit(ends.0), p.from_unit(ends.1)])
            };
            BootstrapRow {
                drawn: if b.drawn == Drawn::Lines { "lines" } else { "positions" }.into(),
                samples: b.samples,
                interval95: found.free.iter().zip(&b.interval95).map(of).collect(),
            }
        })
        .collect()
}

/// Returns all FRFs of an identification.
pub(crate) fn all_frfs(set: &MeasurementSet, found: &Identification) -> Vec<FrfRow> {
    let mut rows = frfs(set, &found.fitted_frfs, Role::Fit);
    rows.extend(frfs(set, &found.held_out_frfs, Role::HeldOut));
    rows
}

/// Returns all positions of an identification.
pub fn positions(
    study: &Study,
    found: &Identification,
    fit_positions: &[String],
) -> BTreeMap<String, PositionRow> {
    if !found.fitted_frfs.is_empty() {
        return gathered(&all_frfs(&study.set, found));
    }
    let gain = (found.gain.count > 0).then_some(found.gain.gain);
    let rows = |predictions: &[PositionPrediction], role: Role| -> Vec<(String, PositionRow)> {
        predictions
            .iter()
            .map(|p| {
                (
                    study.set.positions[p.position].name.clone(),
                    position(&study.set, p, role, gain, fit_positions),
                )
            })
            .collect()
    };
    rows(&found.fitted, Role::Fit).into_iter().chain(rows(&found.held_out, Role::HeldOut)).collect()
}

/// Returns derived quantities by name: largest errors, scatter and gaps.
/// Where nothing is held out, `left_out` names those of fits without each position.
pub(crate) fn derived(
    positions: &BTreeMap<String, PositionRow>,
    frfs: &[FrfRow],
    leave_one_out: bool,
) -> BTreeMap<String, f64> {
    let mut derived = BTreeMap::new();
    for role in [Role::Fit, Role::HeldOut] {
        let called = if leave_one_out { "left_out".into() } else { role.to_string() };
        if let Some(gap) = gap_over(frfs.iter().filter(|r| r.role == role)) {
            derived.insert(format!("gap_{called}"), gap);
        }
        let of_role = || positions.values().filter(|p| p.role == role);
        if let Some(largest) = of_role().filter_map(|p| p.largest_error(MISSING)).reduce(f64::max) {
            derived.insert(format!("largest_frequency_error_{called}"), largest);
        }
        let logs = of_role()
            .flat_map(|p| &p.orders)
            .filter_map(|o| Some((o.predicted_amplitude? / o.measured_amplitude?).ln()));
        if let Some(rms) = root_mean_square(logs) {
            derived.insert(format!("ln_amplitude_rms_{called}"), rms);
        }
    }
    derived
}

/// Returns warnings about modes without a partner.
pub(crate) fn pairing_warnings(positions: &BTreeMap<String, PositionRow>) -> Vec<String> {
    let mut warnings = Vec::new();
    for (name, p) in positions {
        for o in p.orders.iter().filter(|o| o.predicted_hz.is_none()) {
            if let Some(measured_hz) = o.measured_hz {
                warnings.push(format!(
                    "{name}: the model has no peak for order {} measured at {measured_hz} Hz; it counts as an error of 30 %; delete it if it is no mode of this machine",
                    o.order
                ));
            }
        }
        for peak in p.lone_peaks.iter().filter(|p| p.unexpected) {
            warnings.push(format!(
                "{name}: the model has a peak at {:.1} Hz that was not measured; it counts as an error of 30 %; look for it in the FRF",
                peak.frequency_hz
            ));
        }
    }
    warnings
}

//! Tables of result documents for the terminal.

use std::collections::{BTreeMap, BTreeSet};

use super::certainty::{BootstrapRow, PriorRow, ToleranceRow};
use super::document::{
    ComparisonDocument, FrfRow, ObjectivesDocument, OrderRow, ParameterRow, PeaksDocument, PositionRow,
};
use super::terminal::{
    figure, percent, range, table, table_text, unit, width, with_deviation, with_interval, wrapped,
};
use super::text_table::{TextTable, cell};
use super::vocabulary::PriorKind;

/// Width (columns) from which on a table of parameters has a column of descriptions; below, they follow as
/// text.
const DESCRIBED_WIDTH: usize = 110;

/// Says what «depends» in a table of parameters means, and on what the values depend.
pub fn dependence(parameters: &BTreeMap<String, ParameterRow>) -> Option<String> {
    let row = parameters.values().find(|row| row.depends_on_discrepancy)?;
    let on = if row.depends_on.is_empty() {
        "a misfit beyond the noise".into()
    } else {
        row.depends_on.join("; ")
    };
    Some(format!(
        "depends: the interval is narrow, but the fit is not that of the machine as described. The value depends on {on}. Run diagnose to find what the description lacks"
    ))
}

/// Cells of a parameter: value, interval, and whether the data identify it.
pub fn parameter_cells(row: &ParameterRow) -> [String; 3] {
    let identifiable = match (row.fitted, row.identifiable) {
        (false, _) => "not fitted",
        (true, None) if row.depends_on_discrepancy => "depends",
        (true, Some(true)) => "yes",
        _ => "no",
    };
    let (value, interval) = match row.interval95.filter(|ends| ends.iter().all(|x| x.is_finite())) {
        Some(_) if row.intervals95.len() > 1 => {
            let part = |ends: &[f64; 2]| with_interval(row.value, *ends).1;
            (figure(row.value), row.intervals95.iter().map(part).collect::<Vec<_>>().join(" or "))
        }
        Some(ends) => with_interval(row.value, ends),
        None => (figure(row.value), "–".into()),
    };
    [value, interval, identifiable.into()]
}

/// Parameters with description, interval and identifiability (Tab. 3 and 5 of Tian et al.).
pub fn parameters_table(parameters: &BTreeMap<String, ParameterRow>) -> String {
    let is_wide = width() >= DESCRIBED_WIDTH;
    let description = is_wide.then_some("Description");
    let is_published = parameters.values().any(|row| row.published.is_some());
    let published = is_published.then_some("Published");
    let heads = ["Parameter", "Value", "Unit", "95 % interval", "Identifiable"];
    let mut out = table(heads.into_iter().chain(published).chain(description));
    if is_wide {
        let before = heads.len() + usize::from(is_published);
        out.column_iter_mut()
            .skip(before)
            .for_each(|column| column.set_cell_alignment(comfy_table::CellAlignment::Left));
    }
    for (id, row) in parameters {
        let [value, interval, identifiable] = parameter_cells(row);
        let cells = [id.clone(), value, unit(&row.unit), interval, identifiable];
        let published = is_published.then(|| row.published.map_or_else(|| "–".into(), figure));
        out.add_row(cells.into_iter().chain(published).chain(is_wide.then(|| row.description.clone())));
    }
    let note = dependence(parameters).map_or(String::new(), |text| wrapped(&format!(" {text}")));
    let described = parameters.iter().filter(|(_, row)| !is_wide && !row.description.is_empty());
    let list: Vec<String> = described.map(|(id, row)| format!("{id}: {}", row.description)).collect();
    let list = if list.is_empty() { String::new() } else { wrapped(&format!(" {}", list.join("; "))) };
    let priors = parameters.iter().filter_map(|(id, row)| Some(format!("{id} {}", row.prior_text()?)));
    let priors: Vec<String> = priors.collect();
    let priors = match priors.is_empty() {
        true => String::new(),
        false => wrapped(&format!(" prior of the description: {}", priors.join("; "))),
    };
    table_text(&out) + &note + &priors + &list
}

/// A number to three digits.
fn short(x: f64) -> String {
    match x.abs() {
        0.0 => "0".into(),
        size if !(1e-3..1e3).contains(&size) => format!("{x:.1e}"),
        size => format!("{x:.*}", (2.0 - size.log10().floor()) as usize),
    }
}

/// Cells of a tolerance: name, unit, stated value, estimate with its standard deviation, and the move from
/// one to the other. Standard deviations of a log-normal one are factors.
pub fn tolerance_cells((name, row): (&String, &ToleranceRow)) -> [String; 5] {
    let PriorRow { mean, sd, kind } = &row.prior;
    let within = |middle: f64, sd: f64| match *kind == PriorKind::LogNormal {
        true => format!("{} ×÷ {}", short(middle), short(sd.exp())),
        false => format!("{} ± {}", short(middle), short(sd)),
    };
    [
        name.clone(),
        row.unit.clone(),
        within(*mean, *sd),
        within(row.value, row.sd),
        format!("{:+.1} sd", row.deviation()),
    ]
}

/// Heads of [`tolerance_cells`].
pub const TOLERANCE_HEADS: [&str; 5] = ["Tolerance", "Unit", "Stated", "Estimated", "Moved by"];

/// Tolerances fitted as nuisance parameters: how many, and those that moved by more than their standard
/// deviation. `None` where there are none.
pub fn moved_tolerances(tolerances: &BTreeMap<String, ToleranceRow>) -> Option<String> {
    if tolerances.is_empty() {
        return None;
    }
    let moved = || tolerances.iter().filter(|(_, row)| row.deviation().abs() > 1.0);
    let head = format!("{} tolerances are fitted as nuisance parameters; ", tolerances.len());
    if moved().next().is_none() {
        return Some(wrapped(&(head + "none moved by more than its standard deviation")));
    }
    let mut out = table(TOLERANCE_HEADS);
    moved().for_each(|each| {
        out.add_row(tolerance_cells(each));
    });
    Some(wrapped(&(head + "those that moved by more than one standard deviation (sd):")) + &table_text(&out))
}

/// Tabulates the frequencies of each position: measured, predicted, error, and printed where there are such
/// (Tab. 4 of Tian et al.).
pub fn positions(caption: &str, positions: &BTreeMap<String, PositionRow>, leave_one_out: bool) -> TextTable {
    let orders: BTreeSet<u32> = positions.values().flat_map(|p| p.orders.iter().map(|o| o.order)).collect();
    let header =
        ["Position".to_string(), "Hz".into()].into_iter().chain(orders.iter().map(|o| format!("Order {o}")));
    let mut out = TextTable::new(caption, 2, header.chain(["Overall".into()]));
    for (name, p) in positions.iter().filter(|_| !orders.is_empty()) {
        let mut row = |class: &str,
                       first: &str,
                       what: &str,
                       pick: &dyn Fn(&OrderRow) -> Option<String>,
                       last: String| {
            let cells = orders.iter().map(|k| {
                p.orders.iter().find(|o| o.order == *k).and_then(pick).unwrap_or_else(|| "–".into())
            });
            out.row_of(class, [first.to_string(), what.into()].into_iter().chain(cells).chain([last]));
        };
        row("first", name, "measured", &|o| o.measured_hz.map(figure), String::new());
        row("", p.role.label(leave_one_out), "predicted", &|o| o.predicted_hz.map(figure), String::new());
        row("strong", "", "error", &|o| o.relative_error.map(percent), cell(p.overall_error, percent));
        if p.orders.iter().any(|o| o.published_hz.is_some()) {
            row(
                "",
                "",
                "published",
                &|o| o.published_hz.map(figure),
                cell(p.overall_error_published, percent),
            );
        }
    }
    out
}

/// Tabulates the gap of each FRF.
pub fn frfs(rows: &[FrfRow], leave_one_out: bool) -> TextTable {
    let caption = "FRFs, with their gap: the root mean square of ln(measured/predicted), per component";
    let header = ["FRF", "Response/excitation", "Role", "Lines", "Gap", "Noise floor", "Noise from"];
    let mut out = TextTable::new(caption, 3, header);
    for row in rows {
        let names: Vec<&str> =
            [&row.position, &row.record].into_iter().flatten().map(String::as_str).collect();
        out.row([
            names.join(" "),
            format!("{}/{}", row.response, row.excitation),
            row.role.label(leave_one_out).into(),
            row.lines.to_string(),
            figure(row.gap),
            cell(row.noise_floor, figure),
            row.noise_source.clone(),
        ]);
    }
    out
}

/// Tabulates the gap of each position.
pub fn gaps(caption: &str, positions: &BTreeMap<String, PositionRow>) -> TextTable {
    let mut out = TextTable::new(caption, 2, ["Position", "Role", "Gap", "Noise floor"]);
    for (name, p) in positions.iter().filter(|(_, p)| p.gap.is_some()) {
        out.row([name.clone(), p.role.label(false).into(), cell(p.gap, figure), cell(p.noise_floor, figure)]);
    }
    out
}

/// Tabulates intervals by bootstrap.
pub fn bootstrap(bootstraps: &[BootstrapRow]) -> TextTable {
    let header = bootstraps.iter().map(|b| format!("{} × {}", b.samples, b.drawn));
    let mut out =
        TextTable::new("95 % of bootstrap samples", 1, ["Bootstrap".to_string()].into_iter().chain(header));
    for id in bootstraps.iter().flat_map(|b| b.interval95.keys()).collect::<BTreeSet<_>>() {
        let cells =
            bootstraps.iter().map(|b| b.interval95.get(id).map_or_else(|| "–".into(), |ends| range(*ends)));
        out.row([id.clone()].into_iter().chain(cells));
    }
    out
}

/// Tabulates single- against multi-position identification: errors of frequencies (Tab. 5 of Tian et al.), or
/// gaps of FRFs.
pub fn summary(of: &ComparisonDocument) -> TextTable {
    let is_of_gaps = of.runs.values().any(|run| run.common_gap.is_some());
    let (caption, names) = match is_of_gaps {
        true => ("Gaps at the positions held out", 1),
        false => ("Overall frequency errors at the positions held out", 2),
    };
    let header = std::iter::once("Fitted on".to_string())
        .chain((names > 1).then(String::new))
        .chain(of.common_positions.iter().cloned());
    let mut out = TextTable::new(caption, names, header.chain(["together".into()]));
    for run in of.runs.values() {
        let on = run.fit_positions.join(",");
        let line = |pick: fn(&PositionRow) -> Option<f64>, write: fn(f64) -> String| -> Vec<String> {
            of.common_positions.iter().map(|p| cell(run.positions.get(p).and_then(pick), write)).collect()
        };
        if is_of_gaps {
            out.row(std::iter::once(on).chain(line(|p| p.gap, figure)).chain([cell(run.common_gap, figure)]));
            continue;
        }
        let mut row = |first: String, what: &str, middle: Vec<String>, last: String| {
            out.row([first, what.into()].into_iter().chain(middle).chain([last]));
        };
        row(on, "ours", line(|p| p.overall_error, percent), cell(run.common_error, percent));
        if run.common_error_published.is_some() {
            row(String::new(), "rounded", line(|p| p.overall_error_rounded, percent), String::new());
            row(
                String::new(),
                "published",
                line(|p| p.overall_error_published, percent),
                cell(run.common_error_published, percent),
            );
        }
    }
    out
}

/// Tracked modes, record by record; spurious ones only where asked for, with the reasons.
pub fn peaks_table(peaks: &PeaksDocument, all: bool) -> String {
    if !peaks.modes.iter().any(|m| all || m.regular) {
        let what =
            if peaks.fits.len() == 1 { "the FRF" } else { &format!("any of {} FRFs", peaks.fits.len()) };
        return format!("no mode found in {what}\n");
    }
    let mut text = String::new();
    let amplitude = match peaks.amplitude_unit.as_str() {
        "" => "Amplitude".to_string(),
        stated => format!("Amplitude {}", unit(stated)),
    };
    let mut out = table(["Mode", "Record", "Frequency Hz", "Damping ratio", &amplitude]);
    for mode in peaks.modes.iter().filter(|m| all || m.regular) {
        for (at, (name, row)) in mode.records.iter().enumerate() {
            let label = if mode.regular { format!("{}", mode.order) } else { format!("({})", mode.order) };
            out.add_row([
                if at == 0 { label } else { String::new() },
                name.clone(),
                row.frequency_sd_hz.map_or_else(
                    || figure(row.frequency_hz),
                    |sd| with_deviation(row.frequency_hz, 1.96 * sd),
                ),
                row.damping_sd.map_or_else(
                    || percent(row.damping_ratio),
                    |sd| format!("{} %", with_deviation(100.0 * row.damping_ratio, 196.0 * sd)),
                ),
                figure(row.amplitude),
            ]);
        }
    }
    text += &table_text(&out);
    text.push('\n');
    for mode in peaks.modes.iter().filter(|m| all || m.regular) {
        let verdict = if mode.regular { "a mode" } else { "spurious" };
        let evidence = &mode.evidence;
        let predicted =
            evidence.roughness.map(|r| format!(", predicted from the other records within {}", percent(r)));
        let short = format!(
            "observed in {} of {}{}",
            evidence.observed,
            evidence.expected,
            predicted.unwrap_or_default()
        );
        let why = if all { evidence.reasons.join("; ") } else { short };
        text += &wrapped(&format!("{} at {:.1} Hz, {verdict}: {why}", mode.order, mode.frequency_hz));
    }
    text
}

/// Quantities derived from the parameters.
pub fn derived_table(
    derived: &BTreeMap<String, f64>,
    intervals: &BTreeMap<String, [f64; 2]>,
    names: &[String],
) -> String {
    let mut out = table(["Derived quantity", "Value", "95 % interval"]);
    for name in names {
        let (value, interval) = match (derived.get(name), intervals.get(name)) {
            (Some(value), Some(ends)) => with_interval(*value, *ends),
            (value, _) => (value.map_or_else(|| "–".into(), |x| figure(*x)), "–".into()),
        };
        out.add_row([name.clone(), value, interval]);
    }
    table_text(&out)
}

/// Parameters of each run with their intervals, and the printed values where there are any (Tab. 3 and 5 of
/// Tian et al.).
pub fn run_parameters_table(comparison: &ComparisonDocument) -> String {
    let mut out =
        table(["Parameter", "Fitted on", "Value", "Unit", "95 % interval", "Identifiable", "Published"]);
    let ids: BTreeSet<&String> = comparison.runs.values().flat_map(|run| run.parameters.keys()).collect();
    for id in ids {
        for (at, run) in comparison.runs.values().enumerate() {
            let Some(row) = run.parameters.get(id) else { continue };
            let [value, interval, identifiable] = parameter_cells(row);
            let first = if at == 0 { id.clone() } else { String::new() };
            let published = row.published.map_or_else(|| "–".into(), figure);
            out.add_row([
                first,
                run.fit_positions.join(","),
                value,
                unit(&row.unit),
                interval,
                identifiable,
                published,
            ]);
        }
    }
    table_text(&out)
}

/// Natural frequencies (Hz) of each order over the positions: measured, predicted by each run, and printed
/// (Tab. 4 and 6–9 of Tian et al.). A row shows the trend along the stroke.
pub fn run_frequencies_table(comparison: &ComparisonDocument) -> String {
    let Some(first) = comparison.runs.values().next() else { return String::new() };
    let names: Vec<&String> = first.positions.keys().collect();
    let header = ["Order".to_string(), "Hz".into()].into_iter().chain(names.iter().map(|n| (*n).clone()));
    let mut out = table(header);
    let orders: BTreeSet<u32> =
        first.positions.values().flat_map(|p| p.orders.iter().map(|o| o.order)).collect();
    for (at, order) in orders.iter().enumerate() {
        if at > 0 {
            out.add_row([""]);
        }
        let mut row = |head: String,
                       what: String,
                       run: &super::document::ComparisonRun,
                       pick: fn(&OrderRow) -> Option<f64>| {
            let of = |name: &&String| {
                run.positions.get(*name)?.orders.iter().find(|o| o.order == *order).and_then(pick)
            };
            let cells: Vec<Option<f64>> = names.iter().map(of).collect();
            if cells.iter().any(Option::is_some) {
                let cells = cells.into_iter().map(|x| x.map_or_else(|| "–".into(), figure));
                out.add_row([head, what].into_iter().chain(cells));
            }
        };
        row(order.to_string(), "measured".into(), first, |o| o.measured_hz);
        for run in comparison.runs.values() {
            let on = run.fit_positions.join(",");
            row(String::new(), format!("fitted on {on}"), run, |o| o.predicted_hz);
            row(String::new(), "published".into(), run, |o| o.published_hz);
        }
    }
    table_text(&out)
}

/// Objectives scored by leave-one-position-out cross-validation.
pub fn objectives_table(objectives: &ObjectivesDocument) -> String {
    let mut out = table(["Objective", "Frequency rms", "ln amplitude rms", "Missing modes"]);
    for row in &objectives.objectives {
        let amplitude = row.ln_amplitude_error.map_or_else(|| "–".into(), figure);
        out.add_row([
            row.objective.to_string(),
            percent(row.frequency_error),
            amplitude,
            row.missing.to_string(),
        ]);
    }
    table_text(&out)
}

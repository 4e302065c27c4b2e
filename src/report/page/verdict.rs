//! A diagnosis: the verdict in a sentence, the location of the gap, and the share of it that each effect
//! closes.

use serde_json::{Value, json};

use super::chart::{
    Chart, Switches, axis, bar_layout, colour, layout, line, log_axis, name_axis, percent_axis, scatter, with,
};
use super::curve::{self, PageCurve};
use super::sketch::Sketch;
use super::text::{TextTable, cell, escape, paragraph, rounded};
use crate::diagnosis::{DiagnosisDocument, EffectRow, combination_text, effect_ids};
use crate::diagnosis_text::{interval_text, is_undetermined};
use crate::terminal::{figure, listed, percent, probability, share_closed, unit};
use crate::vocabulary::{EffectStatus, VerdictKind};

/// The verdict in one sentence.
pub fn sentence(of: &DiagnosisDocument) -> String {
    let verdict = &of.verdict;
    let effects = |last: &str, between: &str| {
        let combinations: Vec<String> =
            verdict.effects.iter().map(|combination| combination_text(combination, between)).collect();
        listed(&combinations, last)
    };
    let place = of.places.first().map(|w| format!(" at «{}»", w.place_text())).unwrap_or_default();
    match verdict.kind {
        VerdictKind::None => {
            "The model explains the measurements: no effect is missing beyond noise and tolerances.".into()
        }
        VerdictKind::Effect => format!("The model lacks {}.", effects("and", " together with ")),
        VerdictKind::Ambiguous => {
            format!("The model lacks {}: these data do not distinguish them.", effects("or", " with "))
        }
        VerdictKind::Unknown if verdict.confirmed == Some(false) => {
            "Measurements that were not fitted confirm no effect of the library.".into()
        }
        VerdictKind::Unknown => format!("The model lacks an effect{place} that is not in the library."),
        VerdictKind::WrongParameter => "A parameter that was held fixed is wrong.".into(),
        VerdictKind::Measurement if of.verdict.faults.is_empty() => {
            "The measurements are faulty: no effect makes them consistent.".into()
        }
        VerdictKind::Measurement => format!("The measurements are faulty: {}.", of.verdict.faults.join(", ")),
        VerdictKind::Insufficient => "The data do not suffice for a verdict.".into(),
    }
}

/// What stands under the verdict: reason, location, next measurement, and a sketch with the location marked.
pub fn summary(of: &DiagnosisDocument, machine: &Sketch) -> String {
    let described = of
        .named_effects()
        .filter_map(|row| Some(paragraph(&format!("{}: {}.", row.id, row.description.as_ref()?))));
    let mut out: String = described.collect();
    let without = of.stamp.without.iter().map(|id| format!("without {id}"));
    let changes: Vec<String> = of.stamp.overrides.iter().cloned().chain(without).collect();
    if !changes.is_empty() {
        out += &paragraph(&format!("Changes to the description: {}.", listed(&changes, "and")));
    }
    if !of.verdict.reason.is_empty() {
        out += &paragraph(&of.verdict.reason);
    }
    if let (Some(place), VerdictKind::Effect | VerdictKind::Ambiguous | VerdictKind::WrongParameter) =
        (&of.verdict.place, of.verdict.kind)
    {
        let band = of.verdict.band_text().map_or(String::new(), |band| format!("; {band}"));
        let what = if of.verdict.kind == VerdictKind::Ambiguous { "The first of them" } else { "It" };
        out += &paragraph(&format!("{what} acts at «{place}»{band}."));
    }
    out += &size(of).map_or_else(String::new, |text| paragraph(&text));
    if let Some(phase) = &of.verdict.phase {
        out += &paragraph(&format!("Its residual is largest in this phase of the motion: {phase}."));
    }
    if let Some(next) = &of.verdict.next_measurement {
        out += &format!("<p><strong>Measure next:</strong> {}</p>\n", escape(next));
    }
    out + &of.verdict.place.as_ref().map_or_else(String::new, |place| machine.drawn(place))
}

/// How large the named effects are, and what they change; the gap where none is named.
fn size(of: &DiagnosisDocument) -> Option<String> {
    if of.verdict.effects.is_empty() {
        let (gap, at) =
            of.gap.held_out.map(|gap| (gap, "held-out")).or(of.gap.fit.map(|gap| (gap, "fitted")))?;
        let floor =
            of.noise_floor.map_or_else(String::new, |x| format!(", where noise alone leaves {}", percent(x)));
        return Some(format!("How large: the gap at {at} data is {}{floor}.", percent(gap)));
    }
    let values: Vec<String> = of
        .named_effects()
        .filter(|row| !row.parameters.is_empty())
        .map(|row| format!("{}: {}", row.id, parameter_values(row)))
        .collect();
    let closed = of.chosen.closed.filter(|_| !of.verdict.effects.is_empty());
    let closed = closed.map(|c| {
        let first =
            if of.verdict.kind == VerdictKind::Ambiguous { "the first of them closes" } else { "it closes" };
        format!("{first} {} of the squared held-out gap{}", share_closed(Some(c)), interval_text(of))
    });
    let parts: Vec<String> = values.into_iter().chain(closed).collect();
    (!parts.is_empty()).then(|| format!("How large: {}.", parts.join("; ")))
}

/// The values of the parameters of an effect, with their units.
fn parameter_values(of: &EffectRow) -> String {
    let value = |(id, x): (&String, &f64)| {
        let unit = unit(of.parameter_units.get(id).map_or("", String::as_str));
        format!("{id} = {} {unit}", figure(*x)).trim_end().to_owned()
    };
    of.parameters.iter().map(value).collect::<Vec<_>>().join(", ")
}

/// The section behind the verdict: gap, location, effects.
pub fn content(of: &DiagnosisDocument, curves: &[PageCurve]) -> String {
    let after = if of.chosen.id.is_empty() {
        "as chosen".to_string()
    } else {
        format!("with {}", combination_text(&of.chosen.id, " and "))
    };
    let overlay = curve::chart("diagnosis-curves", curves, &after);
    let motion = super::motion::content(of);
    format!(
        "{}{overlay}{motion}{}{}{}{}{}{}{}{}",
        change(of),
        gaps(of),
        bands(of),
        residual_map(of),
        looks(of),
        places(of),
        delta_z(of),
        effects(of),
        before_after(of)
    )
}

/// What the chosen model changes: the gap, and the headline metrics.
fn change(of: &DiagnosisDocument) -> String {
    let chosen = &of.chosen;
    let mut table =
        TextTable::new("Held-out positions before and after", 1, ["Figure", "as described", "chosen model"]);
    if of.gap.held_out.is_some() && chosen.gap_held_out.is_some() {
        table.row(["gap".to_string(), cell(of.gap.held_out, percent), cell(chosen.gap_held_out, percent)]);
    }
    chosen
        .headline_metrics
        .iter()
        .for_each(|p| table.row([p.figure.clone(), percent(p.before), percent(p.after)]));
    let interval = interval_text(of);
    let ceiling = chosen.ceiling.map_or_else(String::new, |c| {
        format!(" A generic impedance at one interface closes {} at most.", share_closed(Some(c)))
    });
    let closed = chosen.closed.map_or_else(String::new, |c| {
        paragraph(&format!(
            "Share of the squared gap above the noise floor that the chosen model closes: {}{interval}.{ceiling}",
            share_closed(Some(c))
        ))
    });
    format!("{}{closed}", table.html())
}

/// The gap by part.
fn gaps(of: &DiagnosisDocument) -> String {
    let mut table = TextTable::new(
        "Gap between the machine as described and the measurements",
        2,
        ["Over", "Role", "Gap"],
    );
    let mut row = |name: &str, role: &str, x: Option<f64>| {
        if x.is_some() {
            table.row([name.to_string(), role.into(), cell(x, percent)]);
        }
    };
    row("all fitted data", "", of.gap.fit);
    row("all held-out data", "", of.gap.held_out);
    row("noise floor", "", of.noise_floor);
    let role = |name: &String| match (of.fit_positions.contains(name), of.held_out_positions.contains(name)) {
        (true, _) => "fitted",
        (_, true) => "held out",
        _ => "",
    };
    of.gap.by_position.iter().for_each(|(name, x)| row(name, role(name), Some(*x)));
    of.gap.by_mode.iter().enumerate().for_each(|(at, x)| row(&format!("mode {}", at + 1), "", *x));
    of.gap.by_phase.iter().for_each(|(name, x)| row(name, "", Some(*x)));
    table.html()
}

/// Ratio of measured over predicted FRFs.
fn looks(of: &DiagnosisDocument) -> String {
    let mut table =
        TextTable::new("Measured over predicted, by channel", 2, ["Channel", "Pattern", "Factor"]);
    of.ratio.iter().for_each(|r| table.row([r.channel.clone(), r.looks_like.clone(), figure(r.factor)]));
    table.html()
}

fn bands(of: &DiagnosisDocument) -> String {
    let bands = &of.gap.by_band;
    let mut chart = Chart::new(
        "bands",
        "Gap by frequency band",
        "",
        260,
        layout(false, name_axis("frequency band (Hz)"), percent_axis("gap")),
    );
    if !bands.is_empty() {
        let (x, y): (Vec<String>, Vec<f64>) =
            bands.iter().map(|b| (band(b.from_hz, b.to_hz), rounded(b.gap, 4))).unzip();
        let hover = "%{x} Hz: %{y:.1%}<extra></extra>";
        let marker = json!({ "color": colour(0) });
        chart.trace(json!({ "type": "bar", "x": x, "y": y, "marker": marker, "hovertemplate": hover }));
    }
    chart.html()
}

fn band(from_hz: f64, to_hz: f64) -> String {
    format!("{}–{}", whole(from_hz), whole(to_hz))
}

/// A frequency as the name of a band's edge.
fn whole(f: f64) -> String {
    if f >= 10.0 { format!("{f:.0}") } else { rounded(f, 2).to_string() }
}

/// Position and channel against band.
fn residual_map(of: &DiagnosisDocument) -> String {
    if of.residual_map.is_empty() {
        return String::new();
    }
    let mut edges: Vec<(f64, f64)> = of.residual_map.iter().map(|c| (c.from_hz, c.to_hz)).collect();
    edges.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
    edges.dedup();
    let mut names: Vec<String> = Vec::new();
    let name = |c: &crate::diagnosis::ResidualCell| format!("{} {}", c.position, c.channel);
    for c in &of.residual_map {
        if !names.contains(&name(c)) {
            names.push(name(c));
        }
    }
    // The axis begins below.
    names.reverse();
    let mut z: Vec<Vec<Option<f64>>> = vec![vec![None; edges.len()]; names.len()];
    for c in &of.residual_map {
        let at =
            (names.iter().position(|n| *n == name(c)), edges.iter().position(|e| *e == (c.from_hz, c.to_hz)));
        if let (Some(row), Some(column)) = at {
            z[row][column] = Some(rounded(c.gap, 3));
        }
    }
    let mut chart = Chart::new(
        "residual-map",
        "Gap by position, channel and frequency band",
        "The darker a cell, the larger the difference between model and measurement there.",
        130 + 26 * names.len(),
        layout(false, name_axis("frequency band (Hz)"), name_axis("")),
    );
    let x: Vec<String> = edges.iter().map(|e| band(e.0, e.1)).collect();
    let y: Vec<String> = names.iter().map(|n| escape(n)).collect();
    chart.trace(json!({
        "type": "heatmap", "x": x, "y": y, "z": z, "zmin": 0.0, "hoverongaps": false,
        "colorscale": [[0.0, "#FFF7DC"], [0.35, "#E69F00"], [0.7, "#D55E00"], [1.0, "#3B0F00"]],
        "hovertemplate": "%{y}, %{x} Hz: %{z:.3~g}<extra></extra>",
    }));
    chart.html()
}

/// Interfaces by the gap with a generic impedance there; the best on top, as the axis begins below.
fn places(of: &DiagnosisDocument) -> String {
    let known: Vec<_> = of.places.iter().rev().filter_map(|w| Some((w, w.gap_held_out?))).collect();
    let mut chart = Chart::new(
        "where",
        "Held-out gap with a generic impedance at one interface",
        "The named effect comes first, at its location. The shorter the bar, the better a change at this interface alone explains the \
         measurements. Dashed line: gap of the machine as described.",
        110 + 30 * known.len(),
        layout(false, percent_axis("held-out gap"), name_axis("")),
    );
    if !known.is_empty() {
        let (names, left): (Vec<String>, Vec<f64>) = known
            .iter()
            .map(|(w, g)| (escape(&format!("{}, {}", w.place_text(), w.shape_text())), rounded(*g, 4)))
            .unzip();
        let shapes: Vec<String> = known.iter().map(|(w, _)| escape(w.shape_text())).collect();
        let ends: Vec<String> = names.first().into_iter().chain(names.last()).cloned().collect();
        chart.trace(json!({
            "type": "bar", "x": left, "y": names, "orientation": "h", "text": shapes,
            "marker": { "color": colour(0) }, "hovertemplate": "%{y}: %{x:.1%}, like %{text}<extra></extra>",
        }));
        if let Some(now) = of.gap.held_out {
            let pen = with(line("#8A8A8A", 2.0), json!({ "dash": "dash" }));
            let look = json!({ "line": pen, "hovertemplate": "as described: %{x:.1%}<extra></extra>" });
            chart.trace(scatter([now; 2], ends, "lines", look));
        }
    }
    chart.html()
}

/// Whether the verdict names an effect.
fn in_verdict(of: &DiagnosisDocument, effect: &EffectRow) -> bool {
    effect.selected
        || of.verdict.effects.iter().any(|combination| effect_ids(combination).any(|id| id == effect.id))
}

/// Effects that change the gap and those in the verdict, in the order of the document; reversed, as the axis
/// begins below.
fn tried(of: &DiagnosisDocument) -> Vec<&EffectRow> {
    let matters = |e: &&EffectRow| {
        e.status == EffectStatus::Tried && (in_verdict(of, e) || e.closed.is_none_or(|c| c.abs() > 0.005))
    };
    of.effects.iter().filter(matters).take(12).collect::<Vec<_>>().into_iter().rev().collect()
}

fn effects(of: &DiagnosisDocument) -> String {
    let rows: Vec<_> = tried(of).into_iter().filter_map(|e| Some((e, e.closed?))).collect();
    let mut chart = Chart::new(
        "effects",
        "Share of the squared gap that each effect closes, with 95 % intervals",
        "Share of the squared held-out gap above the noise floor that an effect closes; grey bars: 95 % interval, for the named effect. Orange: in the verdict. \
         Effects that close nothing are in the table only.",
        110 + 28 * rows.len(),
        layout(false, percent_axis("share closed"), name_axis("")),
    );
    for (effect, closed) in &rows {
        let interval = effect.closed95.filter(|interval| !is_undetermined(*interval));
        let [low, high] = interval.unwrap_or([*closed; 2]);
        let spread = json!({
            "type": "data", "array": [(high - closed).max(0.0)], "arrayminus": [(closed - low).max(0.0)],
            "symmetric": false, "color": "#8A8A8A",
        });
        // An effect with which the gap grows manyfold would hide the others.
        let bar = json!({
            "type": "bar", "x": [rounded(closed.max(-1.0), 4)], "y": [escape(&effect.id)], "orientation": "h",
            "marker": { "color": colour(usize::from(in_verdict(of, effect))) },
            "hovertemplate": format!("{}: %{{x:.1%}}<extra></extra>", escape(&effect.id)),
        });
        let spread = interval.map_or(Value::Null, |_| json!({ "error_x": spread }));
        chart.trace(with(bar, spread));
    }
    let header = ["Effect", "Values, or why not", "Gap before", "Gap after", "Closed", "95 % interval", "p"];
    let mut table = TextTable::new(
        "Candidates, best first; p: share of null simulations with a statistic as large",
        2,
        header,
    );
    for effect in of.effects.iter().filter(|effect| effect.status != EffectStatus::NotApplicable) {
        let class = if effect.selected { "strong" } else { "" };
        table.row_of(
            class,
            [
                effect.id.clone(),
                match (&effect.why, effect.selected) {
                    (Some(why), _) => why.clone(),
                    (None, true) => format!("in the verdict; {}", parameter_values(effect)),
                    (None, false) => effect.status.to_string(),
                },
                cell(effect.gap_held_out_before.filter(|_| effect.status == EffectStatus::Tried), percent),
                cell(effect.gap_held_out_after, percent),
                share_closed(effect.closed),
                match effect.closed95 {
                    None => "–".into(),
                    Some(wide) if is_undetermined(wide) => "not determined".into(),
                    Some([a, b]) => format!("{} … {}", percent(a), percent(b)),
                },
                cell(effect.p_value, probability),
            ],
        );
    }
    let skipped: Vec<&str> = of
        .effects
        .iter()
        .filter(|e| e.status == EffectStatus::NotApplicable)
        .map(|e| e.id.as_str())
        .collect();
    let skipped = match skipped.is_empty() {
        true => String::new(),
        false => paragraph(&format!("Not applicable to this machine or these data: {}.", skipped.join(", "))),
    };
    format!("{}{}{skipped}", chart.html(), table.html())
}

fn before_after(of: &DiagnosisDocument) -> String {
    let rows: Vec<_> = tried(of)
        .into_iter()
        .filter_map(|e| Some((escape(&e.id), e.gap_held_out_before?, e.gap_held_out_after?)))
        .collect();
    let mut chart = Chart::new(
        "before-after",
        "Held-out gap before and after adding each effect",
        "",
        130 + 34 * rows.len(),
        bar_layout(percent_axis("held-out gap"), name_axis("")),
    );
    if !rows.is_empty() {
        for (what, n, pick) in [("after", 0, 2), ("before", 6, 1)] {
            let x: Vec<f64> = rows.iter().map(|r| rounded(if pick == 1 { r.1 } else { r.2 }, 4)).collect();
            let names: Vec<String> = rows.iter().map(|r| r.0.clone()).collect();
            chart.trace(json!({
                "type": "bar", "x": x, "y": names, "name": what, "orientation": "h",
                "marker": { "color": colour(n) }, "hovertemplate": "%{y}: %{x:.1%}",
            }));
        }
    }
    chart.html()
}

fn delta_z(of: &DiagnosisDocument) -> String {
    let stiffness = with(axis("ΔZ (N/m or N·m/rad)"), json!({ "tickformat": "~e" }));
    let layout = layout(true, log_axis("frequency (Hz)"), stiffness);
    let options: Vec<String> = of.delta_z.iter().map(|d| d.interface.clone()).collect();
    let mut chart = Chart::new(
        "delta-z",
        "Missing dynamic stiffness of an interface over frequency",
        "The change of dynamic stiffness ΔZ(ω) that would explain the residual at each interface: a stiffness is a constant real part, a damper an imaginary part that \
         rises with ω, a mass a real part that falls with ω².",
        360,
        layout,
    )
    .switches(vec![Switches { label: "Interface".into(), options, many: false, coloured: false }]);
    for (at, delta) in of.delta_z.iter().enumerate() {
        for (what, n, part) in [("real part", 0, &delta.real), ("imaginary part", 1, &delta.imag)] {
            let (x, y): (Vec<f64>, Vec<f64>) =
                delta.frequency_hz.iter().zip(part).map(|(f, z)| (rounded(*f, 6), rounded(*z, 5))).unzip();
            let hover = "%{x:.6~g} Hz<br>%{y:.4~g}";
            let look = json!({ "name": what, "line": line(colour(n), 1.6), "hovertemplate": hover });
            chart.trace_for(vec![Some(at)], scatter(x, y, "lines", look));
        }
    }
    chart.html()
}

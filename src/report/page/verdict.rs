//! A diagnosis: the verdict in a sentence, where the gap is, which effect closes how much of it.

use plotly::common::{ColorScale, ColorScaleElement, ErrorData, ErrorType, Marker, Mode, Orientation};
use plotly::layout::{AxisType, BarMode};
use plotly::{Bar, HeatMap, Scatter};

use super::chart::{Chart, Switches, axis, colour, layout, line, log_axis};
use super::curve::{self, PageCurve};
use super::text::{TextTable, cell, escape, listed, paragraph, rounded};
use crate::diagnosis::{DiagnosisDocument, EffectRow, interval_text, is_undetermined};
use crate::terminal::{figure, percent};

/// The verdict in one sentence.
pub fn sentence(of: &DiagnosisDocument) -> String {
    let verdict = &of.verdict;
    let effects = |last: &str| listed(&verdict.effects, last);
    let place = of.places.first().map(|w| format!(" at «{}»", w.place_text())).unwrap_or_default();
    match verdict.kind.as_str() {
        "none" => "The model explains the measurements: there is no gap beyond the noise.".into(),
        "effect" => format!("What the model leaves out is {}.", effects("and").replace('+', " together with ")),
        "ambiguous" => format!("What the model leaves out is {}: these data cannot tell which.", effects("or").replace('+', " with ")),
        "unknown" => format!("There is a gap{place} that no effect of the library explains."),
        "wrong-parameter" => "A parameter that was kept fixed is wrong.".into(),
        "measurement" => "The measurements are at fault: no effect makes them consistent.".into(),
        "insufficient" => "The data do not suffice for a verdict.".into(),
        other => format!("Verdict: {other}."),
    }
}

/// What stands under the verdict: reason, place, next measurement.
pub fn summary(of: &DiagnosisDocument) -> String {
    let mut out = String::new();
    let without = of.stamp.without.iter().map(|id| format!("without {id}"));
    let changes: Vec<String> = of.stamp.overrides.iter().cloned().chain(without).collect();
    if !changes.is_empty() {
        out += &paragraph(&format!("The machine was described {}.", listed(&changes, "and")));
    }
    if !of.verdict.reason.is_empty() {
        out += &paragraph(&of.verdict.reason);
    }
    if let (Some(place), "effect" | "ambiguous" | "wrong-parameter") = (&of.verdict.place, of.verdict.kind.as_str()) {
        let band = of.verdict.band_text().map_or(String::new(), |band| format!("; {band}"));
        let what = if of.verdict.kind == "ambiguous" { "The first of them" } else { "It" };
        out += &paragraph(&format!("{what} acts at «{place}»{band}."));
    }
    if let Some(phase) = &of.verdict.phase {
        out += &paragraph(&format!("It shows most at this phase of the motion: {phase}."));
    }
    if let Some(next) = &of.verdict.next_measurement {
        out += &format!("<p><strong>Measure next:</strong> {}</p>\n", escape(next));
    }
    out
}

/// The section behind the verdict: how far, where, which.
pub fn content(of: &DiagnosisDocument, curves: &[PageCurve]) -> String {
    let after = if of.chosen.id.is_empty() { "as chosen".to_string() } else { format!("with {}", of.chosen.id.replace('+', " and ")) };
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

/// What the chosen model changes: the gap, and errors in plain units.
fn change(of: &DiagnosisDocument) -> String {
    let chosen = &of.chosen;
    let mut table = TextTable::new("Before and after, over what was held out", 1, ["", "as described", "as chosen"]);
    if of.gap.held_out.is_some() && chosen.gap_held_out.is_some() {
        table.row(["gap".to_string(), cell(of.gap.held_out, percent), cell(chosen.gap_held_out, percent)]);
    }
    chosen.headline_metrics.iter().for_each(|p| table.row([p.figure.clone(), percent(p.before), percent(p.after)]));
    let interval = interval_text(chosen.closed95, "95 %: ");
    let ceiling =
        chosen.ceiling.map_or_else(String::new, |c| format!(" The best free change at one interface would close {}.", percent(c)));
    let closed = chosen
        .closed
        .map_or_else(String::new, |c| paragraph(&format!("Of the gap above the noise {}{interval} is closed.{ceiling}", percent(c))));
    format!("{}{closed}", table.html())
}

/// The gap by part.
fn gaps(of: &DiagnosisDocument) -> String {
    let mut table = TextTable::new("The gap between the machine as described and what was measured", 2, ["Over", "", "Gap"]);
    let mut row = |name: &str, role: &str, x: Option<f64>| {
        if x.is_some() {
            table.row([name.to_string(), role.into(), cell(x, percent)]);
        }
    };
    row("all that was fitted", "", of.gap.fit);
    row("all that was held out", "", of.gap.held_out);
    row("the noise alone", "", of.noise_floor);
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

/// What the ratio of measured and modelled looks like.
fn looks(of: &DiagnosisDocument) -> String {
    let mut table = TextTable::new("Measured over modelled, by channel", 2, ["Channel", "looks like", "Factor"]);
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
        layout().x_axis(axis("frequency band (Hz)").type_(AxisType::Category)).y_axis(axis("gap").tick_format(".0%")),
    );
    if !bands.is_empty() {
        let (x, y): (Vec<String>, Vec<f64>) = bands.iter().map(|b| (band(b.from_hz, b.to_hz), rounded(b.gap, 4))).unzip();
        chart.trace(Bar::new(x, y).marker(Marker::new().color(colour(0))).hover_template("%{x} Hz: %{y:.1%}<extra></extra>"));
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
        let at = (names.iter().position(|n| *n == name(c)), edges.iter().position(|e| *e == (c.from_hz, c.to_hz)));
        if let (Some(row), Some(column)) = at {
            z[row][column] = Some(rounded(c.gap, 3));
        }
    }
    let scale = [(0.0, "#FFF7DC"), (0.35, "#E69F00"), (0.7, "#D55E00"), (1.0, "#3B0F00")];
    let scale = ColorScale::Vector(scale.iter().map(|(at, c)| ColorScaleElement(*at, (*c).to_string())).collect());
    let mut chart = Chart::new(
        "residual-map",
        "Gap by position, channel and frequency band",
        "Where the model is off: the darker, the farther from the measurement.",
        130 + 26 * names.len(),
        layout().x_axis(axis("frequency band (Hz)").type_(AxisType::Category)).y_axis(axis("").type_(AxisType::Category)),
    );
    let x: Vec<String> = edges.iter().map(|e| band(e.0, e.1)).collect();
    let y: Vec<String> = names.iter().map(|n| escape(n)).collect();
    let map = HeatMap::new(x, y, z).zmin(0.0).color_scale(scale).hover_on_gaps(false);
    chart.trace(map.hover_template("%{y}, %{x} Hz: %{z:.3~g}<extra></extra>"));
    chart.html()
}

/// Interfaces, by what a free change there leaves of the gap; the best on top, as the axis begins below.
fn places(of: &DiagnosisDocument) -> String {
    let known: Vec<_> = of.places.iter().rev().filter_map(|w| Some((w, w.gap_held_out?))).collect();
    let mut chart = Chart::new(
        "where",
        "Gap left when one interface may change freely",
        "What the verdict names stands first, in its place. The shorter the bar, the better a change at this interface alone explains the \
         measurements. Line: the gap as it is.",
        110 + 30 * known.len(),
        layout()
            .show_legend(false)
            .x_axis(axis("gap left on what was held out").tick_format(".0%"))
            .y_axis(axis("").type_(AxisType::Category)),
    );
    if !known.is_empty() {
        let (names, left): (Vec<String>, Vec<f64>) =
            known.iter().map(|(w, g)| (escape(&format!("{}, {}", w.place_text(), w.shape_text())), rounded(*g, 4))).unzip();
        let shapes: Vec<String> = known.iter().map(|(w, _)| escape(w.shape_text())).collect();
        let ends: Vec<String> = names.first().into_iter().chain(names.last()).cloned().collect();
        let bars = Bar::new(left, names).orientation(Orientation::Horizontal).text_array(shapes).marker(Marker::new().color(colour(0)));
        chart.trace(bars.hover_template("%{y}: %{x:.1%}, like %{text}<extra></extra>"));
        if let Some(now) = of.gap.held_out {
            let now = Scatter::new(vec![now; 2], ends).mode(Mode::Lines).line(line("#8A8A8A", 2.0).dash(plotly::common::DashType::Dash));
            chart.trace(now.hover_template("gap as it is: %{x:.1%}<extra></extra>"));
        }
    }
    chart.html()
}

/// Whether the verdict names an effect.
fn in_verdict(of: &DiagnosisDocument, effect: &EffectRow) -> bool {
    effect.selected || of.verdict.effects.iter().any(|v| v.split('+').any(|id| id == effect.id))
}

/// Effects that change anything, in the order of the document, the best on top: as the axis begins below, from the last to the first.
fn tried(of: &DiagnosisDocument) -> Vec<&EffectRow> {
    let tells = |e: &&EffectRow| e.status == "tried" && (in_verdict(of, e) || e.closed.is_none_or(|c| c.abs() > 0.005));
    of.effects.iter().filter(tells).take(12).collect::<Vec<_>>().into_iter().rev().collect()
}

/// A probability as one reads it.
fn probability(p: f64) -> String {
    if p < 1e-4 { "< 0.0001".into() } else { format!("{p:.4}") }
}

fn effects(of: &DiagnosisDocument) -> String {
    let rows: Vec<_> = tried(of).into_iter().filter_map(|e| Some((e, e.closed?))).collect();
    let mut chart = Chart::new(
        "effects",
        "Share of the gap that each effect closes, with 95 % intervals",
        "Share of the gap above the noise that an effect closes on what was held out; grey bars: 95 %, for what the verdict names. Orange: in the verdict. \
         Effects that change nothing stand in the table alone.",
        110 + 28 * rows.len(),
        layout().show_legend(false).x_axis(axis("share closed").tick_format(".0%")).y_axis(axis("").type_(AxisType::Category)),
    );
    for (effect, closed) in &rows {
        let interval = effect.closed95.filter(|interval| !is_undetermined(*interval));
        let [low, high] = interval.unwrap_or([*closed; 2]);
        let spread = ErrorData::new(ErrorType::Data)
            .array(vec![(high - closed).max(0.0)])
            .array_minus(vec![(closed - low).max(0.0)])
            .symmetric(false)
            .color("#8A8A8A".to_string());
        let bar = Bar::new(vec![rounded(*closed, 4)], vec![escape(&effect.id)])
            .orientation(Orientation::Horizontal)
            .marker(Marker::new().color(colour(usize::from(in_verdict(of, effect)))))
            .hover_template(format!("{}: %{{x:.1%}}<extra></extra>", escape(&effect.id)));
        chart.trace(if interval.is_some() { bar.error_x(spread) } else { bar });
    }
    let header = ["Effect", "", "Gap before", "Gap after", "Closed", "95 % interval", "p"];
    let mut table = TextTable::new("All effects, best first; p: the share of simulated machines without it that show as much", 2, header);
    let parameters = |e: &EffectRow| e.parameters.iter().map(|(id, x)| format!("{id} {}", figure(*x))).collect::<Vec<_>>().join(", ");
    for effect in &of.effects {
        let class = if effect.selected { "strong" } else { "" };
        table.row_of(
            class,
            [
                effect.id.clone(),
                match (&effect.why, effect.selected) {
                    (Some(why), _) => why.clone(),
                    (None, true) => format!("in the verdict; {}", parameters(effect)),
                    (None, false) => effect.status.clone(),
                },
                cell(effect.gap_held_out_before.filter(|_| effect.status == "tried"), percent),
                cell(effect.gap_held_out_after, percent),
                cell(effect.closed.map(|c| if c.abs() < 5e-5 { 0.0 } else { c }), percent),
                match effect.closed95 {
                    None => "–".into(),
                    Some(wide) if is_undetermined(wide) => "left open".into(),
                    Some([a, b]) => format!("{} … {}", percent(a), percent(b)),
                },
                cell(effect.p_value, probability),
            ],
        );
    }
    format!("{}{}", chart.html(), table.html())
}

fn before_after(of: &DiagnosisDocument) -> String {
    let rows: Vec<_> = tried(of).into_iter().filter_map(|e| Some((escape(&e.id), e.gap_held_out_before?, e.gap_held_out_after?))).collect();
    let mut chart = Chart::new(
        "before-after",
        "Gap before and after each effect was added",
        "",
        130 + 34 * rows.len(),
        layout()
            .show_legend(true)
            .bar_mode(BarMode::Group)
            .x_axis(axis("gap on what was held out").tick_format(".0%"))
            .y_axis(axis("").type_(AxisType::Category)),
    );
    if !rows.is_empty() {
        for (what, n, pick) in [("after", 0, 2), ("before", 6, 1)] {
            let x: Vec<f64> = rows.iter().map(|r| rounded(if pick == 1 { r.1 } else { r.2 }, 4)).collect();
            let names: Vec<String> = rows.iter().map(|r| r.0.clone()).collect();
            let bars = Bar::new(x, names).name(what).orientation(Orientation::Horizontal).marker(Marker::new().color(colour(n)));
            chart.trace(bars.hover_template("%{y}: %{x:.1%}"));
        }
    }
    chart.html()
}

fn delta_z(of: &DiagnosisDocument) -> String {
    let layout = layout().show_legend(true).x_axis(log_axis("frequency (Hz)")).y_axis(axis("ΔZ (N/m or N·m/rad)").tick_format("~e"));
    let options: Vec<String> = of.delta_z.iter().map(|d| d.interface.clone()).collect();
    let mut chart = Chart::new(
        "delta-z",
        "Change of dynamic stiffness that an interface would need, over frequency",
        "The change of dynamic stiffness ΔZ(ω) that each interface would need: a stiffness is a constant real part, a damper an imaginary part that \
         rises with ω, a mass a real part that falls with ω².",
        360,
        layout,
    )
    .switches(vec![Switches { label: "Interface".into(), options, many: false, coloured: false }]);
    for (at, delta) in of.delta_z.iter().enumerate() {
        for (what, n, part) in [("real part", 0, &delta.real), ("imaginary part", 1, &delta.imag)] {
            let (x, y): (Vec<f64>, Vec<f64>) = delta.frequency_hz.iter().zip(part).map(|(f, z)| (rounded(*f, 6), rounded(*z, 5))).unzip();
            let trace = Scatter::new(x, y).mode(Mode::Lines).name(what).line(line(colour(n), 1.6));
            chart.trace_for(vec![Some(at)], trace.hover_template("%{x:.6~g} Hz<br>%{y:.4~g}"));
        }
    }
    chart.html()
}

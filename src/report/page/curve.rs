//! Measured against predicted FRFs: magnitude and phase over frequency.

use num_complex::Complex64;
use serde_json::{Value, json};

use super::chart::{Chart, Switches, axis, colour_of, hover_layout, line, log_axis, scatter, with};
use super::text::{escape, rounded};
use super::thin::{Thinned, thin};

/// A measured peak of a set that has no FRFs.
#[derive(Debug, Clone, PartialEq)]
pub struct PeakMark {
    /// Order.
    pub order: u32,
    /// Frequency (Hz).
    pub frequency_hz: f64,
    /// Amplitude in the curve's unit.
    pub amplitude: Option<f64>,
}

/// An FRF as measured, as predicted, or both, in one unit.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct PageCurve {
    /// Position or record.
    pub position: String,
    /// Response and excitation, such as `table/table`, and the record where a position has several.
    pub channel: String,
    /// Held out of the fit.
    pub held_out: bool,
    /// Quantity and unit of the values, such as `receptance (µm/N)`.
    pub unit: String,
    /// Measured lines; NaN where lines are missing or were not accepted, so that the curve breaks there.
    pub measured: Vec<(f64, Complex64)>,
    /// Predicted lines.
    pub predicted: Vec<(f64, Complex64)>,
    /// Lines predicted by the model before an effect is added.
    pub before: Vec<(f64, Complex64)>,
    /// Measured peaks, where no FRF was measured.
    pub peaks: Vec<PeakMark>,
}

impl PageCurve {
    fn role(&self) -> &'static str {
        if self.held_out { "held out" } else { "fitted" }
    }
}

/// Largest number of points of all curves, limited by the page's size and the drawing time on a laptop.
const MOST_POINTS: usize = 90_000;
/// Deviation in ln|H| and phase (rad) up to which a left-out line is invisible.
const MAX_DEVIATION: f64 = 0.005;

/// A trace with its layer, the lowest at the back, and its switches.
type Layered = (u8, Vec<Option<usize>>, Value);

/// Formats the chart `id` of curves; `after` names the model with the added effect where there are
/// predictions before it.
pub fn chart(id: &str, curves: &[PageCurve], after: &str) -> String {
    if curves.is_empty() {
        return String::new();
    }
    let names = |pick: &dyn Fn(&PageCurve) -> &String| {
        let mut names: Vec<String> = Vec::new();
        curves.iter().map(pick).for_each(|n| {
            if !names.contains(n) {
                names.push(n.clone());
            }
        });
        names
    };
    let positions = names(&|c| &c.position);
    let channels = names(&|c| &c.channel);
    let many: usize = curves
        .iter()
        .map(|c| [&c.measured, &c.predicted, &c.before].iter().filter(|lines| !lines.is_empty()).count())
        .sum();
    let compared = curves.iter().any(|c| !c.before.is_empty());
    // The vertical axis has the unit of the channel shown.
    let unit_of = |channel: &String| {
        curves.iter().find(|c| c.channel == *channel).map(|c| escape(&c.unit)).unwrap_or_default()
    };
    let titles: Vec<String> = channels.iter().map(unit_of).collect();
    let phase_axis = json!({
        "domain": [0.0, 0.3], "range": [-185.0, 185.0], "tickvals": [-180.0, -90.0, 0.0, 90.0, 180.0],
    });
    let layout = hover_layout(
        with(log_axis("frequency (Hz)"), json!({ "anchor": "y2", "showspikes": true })),
        with(log_axis(&titles[0]), json!({ "domain": [0.36, 1.0] })),
    );
    let layout = with(layout, json!({ "yaxis2": with(axis("phase (°)"), phase_axis) }));
    let mut drawing = Drawing {
        most: (MOST_POINTS / many.max(1)).clamp(200, 3000),
        positions: positions.len(),
        added: compared.then_some(after),
        ..Drawing::default()
    };
    for curve in curves {
        let at = positions.iter().position(|n| *n == curve.position).unwrap_or(0);
        let channel = channels.iter().position(|n| *n == curve.channel);
        drawing.draw(curve, at, channel);
    }
    let what =
        if curves.iter().any(|c| !c.measured.is_empty()) { "measured and predicted" } else { "predicted" };
    let label = format!("Magnitude and phase of {} {what} frequency response functions", curves.len());
    let mut switches = vec![
        Switches { label: "Positions".into(), options: positions, many: true, coloured: true },
        Switches { label: "Response/excitation".into(), options: channels, many: false, coloured: false },
    ];
    if compared {
        switches.push(Switches {
            label: "Model".into(),
            options: vec!["as described".into(), after.into()],
            many: true,
            coloured: false,
        });
    }
    let mut chart = Chart::new(id, &label, &drawing.caption(curves), 600, layout)
        .switches(switches)
        .titles(1, titles)
        .samples(drawing.samples(curves))
        .log_switch();
    // Predictions lie over measurements at all positions, marks over both.
    drawing.traces.sort_by_key(|t| t.0);
    for (_, key, trace) in drawing.traces {
        chart.trace_for(key, trace);
    }
    chart.html()
}

/// Traces of the curves drawn so far.
#[derive(Default)]
struct Drawing<'a> {
    /// Largest number of points of a curve.
    most: usize,
    /// Number of positions, which differ by colour.
    positions: usize,
    /// Name of the model with the added effect, where predictions before it are compared.
    added: Option<&'a str>,
    traces: Vec<Layered>,
    /// Largest deviation of the drawn lines from those left out.
    worst: f64,
    /// Whether lines are left out.
    dropped: bool,
}

impl Drawing<'_> {
    /// Draws the lines and marks of a curve, with the numbers of its position and channel.
    fn draw(&mut self, curve: &PageCurve, at: usize, channel: Option<usize>) {
        let result = self.added.unwrap_or("predicted");
        let colour = colour_of(at, self.positions);
        for (lines, what, model) in [
            (&curve.measured, "measured", None),
            (&curve.before, "as described", Some(0)),
            (&curve.predicted, result, Some(1)),
        ] {
            if lines.is_empty() {
                continue;
            }
            let parts = self.parts(lines);
            let hover = |y: &str| {
                let (position, what, role) = (escape(&curve.position), escape(what), curve.role());
                format!("{position}, {what} ({role})<br>%{{x:.6~g}} Hz<br>%{{y:.4~g}} {y}<extra></extra>")
            };
            let (width, dashes) = match (model, curve.held_out) {
                (None, _) => (3.5, None),
                (Some(0), _) => (1.6, Some("dot")),
                (_, false) => (1.4, None),
                (_, true) => (1.4, Some("dash")),
            };
            let pen = with(line(&colour, width), dashes.map_or(Value::Null, |dash| json!({ "dash": dash })));
            let (level, opacity) = if model.is_none() { (0, 0.4) } else { (1, 1.0) };
            let trace = |(x, y): TracePoints, hover: String, y_axis: Value| {
                let name = escape(&curve.position);
                let look = json!({ "opacity": opacity, "name": name, "line": pen, "hovertemplate": hover });
                scatter(x, y, "lines", with(look, y_axis))
            };
            let key = vec![Some(at), channel, model];
            let unit = curve.unit.split(['(', ')']).nth(1).unwrap_or("");
            let above = trace(joined(&parts, magnitude), hover(&escape(unit)), Value::Null);
            let below = trace(joined(&parts, phase), hover("°"), json!({ "yaxis": "y2" }));
            self.traces.push((level, key.clone(), above));
            self.traces.push((level, key, below));
        }
        let seen = curve.peaks.iter().filter_map(|p| Some((p.frequency_hz, Some(rounded(p.amplitude?, 5)))));
        let (x, y): (Vec<f64>, Vec<Option<f64>>) = seen.unzip();
        if !x.is_empty() {
            let symbol = if curve.held_out { "diamond-open" } else { "circle" };
            let name = escape(&curve.position);
            let text = format!(
                "{name}, measured peak ({})<br>%{{x:.6~g}} Hz<br>%{{y:.4~g}}<extra></extra>",
                curve.role()
            );
            let mark = json!({ "color": colour, "size": 9, "symbol": symbol });
            let look = json!({ "marker": mark, "hovertemplate": text, "name": name });
            self.traces.push((2, vec![Some(at), channel, None], scatter(x, y, "markers", look)));
        }
    }

    /// Thins the parts of a curve between which it breaks.
    fn parts(&mut self, lines: &[(f64, Complex64)]) -> Vec<CurvePart> {
        let mut parts = Vec::new();
        for part in lines.split(|(_, h)| !h.is_finite()).filter(|part| !part.is_empty()) {
            let (f, h): (Vec<f64>, Vec<Complex64>) = part.iter().copied().unzip();
            let most = (self.most * f.len()).div_ceil(lines.len());
            let thinned = thin(&f, &h, MAX_DEVIATION, most.max(2));
            self.worst = self.worst.max(thinned.deviation);
            self.dropped |= thinned.kept.len() < f.len();
            parts.push(CurvePart { f, h, thinned });
        }
        parts
    }

    /// Returns the legend of lines and marks.
    fn samples(&self, curves: &[PageCurve]) -> Vec<(&'static str, String)> {
        let any = |is: fn(&PageCurve) -> bool| curves.iter().any(is);
        let held_out = any(|c| c.held_out);
        let fitted = if held_out { ", fitted" } else { "" };
        let result = self.added.unwrap_or("predicted");
        let samples = [
            any(|c| !c.measured.is_empty()).then(|| ("wide", "measured".to_string())),
            any(|c| !c.peaks.is_empty() && !c.held_out).then(|| ("mark", format!("measured peak{fitted}"))),
            any(|c| !c.peaks.is_empty() && c.held_out).then(|| ("open", "measured peak, held out".into())),
            self.added.is_some().then(|| ("dotted", "as described, at its best fit".into())),
            any(|c| !c.held_out).then(|| ("line", format!("{result}{fitted}"))),
            held_out.then(|| ("dashed", format!("{result}, held out"))),
        ];
        samples.into_iter().flatten().collect()
    }

    /// Returns the caption.
    fn caption(&self, curves: &[PageCurve]) -> String {
        let breaks = curves.iter().any(|c| c.measured.iter().any(|(_, h)| !h.is_finite()));
        let worst = self.worst.max(1e-4);
        let captions = [
            breaks.then(|| "Measured curves break where lines are missing or were not accepted.".to_string()),
            Some("Drag to zoom, double-click to reset, hover for values.".into()),
            self.dropped.then(|| {
                format!(
                    "Lines are thinned for display: straight lines between those drawn deviate by at most {:.1} % in |H| and {:.2}° in phase.",
                    100.0 * worst,
                    worst.to_degrees()
                )
            }),
        ];
        captions.into_iter().flatten().collect::<Vec<String>>().join(" ")
    }
}

/// A part of a curve without a break.
struct CurvePart {
    f: Vec<f64>,
    h: Vec<Complex64>,
    thinned: Thinned,
}

/// Coordinates of a trace, which breaks where there is no value.
type TracePoints = (Vec<f64>, Vec<Option<f64>>);

/// Returns the points of all parts with breaks between them.
fn joined(parts: &[CurvePart], points: fn(&[f64], &[Complex64], &Thinned) -> TracePoints) -> TracePoints {
    let mut all = TracePoints::default();
    for (at, CurvePart { f, h, thinned }) in parts.iter().enumerate() {
        if at > 0 {
            all.0.push(rounded(f[0], 7));
            all.1.push(None);
        }
        let (mut x, mut y) = points(f, h, thinned);
        // A line alone is drawn as one of no length, which its round ends make visible.
        if let ([only], [value]) = (&x[..], &y[..]) {
            let (only, value) = (*only, *value);
            x.push(only);
            y.push(value);
        }
        all.0.extend(x);
        all.1.extend(y);
    }
    all
}

fn magnitude(f: &[f64], h: &[Complex64], thinned: &Thinned) -> TracePoints {
    thinned.kept.iter().map(|&i| (rounded(f[i], 7), Some(rounded(h[i].norm(), 5)))).unzip()
}

/// Returns the phase in degrees, interrupted where it wraps from one end of its range to the other.
fn phase(f: &[f64], h: &[Complex64], thinned: &Thinned) -> TracePoints {
    let mut points: Vec<(f64, Option<f64>)> = Vec::with_capacity(thinned.kept.len());
    for &i in &thinned.kept {
        let here = h[i].arg().to_degrees();
        if let Some((_, Some(before))) =
            points.last().filter(|p| p.1.is_some_and(|b| (b - here).abs() > 180.0))
        {
            debug_assert!((before - here).abs() > 180.0);
            points.push((rounded(f[i], 7), None));
        }
        points.push((rounded(f[i], 7), Some((here * 100.0).round() / 100.0)));
    }
    points.into_iter().unzip()
}

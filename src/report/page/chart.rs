//! Charts: traces and layouts of Plotly.js as JSON, with the switches that show and hide traces.

use serde::Serialize;
use serde_json::{Value, json};

use super::text::escape;

/// Colours that colour-blind readers can distinguish (Okabe and Ito), in the order of use.
pub const PALETTE: [&str; 7] = ["#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#8A8A8A"];

/// Returns the colour of the n-th item.
pub fn colour(n: usize) -> &'static str {
    PALETTE[n % PALETTE.len()]
}

/// Colours in their order along a series, from the first item to the last (after viridis, dark enough on white).
const SERIES: [[f64; 3]; 5] =
    [[68.0, 1.0, 84.0], [59.0, 82.0, 139.0], [33.0, 145.0, 140.0], [94.0, 180.0, 80.0], [226.0, 178.0, 0.0]];

/// Returns the colour of the n-th of a number of items: of the palette where it has enough, else along a
/// series, so that no two are alike.
pub fn colour_of(n: usize, count: usize) -> String {
    if count <= PALETTE.len() {
        return colour(n).into();
    }
    let place = n as f64 / (count - 1) as f64 * (SERIES.len() - 1) as f64;
    let from = (place as usize).min(SERIES.len() - 2);
    let share = (place - from as f64).min(1.0);
    let part = |i: usize| (SERIES[from][i] * (1.0 - share) + SERIES[from + 1][i] * share).round() as u8;
    format!("#{:02X}{:02X}{:02X}", part(0), part(1), part(2))
}

/// Returns the dash of the n-th item. It changes with every round of the palette.
pub fn dash(n: usize) -> &'static str {
    ["solid", "dot", "dashdot", "longdash"][(n / PALETTE.len()) % 4]
}

/// Returns the symbol of the n-th item.
pub fn symbol(n: usize) -> &'static str {
    ["circle", "square", "diamond", "cross"][n % 4]
}

/// Returns an object with the keys of another added to it.
pub fn with(mut object: Value, other: Value) -> Value {
    if let (Value::Object(object), Value::Object(other)) = (&mut object, other) {
        object.extend(other);
    }
    object
}

/// Returns a line of a colour and width.
pub fn line(colour: &str, width: f64) -> Value {
    json!({ "color": colour, "width": width })
}

/// Returns an axis with a title.
pub fn axis(title: &str) -> Value {
    json!({ "title": { "text": title }, "automargin": true, "zeroline": false })
}

/// Returns an axis of names.
pub fn name_axis(title: &str) -> Value {
    with(axis(title), json!({ "type": "category" }))
}

/// Returns an axis whose numbers are shares, in percent.
pub fn percent_axis(title: &str) -> Value {
    with(axis(title), json!({ "tickformat": ".2~%" }))
}

/// Returns a logarithmic axis with a title, with labels at 1, 2 and 5 of each decade as plain numbers.
pub fn log_axis(title: &str) -> Value {
    with(axis(title), json!({ "type": "log", "tickformat": "~g", "nticks": 6 }))
}

/// Returns the layout of a chart of the page, with the legend above, if any.
pub fn layout(legend: bool, x_axis: Value, y_axis: Value) -> Value {
    json!({
        "margin": { "l": 64, "r": 16, "t": 32, "b": 48 },
        "legend": { "orientation": "h", "x": 0.0, "y": 1.02, "yanchor": "bottom" },
        "paper_bgcolor": "transparent", "plot_bgcolor": "transparent",
        "showlegend": legend, "xaxis": x_axis, "yaxis": y_axis,
    })
}

/// Returns a layout without legend, whose hover labels belong to the nearest point.
pub fn hover_layout(x_axis: Value, y_axis: Value) -> Value {
    with(layout(false, x_axis, y_axis), json!({ "hovermode": "closest" }))
}

/// Returns a layout with groups of bars.
pub fn bar_layout(x_axis: Value, y_axis: Value) -> Value {
    with(layout(true, x_axis, y_axis), json!({ "barmode": "group" }))
}

/// Returns a trace of points, drawn as a mode says.
pub fn scatter(x: impl Serialize, y: impl Serialize, mode: &str, more: Value) -> Value {
    with(json!({ "type": "scatter", "x": x, "y": y, "mode": mode }), more)
}

/// Returns the name of the n-th vertical axis, as traces refer to it.
pub fn y_axis(n: usize) -> String {
    if n == 0 { "y".into() } else { format!("y{}", n + 1) }
}

/// Returns the layout of a chart of panels one above the other, each with a title and numbers of a format, on
/// a common horizontal axis.
pub fn panels(x_axis: Value, titles: &[String], format: &str) -> Value {
    let count = titles.len();
    let mut layout =
        hover_layout(with(x_axis, json!({ "anchor": y_axis(count.saturating_sub(1)) })), Value::Null);
    for (n, title) in titles.iter().enumerate() {
        let (low, high) = ((count - 1 - n) as f64 / count as f64, (count - n) as f64 / count as f64);
        let panel = json!({ "domain": [low + 0.03, high - 0.03], "tickformat": format, "nticks": 4 });
        layout[y_axis(n).replace('y', "yaxis")] = with(axis(title), panel);
    }
    layout
}

/// A group of switches over a chart.
#[derive(Debug, Clone)]
pub struct Switches {
    /// Label of the group.
    pub label: String,
    /// The choices.
    pub options: Vec<String>,
    /// Several choices can be on, initially all; otherwise one, initially the first.
    pub many: bool,
    /// The choices have the colours of the palette, in its order.
    pub coloured: bool,
}

/// A chart of the page.
pub struct Chart {
    id: String,
    label: String,
    caption: String,
    height: usize,
    layout: Value,
    traces: Vec<Value>,
    switches: Vec<Switches>,
    samples: Vec<(&'static str, String)>,
    keys: Vec<Vec<Option<usize>>>,
    titles: Option<(usize, Vec<String>)>,
    log_switch: bool,
}

impl Chart {
    /// Returns an empty chart. `id` is a fixed word; `label` is its heading and its description for screen
    /// readers.
    pub fn new(id: &str, label: &str, caption: &str, height: usize, layout: Value) -> Self {
        Chart {
            id: id.into(),
            label: label.into(),
            caption: caption.into(),
            height,
            layout,
            traces: Vec::new(),
            switches: Vec::new(),
            samples: Vec::new(),
            keys: Vec::new(),
            titles: None,
            log_switch: false,
        }
    }

    /// Adds groups of switches; those with a single choice are not shown.
    pub fn switches(mut self, switches: Vec<Switches>) -> Self {
        self.switches = switches;
        self
    }

    /// Adds a legend of the kinds of lines and marks: a style sheet's class for each, and what it means.
    pub fn samples(mut self, samples: Vec<(&'static str, String)>) -> Self {
        self.samples = samples;
        self
    }

    /// Sets the title of the vertical axis for each choice of a group of switches.
    pub fn titles(mut self, group: usize, titles: Vec<String>) -> Self {
        self.titles = Some((group, titles));
        self
    }

    /// Adds a switch between a logarithmic and a linear frequency axis, and fields for its range.
    pub fn log_switch(mut self) -> Self {
        self.log_switch = true;
        self
    }

    /// Adds a trace that is always shown.
    pub fn trace(&mut self, trace: Value) {
        self.trace_for(Vec::new(), trace);
    }

    /// Adds a trace that is shown while the given choice of each group of switches is on (`None`: any
    /// choice).
    pub fn trace_for(&mut self, key: Vec<Option<usize>>, trace: Value) {
        self.traces.push(trace);
        self.keys.push(key);
    }

    /// Formats the chart as HTML; empty without traces.
    pub fn html(&self) -> String {
        if self.traces.is_empty() {
            return String::new();
        }
        let mut out =
            format!("<figure class=\"chart\" id=\"{}\">\n<h3>{}</h3>\n", self.id, escape(&self.label));
        let shown = self.switches.iter().enumerate().filter(|(_, s)| s.options.len() > 1);
        for (group, switches) in shown {
            out += &format!(
                "<div class=\"switches\" role=\"group\" aria-label=\"{0}\" data-group=\"{group}\" data-many=\"{1}\"><span>{0}</span>",
                escape(&switches.label),
                switches.many
            );
            for (at, option) in switches.options.iter().enumerate() {
                let on = switches.many || at == 0;
                let mark = if switches.coloured {
                    format!("<i style=\"background:{}\"></i>", colour_of(at, switches.options.len()))
                } else {
                    String::new()
                };
                let name = escape(option);
                out += &format!(
                    "<button type=\"button\" data-option=\"{at}\" aria-pressed=\"{on}\">{mark}{name}</button>"
                );
            }
            out += "</div>\n";
        }
        if !self.samples.is_empty() {
            let item = |(class, text): &(&str, String)| {
                format!("<li><i class=\"{class}\"></i>{}</li>", escape(text))
            };
            out += &format!(
                "<ul class=\"samples\">{}</ul>\n",
                self.samples.iter().map(item).collect::<String>()
            );
        }
        if self.log_switch {
            // The range can also be typed, because dragging requires a mouse.
            out += "<div class=\"switches\"><button type=\"button\" class=\"log\" aria-pressed=\"true\">logarithmic frequency</button>\
                    <label>from <input type=\"number\" class=\"from\" min=\"0\" step=\"any\"></label>\
                    <label>to <input type=\"number\" class=\"to\" min=\"0\" step=\"any\"> Hz</label>\
                    <button type=\"button\" class=\"whole\">whole range</button></div>\n";
        }
        out += &format!(
            "<div class=\"plot\" role=\"img\" aria-label=\"{}\" style=\"height:{}px\"></div>\n",
            escape(&self.label),
            self.height
        );
        if !self.caption.is_empty() {
            out += &format!("<figcaption>{}</figcaption>\n", escape(&self.caption));
        }
        let plot = json!({ "data": self.traces, "layout": self.layout });
        // Only `<` can end or change a script element. In JSON text it may be written as an escape.
        let given = json!({ "plot": plot, "keys": self.keys, "titles": self.titles });
        let given = given.to_string().replace('<', "\\u003c");
        out + &format!("<script type=\"application/json\">{given}</script>\n</figure>\n")
    }
}

/// Plotly.js, the part for charts of two axes.
pub const LIBRARY: &str = include_str!("plotly/plotly-cartesian.min.js");

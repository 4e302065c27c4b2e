//! Charts: traces and layout of the charting crate, with the switches that show and hide traces.

use plotly::color::NamedColor;
use plotly::common::{DashType, Line, MarkerSymbol};
use plotly::layout::{Axis, AxisType, HoverMode, Legend, Margin};
use plotly::{Layout, Plot, Trace};

use super::text::escape;

/// Colours that colour-blind readers can distinguish (Okabe and Ito), in the order of use.
pub const PALETTE: [&str; 7] = ["#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#8A8A8A"];

/// Returns the colour of the n-th item.
pub fn colour(n: usize) -> &'static str {
    PALETTE[n % PALETTE.len()]
}

/// Returns the dash of the n-th item. It changes with every round of the palette.
pub fn dash(n: usize) -> DashType {
    [DashType::Solid, DashType::Dot, DashType::DashDot, DashType::LongDash][(n / PALETTE.len()) % 4].clone()
}

/// Returns the symbol of the n-th item.
pub fn symbol(n: usize) -> MarkerSymbol {
    [MarkerSymbol::Circle, MarkerSymbol::Square, MarkerSymbol::Diamond, MarkerSymbol::Cross][n % 4].clone()
}

/// Returns a line of a colour and width.
pub fn line(colour: &str, width: f64) -> Line {
    Line::new().color(colour.to_string()).width(width)
}

/// Returns an axis with a title.
pub fn axis(title: &str) -> Axis {
    Axis::new().title(title).auto_margin(true).zero_line(false)
}

/// Returns a logarithmic axis with a title, with labels at 1, 2 and 5 of each decade as plain numbers.
pub fn log_axis(title: &str) -> Axis {
    axis(title).type_(AxisType::Log).tick_format("~g").n_ticks(6)
}

/// Adds the n-th of up to eight vertical axes to a layout.
fn with_y_axis(layout: Layout, n: usize, axis: Axis) -> Layout {
    match n {
        0 => layout.y_axis(axis),
        1 => layout.y_axis2(axis),
        2 => layout.y_axis3(axis),
        3 => layout.y_axis4(axis),
        4 => layout.y_axis5(axis),
        5 => layout.y_axis6(axis),
        6 => layout.y_axis7(axis),
        _ => layout.y_axis8(axis),
    }
}

/// Returns the layout of a chart of the page, with the legend above.
pub fn layout() -> Layout {
    Layout::new()
        .margin(Margin::new().left(64).right(16).top(32).bottom(48))
        .legend(
            Legend::new()
                .orientation(plotly::common::Orientation::Horizontal)
                .y(1.02)
                .y_anchor(plotly::common::Anchor::Bottom)
                .x(0.0),
        )
        .paper_background_color(NamedColor::Transparent)
        .plot_background_color(NamedColor::Transparent)
}

/// Returns the name of the n-th vertical axis, as traces refer to it.
pub fn y_axis(n: usize) -> String {
    if n == 0 { "y".into() } else { format!("y{}", n + 1) }
}

/// Returns the layout of a chart of panels one above the other, each with a title and numbers of a format, on
/// a common horizontal axis.
pub fn panels(x_axis: Axis, titles: &[String], format: &str) -> Layout {
    let count = titles.len();
    let x_axis = x_axis.anchor(y_axis(count.saturating_sub(1)));
    let mut layout = layout().show_legend(false).hover_mode(HoverMode::Closest).x_axis(x_axis);
    for (n, title) in titles.iter().enumerate() {
        let (low, high) = ((count - 1 - n) as f64 / count as f64, (count - n) as f64 / count as f64);
        let panel = axis(title).domain(&[low + 0.03, high - 0.03]).tick_format(format).n_ticks(4);
        layout = with_y_axis(layout, n, panel);
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
    plot: Plot,
    traces: usize,
    switches: Vec<Switches>,
    keys: Vec<Vec<Option<usize>>>,
    titles: Option<(usize, Vec<String>)>,
    log_switch: bool,
}

impl Chart {
    /// Returns an empty chart. `id` is a fixed word; `label` is its heading and its description for screen
    /// readers.
    pub fn new(id: &str, label: &str, caption: &str, height: usize, layout: Layout) -> Self {
        let mut plot = Plot::new();
        plot.set_layout(layout);
        Chart {
            id: id.into(),
            label: label.into(),
            caption: caption.into(),
            height,
            plot,
            traces: 0,
            switches: Vec::new(),
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
    pub fn trace(&mut self, trace: Box<dyn Trace>) {
        self.trace_for(Vec::new(), trace);
    }

    /// Adds a trace that is shown while the given choice of each group of switches is on (`None`: any
    /// choice).
    pub fn trace_for(&mut self, key: Vec<Option<usize>>, trace: Box<dyn Trace>) {
        self.plot.add_trace(trace);
        self.keys.push(key);
        self.traces += 1;
    }

    /// Formats the chart as HTML; empty without traces.
    pub fn html(&self) -> String {
        if self.traces == 0 {
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
                    format!("<i style=\"background:{}\"></i>", colour(at))
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
        // Only `<` can end or change a script element. In JSON text it may be written as an escape.
        let plot = self.plot.to_json().replace('<', "\\u003c");
        let keys: Vec<Vec<i64>> = self
            .keys
            .iter()
            .map(|k| k.iter().map(|o| o.map_or(-1, |o| i64::try_from(o).unwrap_or(-1))).collect())
            .collect();
        let keys = serde_json::to_string(&keys).unwrap_or_else(|_| "[]".into());
        let titles =
            serde_json::to_string(&self.titles).unwrap_or_else(|_| "null".into()).replace('<', "\\u003c");
        out + &format!(
            "<script type=\"application/json\">{{\"plot\":{plot},\"keys\":{keys},\"titles\":{titles}}}</script>\n</figure>\n"
        )
    }
}

/// Returns the script of the charting crate as a script element, without the typesetting of formulas, which
/// no chart uses.
pub fn library() -> String {
    let all = Plot::offline_js_sources();
    let end = all.find("</script>").map_or(all.len(), |at| at + "</script>".len());
    all[..end].to_string()
}

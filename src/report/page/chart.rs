//! Charts: traces and layout by the charting crate, and which of the page's switches show which trace.

use plotly::color::NamedColor;
use plotly::common::{DashType, Line, MarkerSymbol};
use plotly::layout::{Axis, AxisType, Legend, Margin};
use plotly::{Layout, Plot, Trace};

use super::text::escape;

/// Colours that the colour-blind tell apart (Okabe and Ito), in the order of use; the last serves where they run out.
pub const PALETTE: [&str; 7] = ["#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#8A8A8A"];

/// The colour of the n-th of several.
pub fn colour(n: usize) -> &'static str {
    PALETTE[n % PALETTE.len()]
}

/// The dash of the n-th of several: a second round of colours differs in it.
pub fn dash(n: usize) -> DashType {
    [DashType::Solid, DashType::Dot, DashType::DashDot, DashType::LongDash][(n / PALETTE.len()) % 4].clone()
}

/// A symbol for the n-th of several.
pub fn symbol(n: usize) -> MarkerSymbol {
    [MarkerSymbol::Circle, MarkerSymbol::Square, MarkerSymbol::Diamond, MarkerSymbol::Cross][n % 4].clone()
}

/// A line of a colour.
pub fn line(colour: &str, width: f64) -> Line {
    Line::new().color(colour.to_string()).width(width)
}

/// An axis with a title.
pub fn axis(title: &str) -> Axis {
    Axis::new().title(title).auto_margin(true).zero_line(false)
}

/// A logarithmic axis with a title: labels at 1, 2 and 5 of each decade as plain numbers.
pub fn log_axis(title: &str) -> Axis {
    axis(title).type_(AxisType::Log).tick_format("~g").n_ticks(6)
}

/// A layout with one more of up to eight vertical axes.
pub fn with_y_axis(layout: Layout, n: usize, axis: Axis) -> Layout {
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

/// A layout with a legend above, for charts of the page.
pub fn layout() -> Layout {
    Layout::new()
        .margin(Margin::new().left(64).right(16).top(32).bottom(48))
        .legend(Legend::new().orientation(plotly::common::Orientation::Horizontal).y(1.02).y_anchor(plotly::common::Anchor::Bottom).x(0.0))
        .paper_background_color(NamedColor::Transparent)
        .plot_background_color(NamedColor::Transparent)
}

/// A group of switches over a chart.
#[derive(Debug, Clone)]
pub struct Switches {
    /// What they choose.
    pub label: String,
    /// The choices.
    pub options: Vec<String>,
    /// Several at once, all at first; else one, the first.
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
    /// An empty chart. `id` is a word of ours; `label` tells what it shows to those who cannot see it.
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

    /// Gives it groups of switches; those of a single choice are left out.
    pub fn switches(mut self, switches: Vec<Switches>) -> Self {
        self.switches = switches;
        self
    }

    /// Gives the vertical axis a title for each choice of a group of switches.
    pub fn titles(mut self, group: usize, titles: Vec<String>) -> Self {
        self.titles = Some((group, titles));
        self
    }

    /// Gives it a switch between a logarithmic and a linear frequency axis, and fields for the range.
    pub fn log_switch(mut self) -> Self {
        self.log_switch = true;
        self
    }

    /// Adds a trace that is always shown.
    pub fn trace(&mut self, trace: Box<dyn Trace>) {
        self.trace_for(Vec::new(), trace);
    }

    /// Adds a trace that is shown where, in each group of switches, the choice named is on (`None`: any).
    pub fn trace_for(&mut self, key: Vec<Option<usize>>, trace: Box<dyn Trace>) {
        self.plot.add_trace(trace);
        self.keys.push(key);
        self.traces += 1;
    }

    /// As HTML; nothing without traces.
    pub fn html(&self) -> String {
        if self.traces == 0 {
            return String::new();
        }
        let mut out = format!("<figure class=\"chart\" id=\"{}\">\n<h3>{}</h3>\n", self.id, escape(&self.label));
        let shown = self.switches.iter().enumerate().filter(|(_, s)| s.options.len() > 1);
        for (group, switches) in shown {
            out += &format!(
                "<div class=\"switches\" role=\"group\" aria-label=\"{0}\" data-group=\"{group}\" data-many=\"{1}\"><span>{0}</span>",
                escape(&switches.label),
                switches.many
            );
            for (at, option) in switches.options.iter().enumerate() {
                let on = switches.many || at == 0;
                let mark = if switches.coloured { format!("<i style=\"background:{}\"></i>", colour(at)) } else { String::new() };
                let name = escape(option);
                out += &format!("<button type=\"button\" data-option=\"{at}\" aria-pressed=\"{on}\">{mark}{name}</button>");
            }
            out += "</div>\n";
        }
        if self.log_switch {
            // The range can be typed, too: dragging needs a mouse.
            out += "<div class=\"switches\"><button type=\"button\" class=\"log\" aria-pressed=\"true\">logarithmic frequency</button>\
                    <label>from <input type=\"number\" class=\"from\" min=\"0\" step=\"any\"></label>\
                    <label>to <input type=\"number\" class=\"to\" min=\"0\" step=\"any\"> Hz</label>\
                    <button type=\"button\" class=\"whole\">whole range</button></div>\n";
        }
        out +=
            &format!("<div class=\"plot\" role=\"img\" aria-label=\"{}\" style=\"height:{}px\"></div>\n", escape(&self.label), self.height);
        if !self.caption.is_empty() {
            out += &format!("<figcaption>{}</figcaption>\n", escape(&self.caption));
        }
        // In a script element nothing but `<` could end or change it; inside JSON text it may be written as an escape.
        let plot = self.plot.to_json().replace('<', "\\u003c");
        let keys: Vec<Vec<i64>> =
            self.keys.iter().map(|k| k.iter().map(|o| o.map_or(-1, |o| i64::try_from(o).unwrap_or(-1))).collect()).collect();
        let keys = serde_json::to_string(&keys).unwrap_or_else(|_| "[]".into());
        let titles = serde_json::to_string(&self.titles).unwrap_or_else(|_| "null".into()).replace('<', "\\u003c");
        out + &format!("<script type=\"application/json\">{{\"plot\":{plot},\"keys\":{keys},\"titles\":{titles}}}</script>\n</figure>\n")
    }
}

/// The script of the charting crate, once, as a script element; without the typesetting of formulas, which no chart here uses.
pub fn library() -> String {
    let all = Plot::offline_js_sources();
    let end = all.find("</script>").map_or(all.len(), |at| at + "</script>".len());
    all[..end].to_string()
}

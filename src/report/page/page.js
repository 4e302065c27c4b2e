"use strict";
(() => {
  const errors = [];
  addEventListener("error", (e) => errors.push(String(e.message)));
  addEventListener("unhandledrejection", (e) => errors.push(String(e.reason)));
  document.addEventListener("securitypolicyviolation", (e) => errors.push("refused: " + e.violatedDirective + " " + e.blockedURI));

  const axes = (layout) => Object.keys(layout).filter((k) => /^[xy]axis\d*$/.test(k));
  const style = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();
  const narrow = () => document.body.clientWidth < 560;

  // Colours and fonts of the page's style, for light, dark and print.
  function dressed(layout) {
    const change = {
      paper_bgcolor: "rgba(0,0,0,0)", plot_bgcolor: "rgba(0,0,0,0)",
      "font.color": style("--ink"), "font.size": narrow() ? 11 : 13, "font.family": getComputedStyle(document.body).fontFamily,
      "hoverlabel.bgcolor": style("--paper"), "hoverlabel.bordercolor": style("--quiet"), "hoverlabel.font.color": style("--ink"),
      "legend.bgcolor": "rgba(0,0,0,0)", "modebar.color": style("--quiet"), "modebar.activecolor": style("--ink"), "modebar.bgcolor": "rgba(0,0,0,0)",
    };
    for (const axis of axes(layout)) {
      change[axis + ".gridcolor"] = style("--grid");
      change[axis + ".linecolor"] = style("--quiet");
      change[axis + ".tickcolor"] = style("--quiet");
      change[axis + ".spikecolor"] = style("--quiet");
    }
    return change;
  }

  function put(object, path, value) {
    const keys = path.split("."), last = keys.pop();
    let here = object;
    for (const key of keys) here = here[key] ??= {};
    here[last] = value;
  }

  const charts = [];
  for (const figure of document.querySelectorAll("figure.chart")) {
    const given = JSON.parse(figure.querySelector('script[type="application/json"]').textContent);
    const plot = figure.querySelector(".plot");
    const { data, layout } = given.plot;
    for (const axis of axes(layout)) if (layout[axis].showspikes) Object.assign(layout[axis], { spikethickness: 1, spikemode: "across", spikedash: "dot" });
    layout.dragmode = "zoom";
    const groups = [...figure.querySelectorAll("[data-group]")];

    const visible = () => given.keys.map((key) => groups.every((group) => {
      const option = key[Number(group.dataset.group)];
      if (option == null) return true;
      return group.querySelector(`[data-option="${option}"]`)?.getAttribute("aria-pressed") === "true";
    }));
    for (const group of groups) {
      const many = group.dataset.many === "true";
      group.addEventListener("click", (event) => {
        const button = event.target.closest("button");
        if (!button) return;
        if (many) button.setAttribute("aria-pressed", String(button.getAttribute("aria-pressed") !== "true"));
        else for (const other of group.querySelectorAll("button")) other.setAttribute("aria-pressed", String(other === button));
        if (chart.drawn) Plotly.restyle(plot, { visible: visible() });
        if (given.titles && Number(group.dataset.group) === given.titles[0]) {
          const title = given.titles[1][Number(button.dataset.option)];
          if (chart.drawn) Plotly.relayout(plot, { "yaxis.title.text": title });
          else put(layout, "yaxis.title.text", title);
        }
      });
    }
    const log = figure.querySelector(".log"), from = figure.querySelector(".from"), to = figure.querySelector(".to");
    const type = () => (log.getAttribute("aria-pressed") === "true" ? "log" : "linear");
    const range = () => {
      const ends = [Number(from.value), Number(to.value)];
      if (!chart.drawn) return undefined;
      if (!(ends[0] > 0 && ends[1] > ends[0])) return Plotly.relayout(plot, { "xaxis.type": type(), "xaxis.autorange": true });
      return Plotly.relayout(plot, { "xaxis.type": type(), "xaxis.range": type() === "log" ? ends.map(Math.log10) : ends });
    };
    if (log) {
      log.addEventListener("click", () => { log.setAttribute("aria-pressed", String(type() !== "log")); range(); });
      for (const field of [from, to]) field.addEventListener("change", range);
      figure.querySelector(".whole").addEventListener("click", () => {
        from.value = to.value = "";
        if (chart.drawn) Plotly.relayout(plot, { "xaxis.autorange": true, "yaxis.autorange": true });
      });
    }
    const chart = { figure, plot, layout, drawn: null, traces: data.length };
    chart.draw = () => {
      if (chart.drawn) return chart.drawn;
      for (const [path, value] of Object.entries(dressed(layout))) put(layout, path, value);
      visible().forEach((on, at) => { data[at].visible = on; });
      chart.drawn = Plotly.newPlot(plot, data, layout, { responsive: true, displaylogo: false, modeBarButtonsToRemove: ["select2d", "lasso2d", "autoScale2d"] });
      return chart.drawn;
    };
    charts.push(chart);
  }

  // Charts are drawn one after another from the top, so that the page is usable meanwhile.
  const all = (async () => {
    for (const chart of charts) {
      await chart.draw();
      await new Promise((done) => setTimeout(done));
    }
  })();

  const dress = () => charts.forEach((c) => { if (c.drawn) Plotly.relayout(c.plot, dressed(c.layout)); else c.draw(); });
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", dress);
  addEventListener("beforeprint", dress);
  addEventListener("afterprint", dress);

  // Opened with #selftest, the page reports what it shows and whether a switch works.
  if (location.hash === "#selftest") {
    all.then(async () => {
      const shown = (c) => c.plot.data.filter((t) => t.visible !== false).length;
      const result = { charts: charts.length, traces: charts.reduce((n, c) => n + c.traces, 0), toggled: null, errors };
      result.drawn = charts.filter((c) => c.plot.querySelector("svg.main-svg")).length;
      result.lines = document.querySelectorAll(".plot path.js-line, .plot .point, .plot .hm image").length;
      const first = charts.find((c) => c.figure.querySelector('[data-many="true"] button'));
      if (first) {
        const button = first.figure.querySelector('[data-many="true"] button');
        const before = shown(first);
        button.click();
        await new Promise((done) => setTimeout(done, 50));
        const less = shown(first);
        button.click();
        await new Promise((done) => setTimeout(done, 50));
        result.toggled = { name: button.textContent, before, less, after: shown(first) };
      }
      result.ready_ms = Math.round(performance.now());
      result.wide = document.documentElement.scrollWidth - document.documentElement.clientWidth;
      result.requests = performance.getEntriesByType("resource").map((r) => r.name).filter((n) => !/^(data|blob):/.test(n));
      const out = document.createElement("output");
      out.id = "selftest-result";
      out.hidden = true;
      out.textContent = JSON.stringify(result);
      document.body.append(out);
    });
  }
})();

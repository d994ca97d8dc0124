// The interactive curves: linked in time, drawn when the reader gets there.
"use strict";

{
  const { data, column, endOf, make, whenNear } = report;
  const FONT = 'system-ui, -apple-system, "Segoe UI", Roboto, "Liberation Sans", Arial, sans-serif';
  const NARROW = 720; // px, below which all panels stand in one column
  const LEGEND = 44, TITLE = 30, AXIS = 44; // px
  const INNER = 480; // px, height of all panels with their titles where there is room for two columns
  const PANEL = 130; // px, height of a panel where there is not

  // A finger that drags wants to scroll the page, not to zoom.
  const DRAGS = matchMedia("(pointer: fine)").matches;

  /** Runs the embedded library the first time a chart is drawn. */
  function plotly() {
    if (!window.Plotly) {
      const script = make("script");
      script.textContent = document.getElementById("plotly-source").textContent;
      document.head.append(script);
    }
    return window.Plotly;
  }

  /** A text that plotly shows as it is, markup included. */
  const plain = (text) => text.replace(/&/g, "&amp;").replace(/</g, "&lt;").replace(/>/g, "&gt;");
  const dash = (style) => (style.dashes.length ? style.dashes.map((x) => `${x}px`).join(",") : "solid");

  class Explorer {
    constructor(root) {
      this.root = root;
      this.test = data.tests[Number(root.dataset.test)];
      this.quantities = data.quantities.filter((quantity) =>
        quantity.panels.some((panel) => this.test.runs.some((run) => panel.column in run.columns)),
      );
      this.hidden = new Set(); // laws that the reader switched off
      this.inputs = new Map(); // by quantity
      this.range = null; // of time, as the reader chose it
      this.plot = make("div", { class: "plot" });
      this.note = make("p", { class: "note" });
      root.append(this.makePicker(), this.plot, this.note);
      const names = this.quantities.map((quantity) => quantity.name);
      this.show(this.quantities[Math.max(0, names.indexOf("Angles"))]);
      new ResizeObserver(() => {
        if (this.columns() !== this.drawnColumns) this.draw();
      }).observe(root);
      this.player = root.closest("section").querySelector(".player");
      this.player?.addEventListener("timechange", (event) => this.moveCursor(event.detail));
    }

    makePicker() {
      const picker = make("fieldset", { class: "picker" },
        make("legend", { class: "unseen" }, "Quantity"));
      const group = `quantity-${this.root.dataset.test}`;
      for (const quantity of this.quantities) {
        const input = make("input", { type: "radio", name: group });
        input.addEventListener("change", () => this.show(quantity));
        const label = make("label", {}, input, quantity.name);
        picker.append(label);
        this.inputs.set(quantity, input);
      }
      return picker;
    }

    show(quantity) {
      this.inputs.get(quantity).checked = true;
      this.quantity = quantity;
      this.note.textContent = [
        quantity.note ?? "",
        DRAGS ? "Drag to zoom, double-click to see all; the time range stays when the quantity changes." : "",
        "A click on a curve takes the animation there.",
      ].filter(Boolean).join(" ");
      this.draw();
    }

    columns() {
      return this.root.clientWidth < NARROW ? 1 : 2;
    }

    desired(panel) {
      if (panel.desired === "zero") return 0;
      if (panel.desired.startsWith("goal")) return this.test.goal[Number(panel.desired.slice(4))];
      return undefined;
    }

    async draw() {
      this.drawnColumns = this.columns();
      const panels = this.quantity.panels.filter((panel) =>
        this.test.runs.some((run) => panel.column in run.columns),
      );
      const two = this.drawnColumns === 2 && panels.some((panel) => panel.side === 1);
      const sides = two ? [0, 1].map((side) => panels.filter((panel) => panel.side === side)) : [panels];
      const rows = Math.max(...sides.map((side) => side.length));
      const inner = this.drawnColumns === 2 ? INNER : Math.max(2, rows) * (PANEL + TITLE);
      const panelHeight = inner / rows - TITLE;
      const end = endOf(this.test);
      const layout = {
        height: LEGEND + inner + AXIS,
        margin: { l: 56, r: 12, t: LEGEND, b: AXIS },
        font: { family: FONT, size: 12, color: "#1c2126" },
        paper_bgcolor: "rgba(0,0,0,0)",
        plot_bgcolor: "rgba(0,0,0,0)",
        hovermode: "x unified",
        hoversubplots: "axis",
        dragmode: DRAGS ? "zoom" : false,
        showlegend: true,
        legend: { orientation: "h", x: 0, xanchor: "left", y: 1 + 6 / inner, yanchor: "bottom",
          groupclick: "togglegroup", font: { size: 13 } },
        hoverlabel: { font: { family: FONT, size: 12 } },
        modebar: { bgcolor: "rgba(0,0,0,0)", color: "#8a939c", activecolor: "#1c2126" },
        annotations: [],
        shapes: [],
      };
      const traces = [];
      const named = new Set();
      const trace = (group, style, values) => {
        traces.push({
          type: "scatter", mode: "lines", name: plain(group), legendgroup: group, showlegend: !named.has(group),
          visible: this.hidden.has(group) ? "legendonly" : true, ...values,
          line: { color: style.color, width: 1.8, dash: dash(style), simplify: false },
        });
        named.add(group);
      };
      let number = 0;
      sides.forEach((side, s) => {
        const suffix = s ? "2" : "";
        const domain = sides.length === 1 ? [0, 1] : s ? [0.545, 1] : [0, 0.455];
        side.forEach((panel, k) => {
          number += 1;
          const yaxis = `y${number === 1 ? "" : number}`;
          const top = 1 - (k * (panelHeight + TITLE) + TITLE) / inner;
          const bottom = top - panelHeight / inner;
          layout[`yaxis${number === 1 ? "" : number}`] = {
            domain: [Math.max(0, bottom), top], anchor: `x${suffix}`, gridcolor: "#e6eaed",
            zerolinecolor: "#b9c1c8", automargin: false, ticksuffix: "", nticks: 5, fixedrange: false,
          };
          layout.annotations.push({
            text: `${panel.symbol}${panel.meaning && ", "}${panel.meaning} [${panel.unit}]`, xref: "paper", yref: "paper", x: domain[0], y: top,
            xanchor: "left", yanchor: "bottom", showarrow: false, font: { size: 12.5, color: "#1c2126" },
          });
          for (const push of this.test.pushes) {
            layout.shapes.push({
              type: "rect", xref: `x${suffix}`, yref: `${yaxis} domain`, x0: push.start,
              x1: push.start + push.duration, y0: 0, y1: 1, line: { width: 1, color: "#aab3bb" },
              fillcolor: "#1c2126", opacity: 0.16, layer: "below",
            });
          }
          const axes = { xaxis: `x${suffix}`, yaxis };
          const goal = this.desired(panel);
          if (goal !== undefined) {
            trace("desired", data.desired, { ...axes, x: [0, end], y: [goal * panel.factor, goal * panel.factor],
              hoverinfo: "skip" });
          }
          for (const run of this.test.runs) {
            const values = column(run, panel.column);
            if (!values) continue;
            trace(run.title, data.styles[run.law], {
              ...axes, x: Array.from(column(run, "t")),
              y: Array.from(values, (x) => (Number.isFinite(x) ? x * panel.factor : null)),
              hovertemplate: `${panel.symbol} %{y:.4~g} ${panel.unit}`,
            });
          }
          if (k === side.length - 1) {
            layout[`xaxis${suffix}`] = {
              domain, anchor: yaxis, range: this.range ?? [0, end], gridcolor: "#e6eaed", zeroline: false,
              title: { text: "time [s]", standoff: 6 }, ticks: "outside", tickcolor: "#b9c1c8",
              unifiedhovertitle: { text: "%{x:.2f} s" }, ...(s ? { matches: "x" } : {}),
            };
          }
        });
      });
      const config = {
        displaylogo: false, responsive: true, displayModeBar: "hover",
        plotlyServerURL: "", // nothing leaves this page
        modeBarButtons: [["toImage"], ["zoom2d", "pan2d"], ["zoomIn2d", "zoomOut2d", "resetScale2d"]],
        toImageButtonOptions: { format: "svg", filename: `${this.test.key}-${this.quantity.name.toLowerCase().replaceAll(" ", "-")}` },
      };
      this.plot.style.height = `${layout.height}px`;
      this.end = end;
      this.drawing = (this.drawing ?? Promise.resolve()).then(() =>
        plotly().react(this.plot, traces, layout, config));
      await this.drawing;
      this.listen();
      this.moveCursor(this.player?.player?.time ?? 0);
    }

    listen() {
      if (this.listening) return;
      this.listening = true;
      this.plot.on("plotly_relayout", (change) => {
        if ("xaxis.range[0]" in change) this.range = [change["xaxis.range[0]"], change["xaxis.range[1]"]];
        if ("xaxis2.range[0]" in change) this.range = [change["xaxis2.range[0]"], change["xaxis2.range[1]"]];
        if (change["xaxis.autorange"] || change["xaxis2.autorange"]) this.range = null;
      });
      this.plot.on("plotly_doubleclick", () => (this.range = null));
      this.plot.on("plotly_restyle", () => {
        this.hidden = new Set(
          this.plot.data.filter((t) => t.visible === "legendonly").map((t) => t.legendgroup));
      });
      this.plot.on("plotly_afterplot", () => this.moveCursor(this.player?.player?.time ?? 0));
      this.plot.on("plotly_click", (event) => {
        const player = this.player?.player;
        player?.pause();
        player?.seek(event.points[0].x);
      });
    }

    /** Marks the animation's time in every column of panels. */
    moveCursor(time) {
      const full = this.plot._fullLayout;
      const axes = [full?.xaxis, full?.xaxis2].filter((axis) => axis && Number.isFinite(axis._offset));
      this.cursors ??= [];
      while (this.cursors.length < axes.length) {
        this.cursors.push(make("div", { class: "cursor" }));
        this.plot.append(this.cursors.at(-1));
      }
      this.cursors.forEach((cursor, k) => {
        const axis = axes[k];
        const inside = axis && time > 0 && time >= axis.range[0] && time <= axis.range[1];
        cursor.style.display = inside ? "block" : "none";
        if (!inside) return;
        if (!cursor.isConnected) this.plot.append(cursor);
        cursor.style.left = `${axis._offset + ((time - axis.range[0]) / (axis.range[1] - axis.range[0])) * axis._length}px`;
        cursor.style.top = `${LEGEND + TITLE}px`;
        cursor.style.height = `${this.plot.clientHeight - LEGEND - TITLE - AXIS}px`;
      });
    }
  }

  for (const root of document.querySelectorAll(".explore")) whenNear(root, () => new Explorer(root));
}

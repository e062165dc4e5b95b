// The chart of metrics over levels: grows while the run is live, and marks the score.
/**
 * @import { CurveData } from "../server_data.d.ts"
 * @import uPlot from "uplot"
 */
import { need } from "../dom.js";
import { colour } from "../player/colours.js";

const COLOURS = ["--chart-1", "--chart-2"];
const HEIGHT = 220;
const SHARES = [0, 25, 50, 75, 100]; // of the axis [%]
const WITH_LOSSES = [-100, -50, 0, 50, 100]; // where wrong answers cost
const { uPlot: Plot } = window;

/**
 * @param {CurveData} curve
 * @returns {uPlot.Plugin}
 */
function marksPlugin(curve) {
  return {
    hooks: {
      drawAxes: (plot) => {
        const { ctx, bbox } = plot;
        const ratio = devicePixelRatio;
        ctx.save();
        ctx.strokeStyle = colour("--chart-level");
        ctx.fillStyle = colour("--text-2");
        ctx.font = `${11 * ratio}px system-ui, sans-serif`;
        ctx.textBaseline = "alphabetic";
        ctx.setLineDash([4 * ratio, 4 * ratio]);
        const y = Math.round(plot.valToPos(curve.limit, "y", true));
        ctx.beginPath();
        ctx.moveTo(bbox.left, y);
        ctx.lineTo(bbox.left + bbox.width, y);
        ctx.stroke();
        if (curve.mark !== null) {
          const x = Math.round(
            plot.valToPos(Math.min(Math.max(curve.mark, curve.range[0]), curve.range[1]), "x", true),
          );
          const text = `${curve.mark_label} ${curve.mark.toFixed(2)}`;
          ctx.strokeStyle = colour("--focus");
          ctx.lineWidth = 1.5 * ratio;
          ctx.beginPath();
          ctx.moveTo(x, bbox.top);
          ctx.lineTo(x, bbox.top + bbox.height);
          ctx.stroke();
          const overflows = x + ctx.measureText(text).width + 10 * ratio > bbox.left + bbox.width;
          ctx.textAlign = overflows ? "right" : "left";
          ctx.fillText(text, x + (overflows ? -5 : 5) * ratio, bbox.top + 12 * ratio);
        }
        ctx.restore();
      },
    },
  };
}

export class Curve {
  /** @param {HTMLElement} box */
  constructor(box) {
    this.box = box;
    const { nextElementSibling: data } = box;
    if (!(data instanceof HTMLElement)) throw new Error("The chart has no data beside it.");
    this.data = data; // the part of the page with the data
    /** @type {uPlot | null} */
    this.plot = null;
    this.update();
    document.addEventListener("themechange", () => this.update());
    new ResizeObserver(() => this.plot?.setSize({ width: this.width(), height: HEIGHT })).observe(this.box);
  }

  width() {
    return Math.max(this.box.clientWidth, 200);
  }

  // Draws the data embedded in the page, which the server updates with the latest levels.
  update() {
    const text = this.data.querySelector("script")?.textContent;
    if (!text) return;
    /** @type {CurveData} */
    const curve = JSON.parse(text);
    this.plot?.destroy();
    const container = document.createElement("div");
    const readout = document.createElement("output");
    const title = document.createElement("p");
    title.className = "chart-title";
    const names = document.createElement("span");
    curve.lines.forEach(({ label }, index) => {
      const name = document.createElement("span");
      name.textContent = `${label} `;
      name.style.color = colour(COLOURS[index]);
      names.append(name);
    });
    names.append(`[${curve.unit}]`);
    title.append(names, readout);
    container.className = "chart";
    container.setAttribute("role", "img");
    container.setAttribute("aria-label", need(this.data, "p", HTMLElement).textContent);
    this.box.replaceChildren(title, container);
    const axis = {
      stroke: colour("--text-2"),
      grid: { stroke: colour("--chart-grid"), width: 1 },
      ticks: { show: false },
    };
    this.plot = new Plot(
      {
        width: this.width(),
        height: HEIGHT,
        cursor: { drag: { x: false, y: false } },
        legend: { show: false },
        scales: {
          x: { time: false, range: () => curve.range },
          y: { range: (_plot, low) => [low < 0 ? -112 : 0, 112] },
        },
        axes: [
          { ...axis, label: curve.x_label, labelSize: 20, labelFont: "12px system-ui, sans-serif", size: 32 },
          { ...axis, size: 56, splits: (plot) => ((plot.scales.y.min ?? 0) < 0 ? WITH_LOSSES : SHARES) },
        ],
        series: [
          {},
          ...curve.lines.map(({ label }, index) => ({
            label,
            stroke: colour(COLOURS[index]),
            width: 1.5,
            points: { show: true, size: 5 },
          })),
        ],
        plugins: [marksPlugin(curve)],
        hooks: { setCursor: [(plot) => this.showValues(plot, curve, readout)] },
      },
      [curve.x, ...curve.lines.map(({ values }) => values)],
      container,
    );
  }

  /**
   * @param {uPlot} plot
   * @param {CurveData} curve
   * @param {HTMLElement} output
   */
  showValues(plot, curve, output) {
    const at = plot.cursor.idx;
    if (at === null || at === undefined || curve.x[at] === undefined) {
      output.textContent = "";
      return;
    }
    const parts = curve.lines.map(({ label, values }) => `${label} ${values[at].toFixed(1)} ${curve.unit}`);
    output.textContent = `${curve.x[at]}: ${parts.join(", ")}`;
  }
}

// Charts of a metric over the levels, one line for each run.
/**
 * @import { ComparedCurve } from "../server_data.d.ts"
 */
import { colour } from "../player/colours.js";
import { aligned } from "./aligned.js";
import { COLOURS, DASHES } from "./lines.js";

const HEIGHT = 220;
const { uPlot: Plot } = window;

/**
 * @param {HTMLElement} box
 * @param {ComparedCurve[]} curves
 * @param {number[]} runs
 */
export function showLevelCurves(box, curves, runs) {
  const draw = () => {
    box.replaceChildren();
    for (const curve of curves) drawCurve(box, curve, runs);
  };
  draw();
  document.addEventListener("themechange", draw);
}

/**
 * @param {HTMLElement} box
 * @param {ComparedCurve} curve
 * @param {number[]} runs
 */
function drawCurve(box, curve, runs) {
  const container = document.createElement("div");
  const title = document.createElement("p");
  const readout = document.createElement("span");
  const target = document.createElement("div");
  container.className = "chart";
  title.className = "chart-title";
  readout.className = "readout";
  title.append(curve.unit ? `${curve.title} [${curve.unit}]` : curve.title, readout);
  target.setAttribute("role", "img");
  target.setAttribute("aria-label", `${curve.title}, runs ${runs.join(", ")}`);
  container.append(title, target);
  box.append(container);
  const width = () => Math.max(target.clientWidth, 200);
  const axis = {
    stroke: colour("--text-2"),
    grid: { stroke: colour("--chart-grid"), width: 1 },
    ticks: { show: false },
  };
  const [x, ...values] = aligned(curve.lines);
  const plot = new Plot(
    {
      width: width(),
      height: HEIGHT,
      cursor: { drag: { x: false, y: false } },
      legend: { show: false },
      scales: {
        x: { time: false },
        y: { range: (_plot, low, high) => [Math.min(0, low) * 1.1, Math.max(high, curve.limit) * 1.1] },
      },
      axes: [
        { ...axis, label: curve.x_label, labelSize: 20, labelFont: "12px system-ui, sans-serif", size: 32 },
        { ...axis, size: 56 },
      ],
      series: [
        {},
        ...runs.map((id, index) => ({
          label: `#${id}`,
          stroke: colour(COLOURS[index]),
          dash: DASHES[index],
          width: 1.5,
          spanGaps: true,
          points: { show: true, size: 5 },
        })),
      ],
      hooks: {
        setCursor: [
          ({ cursor: { idx: at } }) => {
            const shown = at === null || at === undefined ? [] : runs.map((id, index) => [id, values[index][at]]);
            const parts = shown.map(([id, value]) => `#${id} ${value === null ? "–" : Number(value).toPrecision(3)}`);
            readout.textContent = parts.length ? `${x[Number(at)]}: ${parts.join(", ")}` : "";
          },
        ],
      },
    },
    [x, ...values],
    target,
  );
  new ResizeObserver(() => plot.setSize({ width: width(), height: HEIGHT })).observe(target);
}

// What is drawn into every chart beside its lines: the levels with their names, stages, losses, first touches and
// ends of routes.
/**
 * @import uPlot from "uplot"
 * @import { Moments, PlayerData } from "../server_data.d.ts"
 * @import { Band } from "./stages.js"
 */
import { colour } from "./colours.js";
import { stageColour } from "./stages.js";

const TICK_PX = 9;
const BAND_PX = 5; // of a stage, at the foot of the chart
const TINT = 0.12; // of the chart above it

/** @typedef {Pick<Moments, "losses" | "touches" | "completed"> & {bands: Band[]}} ChartMarks */

/**
 * The plugin of uPlot; owner: levelAt(index), marks()
 * @param {PlayerData} data
 * @param {{levelAt: (index: number) => number | null, marks: () => ChartMarks}} owner
 * @returns {uPlot.Plugin}
 */
export function marksPlugin(data, owner) {
  return {
    hooks: {
      drawClear: (plot) => drawStages(plot, owner.marks().bands),
      drawAxes: (plot) => drawLevels(plot, data, (index) => owner.levelAt(index)),
      draw: (plot) => drawMarks(plot, owner.marks()),
    },
  };
}

/**
 * Below all lines: a band at the foot, and a tint of the same colour above it.
 * @param {uPlot} plot
 * @param {Band[]} bands
 */
function drawStages(plot, bands) {
  const { ctx, bbox } = plot;
  const foot = bbox.top + bbox.height;
  const height = BAND_PX * devicePixelRatio;
  /** @type {(t: number) => number} */
  const place = (t) => Math.min(Math.max(plot.valToPos(t, "x", true), bbox.left), bbox.left + bbox.width);
  ctx.save();
  for (const { stage, from, to } of bands) {
    const [left, right] = [place(from), place(to)];
    ctx.fillStyle = colour(stageColour(stage));
    ctx.globalAlpha = TINT;
    ctx.fillRect(left, bbox.top, right - left, bbox.height);
    ctx.globalAlpha = 1;
    ctx.fillRect(left, foot - height, right - left, height);
  }
  ctx.restore();
}

/**
 * @param {uPlot} plot
 * @param {PlayerData} data
 * @param {(index: number) => number | null} levelAt
 */
function drawLevels(plot, data, levelAt) {
  const { ctx, bbox } = plot;
  ctx.save();
  ctx.strokeStyle = colour("--chart-level");
  ctx.fillStyle = colour("--text-2");
  ctx.font = `${11 * devicePixelRatio}px system-ui, sans-serif`;
  ctx.textAlign = "left";
  ctx.textBaseline = "alphabetic";
  // In a grid, several levels can share a value, so their names are shown instead.
  const names = data.names.length ? data.names : data.levels.map(String);
  const longest = names.reduce((a, b) => (b.length > a.length ? b : a), "");
  const width = plot.valToPos(data.level_s, "x", true) - plot.valToPos(0, "x", true);
  const sample = `0.4 ${data.level.unit} `;
  const fits = !data.names.length && ctx.measureText(sample).width < width;
  // If there are many levels, only every n-th is labelled so that the labels do not overlap.
  const every = Math.ceil(ctx.measureText(`${longest}  `).width / width);
  ctx.setLineDash([4 * devicePixelRatio, 4 * devicePixelRatio]);
  names.forEach((_name, index) => {
    const x = Math.round(plot.valToPos(index * data.level_s, "x", true));
    if (x < bbox.left || x > bbox.left + bbox.width) return;
    ctx.beginPath();
    ctx.moveTo(x, bbox.top);
    ctx.lineTo(x, bbox.top + bbox.height);
    if (index) ctx.stroke();
    if (index % every) return;
    const level = levelAt(index);
    if (level === null) return;
    const value = names[level];
    ctx.fillText(
      fits ? `${value} ${data.level.unit}` : `${value}`,
      x + 5 * devicePixelRatio,
      bbox.top + 12 * devicePixelRatio,
    );
  });
  ctx.restore();
}

/**
 * Ticks where the target was lost, triangles where the hull first touched something, and squares
 * where a route was completed, at the foot of the chart.
 * @param {uPlot} plot
 * @param {ChartMarks} marks
 */
function drawMarks(plot, { losses, touches, completed = [] }) {
  const { ctx, bbox } = plot;
  const foot = bbox.top + bbox.height;
  const size = TICK_PX * devicePixelRatio;
  /** @type {(times: number[]) => number[]} */
  const places = (times) =>
    times.map((t) => plot.valToPos(t, "x", true)).filter((x) => x >= bbox.left && x <= bbox.left + bbox.width);
  ctx.save();
  ctx.fillStyle = colour("--bad");
  for (const x of places(losses)) ctx.fillRect(x - devicePixelRatio, foot - size, 2 * devicePixelRatio, size);
  ctx.fillStyle = colour("--good");
  for (const x of places(completed)) ctx.fillRect(x - size / 2, foot - size, size, size);
  ctx.fillStyle = colour("--warn");
  for (const x of places(touches)) {
    ctx.beginPath();
    ctx.moveTo(x, foot - size);
    ctx.lineTo(x + size / 2, foot);
    ctx.lineTo(x - size / 2, foot);
    ctx.fill();
  }
  ctx.restore();
}

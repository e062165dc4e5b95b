// Precision over recall of a detector: a line for each level, from clear water to turbid.
/**
 * @import { Recognition } from "../server_data.d.ts"
 * @import uPlot from "uplot"
 */
import { colour } from "../player/colours.js";
import { meanPercent, mixed } from "./level_lines.js";

const HEIGHT = 260;
const { uPlot: Plot } = window;

export class PrecisionRecall {
  /**
   * @param {HTMLElement} box
   * @param {Pick<Recognition, "recalls" | "levels">} found
   * @param {string} label of the levels
   */
  constructor(box, found, label) {
    this.box = box;
    this.recalls = found.recalls;
    this.levels = found.levels.filter(({ precision }) => precision.length > 0);
    this.label = label;
    /** @type {uPlot | null} */
    this.plot = null;
    this.draw();
    document.addEventListener("themechange", () => this.draw());
    new ResizeObserver(() => this.plot?.setSize({ width: this.width(), height: HEIGHT })).observe(box);
  }

  width() {
    return Math.max(this.box.clientWidth, 200);
  }

  draw() {
    this.plot?.destroy();
    const ends = [colour("--chart-1"), colour("--chart-2")];
    const paints = this.levels.map((_, index) => mixed(ends, index / Math.max(this.levels.length - 1, 1)));
    const container = document.createElement("div");
    container.className = "chart";
    container.setAttribute("role", "img");
    container.setAttribute("aria-label", `Precision over recall for each ${this.label.toLowerCase()}`);
    const readout = document.createElement("output");
    const title = document.createElement("p");
    title.className = "chart-title";
    const unit = document.createElement("span");
    unit.textContent = "Precision [%]";
    title.append(unit, readout);
    this.box.replaceChildren(title, container, this.legend(paints));
    const percent = [0, 25, 50, 75, 100];
    const axis = {
      stroke: colour("--text-2"),
      grid: { stroke: colour("--chart-grid"), width: 1 },
      ticks: { show: false },
      splits: () => percent,
    };
    this.plot = new Plot(
      {
        width: this.width(),
        height: HEIGHT,
        cursor: { drag: { x: false, y: false } },
        legend: { show: false },
        scales: { x: { time: false, range: () => [0, 100] }, y: { range: () => [0, 104] } },
        axes: [
          { ...axis, label: "Recall [%]", labelSize: 20, labelFont: "12px system-ui, sans-serif", size: 32 },
          { ...axis, size: 44 },
        ],
        series: [
          {},
          ...this.levels.map(({ value }, index) => ({
            label: String(value),
            stroke: paints[index],
            width: 2,
            points: { show: false },
          })),
        ],
        hooks: { setCursor: [(plot) => this.read(plot.cursor.idx, readout)] },
      },
      [
        this.recalls.map((recall) => 100 * recall),
        ...this.levels.map(({ precision }) => precision.map((share) => 100 * share)),
      ],
      container,
    );
  }

  /** @param {string[]} paints */
  legend(paints) {
    const list = document.createElement("ul");
    list.className = "legend level-lines";
    list.append(
      ...this.levels.map(({ value, precision }, index) => {
        const item = document.createElement("li");
        const line = document.createElement("i");
        line.style.background = paints[index];
        item.append(line, `${value}: ${meanPercent(precision).toFixed(1)} %`);
        return item;
      }),
    );
    list.setAttribute("aria-label", `Average precision at each ${this.label.toLowerCase()}`);
    return list;
  }

  /**
   * @param {number | null | undefined} at
   * @param {HTMLElement} output
   */
  read(at, output) {
    if (at === null || at === undefined) {
      output.textContent = "";
      return;
    }
    const parts = this.levels.map(({ value, precision }) => `${value}: ${(100 * precision[at]).toFixed(0)}`);
    output.textContent = `recall ${(100 * this.recalls[at]).toFixed(0)} %, ${parts.join(", ")}`;
  }
}

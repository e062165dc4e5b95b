// From metres north and east to pixels of a map that has north up. No page is needed for it.
/** @import { Place } from "./places.js" */

const MARGIN_M = 0.4; // around what is to be seen
const STEPS_M = [0.5, 1, 2, 5, 10, 20, 50];
const LINE_PX = 44; // least distance of two lines of the grid
export const EDGE_PX = 26; // for the numbers beside and below

export class MapScale {
  /**
   * Shows all places in a map of this size, whose numbers count from an origin.
   * @param {Place[]} places
   * @param {{width: number, height: number, origin: Place}} map [px]
   */
  constructor(places, { width, height, origin }) {
    this.width = width;
    this.height = height;
    this.origin = origin;
    const [norths, easts] = [places.map(([north]) => north), places.map(([, east]) => east)];
    const [south, north] = [Math.min(...norths) - MARGIN_M, Math.max(...norths) + MARGIN_M];
    const [west, east] = [Math.min(...easts) - MARGIN_M, Math.max(...easts) + MARGIN_M];
    const [across, along] = [width - EDGE_PX, height - EDGE_PX];
    this.perMetre = Math.min(across / (east - west), along / (north - south)); // [px/m]
    this.middle = [(south + north) / 2, (west + east) / 2];
    this.centre = [EDGE_PX + across / 2, along / 2]; // [px] from the upper left
  }

  /**
   * @param {Place} place
   * @returns {[number, number]} x and y [px]
   */
  at([north, east]) {
    return [
      this.centre[0] + this.perMetre * (east - this.middle[1]),
      this.centre[1] - this.perMetre * (north - this.middle[0]),
    ];
  }

  /**
   * @param {Place} place
   */
  text(place) {
    return this.at(place)
      .map((px) => px.toFixed(1))
      .join(" ");
  }

  /** Distance of the lines of the grid [m]. */
  get step() {
    return STEPS_M.find((step) => step * this.perMetre >= LINE_PX) ?? STEPS_M[STEPS_M.length - 1];
  }

  /**
   * Lines of the grid: metres from the origin, and where they are [px].
   * @returns {{norths: {metres: number, px: number}[], easts: {metres: number, px: number}[]}}
   */
  grid() {
    const { origin, step } = this;
    /** @type {(axis: 0 | 1, low: number, high: number) => number[]} */
    const within = (axis, low, high) => {
      const first = Math.ceil((low - origin[axis]) / step);
      const last = Math.floor((high - origin[axis]) / step);
      return Array.from({ length: Math.max(last - first + 1, 0) }, (_, index) => (first + index) * step);
    };
    const [up, side] = [this.centre[1] / this.perMetre, (this.width - this.centre[0]) / this.perMetre];
    const norths = within(0, this.middle[0] - up, this.middle[0] + up);
    const easts = within(1, this.middle[1] - side, this.middle[1] + side);
    return {
      norths: norths.map((metres) => ({ metres, px: this.at([origin[0] + metres, 0])[1] })),
      easts: easts.map((metres) => ({ metres, px: this.at([0, origin[1] + metres])[0] })),
    };
  }
}

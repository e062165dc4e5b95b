// What maps consist of: a grid in metres, and marks at places.
/**
 * @import { Place } from "./places.js"
 * @import { MapScale } from "./map_scale.js"
 */
import { need } from "../dom.js";
import { EDGE_PX } from "./map_scale.js";

/**
 * @param {SVGGElement} group
 * @param {MapScale} scale
 */
export function drawGrid(group, scale) {
  const { norths, easts } = scale.grid();
  const [right, bottom] = [scale.width, scale.height - EDGE_PX];
  const lines = [
    ...norths.map(({ px }) => `M${EDGE_PX} ${px}H${right}`),
    ...easts.map(({ px }) => `M${px} 0V${bottom}`),
  ];
  const path = made("path", { d: lines.join("") });
  const texts = [
    ...norths
      .filter(({ px }) => px > 20 && px < bottom - 4)
      .map(({ metres, px }) => label(metres, { x: EDGE_PX - 5, y: px + 4, "text-anchor": "end" })),
    ...easts
      .filter(({ px }) => px < right - 40)
      .map(({ metres, px }) => label(metres, { x: px, y: bottom + 16, "text-anchor": "middle" })),
  ];
  const axes = [label("N [m]", { x: 0, y: 12 }), label("E [m]", { x: right, y: bottom + 16, "text-anchor": "end" })];
  group.replaceChildren(path, ...texts, ...axes);
}

/**
 * @param {string} name
 * @param {Record<string, string | number>} attributes
 */
function made(name, attributes) {
  const element = document.createElementNS("http://www.w3.org/2000/svg", name);
  for (const [key, value] of Object.entries(attributes)) element.setAttribute(key, String(value));
  return element;
}

/**
 * @param {string | number} text
 * @param {Record<string, string | number>} attributes
 */
function label(text, attributes) {
  const element = made("text", attributes);
  element.textContent = String(text).replace("-", "−");
  return element;
}

/**
 * @param {MapScale} scale
 * @param {Place[]} corners
 */
export function outline(scale, corners) {
  return `${line(scale, corners)}Z`;
}

/**
 * @param {MapScale} scale
 * @param {Place[]} places
 */
export function line(scale, places) {
  return `M${places.map((place) => scale.text(place)).join("L")}`;
}

/**
 * Circles with a dot in their middle, as one path.
 * @param {MapScale} scale
 * @param {{at: Place, sigma: number}[]} around sigma: radius [m]
 */
export function discs(scale, around) {
  return around
    .map(({ at, sigma }) => {
      const radius = (sigma * scale.perMetre).toFixed(1);
      const [x, y] = scale.at(at);
      const half = `a${radius} ${radius} 0 0 1 `;
      const across = (2 * sigma * scale.perMetre).toFixed(1);
      const ring = `M${(x - sigma * scale.perMetre).toFixed(1)} ${y.toFixed(1)}${half}${across} 0${half}-${across} 0`;
      return `${ring}M${scale.text(at)}h0`;
    })
    .join("");
}

/**
 * The corners of the square around a circle.
 * @param {Place} centre
 * @param {number} radius
 * @returns {Place[]}
 */
export function around([north, east], radius) {
  return [
    [north - radius, east - radius],
    [north + radius, east + radius],
  ];
}

/**
 * @param {SVGSVGElement} svg
 * @param {string} name
 * @param {string} path
 */
export function write(svg, name, path) {
  need(svg, `[data-map="${name}"]`, SVGPathElement).setAttribute("d", path);
}

/**
 * @param {SVGSVGElement} svg
 * @param {string} name
 * @param {[number, number]} at [px]
 * @param {number} [turned] [°]
 */
export function move(svg, name, [x, y], turned = 0) {
  const mark = need(svg, `[data-map="${name}"]`, SVGGElement);
  mark.setAttribute("transform", `translate(${x.toFixed(1)} ${y.toFixed(1)}) rotate(${turned.toFixed(1)})`);
}

/**
 * @param {SVGSVGElement} svg
 * @param {string} name
 * @param {[number, number]} centre [px]
 * @param {number} radius [px]
 */
export function circle(svg, name, [x, y], radius) {
  const element = need(svg, `[data-map="${name}"]`, SVGCircleElement);
  for (const [key, value] of Object.entries({ cx: x, cy: y, r: radius })) element.setAttribute(key, value.toFixed(1));
}

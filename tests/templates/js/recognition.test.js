// What a detector recognised, as the page of a run shows it.
import assert from "node:assert/strict";
import { test } from "node:test";
import { confusionRows } from "../../../templates/static/js/run/confusion.js";
import { crop } from "../../../templates/static/js/run/crop.js";
import { caption } from "../../../templates/static/js/run/gallery.js";
import { meanPercent, mixed } from "../../../templates/static/js/run/level_lines.js";

const IMAGE = { width: 320, height: 240 };
/** @type {(left: number, top: number, width: number, height: number) => [number, number][]} */
const box = (left, top, width, height) => [
  [left, top],
  [left + width, top],
  [left + width, top + height],
  [left, top + height],
];

test("a crop has the object in its middle, with its surroundings", () => {
  const { left, top, side } = crop(box(128, 96, 64, 48), IMAGE);
  assert.ok(Math.abs(side - 0.48) < 1e-9);
  assert.ok(Math.abs(left + side / 2 - 0.5) < 1e-9 && Math.abs(top + side / 2 - 0.5) < 1e-9);
});

test("a crop stays in the image, whatever is answered", () => {
  for (const corners of [box(300, 230, 20, 10), box(-1e9, -1e9, 2e9, 2e9), box(-500, 100, 10, 10)]) {
    const { left, top, side } = crop(corners, IMAGE);
    assert.ok(left >= 0 && top >= 0 && left + side <= 1 + 1e-9 && top + side <= 1 + 1e-9);
  }
});

test("a small object is shown with as much around it that one sees where it lies", () => {
  assert.equal(crop(box(160, 120, 4, 4), IMAGE).side, 0.35);
});

test("a caption says what was answered, how surely, on what and where", () => {
  const example = { trial: 0, level: 2, t: 1, corners: box(0, 0, 1, 1), label: "box", confidence: 0.876 };
  assert.equal(caption({ ...example, lies_on: "Rock" }, "optical depth 2"), "box 0.88 on rock, optical depth 2");
  assert.equal(caption({ ...example, confidence: null, lies_on: null }, "optical depth 2"), "box, optical depth 2");
});

test("decoys on which no answer lay are left out of the table, classes never", () => {
  const found = {
    classes: ["Box", "Pipe"],
    lies_on: ["Box", "Pipe", "Rock", "Shell"],
    confusion: [
      [0, 0],
      [0, 3],
      [0, 0],
      [1, 0],
    ],
  };
  assert.deepEqual(
    confusionRows(found).map(({ title, own }) => [title, own]),
    [
      ["Box", 0],
      ["Pipe", 1],
      ["Shell", -1],
    ],
  );
});

test("colours of levels go from one end to the other", () => {
  const ends = ["rgb(0, 100, 200)", "rgb(200, 100, 0)"];
  assert.deepEqual(
    [0, 0.5, 1].map((share) => mixed(ends, share)),
    ["rgb(0, 100, 200)", "rgb(100, 100, 100)", "rgb(200, 100, 0)"],
  );
  assert.equal(meanPercent([1, 0.5, 0]), 50);
});

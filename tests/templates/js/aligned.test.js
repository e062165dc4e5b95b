// Lines of runs with different levels on one axis.
import assert from "node:assert/strict";
import { test } from "node:test";
import { aligned } from "../../../templates/static/js/compare/aligned.js";

test("lines with different points share an axis and have gaps where they have none", () => {
  const lines = [
    { x: [0, 2], values: [90, 40] },
    { x: [4, 2], values: [10, 30] },
    { x: [], values: [] },
  ];
  assert.deepEqual(aligned(lines), [
    [0, 2, 4],
    [90, 40, null],
    [null, 30, 10],
    [null, null, null],
  ]);
});

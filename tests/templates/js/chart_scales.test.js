// The vertical scales of charts.
import assert from "node:assert/strict";
import { test } from "node:test";
import {
  decades,
  drawable,
  isDistance,
  linearRange,
  logarithmicRange,
  tickText,
} from "../../../templates/static/js/player/chart_scales.js";

test("a linear range starts at zero where the values are near it, and has room above them", () => {
  assert.deepEqual(linearRange(1, 10), [0, 10 + 0.28 * 9]);
  assert.deepEqual(linearRange(8, 10), [8 - 0.08 * 2, 10 + 0.28 * 2]);
  assert.deepEqual(linearRange(8, 10, 0.2), [8 - 0.08 * 2, 10 + 0.2 * 2]);
  assert.deepEqual(linearRange(null, null), [0, 1]);
  const [low, high] = linearRange(3, 3);
  assert.ok(low < 3 && high > 3);
});

test("a logarithmic range starts with a decade and has at most four below the largest value", () => {
  const [low, high] = logarithmicRange(0, 20);

  assert.ok(Math.abs(low - 0.001) < 1e-9);
  assert.ok(Math.abs(high - 20 * 20_000 ** 0.28) < 1e-6);
  assert.equal(logarithmicRange(0.5, 20)[0], 0.1);
  assert.deepEqual(logarithmicRange(null, null), [0.1, 10]);
  assert.deepEqual(logarithmicRange(0, 0), [0.1, 10]);
});

test("zero has no place on a logarithmic axis", () => {
  assert.deepEqual(drawable([0, 0.5, null], true), [null, 0.5, null]);
  assert.deepEqual(drawable([0, 0.5, null], false), [0, 0.5, null]);
});

test("only what is never negative can be logarithmic", () => {
  assert.ok(isDistance({ columns: ["distance", "tracker_error"] }));
  assert.ok(!isDistance({ columns: ["distance", "yaw"] }));
});

test("of the lines of a logarithmic grid those of the decades are drawn and labelled", () => {
  assert.deepEqual(decades([0.1, 0.2, 1, 5, 10]), [0.1, null, 1, null, 10]);
  assert.deepEqual([null, 0.1, 0.30000000000000004, 1000].map(tickText), ["", "0.1", "0.3", "1000"]);
});

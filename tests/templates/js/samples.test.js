// Telemetry behind the charts.
import assert from "node:assert/strict";
import { test } from "node:test";
import {
  appendRows,
  lastUntil,
  levelAt,
  noSamples,
  thinned,
  valueAt,
} from "../../../templates/static/js/player/samples.js";

test("the last time up to another one is found, within a tolerance", () => {
  const times = [0, 0.5, 1];

  assert.deepEqual(
    [-1, 0, 0.4, 0.5, 0.9999999, 7].map((t) => lastUntil(times, t)),
    [0, 0, 0, 1, 2, 2],
  );
  assert.equal(lastUntil(times, 0.49), 0);
  assert.equal(lastUntil(times, 0.49, 0.02), 1);
  assert.equal(lastUntil([], 1), -1);
});

test("a run keeps its last value for a second after its end", () => {
  const samples = { t: [0, 10], values: { x: [1, 2] } };

  assert.deepEqual(
    [0, 9.9, 10, 11, 11.1].map((t) => valueAt(samples, "x", t)),
    [1, 1, 2, 2, null],
  );
  assert.equal(valueAt(samples, "y", 5), null);
});

test("rows that are replayed are not appended twice, and a new column is empty before", () => {
  const samples = noSamples();

  appendRows(samples, ["x"], ["t", "x"], [[0, 1], [1, 2]]); // biome-ignore format: a table
  appendRows(samples, ["x", "y"], ["y", "t", "x"], [[7, 1, 2], [8, 2, 3]]); // biome-ignore format: a table
  appendRows(samples, ["x", "y"], ["t", "x"], [[3, 4]]);

  assert.deepEqual(samples, { t: [0, 1, 2, 3], values: { x: [1, 2, 3, 4], y: [null, null, 8, null] } });
});

test("to thin out halves the old samples and keeps the newest 200 and the length of columns", () => {
  const t = Array.from({ length: 1000 }, (_, index) => index);

  const fewer = thinned({ t, values: { x: t } });

  assert.deepEqual(fewer.t.slice(0, 3), [0, 2, 4]);
  assert.deepEqual(fewer.t.slice(-199), t.slice(-199));
  assert.equal(fewer.t.length, 600);
  assert.deepEqual(fewer.values.x, fewer.t);
});

test("the level of a position is read in its middle, and unknown until then", () => {
  const samples = { t: [0, 1, 9, 10.5, 12], values: { level: [2, 2, 2, 2, 0] } };

  assert.equal(levelAt(samples, 0, 10), 2);
  assert.equal(levelAt(samples, 1, 10), 0);
  assert.equal(levelAt(samples, 2, 10), null);
});

// The time that a run still takes, as its page estimates and writes it.
import assert from "node:assert/strict";
import { test } from "node:test";
import { about, duration, Estimate } from "../../../templates/static/js/run/estimate.js";

test("it is written without sixty seconds or minutes", () => {
  assert.deepEqual([599.7, 59.7, 3599.9].map(duration), ["10 min", "1 min", "1 h"]);
  assert.deepEqual([9.9, 9.96, 61, 3661].map(duration), ["9.9 s", "10 s", "1 min 1 s", "1 h 1 min"]);
  assert.deepEqual([3, 54, 61, 7500].map(about), ["5 s", "55 s", "1 min", "2 h 5 min"]);
});

test("it counts down and does not jump when the run is faster than it was", () => {
  const estimate = new Estimate(100);
  // Twice as slow as expected at first, then in one leap to where it should be.
  const left = Array.from({ length: 61 }, (_, t) => estimate.update(t < 30 ? t / 200 : t / 100, t));

  const steps = left.slice(1).map((each, index) => Math.abs(each - left[index]));

  assert.ok(Math.max(...steps) < 6);
  assert.ok(left[60] < left[0]);
});

test("without an estimate of the server it waits until the pace can be measured", () => {
  const estimate = new Estimate();

  assert.ok(Number.isNaN(estimate.update(0, 0)));
  assert.ok(Number.isNaN(estimate.update(0.1, 1)));
  assert.equal(estimate.update(0.5, 5), 5);
});

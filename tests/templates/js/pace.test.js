// The resolution of the scene: as many pixels as the machine has time for.
import assert from "node:assert/strict";
import { test } from "node:test";
import { Pace } from "../../../templates/static/js/player/scene/pace.js";

const FRAME_MS = 1000 / 60; // of the screen

/**
 * Draws on a machine that takes `cost` [ms] for a picture with all pixels.
 * @param {number} initial scale
 * @param {number} cost
 * @param {number} seconds
 */
function drawn(initial, cost, seconds) {
  const pace = new Pace(initial);
  const interval = () => Math.max(FRAME_MS, cost * pace.scale ** 2);
  const changes = [];
  let now = 0;
  while (now < 1000 * seconds) {
    now += interval();
    if (pace.drawn(now, true)) changes.push(now / 1000);
  }
  return { scale: pace.scale, changes, interval: interval() };
}

for (const cost of [1, 12, 20]) {
  test(`a scene has all pixels after four seconds if there is time: ${cost} ms`, () => {
    assert.equal(drawn(0.5, cost, 4).scale, 1);
  });
}

for (const cost of [30, 60, 120, 240]) {
  for (const scale of [0.5, 1]) {
    test(`it settles where twenty pictures a second are drawn: ${cost} ms from ${scale}`, () => {
      const { interval, changes } = drawn(scale, cost, 60);

      assert.ok(interval < 50);
      assert.deepEqual(
        changes.filter((at) => at > 5),
        [],
      );
    });
  }
}

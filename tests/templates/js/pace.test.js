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

for (const cost of [10, 60, 200, 900]) {
  test(`pictures that are limited get no more pixels than at first, and fewer only if they are late: ${cost} ms`, () => {
    const pace = new Pace(0.5, 80);
    let now = 0;
    while (now < 60_000) {
      now += Math.max(80, cost * pace.scale ** 2);
      pace.drawn(now, true);
    }

    assert.equal(pace.scale === 0.5, cost * 0.5 ** 2 < 120);
    assert.ok(pace.scale <= 0.5);
  });
}

test("limited pictures that were late for a while get their pixels back", () => {
  const pace = new Pace(0.5, 80);
  let now = 0;
  const scaleAfter = (/** @type {number} */ pictures, /** @type {number} */ interval) => {
    for (const end = now + pictures * interval; now < end; now += interval) pace.drawn(now, true);
    return pace.scale;
  };

  assert.ok(scaleAfter(50, 400) < 0.4);
  assert.equal(scaleAfter(200, 82), 0.5);
});

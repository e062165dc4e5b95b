// What moves the playhead, and how far.
import assert from "node:assert/strict";
import { test } from "node:test";
import { Playhead } from "../../../templates/static/js/player/playhead.js";

/**
 * A playhead after these calls.
 * @param {{live?: boolean, loop?: boolean}} options
 * @param {((playhead: Playhead) => void)[]} steps
 */
function after(options, ...steps) {
  const playhead = new Playhead({ duration: 100, ...options });
  for (const step of steps) step(playhead);
  return playhead;
}

/** @type {(t: number) => (playhead: Playhead) => void} */
const available = (t) => (playhead) => playhead.available(t);
/** @type {(t: number) => (playhead: Playhead) => void} */
const seek = (t) => (playhead) => playhead.seek(t);
/** @type {(playhead: Playhead) => void} */
const play = (playhead) => playhead.play();
/** @type {(playhead: Playhead) => void} */
const second = (playhead) => playhead.advance(1);

test("it follows live data until somebody seeks", () => {
  const live = { live: true };

  const following = after(live, available(10), available(20));
  const sought = after(live, available(10), seek(4), available(20));
  const back = after(live, available(10), seek(4), (playhead) => playhead.follow(), available(20));

  assert.deepEqual([following.t, following.following], [20, true]);
  assert.deepEqual([sought.t, sought.following], [4, false]);
  assert.deepEqual([back.t, back.following], [20, true]);
});

test("behind live data it waits for more, and at the end of a replay it stops", () => {
  /** @type {((playhead: Playhead) => void)[]} */
  const steps = [available(10), seek(9), (playhead) => playhead.setSpeed(5), play, second];

  const waits = after({ live: true }, ...steps);
  const goesOn = after({ live: true }, ...steps, available(30), second);
  const stops = after({}, ...steps);
  const again = after({}, ...steps, play);
  const loops = after({ loop: true }, ...steps);

  assert.deepEqual([waits.t, waits.playing], [10, true]);
  assert.deepEqual([goesOn.t, goesOn.playing], [15, true]);
  assert.deepEqual([stops.t, stops.playing], [10, false]);
  assert.deepEqual([again.t, again.playing], [0, true]);
  assert.deepEqual([loops.t, loops.playing], [0, true]);
});

test("nobody is told anything while it waits for more", () => {
  const playhead = after({ live: true }, available(10), seek(9), play, second);
  /** @type {string[]} */
  const told = [];
  playhead.listen((_playhead, what) => told.push(what));

  second(playhead);
  assert.deepEqual(told, ["mode"]);

  playhead.available(11);
  second(playhead);
  assert.deepEqual(told, ["mode", "time", "time"]);
});

test("it cannot be moved beyond the data", () => {
  assert.equal(after({}, available(10), seek(50)).t, 10);
  assert.equal(after({}, available(10), seek(-3)).t, 0);
});

for (const damaged of [{}, { t: null, speed: "fast", trial: -1 }, { t: "x", trial: 1.5, speed: 3 }]) {
  test(`a damaged state resumes at the start: ${JSON.stringify(damaged)}`, () => {
    const { t, trial, speed } = after({}, (playhead) => playhead.restore(damaged));

    assert.deepEqual([t, trial, speed], [0, 0, 1]);
  });
}

test("a resumed time is kept until it is known how far the data reach", () => {
  /** @type {(playhead: Playhead) => void} */
  const restored = (playhead) => playhead.restore({ t: 40, speed: 20, trial: 2 });

  const before = after({}, restored);
  const less = after({}, restored, (playhead) => playhead.reaches(30));
  const more = after({}, restored, (playhead) => playhead.reaches(90));

  assert.deepEqual([before.t, before.trial, before.speed], [40, 2, 20]);
  assert.deepEqual([less.t, more.t, more.newest], [30, 40, 90]);
});

test("listeners are told of the mode at once, and of time and mode as they change", () => {
  const playhead = after({}, available(10));
  /** @type {string[]} */
  const told = [];

  playhead.listen((_playhead, what) => told.push(what));
  playhead.seek(4);
  playhead.toggle();

  assert.deepEqual(told, ["mode", "time", "mode"]);
});

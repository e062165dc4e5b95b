// How far a level got, as bands of the time line.
import assert from "node:assert/strict";
import { test } from "node:test";
import { BEFORE, bandAt, bandsFromStart, bandsOf, within } from "../../../templates/static/js/player/stages.js";

const LEVELS = [{ t: 0 }, { t: 40 }];
const REACHED = [
  { level: 1, stage: 0, t: 10 },
  { level: 1, stage: 1, t: 15 },
  { level: 0, stage: 0, t: 52 },
];

test("a stage lasts until the next one, and the last one to the end of its level", () => {
  const bands = bandsOf({ levels: LEVELS, stages: REACHED }, 80);

  assert.deepEqual(bands, [
    { stage: 0, from: 10, to: 15 },
    { stage: 1, from: 15, to: 40 },
    { stage: 0, from: 52, to: 80 },
  ]);
});

test("of a live run a band grows with the rows, but not beyond its level", () => {
  const first = { levels: LEVELS.slice(0, 1), stages: REACHED.slice(0, 2) };

  assert.equal(bandsOf(first, 20, 40).at(-1)?.to, 20);
  assert.equal(bandsOf(first, 55, 40).at(-1)?.to, 40); // the next level is not known yet
});

test("of two stages that are reached at once, the later one counts", () => {
  const stages = [
    { level: 0, stage: 2, t: 10 },
    { level: 0, stage: 3, t: 10 },
  ];

  assert.deepEqual(bandsOf({ levels: LEVELS, stages }, 80), [{ stage: 3, from: 10, to: 40 }]);
});

test("a trial without stages has no bands", () => {
  assert.deepEqual(bandsOf({ levels: LEVELS }, 80), []);
});

test("before its first stage and in the next level, no stage is reached", () => {
  const bands = bandsOf({ levels: LEVELS, stages: REACHED }, 80);

  assert.deepEqual(
    [5, 10, 39.9, 40, 60].map((t) => bandAt(bands, t)?.stage),
    [undefined, 0, 1, undefined, 0],
  );
});

test("the row that reached a stage belongs to it, however its time was rounded", () => {
  const bands = bandsOf({ levels: LEVELS, stages: [{ level: 1, stage: 2, t: 20.2 }] }, 80);

  assert.deepEqual(
    [20.15, Math.fround(20.2), 20.199999, 20.2].map((t) => bandAt(bands, t)?.stage),
    [undefined, 2, 2, 2],
  );
});

test("a level that is compared alone begins at zero", () => {
  const bands = bandsOf({ levels: LEVELS, stages: REACHED }, 80);

  assert.deepEqual(within(bands, 40, 80), [{ stage: 0, from: 12, to: 40 }]);
  assert.deepEqual(within(bands, 12, 20), [
    { stage: 0, from: 0, to: 3 },
    { stage: 1, from: 3, to: 8 },
  ]);
});

test("what comes before the first stage is a band from the start of each level, also of one without stages", () => {
  const levels = [...LEVELS, { t: 80 }, { t: 120 }];
  const stages = [...REACHED, { level: 2, stage: 0, t: 120 }];
  const before = bandsFromStart({ levels, stages }, 150, 40).filter(({ stage }) => stage === BEFORE);

  assert.deepEqual(
    before.map(({ from, to }) => [from, to]),
    [
      [0, 10],
      [40, 52],
      [80, 120],
    ],
  );
  assert.equal(bandsFromStart({ levels: LEVELS.slice(0, 1) }, 15, 40)[0].to, 15); // a live run
});

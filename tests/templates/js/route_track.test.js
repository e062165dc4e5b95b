// What a map and a scene draw of a route, from rows of telemetry.
import assert from "node:assert/strict";
import { test } from "node:test";
import { fixError, fixesOf, fixOf, partedAt, piecesOf } from "../../../templates/static/js/player/route_track.js";

/** @type {[number, number, number][]} */
const POINTS = [
  [0, 0, 10],
  [3, 4, 10],
  [3, 4, 12],
];

test("a route is parted where it has been followed to, and both parts begin or end there", () => {
  assert.deepEqual(partedAt(POINTS, 2.5), [
    [
      [0, 0, 10],
      [1.5, 2, 10],
    ],
    [
      [1.5, 2, 10],
      [3, 4, 10],
      [3, 4, 12],
    ],
  ]);
});

test("the way down counts as well", () => {
  const [done, rest] = partedAt(POINTS, 6);

  assert.deepEqual(done[done.length - 1], [3, 4, 11]);
  assert.deepEqual(rest, [
    [3, 4, 11],
    [3, 4, 12],
  ]);
});

test("nothing of a route is done at its start, and all of it at its end", () => {
  assert.deepEqual(partedAt(POINTS, 0)[1], [[0, 0, 10], ...POINTS.slice(1)]);
  assert.deepEqual(partedAt(POINTS, 7), [POINTS, [[3, 4, 12]]]);
  assert.deepEqual(partedAt(POINTS, 7.1)[0], POINTS);
});

test("a pipe is bare but for the stretches that are covered, across its points", () => {
  const pipe = {
    axis: /** @type {[number, number][]} */ ([
      [0, 0],
      [4, 0],
      [4, 6],
    ]),
    seabed: 20,
    radius: 0.2,
    covered: /** @type {[number, number][]} */ ([
      [1, 2],
      [3, 6],
    ]),
  };

  const { bare, covered } = piecesOf(pipe);

  assert.deepEqual(covered, [
    [
      [1, 0, 20],
      [2, 0, 20],
    ],
    [
      [3, 0, 20],
      [4, 0, 20],
      [4, 2, 20],
    ],
  ]);
  assert.deepEqual(
    bare.map((piece) => [piece[0], piece[piece.length - 1]]),
    [
      [
        [0, 0, 20],
        [1, 0, 20],
      ],
      [
        [2, 0, 20],
        [3, 0, 20],
      ],
      [
        [4, 2, 20],
        [4, 6, 20],
      ],
    ],
  );
});

/** @type {(t: number, at: number | null, age: number | null) => any} */
const row = (t, at, age) => ({ t, x: t, y: 0, fix_x: at, fix_y: at, fix_age: age, fix_sigma: at && 0.5 });

test("there is no fix before the first one", () => {
  assert.equal(fixOf(row(1, null, null)), null);
});

test("each fix counts once, at the time when it was measured", () => {
  const rows = [row(0, null, null), row(1, 2, 0.75), row(2, 2, 1.75), row(3, 6, 0.5)];

  assert.deepEqual(fixesOf(rows), [
    { at: [2, 2], sigma: 0.5, t: 0.25 },
    { at: [6, 6], sigma: 0.5, t: 2.5 },
  ]);
});

test("a fix is off by its distance from where the vehicle was when it was measured", () => {
  const rows = [0, 1, 2, 3].map((t) => row(t, null, null));

  assert.equal(fixError({ at: [1, 3], sigma: 1, t: 1.1 }, rows), 3);
  assert.equal(fixError({ at: [5, 0], sigma: 1, t: 9 }, rows), 2);
});

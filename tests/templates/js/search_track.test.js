// What a search map draws of rows of telemetry, and where.
import assert from "node:assert/strict";
import { test } from "node:test";
import { MapScale } from "../../../templates/static/js/player/map_scale.js";
import { levelAround, wayUntil } from "../../../templates/static/js/player/places.js";
import { footprint, phaseOf } from "../../../templates/static/js/player/search_track.js";

/** @type {any} */
const SCENE = {
  camera: { mount: [0.5, 0, 0.2], focal: 100, width: 200, height: 100 },
  seabed: { depth: 5 },
};
const LEVEL = { t: 0, x: 1, y: 2, z: 2.8, roll: 0, pitch: 0, yaw: 0 };
const FREE = {
  t: 0,
  work_arm_n: 0,
  work_hull_n: 0,
  work_rest_n: 30,
  decoy_arm_n: 0,
  decoy_hull_n: 0,
  decoy_rest_n: 30,
};

/** @param {[number, number][]} corners */
const rounded = (corners) => corners.map((corner) => corner.map((value) => Number(value.toFixed(6))));

test("a level camera 2 m above the seabed sees as much of it as its focal length says", () => {
  assert.deepEqual(rounded(footprint(LEVEL, SCENE)), [
    [2.5, 0],
    [2.5, 4],
    [0.5, 4],
    [0.5, 0],
  ]);
});

test("a vehicle that heads east looks east of where it is", () => {
  const [ahead] = rounded(footprint({ ...LEVEL, yaw: Math.PI / 2 }, SCENE));

  assert.deepEqual(ahead, [3, 3.5]); // to port and ahead
});

test("a bow that rises moves the view forward, and a roll to starboard moves it to port", () => {
  /** @param {[number, number][]} corners */
  const middle = (corners) => [0, 1].map((axis) => corners.reduce((sum, corner) => sum + corner[axis], 0) / 4);
  const [north, east] = middle(footprint(LEVEL, SCENE));

  assert.ok(middle(footprint({ ...LEVEL, pitch: 0.1 }, SCENE))[0] > north + 0.1);
  assert.ok(middle(footprint({ ...LEVEL, roll: 0.1 }, SCENE))[1] < east - 0.1);
});

test("a camera that looks to the side sees nothing endlessly far away", () => {
  for (const corner of footprint({ ...LEVEL, pitch: 1.5 }, SCENE)) assert.ok(Math.hypot(...corner) < 40);
});

test("a box is carried only while nothing but the arm touches it", () => {
  const phases = [
    { ...FREE, searching: 1 },
    { ...FREE, searching: 0 },
    { ...FREE, searching: 0, work_arm_n: 5 },
    { ...FREE, searching: 0, work_arm_n: 5, work_rest_n: 0 },
    { ...FREE, searching: 0, work_arm_n: 5, work_rest_n: 0, work_hull_n: 2 },
    { ...FREE, searching: 1, decoy_arm_n: 5, decoy_rest_n: 0 },
    { ...FREE, searching: 1, work_rest_n: 0 }, // of the first row, before a force was measured
  ].map(phaseOf);

  assert.deepEqual(phases, [
    ...["searching", "following", "following", "carrying", "following", "mistaken", "searching"],
  ]);
});

test("the way ends at the time up to which it is asked for", () => {
  const rows = [0, 1, 2, 3].map((t) => ({ t, x: 3 * t, y: 4 * t }));

  assert.deepEqual(
    [0, 1, 2.5, 9].map((t) => wayUntil(rows, t)),
    [0, 5, 10, 15],
  );
});

test("the rows of a level are all of it, and none of the next one", () => {
  const rows = [0, 1, 2, 3].map((t) => ({ t, level: t < 2 ? 5 : 1 }));

  assert.deepEqual(
    levelAround(rows, 1.9).map(({ t }) => t),
    [0, 1],
  );
  assert.deepEqual(
    levelAround(rows, 2).map(({ t }) => t),
    [2, 3],
  );
  assert.deepEqual(levelAround([], 2), []);
});

test("a map shows all places, north up and at one scale", () => {
  /** @type {[number, number][]} */
  const places = [
    [-2, 1],
    [6, 3],
  ];
  const scale = new MapScale(places, { width: 400, height: 300, origin: [-2, 1] });
  const [[x0, y0], [x1, y1]] = places.map((place) => scale.at(place));

  assert.ok(y1 < y0, "north is up");
  assert.ok(x1 > x0, "east is to the right");
  assert.ok(Math.abs((y0 - y1) / 8 - (x1 - x0) / 2) < 1e-9);
  for (const [x, y] of [
    [x0, y0],
    [x1, y1],
  ])
    assert.ok(x > 26 && x < 400 && y > 0 && y < 274);
});

test("the lines of the grid count from the origin, and are where their metres are", () => {
  const scale = new MapScale(
    [
      [9.7, -4],
      [15.7, 3],
    ],
    { width: 400, height: 400, origin: [10, -3] },
  );
  const { norths, easts } = scale.grid();

  assert.ok(norths.some(({ metres }) => metres === 0));
  assert.ok(norths.length >= 4);
  for (const { metres, px } of norths) assert.equal(px, scale.at([10 + metres, 0])[1]);
  for (const { metres, px } of easts) assert.equal(px, scale.at([0, -3 + metres])[0]);
  assert.ok([...norths, ...easts].every(({ px }) => px >= 0 && px <= 400));
});

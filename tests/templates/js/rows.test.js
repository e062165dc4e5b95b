// Whole rows of telemetry around the playhead, from windows of the series API and from the event stream.
import assert from "node:assert/strict";
import { beforeEach, test } from "node:test";
import { Rows, rowColumns, WINDOW_ROWS } from "../../../templates/static/js/player/rows.js";
import { TRACK_COLUMNS } from "../../../templates/static/js/player/search_track.js";

const END_S = 45;
/** @type {URLSearchParams[]} */
let requests = [];

// The API: a row each 0.05 s up to END_S, at most WINDOW_ROWS of a range; the level changes at 30 s.
beforeEach((context) => {
  requests = [];
  /** @param {string} address */
  const answer = async (address) => {
    const query = new URL(address, "http://service").searchParams;
    requests.push(query);
    const [start, stop] = [Number(query.get("start")), Math.min(Number(query.get("stop")), END_S)];
    const step = Math.max(0.05, (Number(query.get("stop")) - start) / (WINDOW_ROWS - 1));
    const t = Array.from(
      { length: Math.max(Math.floor((stop - start) / step + 1e-6) + 1, 0) },
      (_, i) => start + i * step,
    );
    const columns = { x: t.map((time) => 2 * time), y: t, z: t, level: t.map((time) => Number(time >= 30)) };
    return Response.json({ t, columns });
  };
  if ("mock" in context) context.mock.method(globalThis, "fetch", answer);
});

const COLUMNS = ["x", "y", "z", "level"];
const PAUSED = { trial: 0, t: 5, speed: 1, playing: false, following: false, newest: END_S };

/** @param {Rows} rows */
async function arrived(rows) {
  while (rows.pending.size) await new Promise((done) => setTimeout(done));
}

test("columns are those that the player shows, of those that the run has", () => {
  const columns = ["t", "x", "thrust_3", "unknown", "tracker_ok"].map((name) => ({ name }));

  assert.deepEqual(rowColumns(columns), ["x", "thrust_3", "tracker_ok"]);
});

test("where the workpiece has to be found, all columns of the map of the search are read", () => {
  const names = [...TRACK_COLUMNS, "found_x0", "decoy_u", "decoy_yaw", "workpiece_u"];
  const read = rowColumns(names.map((name) => ({ name })));

  assert.deepEqual(new Set(read), new Set([...TRACK_COLUMNS, "decoy_yaw"]));
});

test("of a dock, its seat and the search for it are read, and no map", () => {
  const shown = ["dock_ahead", "dock_side", "dock_below", "searching"];
  const columns = ["dock_x", ...shown, "dock_depth", "found_x0", "found_confidence"];

  assert.deepEqual(rowColumns(columns.map((name) => ({ name }))), shown);
});

test("of a workpiece, those columns are read that move it and its arrow", () => {
  const shown = ["workpiece_z", "workpiece_yaw", "workpiece_joint", "tool_x", "work_arm_n", "work_fx"];
  const columns = [...shown, "workpiece_u", "workpiece_joint_speed", "tool_yaw", "work_rest_n"];

  assert.deepEqual(rowColumns(columns.map((name) => ({ name }))), shown);
});

test("the row at the playhead arrives once, with where the time lies before the next", async () => {
  const rows = new Rows("/api", COLUMNS);
  rows.want(PAUSED);
  await arrived(rows);
  rows.want(PAUSED);

  const found = rows.at(0, 5.01);

  assert.equal(requests.length, 1);
  assert.deepEqual([requests[0].get("start"), requests[0].get("stop")], ["0", "20"]);
  assert.ok(found);
  assert.ok(Math.abs(found.row.t - 5) < 1e-6 && Math.abs(found.share - 0.2) < 1e-6);
  assert.equal(found.row.x, 2 * found.row.t);
  assert.equal(rows.at(1, 5), null);
});

test("what plays fast is read in longer windows, and the next one before it is reached", async () => {
  const rows = new Rows("/api", COLUMNS);

  rows.want({ ...PAUSED, t: 19, speed: 2, playing: true });
  await arrived(rows);

  const ranges = requests.map((query) => `${query.get("start")}-${query.get("stop")}`);
  assert.deepEqual(ranges.sort(), ["0-40", "40-80"]);
});

test("a live run that is followed asks for nothing and shows the newest rows that came", () => {
  const rows = new Rows("/api", COLUMNS);

  rows.want({ ...PAUSED, following: true });
  rows.append(0, ["t", ...COLUMNS], [[1, 10, 0, 0, 0], [2, 20, 0, 0, 0], [2, 99, 0, 0, 0]]); // biome-ignore format: a table

  assert.equal(requests.length, 0);
  assert.equal(rows.at(0, 2)?.row.x, 20);
  assert.equal(rows.at(0, 0.5), null);
  rows.append(1, ["t", ...COLUMNS], [[0, 1, 0, 0, 0]]);
  assert.equal(rows.at(0, 2), null);
});

test("nothing is interpolated from level to level, and the way so far is that of one level", async () => {
  const rows = new Rows("/api", COLUMNS);
  rows.want({ ...PAUSED, t: 31 });
  await arrived(rows);

  const found = rows.at(0, 29.97);
  const way = rows.before(0, 31, 20);

  assert.equal(found?.next, found?.row);
  assert.equal(found?.share, 0);
  assert.ok(Math.abs(way[0].t - 30) < 1e-6);
  assert.ok(Math.abs(way[way.length - 1].t - 31) < 1e-6);
});

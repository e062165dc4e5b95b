// How numbers are written.
import assert from "node:assert/strict";
import { test } from "node:test";
import { clockText, current, heading, number, short } from "../../../templates/static/js/player/formatting.js";

test("values of charts have three digits and a minus sign", () => {
  assert.deepEqual([null, undefined, 0.12345, -12.345, 123.45].map(short), ["–", "–", "0.123", "−12.3", "123"]);
});

test("the clock shows minutes from the first one on", () => {
  assert.deepEqual([0, 59.99, 60, 605.25].map(clockText), ["0.00 s", "59.99 s", "1:00.0 min", "10:05.3 min"]);
});

test("what is not known is a dash", () => {
  assert.deepEqual([number(Number.NaN, 1, "m"), number(undefined, 1, "m"), heading(null)], ["–", "–", "–"]);
  assert.equal(number(-1.25, 1, "m"), "−1.3 m");
  assert.equal(current(undefined, 1), "–");
});

test("headings and currents are compass courses", () => {
  assert.deepEqual([0, -Math.PI / 2, 5 * Math.PI].map(heading), ["0.0 °", "270.0 °", "180.0 °"]);
  assert.equal(current(0, -0.4), "0.40 m/s to 270°");
  assert.equal(current(0.001, 0.001), "none");
});

test("a time just before a full minute is rounded up to it", () => {
  assert.equal(clockText(719.95), "12:00.0 min");
});

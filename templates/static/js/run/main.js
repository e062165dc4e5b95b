// The run page: server-sent events while the run is live, its files afterwards. Names and logs are
// inserted as text only, never as markup.
/** @import { PlayerData, RunState } from "../server_data.d.ts" */
import { all, dataOf, maybe, need } from "../dom.js";
import { Player } from "../player/player.js";
import { Curve } from "./curve.js";
import { about, duration, Estimate } from "./estimate.js";
import { listen, RowFeed } from "./live.js";
import { RecognitionPart } from "./recognition.js";

/** @type {PlayerData} */
const data = dataOf("run-data");
/** @type {(name: string) => HTMLElement | null} */
const element = (name) => maybe(document, `[data-${name}]`, HTMLElement);
const player = new Player(need(document, "[data-player]", HTMLElement), data);
const feed = new RowFeed(player);
const curves = all(document, "[data-curve-plot]", HTMLElement).map((box) => new Curve(box));
const recognitionBox = element("recognition");
const recognition = recognitionBox && new RecognitionPart(recognitionBox, data, player);
let refreshing = 0;
let estimate = newEstimate();
let logHasGap = false; // a program that prints a lot is not shown completely while it runs

function newEstimate() {
  return new Estimate(Number.parseFloat(element("progress")?.dataset.left ?? ""));
}

/**
 * @param {string} name
 * @param {string} text
 */
function writeText(name, text) {
  need(document, `[data-${name}]`, HTMLElement).textContent = text;
}

/**
 * A state event only says that the run waits; a state read from the database also says how long and why.
 * @param {RunState} state
 */
function showQueue({ position, estimate_s: remaining, why_waiting: why }) {
  if (!position) return;
  const ordinal = position === 1 ? "next" : `number ${position}`;
  const expected = typeof remaining === "number" ? ` It should end in about ${about(remaining)}.` : "";
  writeText("state-sentence", `This run is ${ordinal} in the queue.${expected} ${why ?? ""}`.trim());
}

/** @param {RunState} state */
function showState(state) {
  if (state.viewers) player.camera.viewers = state.viewers;
  const badge = element("state-badge")?.firstElementChild;
  if (badge && !badge.classList.contains(state.state)) {
    refresh(); // the server renders the new state: the reason of a failure, the actions
    return;
  }
  if (badge && state.state === "queued") showQueue(state);
  if (typeof state.progress === "number") showProgress(state.progress, state.t_simulated);
}

/**
 * Both state events (every few seconds) and telemetry (several times a second) move the bar.
 * @param {number} progress
 * @param {number | undefined} simulated
 */
function showProgress(progress, simulated) {
  const bar = maybe(document, "[data-progress]", HTMLProgressElement);
  if (!bar || progress <= bar.value) return;
  bar.value = progress;
  writeText("progress-text", `${Math.round(progress * 100)} %`);
  if (typeof simulated === "number") writeText("simulated", duration(simulated));
  const remaining = estimate.update(progress, performance.now() / 1000);
  if (remaining > 1) writeText("state-sentence", `Running, about ${about(remaining)} left.`);
}

/**
 * @param {string[]} columns
 * @param {number[]} row
 */
function showTelemetryProgress(columns, row) {
  const simulated = row[columns.indexOf("trial")] * data.trial_s + row[columns.indexOf("t")];
  showProgress(simulated / (data.trials * data.trial_s), simulated);
}

/** @param {string} text */
function appendLog(text) {
  const log = element("log");
  if (!log || !text) return;
  const atEnd = log.scrollTop + log.clientHeight >= log.scrollHeight - 20;
  log.append(text);
  if (log.textContent.length > 200000) log.textContent = log.textContent.slice(-150000);
  if (atEnd) log.scrollTop = log.scrollHeight;
  need(document, "[data-log-empty]", HTMLElement).hidden = true;
}

function showEndOfLog() {
  for (const log of all(document, ".log", HTMLElement)) log.scrollTop = log.scrollHeight;
}

/**
 * Replaces the parts rendered by the server (`data-part`) with those of a fresh copy of this page: all,
 * or only those whose names begin with `only`.
 * @param {string | null} [only]
 */
async function refresh(only = null) {
  const sequence = only ? refreshing : ++refreshing;
  const response = await fetch(location.pathname, { credentials: "same-origin" });
  if (!response.ok || sequence !== refreshing) return;
  const fresh = new DOMParser().parseFromString(await response.text(), "text/html");
  for (const old of all(document, only ? `[data-part^="${only}"]` : "[data-part]", HTMLElement)) {
    const next = fresh.querySelector(`[data-part="${old.dataset.part}"]`);
    if (next) old.replaceChildren(...next.childNodes);
  }
  player.layout.unfold();
  document.title = fresh.title;
  if (!only) estimate = newEstimate();
  showEndOfLog();
  for (const curve of curves) curve.update();
}

// The chart over levels is updated after each level, at most every two seconds; less often when many
// watch, since the server renders it for each.
const CURVE_INTERVAL_MS = 2000;
const CURVE_VIEWER_INTERVAL_MS = 100;
/** @type {number | null} */
let level = null;
let curveScheduled = false;

/** @param {number} newest */
function followLevel(newest) {
  if (newest === level || !element("curve-plot")) return;
  const first = level === null;
  level = newest;
  if (first || curveScheduled) return;
  curveScheduled = true;
  setTimeout(
    () => {
      curveScheduled = false;
      if (data.live) refresh("curve-");
    },
    Math.max(CURVE_INTERVAL_MS, CURVE_VIEWER_INTERVAL_MS * player.camera.viewers),
  );
}

function follow() {
  listen(data, {
    state: showState,
    attempt: () => player.clear(),
    rows: (columns, rows) => {
      const newest = rows[rows.length - 1];
      showTelemetryProgress(columns, newest);
      followLevel(Math.floor(newest[columns.indexOf("t")] / data.level_s));
      feed.rows(columns, rows);
    },
    log: ({ text, gap }) => {
      logHasGap ||= gap;
      appendLog(gap ? `\n[...]\n${text}` : text);
    },
    end: async () => {
      data.live = false;
      await refresh();
      await player.ended();
      recognition?.load();
      if (logHasGap) await loadLog();
    },
  });
}

async function loadLog() {
  const response = await fetch(`${data.api}/log`, { credentials: "same-origin" });
  if (!response.ok) return;
  const log = element("log");
  if (!log) return; // of a failed run the page shows only the last lines, beside the cause
  log.textContent = "";
  appendLog(await response.text());
}

showEndOfLog();
await player.start();
if (data.live) follow();

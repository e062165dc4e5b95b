// The run page: server-sent events while the run is live, its files afterwards. Names and logs are
// inserted as text only, never as markup.
import { Player } from "../player/player.js";
import { Curve } from "./curve.js";
import { about, duration, Estimate } from "./estimate.js";
import { listen, RowFeed } from "./live.js";

const data = JSON.parse(document.getElementById("run-data").textContent);
const part = (name) => document.querySelector(`[data-${name}]`);
const player = new Player(document.querySelector("[data-player]"), data);
const feed = new RowFeed(player);
const curves = [...document.querySelectorAll("[data-curve-plot]")].map((box) => new Curve(box));
let refreshing = 0;
let estimate = newEstimate();

function newEstimate() {
  return new Estimate(Number.parseFloat(part("progress")?.dataset.left));
}

// A state that was published knows only that the run waits; one that was read says also how long and why.
function showQueue({ position, estimate_s: left, why_waiting: why }) {
  if (!position) return;
  const place = position === 1 ? "next" : `number ${position}`;
  const expected = typeof left === "number" ? ` It should end in about ${about(left)}.` : "";
  part("state-sentence").textContent = `This run is ${place} in the queue.${expected} ${why ?? ""}`.trim();
}

function showState(state) {
  if (state.viewers) player.camera.viewers = state.viewers;
  const badge = part("state-badge")?.firstElementChild;
  if (badge && !badge.classList.contains(state.state)) {
    refresh(); // the server renders the new state: the reason of a failure, the actions
    return;
  }
  if (badge && state.state === "queued") showQueue(state);
  if (typeof state.progress === "number") showProgress(state.progress, state.t_simulated);
}

// Both state events (every few seconds) and telemetry (several times a second) move the bar.
function showProgress(progress, simulated) {
  const bar = part("progress");
  if (!bar || progress <= bar.value) return;
  bar.value = progress;
  part("progress-text").textContent = `${Math.round(progress * 100)} %`;
  if (typeof simulated === "number") part("simulated").textContent = duration(simulated);
  const left = estimate.update(progress, performance.now() / 1000);
  if (left > 1) part("state-sentence").textContent = `Running, about ${about(left)} left.`;
}

function showTelemetryProgress(columns, row) {
  const at = row[columns.indexOf("trial")] * data.trial_s + row[columns.indexOf("t")];
  showProgress(at / (data.trials * data.trial_s), at);
}

function appendLog(text) {
  const log = part("log");
  if (!log || !text) return;
  const atEnd = log.scrollTop + log.clientHeight >= log.scrollHeight - 20;
  log.append(text);
  if (log.textContent.length > 200000) log.textContent = log.textContent.slice(-150000);
  if (atEnd) log.scrollTop = log.scrollHeight;
  part("log-empty").hidden = true;
}

function showEndOfLog() {
  for (const log of document.querySelectorAll(".log")) log.scrollTop = log.scrollHeight;
}

// Replaces the parts rendered by the server with those of a fresh copy of this page: all, or those
// whose names begin alike.
async function refresh(only = null) {
  const sequence = only ? refreshing : ++refreshing;
  const response = await fetch(location.pathname, { credentials: "same-origin" });
  if (!response.ok || sequence !== refreshing) return;
  const fresh = new DOMParser().parseFromString(await response.text(), "text/html");
  for (const old of document.querySelectorAll(only ? `[data-part^="${only}"]` : "[data-part]")) {
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
let level = null;
let curveScheduled = false;

function followLevel(newest) {
  if (newest === level || !part("curve-plot")) return;
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
      if (logHasGap) await loadLog();
    },
  });
}

// A program that prints a lot is not shown completely while it runs.
let logHasGap = false;

async function loadLog() {
  const response = await fetch(`${data.api}/log`, { credentials: "same-origin" });
  if (!response.ok) return;
  if (!part("log")) return; // it failed: the page shows the last lines beside the cause
  part("log").textContent = "";
  appendLog(await response.text());
}

showEndOfLog();
await player.start();
if (data.live) follow();

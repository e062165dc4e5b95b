// The run page: server-sent events while the run is live, its files afterwards. Names and logs are
// only ever put into text, never into markup.
import { Camera } from "./camera.js";
import { Charts } from "./charts.js";
import { Curve } from "./curve.js";

const data = JSON.parse(document.getElementById("run-data").textContent);
const part = (name) => document.querySelector(`[data-${name}]`);
const charts = new Charts(data);
const camera = new Camera(data, (t) => charts.mark(t));
const curve = new Curve();
let trial = 0;
let refreshing = 0;

const COLUMNS_MAX = 16; // columns of one answer of series.json
let begun = null; // progress when this page first saw some, for the time left

function waiting(position) {
  return position ? `Place ${position} in the queue.` : "Waiting in the queue.";
}

function duration(seconds) {
  if (seconds < 60) return `${seconds.toFixed(seconds < 10 ? 1 : 0)} s`;
  return `${Math.floor(seconds / 60)} min ${Math.round(seconds % 60)} s`;
}

function showState(state) {
  const badge = part("state-badge")?.firstElementChild;
  if (badge && !badge.classList.contains(state.state)) {
    refresh(); // the server's own words: why it waits, what failed, which buttons make sense
    return;
  }
  if (badge && state.state === "queued") part("state-sentence").textContent = waiting(state.position);
  if (typeof state.progress === "number") showProgress(state.progress, state.t_simulated);
}

// State events come every few seconds, telemetry several times a second: the bar follows both.
function showProgress(progress, simulated) {
  const bar = part("progress");
  if (!bar || progress <= bar.value) return;
  bar.value = progress;
  part("progress-text").textContent = `${Math.round(progress * 100)} %`;
  if (typeof simulated === "number") part("simulated").textContent = duration(simulated);
  const now = performance.now() / 1000;
  begun ??= { at: now, progress };
  const rate = (progress - begun.progress) / Math.max(now - begun.at, 1e-3);
  if (now - begun.at > 2 && rate > 0) {
    const left = duration((1 - progress) / rate);
    part("state-sentence").textContent = `The experiment is running, about ${left} left.`;
  }
}

function progressOf(columns, row) {
  const at = row[columns.indexOf("trial")] * data.trial_s + row[columns.indexOf("t")];
  showProgress(at / (data.trials * data.trial_s), at);
}

function addLog(text) {
  const log = part("log");
  if (!log || !text) return;
  const atEnd = log.scrollTop + log.clientHeight >= log.scrollHeight - 20;
  log.append(text);
  if (log.textContent.length > 200000) log.textContent = log.textContent.slice(-150000);
  if (atEnd) log.scrollTop = log.scrollHeight;
  part("log-empty").hidden = true;
}

// Takes parts that the server renders from a fresh copy of this page: all, or the one named.
async function refresh(only = null) {
  const turn = only ? refreshing : ++refreshing;
  const answer = await fetch(location.pathname, { credentials: "same-origin" });
  if (!answer.ok || turn !== refreshing) return;
  const fresh = new DOMParser().parseFromString(await answer.text(), "text/html");
  for (const old of document.querySelectorAll(only ? `[data-part="${only}"]` : "[data-part]")) {
    const next = fresh.querySelector(`[data-part="${old.dataset.part}"]`);
    if (next) old.replaceChildren(...next.childNodes);
  }
  document.title = fresh.title;
  curve.update();
}

// When a level is over the chart over the levels grows; not more often than every two seconds.
const CURVE_PAUSE_MS = 2000;
let level = null;
let curveWaits = false;

function followLevel(newest) {
  if (newest === level || !part("curve-plot")) return;
  const first = level === null;
  level = newest;
  if (first || curveWaits) return;
  curveWaits = true;
  setTimeout(() => {
    curveWaits = false;
    if (data.live) refresh("curve");
  }, CURVE_PAUSE_MS);
}

async function loadSeries() {
  const columns = charts.columns();
  const answers = [];
  for (let at = 0; at < columns.length; at += COLUMNS_MAX) {
    const names = columns.slice(at, at + COLUMNS_MAX).join(",");
    const address = `${data.api}/series.json?columns=${names}&max_points=4000&trial=${trial}`;
    const answer = await fetch(address, { credentials: "same-origin" });
    if (!answer.ok) return;
    answers.push(await answer.json());
  }
  if (!answers.length) return;
  const [{ t }] = answers; // the time axis depends on the rows alone: it is the same in all answers
  charts.replace(t, Object.assign({}, ...answers.map((answer) => answer.columns)));
  if (t.length) camera.available(trial, t[t.length - 1]);
}

function follow() {
  const events = new EventSource(`${data.api}/events`);
  const on = (kind, handle) => events.addEventListener(kind, (event) => handle(JSON.parse(event.data)));
  let wholeLog = part("log")?.textContent ?? "";
  on("state", showState);
  on("telemetry", (batch) => {
    const at = batch.columns.indexOf("trial");
    if (!batch.rows.length) return;
    const newest = batch.rows[batch.rows.length - 1];
    followTrial(newest[at]);
    progressOf(batch.columns, newest);
    followLevel(Math.floor(newest[batch.columns.indexOf("t")] / data.level_s));
    const rows = batch.rows.filter((row) => row[at] === trial);
    const last = charts.append(batch.columns, rows);
    if (last !== null) camera.available(trial, last);
  });
  on("log", ({ text }) => {
    // The page came with what was printed before it was opened; the stream tells that again.
    if (wholeLog.startsWith(text) && text) wholeLog = wholeLog.slice(text.length);
    else {
      wholeLog = "";
      addLog(text);
    }
  });
  on("end", async () => {
    events.close();
    data.live = false;
    camera.ended();
    await refresh();
    await loadSeries();
  });
}

// While it runs the page looks at the trial that is being made, until somebody chooses another.
let chosen = false;

function followTrial(newest) {
  if (chosen || newest === trial) return;
  trial = newest;
  const select = part("trial");
  if (select) select.value = String(trial);
  charts.clear();
}

part("trial")?.addEventListener("change", (event) => {
  chosen = true;
  trial = Number(event.target.value);
  charts.clear();
  loadSeries();
});
charts.onChoice = loadSeries;
charts.onSeek = (t) => camera.seek(t);

await loadSeries();
if (data.live) follow();
else camera.ended();

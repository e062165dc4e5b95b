// The run page: server-sent events while the run is live, its files afterwards. Names and logs are
// only ever put into text, never into markup.
import { Camera } from "./camera.js";
import { Charts } from "./charts.js";

const data = JSON.parse(document.getElementById("run-data").textContent);
const part = (name) => document.querySelector(`[data-${name}]`);
const charts = new Charts(data);
const camera = new Camera(data, (t) => charts.mark(t));
let trial = 0;
let refreshing = 0;

const SENTENCES = {
  queued: (s) => (s.position ? `Place ${s.position} in the queue.` : "Waiting in the queue."),
  running: () => "The experiment is running.",
  succeeded: () => "Finished.",
  failed: () => "Stopped.",
  cancelled: () => "Cancelled. The data so far is kept.",
};

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
  if (badge && state.state === "queued") part("state-sentence").textContent = SENTENCES.queued(state);
  const bar = part("progress");
  if (bar && typeof state.progress === "number") {
    bar.value = state.progress;
    part("progress-text").textContent = `${Math.round(state.progress * 100)} %`;
  }
  if (part("simulated") && typeof state.t_simulated === "number") {
    part("simulated").textContent = duration(state.t_simulated);
  }
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

// Takes the parts that the server renders from a fresh copy of this page.
async function refresh() {
  const turn = ++refreshing;
  const answer = await fetch(location.pathname, { credentials: "same-origin" });
  if (!answer.ok || turn !== refreshing) return;
  const fresh = new DOMParser().parseFromString(await answer.text(), "text/html");
  for (const old of document.querySelectorAll("[data-part]")) {
    const next = fresh.querySelector(`[data-part="${old.dataset.part}"]`);
    if (next) old.replaceChildren(...next.childNodes);
  }
  document.title = fresh.title;
}

async function loadSeries() {
  const columns = charts.columns().slice(0, 16).join(",");
  const address = `${data.api}/series.json?columns=${columns}&max_points=4000&trial=${trial}`;
  const answer = await fetch(address, { credentials: "same-origin" });
  if (!answer.ok) return;
  const series = await answer.json();
  charts.replace(series.t, series.columns);
  if (series.t.length) camera.available(trial, series.t[series.t.length - 1]);
}

function follow() {
  const events = new EventSource(`${data.api}/events`);
  const on = (kind, handle) => events.addEventListener(kind, (event) => handle(JSON.parse(event.data)));
  let wholeLog = part("log")?.textContent ?? "";
  on("state", showState);
  on("telemetry", (batch) => {
    const at = batch.columns.indexOf("trial");
    const rows = batch.rows.filter((row) => at < 0 || row[at] === trial);
    if (batch.rows.length && at >= 0) followTrial(batch.rows[batch.rows.length - 1][at]);
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

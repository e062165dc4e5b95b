// Runs side by side: scene, cameras and charts with one playhead. Its address always shows what is shown.
/** @import { CompareData, ComparedSeries } from "../server_data.d.ts" */
import { dataOf, maybe, need } from "../dom.js";
import { clockText } from "../player/formatting.js";
import { Playhead, SPEEDS } from "../player/playhead.js";
import { Cameras } from "./cameras.js";
import { OverlaidCharts } from "./charts.js";
import { Ghosts } from "./ghosts.js";
import { showLevelCurves } from "./level_curves.js";
import { ComparedMaps } from "./maps.js";
import { ComparedStages } from "./stages.js";

const POINTS_MAX = 1500; // of each run and chart
const ADDRESS_MS = 400; // the address is written at most this often
const LEAP_MAX_S = 0.25; // a hidden tab does not leap
/** @type {CompareData} */
const data = dataOf("compare-data");
const root = need(document, "[data-compare]", HTMLElement);
const playButton = need(root, "[data-play]", HTMLButtonElement);
const slider = need(root, "[data-time]", HTMLInputElement);
const speedSelect = need(root, "[data-speed]", HTMLSelectElement);
const trialSelect = maybe(root, "[data-trial]", HTMLSelectElement);
const levelSelect = maybe(root, "[data-level]", HTMLSelectElement);
const clock = need(root, "[data-clock]", HTMLElement);
const message = need(root, "[data-message]", HTMLElement);
const query = new URLSearchParams(location.search);
const playhead = new Playhead({ duration: data.trial_s });
/** @type {(name: string) => number | null} */
const number = (name) => (query.has(name) && Number.isFinite(Number(query.get(name))) ? Number(query.get(name)) : null);

playhead.restore({
  trial: Math.min(number("trial") ?? 0, data.trials - 1),
  t: number("t") ?? 0,
  speed: number("speed") ?? 1,
});
const charts = new OverlaidCharts(data, playhead, (query.get("columns") ?? "").split(","));
const cameras = new Cameras(data, playhead);
const ghosts = new Ghosts(root, data, playhead);
const maps = new ComparedMaps(data, playhead);
const stages = new ComparedStages(data, playhead, (index, moments) => maps.setMoments(index, moments));
const curveBox = maybe(document, "[data-level-curves]", HTMLElement);
if (curveBox)
  showLevelCurves(
    curveBox,
    data.curves,
    data.runs.map(({ id }) => id),
  );
let requested = 0;
/** @type {number | null} */
let frame = null; // the next animation frame, while playing
/** @type {number | null} */
let before = null; // time of the previous one [ms]

if (trialSelect) trialSelect.value = String(playhead.trial);
if (levelSelect && (number("level") ?? Infinity) < data.levels.length) levelSelect.value = String(number("level"));

function level() {
  return levelSelect?.value ? Number(levelSelect.value) : null;
}

async function load() {
  const sequence = ++requested;
  const columns = charts.columns().join(",") || "t"; // the times tell where each run has data
  const chosen = level() === null ? "" : `&level=${level()}`;
  const response = await fetch(
    `${data.api}&columns=${columns}&trial=${playhead.trial}${chosen}&max_points=${POINTS_MAX}`,
  );
  if (sequence !== requested) return;
  message.textContent = response.ok ? "" : "The telemetry could not be loaded. Reload the page to try again.";
  if (!response.ok) return;
  /** @type {{series: ComparedSeries[]}} */
  const { series } = await response.json();
  const lengths = series.map(({ t }) => (t.length ? t[t.length - 1] : 0));
  const longest = Math.max(...lengths);
  charts.show(series, level());
  cameras.setParts(series, playhead.trial);
  ghosts.setParts(series, playhead.trial);
  maps.setParts(series, playhead.trial);
  stages.setParts(series, playhead.trial, longest);
  slider.max = String(longest);
  slider.disabled = playButton.disabled = longest === 0;
  playhead.reaches(longest);
}

function showMode() {
  playButton.dataset.moving = String(playhead.playing);
  need(playButton, "[data-label]", HTMLElement).textContent = playhead.playing ? "Pause" : "Play";
  speedSelect.value = String(playhead.speed);
  before = null;
  if (playhead.playing && !frame) frame = requestAnimationFrame(advance);
}

function showTime() {
  slider.value = String(playhead.t);
  slider.setAttribute("aria-valuetext", clockText(playhead.t));
  clock.textContent = clockText(playhead.t);
}

/** @param {number} now */
function advance(now) {
  if (before !== null) playhead.advance(Math.min((now - before) / 1000, LEAP_MAX_S));
  before = now;
  frame = playhead.playing ? requestAnimationFrame(advance) : null;
}

/** @type {ReturnType<typeof setTimeout> | null} */
let scheduled = null;

function writeAddress() {
  if (scheduled !== null) return;
  scheduled = setTimeout(() => {
    scheduled = null;
    const chosen = new URLSearchParams();
    if (playhead.trial) chosen.set("trial", String(playhead.trial));
    if (level() !== null) chosen.set("level", String(level()));
    if (playhead.t) chosen.set("t", playhead.t.toFixed(2));
    if (playhead.speed !== 1) chosen.set("speed", String(playhead.speed));
    chosen.set("columns", charts.columns().join(","));
    const runs = data.runs.map(({ id }) => id).join(",");
    history.replaceState(null, "", `?runs=${runs}&${chosen.toString().replaceAll("%2C", ",")}`);
  }, ADDRESS_MS);
}

speedSelect.append(
  ...SPEEDS.map((speed) => new Option(`${speed}×`.replace("0.25", "¼").replace("0.5", "½"), String(speed))),
);
playButton.addEventListener("click", () => playhead.toggle());
slider.addEventListener("input", () => playhead.seek(Number(slider.value)));
speedSelect.addEventListener("change", () => playhead.setSpeed(Number(speedSelect.value)));
trialSelect?.addEventListener("change", () => {
  playhead.setTrial(Number(trialSelect.value));
  load();
});
levelSelect?.addEventListener("change", () => {
  playhead.seek(0);
  load();
});
charts.onChoice = load;
playhead.listen((_playhead, what) => {
  if (what === "mode") showMode();
  showTime();
  writeAddress();
});
await load();

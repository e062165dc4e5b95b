// The player of a run: scene, camera, numbers and charts on one time line, and the bar that moves it.
/** @import { PlayerData, Row } from "../server_data.d.ts" */
import { maybe, need } from "../dom.js";
import { Bar } from "./bar.js";
import { Camera } from "./camera.js";
import { ChartTable } from "./chart_table.js";
import { Charts } from "./charts.js";
import { FullScreen } from "./full_screen.js";
import { Layout } from "./layout.js";
import { mapIn } from "./level_map.js";
import { Marks } from "./marks.js";
import { Memory } from "./memory.js";
import { Menu } from "./menu.js";
import { Numbers } from "./numbers.js";
import { paced } from "./paced.js";
import { Playhead } from "./playhead.js";
import { Rows, rowColumns } from "./rows.js";
import { SceneBox } from "./scene_box.js";
import { StageStrip } from "./stage_strip.js";

const TABLE_MS = 250;

export class Player {
  /**
   * root: the element with the parts; data: of the page; see server/pages/run/player_data.py
   * @param {HTMLElement} root
   * @param {PlayerData} data
   */
  constructor(root, data) {
    this.root = root;
    this.data = data;
    /** @type {Row | null} at the playhead */
    this.row = null;
    this.cameraKey = "";
    this.started = false;
    this.frame = 0; // that is asked for
    /** @type {number | undefined} when the playhead was last moved [ms] */
    this.ticked = undefined;
    this.memory = new Memory(`player-${data.id}-${root.dataset.player}`);
    this.playhead = new Playhead({ duration: data.trial_s, live: data.live, loop: root.dataset.player === "loop" });
    this.rows = new Rows(data.api, rowColumns(data.columns));
    this.charts = new Charts(root, data, this.memory);
    this.camera = new Camera(root, { api: data.api, step: data.step_s });
    this.layout = new Layout(root);
    this.fullScreen = new FullScreen(root);
    const stage = data.stages.length
      ? (/** @type {Row} */ { t }) => this.charts.stageAt(t) || (data.before ?? "none yet")
      : null;
    this.numbers = new Numbers(need(root, "[data-numbers]", HTMLElement), data.columns, stage);
    this.scene = new SceneBox(need(root, "[data-scene]", HTMLElement), { api: data.api }, this.memory);
    const scene = (/** @type {number} */ trial, /** @type {number} */ level) => this.scene.sceneOf(trial, level);
    this.map = mapIn(root, "run", { api: data.api, scene });
    const strip = maybe(root, "[data-stages]", HTMLElement);
    const onSeek = (/** @type {number} */ t) => this.playhead.seek(t);
    this.marks = new Marks(need(root, "[data-marks]", HTMLElement), need(root, "[data-mark-legend]", HTMLElement), {
      api: data.api,
      duration: data.trial_s,
      level: data.level_s,
      stages:
        strip && new StageStrip(strip, { labels: data.stages, before: data.before, duration: data.trial_s, onSeek }),
    });
    this.marks.onChange = (moments) => {
      this.charts.setMoments(moments);
      this.map?.setMoments(moments);
    };
    this.table = new ChartTable(need(root, "[data-chart-table]", HTMLDetailsElement), this.charts);
    const bar = need(root, "[data-bar]", HTMLElement);
    this.menu = new Menu(bar, this, {
      name: `seamark-run-${data.id}`,
      tell: (/** @type {string} */ sentence) => this.bar.tell(sentence),
    });
    this.bar = new Bar(bar, this.playhead, {
      keys: { ...this.menu.keys, ...this.scene.keys },
      levelLength: data.level_s,
      step: data.step_s,
      levelText: (/** @type {Row} */ row) => this.levelText(row),
      moments: () => this.marks.load(this.playhead.trial),
      fullScreen: this.fullScreen,
    });
    this.write = paced(() => {
      this.bar.show(this.playhead, this.row);
      this.numbers.show(this.row);
    });
    this.writeTable = paced(() => this.table.show(), TABLE_MS);
    this.trial = maybe(root, "[data-trial]", HTMLSelectElement);
    this.trial?.addEventListener("change", () => {
      this.playhead.seek(0); // no longer the newest data
      this.setTrial(Number(this.trial?.value));
    });
    this.playhead.restore(this.memory.get("playhead", {}));
    this.charts.setTrial(this.playhead.trial);
    if (this.trial) this.trial.value = String(this.playhead.trial);
    this.charts.onSeek = (t) => this.playhead.seek(t);
    this.charts.onLoad = (t, trial) => {
      if (trial === this.playhead.trial && t > 0) this.playhead.reaches(t);
    };
    this.rows.onRows = () => this.show();
    this.playhead.listen((_playhead, what) => this.moved(what));
  }

  async start() {
    await this.charts.load();
    this.started = true;
    this.run();
  }

  // Moves the playhead with each frame while it plays: a page at rest asks for none.
  run() {
    if (!this.started || this.frame || !this.playhead.playing) return;
    this.frame = requestAnimationFrame((now) => this.tick(now));
  }

  /** @param {number} now */
  tick(now) {
    this.playhead.advance(Math.min((now - (this.ticked ?? now)) / 1000, 0.25)); // a hidden tab does not leap
    this.ticked = this.playhead.playing ? now : undefined;
    this.frame = 0;
    this.run();
  }

  /** @param {"time" | "mode"} what */
  moved(what) {
    this.memory.set("playhead", this.playhead.state());
    this.rows.want(this.playhead);
    this.marks.want(this.playhead);
    if (what === "mode") {
      this.charts.setTrial(this.playhead.trial);
      this.bar.show(this.playhead, this.row);
      this.run();
    }
    this.show();
  }

  show() {
    const { playhead } = this;
    const instant = this.rows.at(playhead.trial, playhead.t);
    this.row = instant?.row ?? null;
    this.write();
    this.charts.mark(playhead.t);
    this.map?.show(playhead, this.row);
    if (playhead.newest > 0) this.showCamera();
    if (instant)
      this.scene.show(playhead, instant, () =>
        this.rows.before(playhead.trial, playhead.t, 20 * Math.max(playhead.speed, 1)),
      );
    this.writeTable();
  }

  showCamera() {
    const { trial, t, following } = this.playhead;
    const key = `${trial}:${Math.floor(t / this.data.step_s + 1e-6)}:${this.row?.t}`;
    if (key === this.cameraKey) return;
    this.cameraKey = key;
    this.camera.show({ trial, t, following }, this.row);
  }

  /**
   * @param {Row} row
   * @returns {string}
   */
  levelText(row) {
    const { names, levels, level } = this.data;
    if (row.level === null || row.level === undefined) return "";
    return names.length
      ? `level ${row.level}: ${names[row.level]}`
      : `${level.label.toLowerCase()} ${levels[row.level]} ${level.unit}`.trimEnd();
  }

  // The moment in words and numbers, for pictures and clips.
  describe() {
    const { data, playhead, row } = this;
    return {
      numbers: this.numbers.lines(row),
      clock: this.bar.timeText(playhead.t, row),
      share: playhead.t / playhead.duration,
      title: `Seamark run ${data.id}, ${data.benchmark}`,
    };
  }

  /**
   * Rows of the trial that is shown have arrived by the event stream.
   * @param {number} trial
   * @param {string[]} columns
   * @param {number[][]} rows
   */
  append(trial, columns, rows) {
    if (trial !== this.playhead.trial || !rows.length) return;
    this.charts.append(columns, rows);
    this.rows.append(trial, columns, rows);
    this.map?.append(trial, columns, rows);
    this.playhead.available(rows[rows.length - 1][columns.indexOf("t")]);
  }

  /** @param {number} trial */
  setTrial(trial) {
    this.playhead.setTrial(trial);
    if (this.trial) this.trial.value = String(trial);
    return this.charts.load();
  }

  // What was shown is no longer part of the run: it has started again.
  clear() {
    this.rows.clear();
    this.charts.clear();
    this.marks.clear();
    this.map?.clear();
    this.playhead.newest = 0;
    this.playhead.moveTo(0);
  }

  async ended() {
    this.playhead.end();
    const { trial } = this.playhead;
    await Promise.all([this.charts.load(), this.marks.load(trial), this.map?.load(trial)]);
  }
}

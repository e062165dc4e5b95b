// The events of a live run: the one place that knows their format.
/**
 * @import { PlayerData, RunListener } from "../server_data.d.ts"
 * @import { Player } from "../player/player.js"
 */

const RETRY_MS = 5000; // after an error that the browser does not retry itself, such as a 503

/**
 * Starts with the newest trial and with the output after that of the page; after an interruption, with
 * what came since the last event.
 * @param {Pick<PlayerData, "api" | "events_after">} data
 * @param {RunListener} handle
 * @param {string} [after]
 * @param {string | null} [attempt]
 */
export function listen(data, handle, after = data.events_after, attempt = null) {
  let last = after;
  let shown = attempt;
  const events = new EventSource(`${data.api}/events?after=${after}`);
  /** @type {(type: string, use?: (data: any) => void) => void} as the server sends them: server_data.d.ts */
  const on = (type, use) =>
    events.addEventListener(type, (event) => {
      if (event.lastEventId) last = event.lastEventId;
      use?.(JSON.parse(event.data));
    });
  events.addEventListener("error", () => {
    if (events.readyState === EventSource.CLOSED) setTimeout(() => listen(data, handle, last, shown), RETRY_MS);
  });
  on("state", handle.state);
  on("log", handle.log);
  on("telemetry", (/** @type {{columns: string[], rows: number[][]}} */ { columns, rows }) => {
    if (!rows.length) return;
    const [newest] = last.split("-"); // a run whose worker died starts again
    if (shown !== null && shown !== newest) handle.attempt();
    shown = newest;
    handle.rows(columns, rows);
  });
  on("end", () => {
    events.close();
    handle.end();
  });
}

// Passes rows to the player: while it follows the run, also from trial to trial.
export class RowFeed {
  /** @param {Player} player */
  constructor(player) {
    this.player = player;
  }

  /**
   * @param {string[]} columns
   * @param {number[][]} rows
   */
  rows(columns, rows) {
    const at = columns.indexOf("trial");
    const newest = rows[rows.length - 1][at];
    const { playhead } = this.player;
    if (playhead.following && newest !== playhead.trial) this.player.setTrial(newest);
    this.player.append(
      playhead.trial,
      columns,
      rows.filter((row) => row[at] === playhead.trial),
    );
  }
}

/**
 * @param {Player} player
 * @param {PlayerData} data
 */
export function followRows(player, data) {
  const feed = new RowFeed(player);
  listen(data, {
    attempt: () => player.clear(),
    rows: (columns, rows) => feed.rows(columns, rows),
    end: () => player.ended(),
  });
}

// The events of a live run: the one place that knows their format.

const RETRY_MS = 5000; // after an error that the browser does not retry itself, such as a 503

// Starts with the newest trial and with the output after that of the page; after an interruption, with
// what came since the last event.
// data: {api, events_after}; handle: {state, log, attempt, rows, end}, all but the last two optional
export function listen(data, handle, after = data.events_after, attempt = null) {
  let last = after;
  let shown = attempt;
  const events = new EventSource(`${data.api}/events?after=${after}`);
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
  on("telemetry", ({ columns, rows }) => {
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
  constructor(player) {
    this.player = player;
  }

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

export function followRows(player, data) {
  const feed = new RowFeed(player);
  listen(data, {
    attempt: () => player.clear(),
    rows: (columns, rows) => feed.rows(columns, rows),
    end: () => player.ended(),
  });
}

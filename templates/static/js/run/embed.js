// The player of a run in a frame of another page.
/** @import { PlayerData } from "../server_data.d.ts" */
import { dataOf, need } from "../dom.js";
import { Player } from "../player/player.js";
import { followRows } from "./live.js";

/** @type {PlayerData} */
const data = dataOf("run-data");
const player = new Player(need(document, "[data-player]", HTMLElement), data);

await player.start();
if (data.live) followRows(player, data);

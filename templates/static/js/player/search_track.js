// What a search map draws, from rows of telemetry: where the camera looked, and what the vehicle did.
// Places are north and east [m]. No page is needed for it.
/**
 * @import { Row, SceneData } from "../server_data.d.ts"
 * @import { Place } from "./places.js"
 */

/** @typedef {"searching" | "following" | "carrying" | "mistaken"} Phase */

/** The columns that it takes. */
export const TRACK_COLUMNS = [
  ...["level", "x", "y", "z", "roll", "pitch", "yaw", "searching", "workpiece_x", "workpiece_y", "decoy_x", "decoy_y"],
  ...["work_arm_n", "work_hull_n", "work_rest_n", "decoy_arm_n", "decoy_hull_n", "decoy_rest_n"],
];
const CORNERS = [
  [-1, -1],
  [1, -1],
  [1, 1],
  [-1, 1],
];
const STEEPEST = 0.2; // cosine of the largest angle from the vertical at which a ray still meets the bottom nearby

/**
 * The corners of what the vehicle's camera sees of the seabed, clockwise from above.
 * @param {Row} row
 * @param {Pick<SceneData, "camera" | "seabed">} scene
 * @returns {Place[]}
 */
export function footprint(row, { camera, seabed }) {
  const turn = rotation(Number(row.roll), Number(row.pitch), Number(row.yaw));
  const [ahead, beside, below] = turn(camera.mount);
  const eye = [Number(row.x) + ahead, Number(row.y) + beside, Number(row.z) + below];
  // Image right is starboard (y), image down is aft (-x), the optical axis is down (z).
  return CORNERS.map(([u, v]) => {
    const ray = turn([(-v * camera.height) / 2 / camera.focal, (u * camera.width) / 2 / camera.focal, 1]);
    const reach = Math.max(seabed.depth - eye[2], 0) / Math.max(ray[2], STEEPEST);
    return [eye[0] + reach * ray[0], eye[1] + reach * ray[1]];
  });
}

/**
 * Turns a vector of the body into one of the world.
 * @param {number} roll
 * @param {number} pitch
 * @param {number} yaw
 * @returns {(vector: number[]) => [number, number, number]}
 */
function rotation(roll, pitch, yaw) {
  const [sr, cr, sp, cp] = [Math.sin(roll), Math.cos(roll), Math.sin(pitch), Math.cos(pitch)];
  const [sy, cy] = [Math.sin(yaw), Math.cos(yaw)];
  return ([x, y, z]) => [
    cy * cp * x + (cy * sp * sr - sy * cr) * y + (cy * sp * cr + sy * sr) * z,
    sy * cp * x + (sy * sp * sr + cy * cr) * y + (sy * sp * cr - cy * sr) * z,
    -sp * x + cp * sr * y + cp * cr * z,
  ];
}

/**
 * What the vehicle does: a box counts as carried while nothing but the arm touches it.
 * @param {Row} row
 * @returns {Phase}
 */
export function phaseOf(row) {
  /** @type {(what: string) => boolean} */
  const carries = (what) =>
    Number(row[`${what}_arm_n`]) > 0 && row[`${what}_hull_n`] === 0 && row[`${what}_rest_n`] === 0;
  if (carries("work")) return "carrying";
  if (carries("decoy")) return "mistaken";
  return row.searching === 1 ? "searching" : "following";
}

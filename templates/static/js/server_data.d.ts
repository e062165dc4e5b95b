// What the server sends to the scripts of the pages. The browser does not load this file.

/** A row of telemetry by column; null where a column has no value. `t` is the simulated time [s]. */
export type Row = Record<string, number | null> & { t: number };

/** Between two rows: the playhead is at `share` of the way from `row` to `next`. */
export interface Between {
  row: Row;
  next: Row;
  share: number;
}

export interface Column {
  name: string;
  unit: string;
  meaning: string;
}

/** A chart of the benchmark, or one that somebody has made (`own`). */
export interface Chart {
  title: string;
  unit: string;
  columns: string[];
  own?: boolean;
}

/** `run-data` of a page with a player: server/pages/run/player_data.py. */
export interface PlayerData {
  id: number;
  benchmark: string;
  live: boolean;
  trials: number;
  trial_s: number;
  level_s: number;
  levels: number[];
  ordered: boolean;
  names: string[];
  level: { label: string; unit: string };
  step_s: number;
  charts: Chart[];
  stages: string[]; // of a level, in their order; none but in interventions
  before: string | null; // what comes before the first one
  columns: Column[];
  api: string;
  events_after: string;
}

/** The run that a scene shows; ghosts have a colour of their own. */
export interface SceneSource {
  api: string;
  colour?: string;
}

/** series.json */
export interface SeriesAnswer {
  t: number[];
  columns: Record<string, (number | null)[]>;
}

/** moments.json; times in [s] */
export interface Moments {
  levels: { t: number }[];
  losses: number[];
  touches: number[];
  completed?: number[]; // ends of routes
  largest_error: { t: number } | null;
  stages?: { level: number; stage: number; t: number }[];
}

/** A moment of a detector's run. */
export interface Example {
  trial: number;
  level: number;
  t: number;
  label: string;
  corners: [number, number][];
  confidence: number | null;
  lies_on: string | null;
}

/** recognition.json */
export interface Recognition {
  recalls: number[];
  levels: { value: number; precision: number[]; time_ms: { median: number; longest: number } }[];
  labels: string[];
  classes: string[];
  lies_on: string[];
  confusion: number[][];
  objects: number[];
  missed: number[];
  examples: { false_alarms: Example[]; misses: Example[]; hits: Example[] };
  images: number;
  recorded: number;
}

export type Triple = [number, number, number];

export interface Solid {
  shape: "box" | "cylinder" | "capsule" | "sphere";
  size: Triple;
  centre: Triple;
  colour: string;
  livery: boolean;
  lettered?: boolean; // on its upper side
}

export interface Placed {
  place: Triple;
  turn: Triple; // [rad] roll, pitch, yaw
}

export interface ArmLink extends Placed {
  parent: number | null;
  joint: { kind: "revolute" | "prismatic"; axis: Triple; column: number; ratio: number } | null;
  solids: Solid[];
  touch: number[];
}

export interface ArmShape extends Placed {
  links: ArmLink[];
  force_sensor: ({ link: number } & Placed) | null;
}

/** `free`: the columns of the workpiece, or of the decoy, are its place in the world. */
export type WorkJoint =
  | { kind: "free"; of?: "decoy" }
  | { kind: "revolute" | "prismatic"; axis: Triple; ratio: number };

export interface WorkLink extends Placed {
  parent: number | null;
  joint: WorkJoint | null;
  solids: Solid[];
}

/** What an arm works on; `face`: what trackers follow, [thing, link], null in the world. */
export interface WorkShape {
  things: ({ links: WorkLink[] } & Placed)[];
  face: { link: [number, number] | null; corners: Triple[] };
}

export interface VehicleShape {
  hull: { centre: Triple; size: Triple }[];
  solids: Solid[];
  thrusters: { position: Triple; direction: Triple }[];
  thrust_max: number;
  nozzle_radius: number;
  arm: ArmShape | null;
}

export interface TargetShape {
  centre: Triple;
  size: Triple;
  heading: number;
  path?: TargetPath; // of one that moves by itself
}

export interface TargetPath {
  start: number; // [s] of the first image of the level
  period: number; // [s] from one image to the next
  places: Triple[]; // north, east [m] and heading [rad] in each
}

export interface Optics {
  mount: Triple;
  focal: number;
  width: number;
  height: number;
}

export interface WaterData {
  law: "beer" | "uwsim";
  attenuation: Triple;
  veil: Triple;
}

export interface LightData {
  level: number;
  lamp: number;
  cone: number;
  forward: number;
}

/** Where a vehicle begins to search and what it is told, north and east; `error`, `mark`: radii of circles. */
export interface SearchData {
  start: [number, number];
  told: [number, number];
  error: number;
  mark: number;
}

/** A pipe on the seabed: its axis, north and east, and from and to which lengths of it sand covers it. */
export interface PipeData {
  axis: [number, number][];
  seabed: number;
  radius: number;
  covered: [number, number][];
}

/** A route to follow, north, east, down: the boat with the transceiver, how far off the told start is and may be. */
export interface RouteData {
  points: Triple[];
  boat: Triple;
  told_error: [number, number];
  error: number;
  pipe?: PipeData; // that has to be seen
}

/** scene.json: north, east, down; [m], [rad] */
export interface SceneData {
  vehicle: VehicleShape | null;
  target: TargetShape | null; // null above a bottom on which many things lie
  workpiece?: WorkShape; // instead of the target
  search?: SearchData; // of a workpiece that has to be found first
  route?: RouteData; // that the vehicle follows
  seabed: { depth: number; tile: number; painted?: boolean }; // painted: another one in each level
  camera: Optics;
  water: WaterData;
  light: LightData;
}

/** A state event of a run. */
export interface RunState {
  state: string;
  viewers?: number;
  position?: number;
  estimate_s?: number | null;
  why_waiting?: string | null;
  progress?: number;
  t_simulated?: number;
}

/** What listens to the event stream of a run. */
export interface RunListener {
  state?: (state: RunState) => void;
  log?: (log: { text: string; gap: boolean }) => void;
  attempt: () => void;
  rows: (columns: string[], rows: number[][]) => void;
  end: () => void;
}

/** The chart of metrics over levels. */
export interface CurveData {
  lines: { label: string; values: number[] }[];
  x: number[];
  x_label: string;
  unit: string;
  range: [number, number];
  limit: number;
  mark: number | null;
  mark_label: string;
}

/** A chart of runs side by side: one column. */
export interface ComparedChart {
  column: string;
  title: string;
  unit: string;
}

/** A chart of one metric over the levels; the lines are in the order of the runs. */
export interface ComparedCurve {
  title: string;
  unit: string;
  x_label: string;
  limit: number;
  lines: { x: number[]; values: number[] }[];
}

/** `compare-data` of the page that compares runs. */
export interface CompareData {
  api: string;
  runs: { id: number; api: string; columns: { name: string }[]; stages: string[]; before: string | null }[];
  trial_s: number;
  trials: number;
  levels: string[];
  level_s: number;
  charts: ComparedChart[];
  curves: ComparedCurve[];
  columns_max: number;
}

/** The series of a run beside others; `start_s` is null where it has no telemetry. */
export interface ComparedSeries extends SeriesAnswer {
  run: number;
  start_s: number | null;
}

/** A problem that a check has found in a program. */
export interface Problem {
  file?: string | null;
  line: number | null;
  sentence: string;
  warning: boolean;
}

/** A check of a program: /api/v1/checks */
export interface Check {
  id: string;
  state: string;
  ok: boolean;
  program_name: string;
  problems: Problem[];
  step_us: { count: number } | null;
  images?: string[]; // addresses; of a detector
  usage: { cpu_s: number; memory_mib: number } | null;
  traceback: string | null;
  output: string | null;
}

/** A parameter that a program declares. */
export interface Parameter {
  name: string;
  type: string;
  default: number | boolean;
  low: number | null;
  high: number | null;
  unit: string | null;
  description: string | null;
}

export type SettingValue = string | number | boolean | (string | number)[];

/** A preset of the form: settings, and a built-in controller or tracker. */
export interface StartingPoint {
  title: string;
  summary: string;
  built_in: string | null;
  config: Record<string, SettingValue>;
}

/** The form of a run, with its controls by name; groups of radio buttons have a value, too. */
export interface VehicleReport {
  name: string;
  title: string;
  errors: string[];
  warnings: string[];
  figures: string[];
  defaults: Record<string, SettingValue>;
}

export type RunForm = HTMLFormElement & {
  elements: HTMLFormControlsCollection &
    Record<string, HTMLInputElement> & { language: HTMLSelectElement; program_text: HTMLTextAreaElement };
};

// With the generated client: has a program read, which is a multipart form; reads a refusal; submits
// a run, follows it to its end and reads its telemetry. Prints a line for each.
import { client } from "./generated/client.gen";
import { checksCreate, filesTelemetryF64, runsCreate, runsShow } from "./generated/sdk.gen";
import type { Problem, RunResponse } from "./generated/types.gen";

const PROGRAM = `class Controller:
    def __init__(self, config):
        self.kp = config["kp"]

    def reset(self, level):
        pass

    def step(self, observation):
        return [self.kp * observation.error[0], self.kp * observation.error[1], 0.0, 0.0]
`;
const CONFIG = { levels: [0.1], level_duration_s: 5, settle_s: 1 };
const FINAL: ReadonlySet<RunResponse["state"]> = new Set(["succeeded", "failed", "cancelled"]);

async function main(): Promise<void> {
  const [address, token] = process.argv.slice(2);
  if (address === undefined || token === undefined) throw new Error("usage: follow_run ADDRESS TOKEN");
  client.setConfig({ baseUrl: address, auth: token });
  await checkProgram();
  await readRefusal();
  await followRun();
}

async function followRun(): Promise<void> {
  const submitted = await runsCreate({
    body: { benchmark: "currents-v1", controller: "pi", config: CONFIG, seed: 7 },
    headers: { "Idempotency-Key": crypto.randomUUID() },
    throwOnError: true,
  });
  let run: RunResponse = submitted.data;
  let retryAfterS = Number(submitted.response.headers.get("Retry-After"));
  while (!FINAL.has(run.state)) {
    await pause(retryAfterS);
    const answer = await runsShow({ path: { run_id: run.id }, throwOnError: true });
    run = answer.data;
    retryAfterS = Number(answer.response.headers.get("Retry-After"));
  }
  if (run.state !== "succeeded") throw new Error(`run ${run.id}: ${run.cause}`);
  const telemetry = await filesTelemetryF64({ path: { run_id: run.id }, throwOnError: true });
  const columns = telemetry.response.headers.get("X-Columns")?.split(",") ?? [];
  const bytes: Blob | File = telemetry.data;
  const rows = new Float64Array(await bytes.arrayBuffer()).length / columns.length;
  console.log(`run ${run.id} ${run.state}, score ${run.result?.["score"]}, ${rows} rows of telemetry`);
}

async function checkProgram(): Promise<void> {
  const program = new File([PROGRAM], "controller.py");
  const run = { benchmark: "currents-v1", config: CONFIG };
  const { data: check } = await checksCreate({
    body: { run, program },
    query: { run: false },
    throwOnError: true,
  });
  console.log(`program in ${check.language}: ${check.problems.length} problems`);
}

async function readRefusal(): Promise<void> {
  const { error, response } = await runsShow({ path: { run_id: 999999 } });
  const problem: Problem | undefined = error;
  console.log(`refused ${response?.status}: ${problem?.detail}`);
}

function pause(seconds: number): Promise<void> {
  return new Promise((resume) => setTimeout(resume, 1000 * seconds));
}

void main();

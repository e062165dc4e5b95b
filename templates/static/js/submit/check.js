// The check button: sends the program to /api/v1/checks and shows the report below the editor.
/**
 * @import { Check, Problem, RunForm } from "../server_data.d.ts"
 * @import { MountedEditor } from "./editor.js"
 */
import { maybe, need } from "../dom.js";

const URL_CHECKS = "/api/v1/checks";
const TIMEOUT_MS = 90_000;

/**
 * @template {keyof HTMLElementTagNameMap} K
 * @param {K} tag
 * @param {string} [className]
 * @param {string} [text]
 * @returns {HTMLElementTagNameMap[K]}
 */
export function element(tag, className, text) {
  const created = document.createElement(tag);
  if (className) created.className = className;
  if (text) created.textContent = text;
  return created;
}

/** @param {number} ms */
function sleep(ms) {
  return new Promise((resolve) => {
    setTimeout(resolve, ms);
  });
}

/**
 * Returns the chosen file, or the text of the editor as a file.
 * @param {RunForm} form
 * @returns {File | undefined}
 */
export function programFile(form) {
  if (form.elements.source.value !== "editor") return form.elements.program.files?.[0];
  const language = form.elements.language.value;
  const template = need(form, `[data-program-template="${CSS.escape(language)}"]`, HTMLTemplateElement);
  return new File([form.elements.program_text.value], template.dataset.file ?? "");
}

/**
 * Returns the document of an answer; raises what a problem says.
 * @param {Response} response
 */
export async function readJson(response) {
  const body = await response.json();
  if (response.ok) return body;
  const details = [body.detail, ...(body.errors ?? []).map((/** @type {{detail: string}} */ error) => error.detail)];
  throw new Error([...new Set(details.filter(Boolean))].join(" "));
}

/**
 * @param {RunForm} form
 * @param {string} benchmark
 * @param {Record<string, unknown>} config
 * @param {File} program
 */
async function requestCheck(form, benchmark, config, program) {
  const body = new FormData();
  body.set("run", JSON.stringify({ benchmark, config }));
  body.set("program", program);
  const headers = { "X-CSRFToken": form.elements.csrf_token.value, Accept: "application/json" };
  const vehicle = form.elements.vehicle_file?.files?.[0];
  if (vehicle) body.set("vehicle", vehicle);
  /** @type {Check} */
  let check = await readJson(await fetch(URL_CHECKS, { method: "POST", body, headers }));
  const deadline = Date.now() + TIMEOUT_MS;
  while (check.state !== "done") {
    if (Date.now() > deadline)
      throw new Error(
        "No worker is available for the check. Try again later, or start the run, which waits in the queue.",
      );
    await sleep(1000);
    check = await readJson(await fetch(`${URL_CHECKS}/${check.id}`, { headers }));
  }
  return check;
}

/**
 * @param {Problem} problem
 * @param {MountedEditor | null} editor
 */
function problemItem(problem, editor) {
  const item = element("li");
  const location = [problem.file, problem.line && `line ${problem.line}`].filter(Boolean).join(", ");
  const { line } = problem;
  if (location && editor && line) {
    const button = element("button", "check-line", location);
    button.type = "button";
    button.addEventListener("click", () => editor.goTo(line));
    item.append(button, " ");
  } else if (location) item.append(element("strong", "", location), " ");
  item.append((problem.warning ? "Warning: " : "") + problem.sentence);
  return item;
}

/**
 * @param {string} title
 * @param {string} text
 */
function details(title, text) {
  const created = element("details");
  const output = element("pre", "", text);
  output.tabIndex = 0;
  created.append(element("summary", "", title), output);
  return created;
}

/** @param {string[]} addresses of images with what the program answered */
function pictures(addresses) {
  const figure = element("figure", "check-images");
  const row = element("div");
  row.append(
    ...addresses.map((address, index) => {
      const image = element("img");
      image.alt = `Image ${index + 1} with the answers of the program`;
      image.src = address;
      return image;
    }),
  );
  const caption = element("figcaption", "small muted");
  caption.textContent =
    "What the program answered to the first images: hits green, false alarms red, " +
    "ignored answers grey, missed objects amber.";
  figure.append(row, caption);
  return figure;
}

/** @param {Check} check */
function verdict(check) {
  if (!check.ok) return "The program does not run:";
  const steps = check.step_us;
  const used = check.usage;
  const time =
    steps && used
      ? `${steps.count} steps, ${used.cpu_s.toFixed(2)} s of CPU time, ${used.memory_mib.toFixed(0)} MiB of memory. `
      : "";
  return `The program runs. ${time}${check.problems.length ? "Warnings:" : ""}`;
}

/**
 * @param {HTMLElement} container
 * @param {Check} check
 * @param {MountedEditor | null} editor
 */
function showReport(container, check, editor) {
  const type = check.ok ? (check.problems.length ? "warn" : "good") : "bad";
  const box = element("div", `notice ${type}`);
  const inner = element("div");
  inner.append(element("p", "check-verdict", `${check.program_name}: ${verdict(check)}`));
  if (check.problems.length) {
    const list = element("ul");
    list.append(...check.problems.map((problem) => problemItem(problem, editor)));
    inner.append(list);
  }
  if (check.traceback) inner.append(details("Traceback", check.traceback));
  if (check.output) inner.append(details("Output", check.output));
  if (check.images?.length) inner.append(pictures(check.images));
  box.append(inner);
  container.replaceChildren(box);
}

/**
 * @param {RunForm} form
 * @param {{configuration: () => Record<string, unknown>}} settings
 * @param {() => Promise<MountedEditor | null>} openEditor
 */
export function startCheck(form, settings, openEditor) {
  const bar = maybe(form, "[data-check-bar]", HTMLElement);
  if (!bar) return;
  const button = need(bar, "[data-check]", HTMLButtonElement);
  const label = need(button, "[data-label]", HTMLElement);
  const container = need(document, "#check-report", HTMLElement);
  const { benchmark = "" } = bar.dataset;

  /**
   * @param {string} text
   * @param {string} type
   */
  function showNotice(text, type) {
    const box = element("div", `notice ${type}`);
    box.append(element("p", "", text));
    container.replaceChildren(box);
  }

  button.addEventListener("click", async () => {
    if (button.getAttribute("aria-disabled") === "true") return;
    const program = programFile(form);
    if (!program) {
      showNotice(
        form.elements.kept_program
          ? "Choose the file again to check it. The kept file can only be used to start the run."
          : "Choose a file first, or write the program in the editor.",
        "warn",
      );
      return;
    }
    const before = label.textContent;
    button.setAttribute("aria-disabled", "true");
    label.textContent = "Checking…";
    container.replaceChildren(
      element("p", "small muted", "Compiling and starting the program. This takes a few seconds."),
    );
    try {
      const editor = await openEditor();
      editor?.mark([]);
      const check = await requestCheck(form, benchmark, settings.configuration(), program);
      showReport(container, check, editor);
      editor?.mark(check.problems.filter((problem) => problem.line));
    } catch (error) {
      showNotice((error instanceof Error && error.message) || "The check failed.", "bad");
    }
    label.textContent = before;
    button.removeAttribute("aria-disabled");
  });
}

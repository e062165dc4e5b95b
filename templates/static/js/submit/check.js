// The check button: sends the program to /api/v1/checks and shows the answer beside the editor.

const ADDRESS = "/api/v1/checks";
const PATIENCE_MS = 90_000;

function element(tag, className, text) {
  const made = document.createElement(tag);
  if (className) made.className = className;
  if (text) made.textContent = text;
  return made;
}

function sleep(ms) {
  return new Promise((resolve) => { setTimeout(resolve, ms); });
}

// The chosen file, or the text of the editor under the name that it will have.
function programOf(form) {
  if (form.elements.source.value !== "editor") return form.elements.program.files[0];
  const language = form.elements.language.value;
  const template = form.querySelector(`[data-program-template="${CSS.escape(language)}"]`);
  return new File([form.elements.program_text.value], template.dataset.file);
}

async function read(answer) {
  const document_ = await answer.json();
  if (answer.ok) return document_;
  throw new Error([document_.detail, ...(document_.errors ?? []).map((e) => e.detail)]
    .filter((text, at, all) => text && all.indexOf(text) === at).join(" "));
}

async function ask(form, benchmark, configuration, program) {
  const body = new FormData();
  body.set("run", JSON.stringify({ benchmark, config: configuration() }));
  body.set("program", program);
  const headers = { "X-CSRFToken": form.elements.csrf_token.value, Accept: "application/json" };
  const answer = await fetch(ADDRESS, { method: "POST", body, headers });
  let check = await read(answer);
  const until = Date.now() + PATIENCE_MS;
  while (check.state !== "done") {
    if (Date.now() > until) throw new Error("No worker has taken the check yet. Try again later; a run waits in its queue.");
    await sleep(1000);
    check = await read(await fetch(`${ADDRESS}/${check.id}`, { headers }));
  }
  return check;
}

function goToLine(form, line) {
  const area = form.elements.program_text;
  const lines = area.value.split("\n");
  const start = lines.slice(0, line - 1).join("\n").length + (line > 1 ? 1 : 0);
  area.focus();
  area.setSelectionRange(start, start + (lines[line - 1] ?? "").length);
  const height = parseFloat(getComputedStyle(area).lineHeight) || 20;
  area.scrollTop = Math.max(0, (line - 5) * height);
}

function problemOf(form, problem, inEditor) {
  const item = element("li");
  const place = [problem.file, problem.line && `line ${problem.line}`].filter(Boolean).join(", ");
  if (place && inEditor && problem.line) {
    const button = element("button", "check-line", place);
    button.type = "button";
    button.addEventListener("click", () => goToLine(form, problem.line));
    item.append(button, " ");
  } else if (place) item.append(element("strong", "", place), " ");
  item.append((problem.warning ? "Warning: " : "") + problem.sentence);
  return item;
}

function details(title, text) {
  const made = element("details");
  made.append(element("summary", "", title), element("pre", "", text));
  made.lastChild.tabIndex = 0;
  return made;
}

function verdict(check) {
  if (!check.ok) return "This would not run:";
  const steps = check.step_us;
  const used = check.usage;
  const time = steps && used ? `${steps.count} steps, ${used.cpu_s.toFixed(2)} s of CPU time, ${used.memory_mib.toFixed(0)} MiB. ` : "";
  return `It runs: ${time}${check.problems.length ? "But look at this:" : ""}`;
}

function show(place, form, check) {
  const inEditor = form.elements.source.value === "editor";
  const kind = check.ok ? (check.problems.length ? "warn" : "good") : "bad";
  const box = element("div", `notice ${kind}`);
  const inner = element("div");
  inner.append(element("p", "check-verdict", `${check.program_name}. ${verdict(check)}`));
  if (check.problems.length) {
    const list = element("ul");
    list.append(...check.problems.map((problem) => problemOf(form, problem, inEditor)));
    inner.append(list);
  }
  if (check.traceback) inner.append(details("Traceback", check.traceback));
  if (check.output) inner.append(details("What it printed", check.output));
  box.append(inner);
  place.replaceChildren(box);
}

export function startCheck(form, configuration) {
  const bar = form.querySelector("[data-check-bar]");
  if (!bar) return;
  const button = bar.querySelector("[data-check]");
  const label = button.querySelector("[data-label]");
  const place = document.getElementById("check-answer");

  function say(text, kind) {
    const box = element("div", `notice ${kind}`);
    box.append(element("p", "", text));
    place.replaceChildren(box);
  }

  button.addEventListener("click", async () => {
    if (button.getAttribute("aria-disabled") === "true") return;
    const program = programOf(form);
    if (!program) {
      say(form.elements.kept_program
        ? "Choose the file again to check it; the one that is kept here is for starting the run."
        : "Choose a file first, or write the program in the editor.", "warn");
      return;
    }
    const before = label.textContent;
    button.setAttribute("aria-disabled", "true");
    label.textContent = "Checking …";
    place.replaceChildren(element("p", "small muted", "It is compiled and started; this takes some seconds."));
    try {
      show(place, form, await ask(form, bar.dataset.benchmark, configuration, program));
    } catch (reason) {
      say(reason.message || "The check could not be made.", "bad");
    }
    label.textContent = before;
    button.removeAttribute("aria-disabled");
  });
}

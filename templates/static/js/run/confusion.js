// Tables of a detector's run: what its answers lay on, and how long they took.
/** @import { Recognition } from "../server_data.d.ts" */

const MANY = 0.25; // of the largest count

/**
 * Rows of the confusion matrix that say something: classes always, decoys and background if an answer lay on them.
 * @param {Pick<Recognition, "classes" | "lies_on" | "confusion">} found
 * @returns {{title: string, counts: number[], own: number}[]}
 */
export function confusionRows({ classes, lies_on: titles, confusion }) {
  return titles
    .map((title, index) => ({ title, counts: confusion[index], own: classes.indexOf(title) }))
    .filter(({ counts, own }) => own >= 0 || counts.some((count) => count > 0));
}

/**
 * @param {HTMLElement} box
 * @param {Recognition} found
 */
export function showConfusion(box, found) {
  const rows = confusionRows(found);
  const most = Math.max(1, ...rows.flatMap(({ counts }) => counts));
  const table = start(["Lies on", ...found.labels]);
  const body = table.createTBody();
  for (const { title, counts, own } of rows) {
    const row = add(body, title, counts.map(String));
    for (const [index, count] of counts.entries()) {
      const cell = row.cells[index + 1];
      if (count === 0) cell.classList.add("none");
      else cell.classList.add(index === own ? "right" : "mistaken");
      cell.classList.toggle("many", count > MANY * most);
    }
  }
  const foot = table.createTFoot();
  add(foot, "Objects", found.objects.map(String));
  add(foot, "Missed", found.missed.map(String));
  box.replaceChildren(table);
}

/**
 * @param {HTMLElement} box
 * @param {Recognition} found
 * @param {string} label of the levels
 */
export function showTimes(box, { levels }, label) {
  const table = start([label, ...levels.map(({ value }) => String(value))]);
  const body = table.createTBody();
  for (const [name, of] of /** @type {const} */ ([
    ["Median [ms]", "median"],
    ["Longest [ms]", "longest"],
  ]))
    add(
      body,
      name,
      levels.map(({ time_ms: time }) => time[of].toPrecision(3)),
    );
  box.replaceChildren(table);
}

/** @param {string[]} titles */
function start(titles) {
  const table = document.createElement("table");
  table.className = "metrics confusion";
  const head = table.createTHead().insertRow();
  for (const [index, title] of titles.entries()) {
    const cell = document.createElement("th");
    cell.scope = "col";
    cell.className = index ? "num" : "";
    cell.textContent = title;
    head.append(cell);
  }
  return table;
}

/**
 * @param {HTMLTableSectionElement} section
 * @param {string} title
 * @param {string[]} values
 */
function add(section, title, values) {
  const row = section.insertRow();
  const name = document.createElement("th");
  name.scope = "row";
  name.textContent = title;
  row.append(name);
  for (const value of values) {
    const cell = row.insertCell();
    cell.className = "num";
    cell.textContent = value;
  }
  return row;
}

// The settings of the form: presets, what differs from the defaults, and what has an effect.

import { parameterValues } from "./parameters.js";

function textOf(value) {
  return Array.isArray(value) ? value.join(", ") : String(value);
}

export function valueOfInput(input) {
  return input.type === "checkbox" ? String(input.checked) : input.value;
}

function setValue(input, text) {
  if (input.type === "checkbox") input.checked = text === "true";
  else input.value = text;
}

function json(id) {
  return JSON.parse(document.getElementById(id).textContent);
}

function changedText(count) {
  return `${count} ${count === 1 ? "setting" : "settings"} changed`;
}

export class Settings {
  constructor(form) {
    this.form = form;
    this.inputs = [...form.querySelectorAll("[data-default]")];
    this.defaults = json("defaults");
    this.presets = json("presets");
    this.points = json("starting-points");
    this.fixed = json("fixed"); // by the assignment; its fields are there, hidden, for the conditions of others
    this.groups = [...form.querySelectorAll("details.group")];
    // By a person, before this script ran: they stay so. The server marks those that it unfolds.
    this.unfolded = new Set(this.groups.filter((group) => group.open && !("unfolded" in group.dataset)));
    form.classList.add("brief");
    for (const button of form.querySelectorAll("[data-more]")) {
      button.addEventListener("click", () => {
        const group = button.closest(".group");
        group.classList.remove("partial");
        button.hidden = true;
        group.querySelector(".field:not([hidden]) :is(input, select)")?.focus();
      });
    }
  }

  differs(input) {
    return valueOfInput(input).trim() !== input.dataset.default;
  }

  // Inputs that differ from their defaults, have an effect, and are sent.
  changed(within = this.form) {
    return this.inputs.filter(
      (input) => within.contains(input) && this.differs(input) && !input.closest("[data-field]").hidden,
    );
  }

  // Unchanged inputs follow the presets of other choices, such as the vehicle; changed ones keep
  // their values. The values of a restored draft are all kept.
  applyPresets({ keepValues = false } = {}) {
    const preset = {};
    for (const [name, choices] of Object.entries(this.presets)) {
      Object.assign(preset, choices[valueOfInput(this.form.elements[name])] ?? {});
    }
    for (const input of this.inputs) {
      if (input.name in this.presets) continue;
      const unchanged = !keepValues && !this.differs(input);
      input.dataset.default = textOf(preset[input.name] ?? this.defaults[input.name]);
      if (unchanged) setValue(input, input.dataset.default);
    }
    this.update();
  }

  // Opens the groups with changed settings, and shows only those in them.
  fold() {
    for (const field of this.form.querySelectorAll("[data-field]")) {
      const input = field.querySelector("[data-default]");
      field.classList.toggle("shown", this.differs(input) || Boolean(field.querySelector(".error")));
    }
    for (const group of this.groups) {
      if (this.unfolded.delete(group)) continue;
      const shown = group.querySelectorAll(".field.shown:not([hidden])").length;
      const all = group.querySelectorAll("[data-field]:not([hidden])").length;
      const more = group.querySelector("[data-more]");
      group.open = shown > 0;
      group.classList.toggle("partial", shown > 0 && shown < all);
      more.hidden = shown === 0 || shown === all;
      more.textContent = `Show all ${all} settings of this group`;
      const advanced = group.querySelector("details.advanced");
      if (advanced) advanced.open = advanced.querySelector(".field.shown") !== null;
    }
  }

  // Hides settings that have no effect with the other choices, unless they have an error. A ranked
  // run refuses them: they are not sent.
  showApplicable() {
    const chosen = (name) => (name === "tracker" && this.hasOwnTracker ? "" : valueOfInput(this.form.elements[name]));
    for (const field of this.form.querySelectorAll("[data-applies], [data-field=tracker]")) {
      const conditions = Object.entries(JSON.parse(field.dataset.applies ?? "{}"));
      const applies =
        conditions.every(([name, values]) => values.includes(chosen(name))) &&
        !(field.dataset.field === "tracker" && this.hasOwnTracker);
      field.hidden = !applies && !field.querySelector(".error");
      const condition = field.querySelector("[data-only]");
      if (condition) condition.hidden = applies;
      for (const input of field.querySelectorAll("input, select")) input.disabled = this.ranked && !applies;
    }
    for (const section of this.form.querySelectorAll("details.advanced, details.group")) {
      const count = section.querySelectorAll("[data-field]:not([hidden])").length;
      section.hidden = count === 0 || this.isUnused(section);
      if (section.classList.contains("advanced")) section.querySelector("[data-count]").textContent = count;
    }
  }

  // An own tracker takes the place of the built-in one, with all options of that one.
  get hasOwnTracker() {
    return this.form.dataset.role === "tracker" && valueOfInput(this.form.elements.controller) === "upload";
  }

  get ranked() {
    return this.form.elements.kind.value === "ranked";
  }

  // Ranked runs have the benchmark's own scenario, and assignments fix it: those settings are
  // neither shown nor sent.
  isUnused(section) {
    return "locked" in section.dataset || (this.ranked && section.dataset.role === "scenario");
  }

  update() {
    for (const group of this.groups) group.querySelector("fieldset").disabled = this.isUnused(group);
    this.showApplicable();
    for (const input of this.inputs) {
      document.getElementById(`${input.name}-label`)?.classList.toggle("changed", this.differs(input));
    }
    for (const group of this.groups) {
      const count = this.changed(group).length;
      const badge = group.querySelector("[data-group-count]");
      badge.hidden = count === 0;
      badge.textContent = `${count} changed`;
    }
    const total = this.used().length;
    const badge = this.form.querySelector("[data-changed-count]");
    badge.hidden = total === 0;
    badge.textContent = changedText(total);
    this.markPoints();
  }

  used() {
    return this.changed().filter((input) => !input.matches(":disabled"));
  }

  unused() {
    return this.changed().filter((input) => input.matches(":disabled"));
  }

  titleOf(input) {
    return document.getElementById(`${input.name}-label`).firstChild.textContent.trim();
  }

  summary() {
    const total = this.used().length;
    return total === 0 ? "default settings" : changedText(total);
  }

  isApplied(point) {
    const { controller } = this.form.elements;
    return (
      (!point.built_in || controller.value === point.built_in) &&
      Object.entries(point.config).every(
        ([name, value]) => valueOfInput(this.form.elements[name]).trim() === textOf(value),
      )
    );
  }

  markPoints() {
    for (const button of this.form.querySelectorAll("[data-starting-point]")) {
      const point = this.points[button.dataset.startingPoint];
      button.setAttribute("aria-pressed", String(this.isApplied(point)));
      button.hidden =
        this.ranked &&
        Object.keys(point.config).some(
          (name) => this.form.elements[name].closest("[data-role]").dataset.role === "scenario",
        );
    }
    const presets = this.form.querySelector("[data-starting-points]");
    if (presets) presets.hidden = !presets.querySelector("[data-starting-point]:not([hidden])");
  }

  // Fills in a preset, or takes it back if it is applied already.
  togglePoint(name) {
    const point = this.points[name];
    const applied = this.isApplied(point);
    const isDefault = Object.keys(point.config).every((setting) => !this.differs(this.form.elements[setting]));
    if (applied && isDefault) return `${point.title}: these are the defaults.`;
    for (const [setting, value] of Object.entries(point.config)) {
      const input = this.form.elements[setting];
      setValue(input, applied ? textOf(this.defaults[setting]) : textOf(value));
      if (setting in this.presets) this.applyPresets();
    }
    if (point.built_in && !applied) {
      this.form.elements.controller.value = point.built_in;
      this.form.querySelector("[name=controller]:checked").dispatchEvent(new Event("change", { bubbles: true }));
    }
    this.update();
    this.fold();
    return applied ? `${point.title}: removed.` : `${point.title}: ${point.summary}`;
  }

  reset() {
    for (const input of this.inputs) {
      if (input.name in this.presets && !(input.name in this.fixed)) setValue(input, textOf(this.defaults[input.name]));
    }
    this.applyPresets({ keepValues: true });
    for (const input of this.inputs) {
      if (!(input.name in this.fixed)) setValue(input, input.dataset.default);
    }
    this.update();
    this.fold();
  }

  configuration() {
    const values = { ...this.fixed };
    for (const input of this.inputs) {
      if (input.matches(":disabled")) continue;
      const text = valueOfInput(input).trim();
      if (input.type === "checkbox") values[input.name] = input.checked;
      else if (input.dataset.list !== undefined) {
        values[input.name] = text
          .split(/[\s,;]+/)
          .filter(Boolean)
          .map(Number);
      } else if (input.inputMode === "decimal" && text !== "" && Number.isFinite(Number(text))) {
        values[input.name] = Number(text);
      } else values[input.name] = text;
    }
    return { ...values, ...parameterValues(this.form) };
  }
}

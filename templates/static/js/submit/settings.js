// The settings of the form: presets, what differs from the defaults, and what has an effect.
/** @import { RunForm, SettingValue, StartingPoint } from "../server_data.d.ts" */
import { all, around, dataOf, maybe, need } from "../dom.js";

import { parameterValues } from "./parameters.js";

/** @typedef {HTMLInputElement | HTMLSelectElement} Input */

/** @param {SettingValue | undefined} value */
function textOf(value) {
  return Array.isArray(value) ? value.join(", ") : String(value);
}

/** @param {Input} input */
export function valueOfInput(input) {
  return input instanceof HTMLInputElement && input.type === "checkbox" ? String(input.checked) : input.value;
}

/**
 * @param {Input} input
 * @param {string} text
 */
function setValue(input, text) {
  if (input instanceof HTMLInputElement && input.type === "checkbox") input.checked = text === "true";
  else input.value = text;
}

/** @param {Input} input */
function defaultOf(input) {
  return input.dataset.default ?? "";
}

/**
 * What the form shows of a setting: the input with its label.
 * @param {Input} input
 */
function fieldOf(input) {
  const field = input.closest("[data-field]");
  if (!(field instanceof HTMLElement)) throw new Error(`The setting ${input.name} has no field.`);
  return field;
}

/** @param {number} count */
function changedText(count) {
  return `${count} ${count === 1 ? "setting" : "settings"} changed`;
}

/**
 * @param {Element} element
 * @returns {Input[]}
 */
function asInput(element) {
  return element instanceof HTMLInputElement || element instanceof HTMLSelectElement ? [element] : [];
}

export class Settings {
  /** @param {RunForm} form */
  constructor(form) {
    this.form = form;
    this.inputs = all(form, "[data-default]", HTMLElement).flatMap(asInput);
    /** @type {Record<string, SettingValue>} */
    this.defaults = dataOf("defaults");
    /** @type {Record<string, Record<string, Record<string, SettingValue>>>} by setting and its choice */
    this.presets = dataOf("presets");
    /** @type {Record<string, StartingPoint>} */
    this.points = dataOf("starting-points");
    // By the assignment; its fields are there, hidden, for the conditions of others.
    /** @type {Record<string, SettingValue>} */
    this.fixed = dataOf("fixed");
    this.groups = all(form, "details.group", HTMLDetailsElement);
    // By a person, before this script ran: they stay so. The server marks those that it unfolds.
    this.unfolded = new Set(this.groups.filter((group) => group.open && !("unfolded" in group.dataset)));
    form.classList.add("brief");
    for (const button of all(form, "[data-more]", HTMLElement)) {
      button.addEventListener("click", () => {
        const group = button.closest(".group") ?? form;
        group.classList.remove("partial");
        button.hidden = true;
        maybe(group, ".field:not([hidden]) :is(input, select)", HTMLElement)?.focus();
      });
    }
  }

  /** @param {Input} input */
  differs(input) {
    return valueOfInput(input).trim() !== input.dataset.default;
  }

  /**
   * Inputs that differ from their defaults, have an effect, and are sent.
   * @param {Element} [within]
   */
  changed(within = this.form) {
    return this.inputs.filter((input) => within.contains(input) && this.differs(input) && !fieldOf(input).hidden);
  }

  /**
   * Unchanged inputs follow the presets of other choices, such as the vehicle; changed ones keep
   * their values. The values of a restored draft are all kept.
   * @param {{keepValues?: boolean}} [options]
   */
  applyPresets({ keepValues = false } = {}) {
    /** @type {Record<string, SettingValue>} */
    const preset = {};
    for (const [name, choices] of Object.entries(this.presets)) {
      Object.assign(preset, choices[valueOfInput(this.form.elements[name])] ?? {});
    }
    for (const input of this.inputs) {
      if (input.name in this.presets) continue;
      const unchanged = !keepValues && !this.differs(input);
      input.dataset.default = textOf(preset[input.name] ?? this.defaults[input.name]);
      if (unchanged) setValue(input, defaultOf(input));
    }
    this.update();
  }

  // Opens the groups with changed settings, and shows only those in them.
  fold() {
    for (const field of all(this.form, "[data-field]", HTMLElement)) {
      const [input] = all(field, "[data-default]", HTMLElement).flatMap(asInput);
      field.classList.toggle("shown", this.differs(input) || Boolean(field.querySelector(".error")));
    }
    for (const group of this.groups) {
      if (this.unfolded.delete(group)) continue;
      const shown = group.querySelectorAll(".field.shown:not([hidden])").length;
      const all = group.querySelectorAll("[data-field]:not([hidden])").length;
      const more = need(group, "[data-more]", HTMLElement);
      group.open = shown > 0;
      group.classList.toggle("partial", shown > 0 && shown < all);
      more.hidden = shown === 0 || shown === all;
      more.textContent = `Show all ${all} settings of this group`;
      const advanced = maybe(group, "details.advanced", HTMLDetailsElement);
      if (advanced) advanced.open = advanced.querySelector(".field.shown") !== null;
    }
  }

  // Hides settings that have no effect with the other choices, unless they have an error. A ranked
  // run refuses them: they are not sent.
  showApplicable() {
    /** @type {(name: string) => string} */
    const chosen = (name) => (name === this.replaced ? "" : valueOfInput(this.form.elements[name]));
    for (const field of all(this.form, `[data-applies], [data-field="${this.role}"]`, HTMLElement)) {
      /** @type {[string, string[]][]} */
      const conditions = Object.entries(JSON.parse(field.dataset.applies ?? "{}"));
      const applies =
        conditions.every(([name, values]) => values.includes(chosen(name))) && field.dataset.field !== this.replaced;
      field.hidden = !applies && !field.querySelector(".error");
      const condition = maybe(field, "[data-only]", HTMLElement);
      if (condition) condition.hidden = applies;
      for (const input of all(field, "input, select", HTMLElement).flatMap(asInput))
        input.disabled = this.ranked && !applies;
    }
    for (const section of all(this.form, "details.advanced, details.group", HTMLDetailsElement)) {
      const count = section.querySelectorAll("[data-field]:not([hidden])").length;
      section.hidden = count === 0 || this.isUnused(section);
      if (section.classList.contains("advanced"))
        need(section, "[data-count]", HTMLElement).textContent = String(count);
    }
  }

  get role() {
    return this.form.dataset.role ?? "";
  }

  // An own tracker or detector takes the place of the built-in one, with all options of that one. The
  // setting that chooses the built-in one has the name of the role.
  get replaced() {
    const own = valueOfInput(this.form.elements.controller) === "upload";
    return own && this.role !== "controller" ? this.role : "";
  }

  get ranked() {
    return this.form.elements.kind.value === "ranked";
  }

  /**
   * Ranked runs have the benchmark's own scenario, and assignments fix it: those settings are
   * neither shown nor sent.
   * @param {HTMLElement} section
   */
  isUnused(section) {
    return "locked" in section.dataset || (this.ranked && section.dataset.role === "scenario");
  }

  update() {
    for (const group of this.groups) need(group, "fieldset", HTMLFieldSetElement).disabled = this.isUnused(group);
    this.showApplicable();
    for (const input of this.inputs) {
      document.getElementById(`${input.name}-label`)?.classList.toggle("changed", this.differs(input));
    }
    for (const group of this.groups) {
      const count = this.changed(group).length;
      const badge = need(group, "[data-group-count]", HTMLElement);
      badge.hidden = count === 0;
      badge.textContent = `${count} changed`;
    }
    const total = this.used().length;
    const badge = need(this.form, "[data-changed-count]", HTMLElement);
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

  /** @param {Input} input */
  titleOf(input) {
    return document.getElementById(`${input.name}-label`)?.firstChild?.textContent?.trim() ?? "";
  }

  summary() {
    const total = this.used().length;
    return total === 0 ? "default settings" : changedText(total);
  }

  /** @param {StartingPoint} point */
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
    for (const button of all(this.form, "[data-starting-point]", HTMLElement)) {
      const point = this.points[button.dataset.startingPoint ?? ""];
      button.setAttribute("aria-pressed", String(this.isApplied(point)));
      button.hidden =
        this.ranked &&
        Object.keys(point.config).some(
          (name) => around(this.form.elements[name], "[data-role]", HTMLElement)?.dataset.role === "scenario",
        );
    }
    const presets = maybe(this.form, "[data-starting-points]", HTMLElement);
    if (presets) presets.hidden = !presets.querySelector("[data-starting-point]:not([hidden])");
  }

  /**
   * Fills in a preset, or takes it back if it is applied already.
   * @param {string} name
   */
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
      const chosen = need(this.form, "[name=controller]:checked", HTMLInputElement);
      chosen.dispatchEvent(new Event("change", { bubbles: true }));
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
      if (!(input.name in this.fixed)) setValue(input, defaultOf(input));
    }
    this.update();
    this.fold();
  }

  configuration() {
    /** @type {Record<string, SettingValue>} */
    const values = { ...this.fixed };
    for (const input of this.inputs) {
      if (input.matches(":disabled")) continue;
      const text = valueOfInput(input).trim();
      if (input instanceof HTMLInputElement && input.type === "checkbox") values[input.name] = input.checked;
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

// The editor: CodeMirror in the place of the text area, which stays in the form and keeps the text.
//
// The editor lives in a shadow tree: there CodeMirror adopts its style sheets instead of adding style
// elements, which the content security policy does not allow.
/**
 * @import { EditorState, Extension, StateEffectType } from "@codemirror/state"
 * @import { Problem, RunForm } from "../server_data.d.ts"
 */
import { all, isNamed, maybe, need } from "../dom.js";

const LIBRARY = new URL("../../vendor/codemirror/codemirror.min.js", import.meta.url);
const ESCAPED_MS = 60_000; // for which Tab leaves the editor after Escape

const COLOURS = {
  "&": { height: "100%", color: "var(--text)", backgroundColor: "transparent", fontSize: ".86rem" },
  "&.cm-focused": { outline: "none" },
  ".cm-scroller": { fontFamily: "var(--mono)", lineHeight: "1.5" },
  ".cm-content": { caretColor: "var(--text)", padding: ".6rem 0" },
  ".cm-gutters": {
    backgroundColor: "transparent",
    color: "var(--text-2)",
    border: "0",
    borderRight: "1px solid var(--line)",
  },
  ".cm-activeLine, .cm-activeLineGutter": {
    backgroundColor: "color-mix(in srgb, var(--accent-soft) 45%, transparent)",
  },
  ".cm-matchingBracket, &.cm-focused .cm-matchingBracket": {
    backgroundColor: "var(--accent-soft)",
    outline: "1px solid var(--accent)",
  },
  ".cm-selectionMatch": { backgroundColor: "var(--warn-soft)" },
  ".cm-panels": { backgroundColor: "var(--surface-2)", color: "var(--text)", borderColor: "var(--line)" },
  ".cm-textfield, .cm-button": {
    backgroundColor: "var(--surface)",
    backgroundImage: "none",
    color: "var(--text)",
    border: "1px solid var(--line-strong)",
    borderRadius: "4px",
    fontSize: ".8rem",
  },
  ".cm-problem": { backgroundColor: "var(--bad-soft)" },
  ".cm-problem.warning": { backgroundColor: "var(--warn-soft)" },
  ".cm-problem-text": {
    padding: ".15rem .6rem .25rem",
    borderLeft: "3px solid var(--bad)",
    backgroundColor: "var(--bad-soft)",
    color: "var(--bad)",
    fontFamily: "var(--sans)",
    whiteSpace: "normal",
  },
  ".cm-problem-text.warning": { borderColor: "var(--warn)", backgroundColor: "var(--warn-soft)", color: "var(--warn)" },
};

/** @typedef {typeof import("../../vendor/codemirror/codemirror.min.js")} CodeMirror */

/**
 * What this page does with the editor.
 * @typedef {object} MountedEditor
 * @property {(text: string) => void} setText
 * @property {() => void} setLanguage that which is chosen
 * @property {(problems: Problem[]) => void} mark
 * @property {(line: number) => void} goTo
 * @property {() => void} focus
 */

/** @param {CodeMirror} library */
function highlighting({ HighlightStyle, syntaxHighlighting, tags }) {
  return syntaxHighlighting(
    HighlightStyle.define([
      {
        tag: [tags.keyword, tags.modifier, tags.operatorKeyword, tags.self],
        color: "var(--accent-strong)",
        fontWeight: "600",
      },
      { tag: [tags.string, tags.character, tags.special(tags.string)], color: "var(--good)" },
      { tag: [tags.number, tags.bool, tags.null, tags.atom], color: "var(--chart-3)" },
      { tag: [tags.comment, tags.docString], color: "var(--text-2)", fontStyle: "italic" },
      {
        tag: [tags.definition(tags.variableName), tags.function(tags.definition(tags.variableName)), tags.className],
        color: "var(--chart-4)",
      },
      { tag: [tags.typeName, tags.processingInstruction, tags.meta], color: "var(--warn)" },
    ]),
  );
}

/**
 * Colours for the syntaxes that the library knows; a text in another one is plain.
 * @param {CodeMirror} library
 * @param {string | undefined} name
 * @returns {Extension}
 */
function syntaxOf(library, name) {
  /** @type {Record<string, () => Extension>} */
  const known = {
    c: () => library.cppLanguage,
    cpp: () => library.cppLanguage,
    matlab: () => library.StreamLanguage.define(library.octave),
    python: () => library.pythonLanguage,
  };
  return known[name ?? ""]?.() ?? [];
}

/**
 * Lines with problems are coloured, with the sentence below them.
 * @param {CodeMirror} library
 */
function problemMarks({ Decoration, EditorView, StateEffect, StateField, WidgetType }) {
  class Sentence extends WidgetType {
    /** @param {Problem} problem */
    constructor(problem) {
      super();
      this.problem = problem;
    }

    toDOM() {
      const box = document.createElement("div");
      box.className = `cm-problem-text${this.problem.warning ? " warning" : ""}`;
      box.textContent = this.problem.sentence;
      return box;
    }
  }
  /** @type {StateEffectType<Problem[]>} */
  const setProblems = StateEffect.define();
  /**
   * @param {EditorState} state
   * @param {Problem[]} problems
   */
  function decorations(state, problems) {
    const marks = problems.flatMap((problem) => {
      if (problem.line === null || problem.line < 1 || problem.line > state.doc.lines) return [];
      const line = state.doc.line(problem.line);
      const className = `cm-problem${problem.warning ? " warning" : ""}`;
      return [
        Decoration.line({ class: className }).range(line.from),
        Decoration.widget({ widget: new Sentence(problem), block: true, side: 1 }).range(line.to),
      ];
    });
    return Decoration.set(marks, true);
  }
  const field = StateField.define({
    create: () => Decoration.none,
    update(marks, transaction) {
      const effect = transaction.effects.find((one) => one.is(setProblems));
      return effect ? decorations(transaction.state, effect.value) : marks.map(transaction.changes);
    },
    provide: (one) => EditorView.decorations.from(one),
  });
  return { field, setProblems };
}

/**
 * @param {CodeMirror} library
 * @param {Extension} language
 * @param {ReturnType<typeof problemMarks>} marks
 * @param {HTMLTextAreaElement} area
 * @returns {Extension[]}
 */
function extensions(library, language, marks, area) {
  const { EditorView, keymap } = library;
  return [
    library.lineNumbers(),
    library.history(),
    library.highlightActiveLine(),
    library.highlightActiveLineGutter(),
    library.bracketMatching(),
    library.indentOnInput(),
    library.indentUnit.of("    "),
    library.highlightSelectionMatches(),
    highlighting(library),
    language,
    marks.field,
    EditorView.theme(COLOURS),
    keymap.of([...library.defaultKeymap, ...library.historyKeymap, ...library.searchKeymap, library.indentWithTab]),
    EditorView.contentAttributes.of({
      "aria-label": "Your program",
      "aria-description": "Tab indents. To leave the editor, press Escape, then Tab.",
    }),
    EditorView.domEventHandlers({
      // Chromium would join the selected lines with inline styles, which the policy does not allow.
      beforeinput(event, view) {
        if (event.inputType !== "insertText" || view.composing || view.state.selection.main.empty) return false;
        view.dispatch({
          ...view.state.replaceSelection(event.data ?? ""),
          userEvent: "input.type",
          scrollIntoView: true,
        });
        return true;
      },
      keyup(event, view) {
        // longer than CodeMirror's own two seconds
        if (event.key === "Escape") view.setTabFocusMode(ESCAPED_MS);
      },
    }),
    EditorView.updateListener.of((update) => {
      if (!update.docChanged) return;
      area.value = update.state.doc.toString();
      area.dispatchEvent(new Event("input", { bubbles: true }));
    }),
  ];
}

/**
 * Mounts CodeMirror and returns its view, with the functions that this page needs.
 * @param {RunForm} form
 * @param {HTMLTextAreaElement} area
 * @returns {Promise<MountedEditor>}
 */
async function mount(form, area) {
  /** @type {CodeMirror} */
  const library = await import(LIBRARY.href);
  const focused = document.activeElement === area;
  const host = document.createElement("div");
  host.className = "editor-host";
  area.after(host);
  area.hidden = true;
  need(form, "label[for=program_text]", HTMLElement).remove(); // the name of the text area
  need(form, "[data-editor-keys]", HTMLElement).hidden = false;
  const root = host.attachShadow({ mode: "open" });
  const marks = problemMarks(library);
  const language = new library.Compartment();
  const selected = () => {
    const { value } = form.elements.language;
    const template = maybe(form, `[data-program-template="${value}"]`, HTMLTemplateElement);
    return syntaxOf(library, template?.dataset.syntax);
  };
  const state = library.EditorState.create({
    doc: area.value,
    extensions: extensions(library, language.of(selected()), marks, area),
  });
  const view = new library.EditorView({ state, root, parent: root });
  if (focused) view.focus();
  return {
    setText(text) {
      view.dispatch({ changes: { from: 0, to: view.state.doc.length, insert: text } });
    },
    setLanguage() {
      view.dispatch({ effects: language.reconfigure(selected()) });
    },
    mark(problems) {
      view.dispatch({ effects: marks.setProblems.of(problems) });
    },
    goTo(number) {
      const line = view.state.doc.line(Math.min(Math.max(number, 1), view.state.doc.lines));
      view.focus();
      view.dispatch({
        selection: { anchor: line.from, head: line.to },
        effects: library.EditorView.scrollIntoView(line.from, { y: "center" }),
      });
    },
    focus: () => view.focus(),
  };
}

/**
 * The problem that the server found in the text when the form was sent.
 * @param {RunForm} form
 * @returns {Problem[]}
 */
function refusedLine(form) {
  const match = document.getElementById("program-error")?.textContent?.match(/line (\d+): (.*)/s);
  return match && form.elements.source.value === "editor"
    ? [{ line: Number(match[1]), sentence: match[2], warning: false }]
    : [];
}

/**
 * Returns a function that gives the mounted editor, or null if the page has none or it did not load.
 * @param {RunForm} form
 * @returns {() => Promise<MountedEditor | null>}
 */
export function startEditor(form) {
  const area = form.elements.program_text;
  if (!area) return async () => null;
  /** @type {Promise<MountedEditor> | null} */
  let editor = null;
  const { language } = form.elements;
  const template = need(form, "[data-template]", HTMLElement);
  const templates = new Map(
    all(form, "[data-program-template]", HTMLTemplateElement).map((each) => [
      each.dataset.programTemplate ?? "",
      each.content.textContent ?? "",
    ]),
  );
  const starter = () => templates.get(language.value) ?? "";

  async function open() {
    if (form.elements.controller.value !== "upload" || form.elements.source.value !== "editor") return null;
    editor ??= mount(form, area).then((mounted) => {
      mounted.mark(refusedLine(form));
      return mounted;
    });
    return editor.catch(() => null); // the text area stays
  }

  /** @param {string} text */
  async function setText(text) {
    const mounted = await open();
    if (mounted) mounted.setText(text);
    else area.value = text;
  }

  form.addEventListener("change", async (event) => {
    if (isNamed(event.target, "controller", "source")) await open();
    if (event.target !== language) return;
    // The user's own text is kept.
    if (!area.value.trim() || [...templates.values()].includes(area.value)) await setText(starter());
    (await open())?.setLanguage();
  });
  template.hidden = false;
  template.addEventListener("click", async () => {
    // no question: undo brings the text back
    await setText(starter());
    (await open())?.focus();
  });
  document.querySelector('#problems a[href="#program"]')?.addEventListener("click", async (event) => {
    const [problem] = refusedLine(form);
    if (!problem?.line) return; // a file: the link leads to its field
    event.preventDefault();
    (await open())?.goTo(problem.line);
  });
  open();
  return open;
}

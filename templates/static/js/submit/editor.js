// The editor: CodeMirror in the place of the text area, which stays in the form and keeps the text.
//
// The editor lives in a shadow tree: there CodeMirror adopts its style sheets instead of adding style
// elements, which the content security policy does not allow.

const LIBRARY = new URL("../../vendor/codemirror/codemirror.min.js", import.meta.url);
const ESCAPED_MS = 60_000; // for which Tab leaves the editor after Escape

const COLOURS = {
  "&": { height: "100%", color: "var(--text)", backgroundColor: "transparent", fontSize: ".86rem" },
  "&.cm-focused": { outline: "none" },
  ".cm-scroller": { fontFamily: "var(--mono)", lineHeight: "1.5" },
  ".cm-content": { caretColor: "var(--text)", padding: ".6rem 0" },
  ".cm-gutters": { backgroundColor: "transparent", color: "var(--text-2)", border: "0", borderRight: "1px solid var(--line)" },
  ".cm-activeLine, .cm-activeLineGutter": { backgroundColor: "color-mix(in srgb, var(--accent-soft) 45%, transparent)" },
  ".cm-matchingBracket, &.cm-focused .cm-matchingBracket": { backgroundColor: "var(--accent-soft)", outline: "1px solid var(--accent)" },
  ".cm-selectionMatch": { backgroundColor: "var(--warn-soft)" },
  ".cm-panels": { backgroundColor: "var(--surface-2)", color: "var(--text)", borderColor: "var(--line)" },
  ".cm-textfield, .cm-button": { backgroundColor: "var(--surface)", backgroundImage: "none", color: "var(--text)", border: "1px solid var(--line-strong)", borderRadius: "4px", fontSize: ".8rem" },
  ".cm-problem": { backgroundColor: "var(--bad-soft)" },
  ".cm-problem.warning": { backgroundColor: "var(--warn-soft)" },
  ".cm-problem-text": { padding: ".15rem .6rem .25rem", borderLeft: "3px solid var(--bad)", backgroundColor: "var(--bad-soft)", color: "var(--bad)", fontFamily: "var(--sans)", whiteSpace: "normal" },
  ".cm-problem-text.warning": { borderColor: "var(--warn)", backgroundColor: "var(--warn-soft)", color: "var(--warn)" },
};

function highlighting({ HighlightStyle, syntaxHighlighting, tags }) {
  return syntaxHighlighting(HighlightStyle.define([
    { tag: [tags.keyword, tags.modifier, tags.operatorKeyword, tags.self], color: "var(--accent-strong)", fontWeight: "600" },
    { tag: [tags.string, tags.character, tags.special(tags.string)], color: "var(--good)" },
    { tag: [tags.number, tags.bool, tags.null, tags.atom], color: "var(--chart-3)" },
    { tag: [tags.comment, tags.docString], color: "var(--text-2)", fontStyle: "italic" },
    { tag: [tags.definition(tags.variableName), tags.function(tags.definition(tags.variableName)), tags.className], color: "var(--chart-4)" },
    { tag: [tags.typeName, tags.processingInstruction, tags.meta], color: "var(--warn)" },
  ]));
}

// Colours for the syntaxes that the library knows; a text in another one is plain.
function syntaxOf(library, name) {
  const known = {
    c: () => library.cppLanguage,
    cpp: () => library.cppLanguage,
    matlab: () => library.StreamLanguage.define(library.octave),
    python: () => library.pythonLanguage,
  };
  return known[name]?.() ?? [];
}

// Lines with problems are coloured, with the sentence below them.
function problemMarks({ Decoration, EditorView, StateEffect, StateField, WidgetType }) {
  class Sentence extends WidgetType {
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
  const setProblems = StateEffect.define();
  function decorations(state, problems) {
    const marks = problems.filter(({ line }) => line >= 1 && line <= state.doc.lines).flatMap((problem) => {
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

function extensions(library, language, marks, area) {
  const { EditorView, keymap } = library;
  return [
    library.lineNumbers(), library.history(), library.highlightActiveLine(),
    library.highlightActiveLineGutter(), library.bracketMatching(), library.indentOnInput(),
    library.indentUnit.of("    "), library.highlightSelectionMatches(), highlighting(library),
    language, marks.field, EditorView.theme(COLOURS),
    keymap.of([...library.defaultKeymap, ...library.historyKeymap, ...library.searchKeymap, library.indentWithTab]),
    EditorView.contentAttributes.of({
      "aria-label": "Your program",
      "aria-description": "Tab indents. To leave the editor, press Escape, then Tab.",
    }),
    EditorView.domEventHandlers({
      // Chromium would join the selected lines with inline styles, which the policy does not allow.
      beforeinput(event, view) {
        if (event.inputType !== "insertText" || view.composing || view.state.selection.main.empty) return false;
        view.dispatch({ ...view.state.replaceSelection(event.data), userEvent: "input.type", scrollIntoView: true });
        return true;
      },
      keyup(event, view) { // longer than CodeMirror's own two seconds
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

// Mounts CodeMirror and returns its view, with the functions that this page needs.
async function mount(form, area) {
  const library = await import(LIBRARY);
  const focused = document.activeElement === area;
  const host = document.createElement("div");
  host.className = "editor-host";
  area.after(host);
  area.hidden = true;
  form.querySelector("label[for=program_text]").remove(); // the name of the text area
  form.querySelector("[data-editor-keys]").hidden = false;
  const root = host.attachShadow({ mode: "open" });
  const marks = problemMarks(library);
  const language = new library.Compartment();
  const selected = () => {
    const template = form.querySelector(`[data-program-template="${form.elements.language.value}"]`);
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

// The problem that the server found in the text when the form was sent.
function refusedLine(form) {
  const found = document.getElementById("program-error")?.textContent.match(/line (\d+): (.*)/s);
  return found && form.elements.source.value === "editor"
    ? [{ line: Number(found[1]), sentence: found[2], warning: false }] : [];
}

// Returns a function that gives the mounted editor, or null if the page has none or it did not load.
export function startEditor(form) {
  const area = form.elements.program_text;
  if (!area) return async () => null;
  let editor = null;
  const { language } = form.elements;
  const template = form.querySelector("[data-template]");
  const templates = new Map([...form.querySelectorAll("[data-program-template]")]
    .map((each) => [each.dataset.programTemplate, each.content.textContent]));

  async function open() {
    if (form.elements.controller.value !== "upload" || form.elements.source.value !== "editor") return null;
    editor ??= mount(form, area).then((mounted) => {
      mounted.mark(refusedLine(form));
      return mounted;
    });
    return editor.catch(() => null); // the text area stays
  }

  async function setText(text) {
    const mounted = await open();
    if (mounted) mounted.setText(text);
    else area.value = text;
  }

  form.addEventListener("change", async (event) => {
    if (["controller", "source"].includes(event.target.name)) await open();
    if (event.target !== language) return;
    // The user's own text is kept.
    if (!area.value.trim() || [...templates.values()].includes(area.value)) await setText(templates.get(language.value));
    (await open())?.setLanguage();
  });
  template.hidden = false;
  template.addEventListener("click", async () => { // no question: undo brings the text back
    await setText(templates.get(language.value));
    (await open())?.focus();
  });
  document.querySelector('#problems a[href="#program"]')?.addEventListener("click", async (event) => {
    const [problem] = refusedLine(form);
    if (!problem) return; // a file: the link leads to its field
    event.preventDefault();
    (await open())?.goTo(problem.line);
  });
  open();
  return open;
}

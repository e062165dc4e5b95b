// The parts of CodeMirror that the editor of the form uses; bundled into codemirror.min.js.
export { defaultKeymap, history, historyKeymap, indentWithTab } from "@codemirror/commands";
export { cppLanguage } from "@codemirror/lang-cpp";
export { pythonLanguage } from "@codemirror/lang-python";
export {
  HighlightStyle, StreamLanguage, bracketMatching, indentOnInput, indentUnit, syntaxHighlighting,
} from "@codemirror/language";
export { octave } from "@codemirror/legacy-modes/mode/octave";
export { highlightSelectionMatches, searchKeymap } from "@codemirror/search";
export { Compartment, EditorState, StateEffect, StateField } from "@codemirror/state";
export {
  Decoration, EditorView, WidgetType, highlightActiveLine, highlightActiveLineGutter, keymap, lineNumbers,
} from "@codemirror/view";
export { tags } from "@lezer/highlight";

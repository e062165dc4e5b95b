// The page of the first controller: the editor, its check, and what was written before signing up.
import { startCheck } from "./check.js";
import { startDraft } from "./draft.js";
import { startEditor } from "./editor.js";

const form = document.getElementById("run-form");

startDraft(form);
const editor = startEditor(form);
startCheck(form, { configuration: () => JSON.parse(form.dataset.settings) }, editor);

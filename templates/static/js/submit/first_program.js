// The page of the first controller: the editor, its check, and what was written before signing up.
import { need } from "../dom.js";
/** @import { RunForm } from "../server_data.d.ts" */
import { startCheck } from "./check.js";
import { startDraft } from "./draft.js";
import { startEditor } from "./editor.js";

const form = /** @type {RunForm} */ (need(document, "form#run-form", HTMLFormElement));

startDraft(form);
const editor = startEditor(form);
startCheck(form, { configuration: () => JSON.parse(form.dataset.settings ?? "{}") }, editor);

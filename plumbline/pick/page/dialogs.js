/** @file Three sheets over the page: help, the comparison of models, and the end. */

import { find, keyLabel, make, px } from "./dom.js";
import { sentence } from "./panel.js";

/** @typedef {import("./store.js").Store} Store */
/** @typedef {import("./server.js").Server} Server */
/** @typedef {import("./actions.js").Action} Action */
/** @typedef {import("./types.js").Facts} Facts */

/**
 * @param {Store} store
 * @param {Server} server
 */
export function createDialogs(store, server) {
  const dialog = find("sheet", HTMLDialogElement);
  const body = find("sheet-body", HTMLElement);
  const title = find("sheet-title", HTMLElement);
  find("sheet-close", HTMLButtonElement).addEventListener("click", () => dialog.close());
  const progress = make("p", { role: "status" });
  store.subscribe((state) => {
    progress.textContent = state.progress || "Working…";
  });
  dialog.addEventListener("click", (event) => {
    if (event.target === dialog) dialog.close();
  });

  /**
   * @param {string} heading
   * @param {(Node | string)[]} children
   */
  function open(heading, ...children) {
    title.textContent = heading;
    body.replaceChildren(...children);
    if (!dialog.open) dialog.showModal();
  }

  /** @param {string} heading What is waited for; its progress comes from the server. */
  function wait(heading) {
    store.set({ progress: "" });
    open(heading, progress);
  }

  /** Write the lens and the report, and say what was written. */
  async function finish() {
    wait("Finish");
    const told = await server.finish();
    if (!told) return dialog.close();
    open("The lens is written", make("p", {}, make("b", {}, sentence(told.finding))),
      make("p", {}, "Files written beside the photo:"),
      make("ul", {}, ...told.files.map((/** @type {string} */ file) => make("li", {}, make("code", {}, file)))),
      make("p", {}, "The Hugin project (.pto) opens in Hugin. Copy the LensFun profile (.xml) to ",
        make("code", {}, told.lensfun), ", and darktable, digiKam and RawTherapee correct photographs with it. "
        + "The page (.html) is the report."),
      make("ul", {}, ...told.notes.map((/** @type {string} */ note) => make("li", {}, sentence(note)))),
      descriptionOf(store.get().facts, async (facts) => {
        if (await server.act({ do: "describe", ...facts })) await finish();
      }));
  }

  return {
    finish,

    /** @param {readonly Action[]} actions */
    help(actions) {
      const groups = [...new Set(actions.map((action) => action.group))];
      open("How to pick",
        make("p", {}, "Click near one end of a straight edge, then near the other. Long edges near the "
          + "border of the photo tell most. Click a line, then beyond its end, to extend it; drag its "
          + "rings to move them. Scroll to zoom, drag to move, also in the middle of a line."),
        ...groups.flatMap((group) => [make("h3", {}, group), make("dl", { class: "keys" },
          ...actions.filter((action) => action.group === group).flatMap((action) => [
            make("dt", {}, ...action.keys.slice(0, 4).flatMap((key) => [make("kbd", {}, keyLabel(key)), " "])),
            make("dd", {}, action.text)]))]));
    },

    async compare() {
      wait("Models compared");
      const told = await server.compare();
      if (!dialog.open) return;
      if (!told) return dialog.close();
      open("Models compared", table(told, (/** @type {string} */ model, /** @type {string[]} */ free) => {
        dialog.close();
        void server.act({ do: "set", ...store.get().settings, model, free });
      }), make("p", {}, make("b", {}, `Recommended: ${told.recommended}. `), sentence(told.reason)),
      ...[told.quote, told.beyond, told.centre].filter(Boolean).map((text) => make("p", {}, sentence(text))));
    },
  };
}

/**
 * A form that says what LensFun is to call the lens.
 *
 * @param {Facts} facts
 * @param {(facts: Facts) => void} take
 */
function descriptionOf(facts, take) {
  /** @type {[keyof Facts, string, boolean][]} */
  const entries = [["maker", "Maker", false], ["model", "Lens name", false], ["mount", "Mount, as LensFun names it", false],
    ["focal_mm", "Focal length in mm", true], ["crop_factor", "Crop factor", true]];
  const inputs = entries.map(([name, , counted]) => make("input", { name, value: String(facts[name] ?? ""),
    ...(counted ? { type: "number", step: "any", min: "0.01" } : { maxlength: "200" }) }));
  const form = make("form", { class: "facts" }, make("h3", {}, "What LensFun calls the lens"),
    ...entries.map(([, label], index) => make("label", {}, `${label} `, inputs[index])), make("button", {}, "Write again"));
  form.addEventListener("submit", (event) => {
    event.preventDefault();
    const [maker, model, mount, focal, crop] = inputs.map((input) => input.value.trim());
    take({ maker, model, mount, focal_mm: Number(focal) || null, crop_factor: Number(crop) || null });
  });
  return form;
}

/**
 * @param {any} told
 * @param {(model: string, free: string[]) => void} take
 */
function table(told, take) {
  const head = ["model", "rms", "left out", "error", ""].map((text) => make("th", { scope: "col" }, text));
  const size = (/** @type {number | null} */ value) => make("td", { class: "number" }, value === null ? "–" : px(value));
  const rows = told.candidates.map((/** @type {any} */ each) => {
    const recommended = each.name === told.recommended;
    const button = make("button", { type: "button" }, recommended ? "take (recommended)" : "take");
    button.addEventListener("click", () => take(each.model, each.free));
    const row = make("tr", {}, make("th", { scope: "row" }, each.name), size(each.rms_after_px), size(each.left_out_px),
      size(each.overall_error_px), make("td", {}, each.failure ? sentence(each.failure) : button));
    row.classList.toggle("selected", recommended);
    return row;
  });
  return make("table", {}, make("thead", {}, make("tr", {}, ...head)), make("tbody", {}, ...rows));
}

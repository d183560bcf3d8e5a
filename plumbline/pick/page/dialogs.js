/** @file Three sheets over the page: help, the comparison of models, and the end. */

import { find, keyLabel, make, px } from "./dom.js";
import { sentence } from "./panel.js";

/** @typedef {import("./store.js").Store} Store */
/** @typedef {import("./server.js").Server} Server */
/** @typedef {import("./actions.js").Action} Action */

/**
 * @param {Store} store
 * @param {Server} server
 */
export function createDialogs(store, server) {
  const dialog = find("sheet", HTMLDialogElement);
  const body = find("sheet-body", HTMLElement);
  const title = find("sheet-title", HTMLElement);
  find("sheet-close", HTMLButtonElement).addEventListener("click", () => dialog.close());
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
    const text = make("p", { role: "status" }, "Working…");
    store.subscribe((state) => {
      if (text.isConnected) text.textContent = state.progress || "Working…";
    });
    open(heading, text);
  }

  return {
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

    async finish() {
      wait("Finish");
      const told = await server.finish();
      if (!dialog.open) return;
      if (!told) return dialog.close();
      open("The lens is written", make("p", {}, make("b", {}, sentence(told.finding))),
        make("p", {}, "Files written beside the photo:"),
        make("ul", {}, ...told.files.map((/** @type {string} */ file) => make("li", {}, make("code", {}, file)))),
        make("p", {}, "The Hugin project (.pto) opens in Hugin; the LensFun profile (.xml) goes into LensFun's "
          + "folder (~/.local/share/lensfun) for darktable, digiKam and RawTherapee; the page (.html) is the report."),
        make("ul", {}, ...told.notes.map((/** @type {string} */ note) => make("li", {}, sentence(note)))));
    },
  };
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

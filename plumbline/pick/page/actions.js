/** @file Everything one can do, each with its key: the one list behind keys, buttons and help. */

import { panned, toWorld, whole, zoomed } from "./camera.js";

/** @typedef {import("./types.js").State} State */
/** @typedef {import("./types.js").Point} Point */
/** @typedef {import("./store.js").Store} Store */
/** @typedef {import("./server.js").Server} Server */
/** @typedef {import("./picking.js").Picking} Picking */

/**
 * @typedef {object} Action
 * @property {string} id
 * @property {string} group
 * @property {string[]} keys As `key` of a keyboard event, with "Ctrl+" (also ⌘) and "Shift+".
 * @property {string} text
 * @property {(key: string) => unknown} run
 * @property {(state: State) => boolean} [useful] Whether it does anything now.
 */

/**
 * @typedef {object} Tools
 * @property {Store} store
 * @property {Server} server
 * @property {Picking} picking
 * @property {() => {width: number, height: number}} size Of the stage.
 * @property {(name: "help" | "compare" | "finish") => void} open A dialog.
 */

const STEP = 80; // screen pixels that an arrow key moves the view by
const NUDGE = 0.1; // photo pixels that Shift and an arrow key move a click by
const CLOSER = 1.5;
export const STRIP = 106; // screen pixels that the stretched view covers, as the style sheet has it

const ARROWS = /** @type {Record<string, Point>} */ ({
  ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1],
});

/**
 * @param {Tools} tools
 * @returns {Action[]}
 */
export function createActions({ store, server, picking, size, open }) {
  /** @returns {Point} Where keys act: at the pointer, else in the middle. */
  const here = () => store.get().pointer ?? [size().width / 2, size().height / 2];
  const line = () => store.get().lines.find((each) => each.number === store.get().selected);
  const zoom = (/** @type {number} */ factor) =>
    store.set({ view: zoomed(store.get().view, size(), here(), factor, store.get().photos) });
  const flip = (/** @type {keyof State["show"]} */ name) => () => store.show({ [name]: !store.get().show[name] });
  const rival = (/** @type {number} */ step) => () => server.act({ do: "rival", line: line()?.number, step });
  const hasRivals = () => Boolean(line()?.rivals);

  /** @param {number} step */
  function choose(step) {
    const { lines, selected } = store.get();
    const index = lines.findIndex((each) => each.number === selected);
    const next = lines[(index + step + lines.length) % lines.length] ?? lines[0];
    if (next) store.set({ selected: next.number, click: null });
  }

  /** @param {string} key */
  async function nudge(key) {
    const { click } = store.get();
    const chosen = line();
    const [dx, dy] = ARROWS[key];
    if (!chosen || click === null) return;
    const [x, y] = chosen.clicks[click];
    await picking.move({ line: chosen.number, index: click, to: [x + NUDGE * dx, y + NUDGE * dy] });
  }

  function guide() {
    const { guide: shown, view } = store.get();
    const { width } = size();
    /** @type {[Point, Point]} */
    const across = [[view.x - width / 4 / view.scale, view.y], [view.x + width / 4 / view.scale, view.y]];
    store.set({ guide: shown ? null : across });
  }

  function cancel() {
    if (store.get().pending) store.set({ pending: null, reason: null });
    else store.set({ selected: null, click: null, reason: null });
  }

  /** @type {Action[]} */
  const actions = [
    { id: "click", group: "Pick", keys: [" "], text: "Click where the pointer is, or in the middle of the view",
      run: () => picking.click(toWorld(store.get().view, size(), here()), {}) },
    { id: "add", group: "Pick", keys: ["a"], text: "Add a click there to the selected line (as Shift and a click)",
      run: () => picking.click(toWorld(store.get().view, size(), here()), { add: true }),
      useful: (state) => state.selected !== null },
    { id: "end", group: "Pick", keys: ["Enter"], text: "End a line of free picks (as a double click)",
      run: () => picking.complete(), useful: (state) => state.pending !== null },
    { id: "cancel", group: "Pick", keys: ["Escape"], text: "Give up the line, or select nothing", run: cancel },
    { id: "free", group: "Pick", keys: ["f"], text: "Free picks instead of traced edges (Alt does it for one click)",
      run: () => store.set({ free: !store.get().free }), useful: (state) => state.snapping },
    { id: "rival", group: "Pick", keys: ["Tab"], text: "Take the next edge that the clicks could mean",
      run: rival(1), useful: hasRivals },
    { id: "rival-back", group: "Pick", keys: ["Shift+Tab"], text: "Take the edge before", run: rival(-1), useful: hasRivals },
    { id: "snap", group: "Pick", keys: ["s"], text: "Trace the selected line, or go back to its clicks",
      run: () => server.act({ do: "snap", line: line()?.number, on: !line()?.snapped }),
      useful: (state) => state.snapping && line() !== undefined },
    { id: "remove", group: "Pick", keys: ["Delete", "Backspace"], text: "Delete the selected click, else the selected line",
      run: () => picking.remove(), useful: (state) => state.selected !== null },
    { id: "nudge", group: "Pick", keys: ["Shift+ArrowLeft", "Shift+ArrowRight", "Shift+ArrowUp", "Shift+ArrowDown"],
      text: "Move the selected click by a tenth of a pixel", run: (key) => nudge(key.slice(6)),
      useful: (state) => state.click !== null },
    { id: "undo", group: "Pick", keys: ["Ctrl+z"], text: "Undo",
      run: () => picking.unclick() || server.act({ do: "undo" }), useful: (state) => state.undo !== "" || state.pending !== null },
    { id: "redo", group: "Pick", keys: ["Ctrl+Shift+z", "Ctrl+y"], text: "Redo",
      run: () => server.act({ do: "redo" }), useful: (state) => state.redo !== "" },
    { id: "next-line", group: "Pick", keys: ["n"], text: "Select the next line", run: () => choose(1) },
    { id: "line-before", group: "Pick", keys: ["b"], text: "Select the line before", run: () => choose(-1) },
    { id: "accept", group: "Pick", keys: ["Ctrl+Enter"], text: "Take all proposed lines (a click takes one, Shift and a click rejects it)",
      run: () => server.act({ do: "accept", proposals: store.get().proposals.map((each) => each.number) }),
      useful: (state) => state.proposals.length > 0 },

    { id: "closer", group: "Look", keys: ["+", "="], text: "Zoom in", run: () => zoom(CLOSER) },
    { id: "farther", group: "Look", keys: ["-"], text: "Zoom out", run: () => zoom(1 / CLOSER) },
    { id: "whole", group: "Look", keys: ["0"], text: "Show everything",
      run: () => store.set({ view: whole(store.get().photos, size(), STRIP) }) },
    { id: "actual", group: "Look", keys: ["1"], text: "One screen pixel for one of the photo", run: () => zoom(1 / store.get().view.scale) },
    { id: "move", group: "Look", keys: Object.keys(ARROWS), text: "Move the view",
      run: (key) => store.set({ view: panned(store.get().view,
        [-STEP * ARROWS[key][0], -STEP * ARROWS[key][1]], store.get().photos) }) },
    { id: "loupe", group: "Look", keys: ["l"], text: "Loupe at the pointer", run: flip("loupe") },
    { id: "strip", group: "Look", keys: ["x"], text: "View stretched across the line", run: flip("strip") },
    { id: "residuals", group: "Look", keys: ["r"], text: "Residuals, magnified", run: flip("residuals") },
    { id: "more", group: "Look", keys: ["]"], text: "Magnify residuals more",
      run: () => store.set({ magnified: Math.min(store.get().magnified * 2, 640) }) },
    { id: "less", group: "Look", keys: ["["], text: "Magnify residuals less",
      run: () => store.set({ magnified: Math.max(store.get().magnified / 2, 1.25) }) },
    { id: "map", group: "Look", keys: ["u"], text: "Map of what is uncertain", run: flip("map") },
    { id: "next", group: "Look", keys: ["w"], text: "Where a next line would help most", run: flip("next") },
    { id: "proposals", group: "Look", keys: ["p"], text: "Proposed lines", run: flip("proposals") },
    { id: "corrected", group: "Look", keys: ["c"], text: "Corrected photo", run: flip("corrected"),
      useful: (state) => state.show.corrected || !state.fit.failure },
    { id: "guide", group: "Look", keys: ["g"], text: "Straight guide to lay along an edge (drag its ends)", run: guide },

    { id: "compare", group: "Result", keys: ["m"], text: "Compare models", run: () => open("compare"), useful: (state) => !state.fit.failure },
    { id: "finish", group: "Result", keys: ["Ctrl+s"], text: "Finish: write the lens and a report", run: () => open("finish"),
      useful: (state) => !state.fit.failure },
    { id: "help", group: "Result", keys: ["?"], text: "This sheet", run: () => open("help") },
  ];
  return actions;
}

/**
 * The name of a key event as the list has it.
 *
 * @param {KeyboardEvent} event
 */
export function keyName(event) {
  const ctrl = event.ctrlKey || event.metaKey;
  const letter = event.key.length === 1;
  const key = letter ? event.key.toLowerCase() : event.key;
  const shift = event.shiftKey && (!letter || ctrl);
  return `${ctrl ? "Ctrl+" : ""}${shift ? "Shift+" : ""}${key}`;
}

/**
 * Run actions by their keys, but not while one types.
 *
 * @param {readonly Action[]} actions
 * @param {Store} store
 * @param {HTMLElement} stage
 */
export function listenToKeys(actions, store, stage) {
  document.addEventListener("keydown", (event) => {
    const target = /** @type {HTMLElement} */ (event.target);
    if (target.closest("input, select, textarea, dialog") || event.altKey) return;
    const onStage = target === stage || target === document.body;
    if (!onStage && ["Tab", "Shift+Tab", " ", "Enter"].includes(keyName(event))) return;
    const action = actions.find((each) => each.keys.includes(keyName(event)));
    if (!action || (action.useful && !action.useful(store.get()))) return;
    event.preventDefault();
    action.run(keyName(event));
  });
}

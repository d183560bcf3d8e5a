/** @file The page's state in one place. Who changes it calls `set`; who shows it subscribes. */

/** @typedef {import("./types.js").State} State */

/** @type {State} */
const EMPTY = {
  photos: [], file: "", snapping: false, models: [], lines: [], proposals: [],
  settings: { model: "ptlens", free: null, goal_px: 0.5 },
  undo: "", redo: "", fit: { failure: "", hint: "" }, judgement: {}, revision: 0, unsaved: "",
  trouble: "", facts: { maker: "", model: "", mount: "", focal_mm: null, crop_factor: null }, progress: "", ready: false, online: true, holds: true, waiting: 0,
  selected: null, click: null, dragged: null, hovered: null, taken: null, pending: null, pointer: null, free: false,
  view: { x: 0, y: 0, scale: 1 },
  show: {
    residuals: true, map: false, corrected: false, loupe: true, strip: true, proposals: true,
    next: true,
  },
  magnified: 20, guide: null, reason: null,
};

/**
 * The store: a state, and those who want to hear of changes.
 *
 * @returns {{get: () => State, set: (patch: Partial<State>) => void,
 *   show: (patch: Partial<State["show"]>) => void,
 *   subscribe: (hear: (state: State, before: State) => void) => void}}
 */
export function createStore() {
  let state = EMPTY;
  /** @type {((state: State, before: State) => void)[]} */
  const hearers = [];
  const store = {
    get: () => state,
    /** @param {Partial<State>} patch */
    set(patch) {
      const before = state;
      state = { ...state, ...patch };
      for (const hear of hearers) hear(state, before);
    },
    /** @param {Partial<State["show"]>} patch */
    show(patch) {
      store.set({ show: { ...state.show, ...patch } });
    },
    /** @param {(state: State, before: State) => void} hear */
    subscribe(hear) {
      hearers.push(hear);
    },
  };
  return store;
}

/** @typedef {ReturnType<typeof createStore>} Store */

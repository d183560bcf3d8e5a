/** @file Mouse, pen, touch and wheel on the stage: what they do to the view, and what is picked. */

import { panned, photoAt, toWorld, zoomed } from "./camera.js";
import { distance } from "./geometry.js";

/** @typedef {import("./types.js").Point} Point */
/** @typedef {import("./store.js").Store} Store */
/** @typedef {import("./picking.js").Picking} Picking */

const STILL = 5; // screen pixels that a click may move
const HOLD_MS = 350; // until a finger that stays aims with the loupe
const PER_NOTCH = 1.0018; // zoom per pixel of the wheel
const PER_PINCH = 1.012; // the same for a trackpad's pinch, which turns less
const FINE = 40; // pixels of a wheel's turn below which it is a trackpad's scroll

/**
 * @param {HTMLElement} stage
 * @param {Store} store
 * @param {Picking} picking
 */
export function listenTo(stage, store, picking) {
  /** @type {Map<number, Point>} */
  const down = new Map();
  /** @type {{mode: "click" | "pan" | "drag" | "guide" | "aim" | "pinch", start: Point, last: Point,
   *   line: number, index: number, timer: number} | null} */
  let held = null;

  const size = () => ({ width: stage.clientWidth, height: stage.clientHeight });
  /** @returns {Point} */
  const at = (/** @type {MouseEvent} */ event) => {
    const box = stage.getBoundingClientRect();
    return [event.clientX - box.left, event.clientY - box.top];
  };
  const world = (/** @type {Point} */ p) => toWorld(store.get().view, size(), p);
  const zoom = (/** @type {Point} */ p, /** @type {number} */ factor) =>
    store.set({ view: zoomed(store.get().view, size(), p, factor, store.get().photos) });
  const pan = (/** @type {Point} */ by) => store.set({ view: panned(store.get().view, by, store.get().photos) });

  /** @param {Point} p */
  function guideEnd(p) {
    const { guide, view } = store.get();
    return guide ? guide.findIndex((end) => distance(end, world(p)) * view.scale < 14) : -1;
  }

  stage.addEventListener("pointerdown", (event) => {
    if (event.target instanceof HTMLButtonElement) return;
    stage.setPointerCapture(event.pointerId);
    stage.focus({ preventScroll: true });
    const p = at(event);
    down.set(event.pointerId, p);
    if (held) window.clearTimeout(held.timer);
    if (down.size > 1) {
      held = { mode: "pinch", start: p, last: p, line: 0, index: 0, timer: 0 };
      return;
    }
    const place = photoAt(world(p), store.get().photos);
    const end = guideEnd(p);
    const handle = place && !store.get().pending && !store.get().show.corrected ? picking.clickAt(place) : null;
    const mode = event.button === 1 ? "pan" : end >= 0 ? "guide" : handle ? "drag" : "click";
    const timer = event.pointerType === "touch" ? window.setTimeout(() => {
      if (held?.mode === "click") held.mode = "aim";
      store.set({ pointer: p });
    }, HOLD_MS) : 0;
    held = { mode, start: p, last: p, line: handle?.line ?? 0, index: end >= 0 ? end : handle?.index ?? 0, timer };
  });

  stage.addEventListener("pointermove", (event) => {
    const p = at(event);
    if (held?.mode === "pinch") {
      pinched(event.pointerId, p);
      return;
    }
    if (event.pointerType !== "touch" || held?.mode === "aim") {
      store.set({ pointer: p, hovered: held ? null : picking.offered(world(p), event.altKey) });
    }
    if (held && down.has(event.pointerId)) pulled(held, p);
  });

  /**
   * @param {NonNullable<typeof held>} what
   * @param {Point} p
   */
  function pulled(what, p) {
    if (what.mode === "click" && distance(p, what.start) > STILL) what.mode = "pan";
    if (what.mode === "pan") pan([p[0] - what.last[0], p[1] - what.last[1]]);
    if (what.mode === "guide") {
      const guide = /** @type {[Point, Point]} */ ([.../** @type {[Point, Point]} */ (store.get().guide)]);
      guide[what.index] = world(p);
      store.set({ guide });
    }
    if (what.mode === "drag" && (store.get().dragged || distance(p, what.start) > STILL)) {
      const place = photoAt(world(p), store.get().photos);
      if (place) store.set({ selected: what.line, click: what.index,
        dragged: { line: what.line, index: what.index, to: place.point } });
    }
    what.last = p;
  }

  /**
   * @param {number} id
   * @param {Point} p
   */
  function pinched(id, p) {
    const [other] = [...down].filter(([each]) => each !== id).map(([, q]) => q);
    const before = down.get(id);
    down.set(id, p);
    if (!other || !before) return;
    /** @type {Point} */
    const middle = [(p[0] + other[0]) / 2, (p[1] + other[1]) / 2];
    pan([(p[0] - before[0]) / 2, (p[1] - before[1]) / 2]);
    zoom(middle, Math.max(distance(p, other), 1) / Math.max(distance(before, other), 1));
  }

  /** @param {PointerEvent} event */
  function up(event) {
    down.delete(event.pointerId);
    if (!held) return;
    const { mode } = held;
    window.clearTimeout(held.timer);
    if (mode === "pinch" && down.size) return;
    held = null;
    if (event.type === "pointercancel") {
      store.set({ dragged: null });
      return;
    }
    const { dragged } = store.get();
    if (mode === "drag" && dragged) void picking.move(dragged);
    else if (mode === "click" || mode === "aim" || mode === "drag") {
      store.set({ pointer: at(event) });
      void picking.click(world(at(event)), { alt: event.altKey, shift: event.shiftKey });
    }
    if (event.pointerType === "touch") store.set({ pointer: null });
  }
  stage.addEventListener("pointerup", up);
  stage.addEventListener("pointercancel", up);
  stage.addEventListener("pointerleave", () => {
    if (!held) store.set({ pointer: null, hovered: null });
  });
  stage.addEventListener("dblclick", () => void picking.complete());
  stage.addEventListener("contextmenu", (event) => {
    event.preventDefault();
    void picking.complete();
  });

  stage.addEventListener("wheel", (event) => {
    event.preventDefault();
    const scroll = !event.ctrlKey && event.deltaMode === 0
      && (event.deltaX !== 0 || Math.abs(event.deltaY) < FINE);
    const lines = event.deltaMode === 1 ? 33 : 1;
    if (scroll || event.shiftKey) pan([-event.deltaX - (event.shiftKey ? event.deltaY : 0), event.shiftKey ? 0 : -event.deltaY]);
    else zoom(at(event), (event.ctrlKey ? PER_PINCH : PER_NOTCH) ** (-event.deltaY * lines));
  }, { passive: false });
}

/** @file Words over the stage: reasons at the pointer, what is not saved, who may pick. */

import { find, make } from "./dom.js";
import { sentence } from "./panel.js";

/** @typedef {import("./store.js").Store} Store */
/** @typedef {import("./server.js").Server} Server */
/** @typedef {import("./types.js").State} State */

/**
 * @param {Store} store
 * @param {Server} server
 */
export function createStatus(store, server) {
  const reason = find("reason", HTMLElement);
  const banner = find("banner", HTMLElement);
  const spoken = find("spoken", HTMLElement);
  const stage = find("stage", HTMLElement);
  const take = make("button", { type: "button" }, "Pick here");
  take.addEventListener("click", () => void server.take());

  store.subscribe((state, before) => {
    if (state.reason !== before.reason) showReason(state);
    banner.replaceChildren(...bannerOf(state, take));
    banner.hidden = !banner.childNodes.length;
    stage.classList.toggle("waiting", state.waiting > 0);
    stage.classList.toggle("taking", state.hovered !== null);
    find("mode", HTMLElement).textContent = modeOf(state);
    if (state.lines !== before.lines || state.fit !== before.fit || state.judgement !== before.judgement) say(speak(state));
  });

  /** @param {string} text A screen reader reads it again only where it changes. */
  function say(text) {
    if (spoken.textContent !== text) spoken.textContent = text;
  }

  /** @param {State} state */
  function showReason({ reason: told }) {
    reason.hidden = !told;
    if (!told) return;
    reason.textContent = sentence(told.text);
    const left = Math.min(told.x + 16, stage.clientWidth - reason.offsetWidth - 8);
    const top = Math.min(told.y + 16, stage.clientHeight - reason.offsetHeight - 8);
    reason.style.transform = `translate(${Math.max(8, left)}px, ${Math.max(8, top)}px)`;
  }
}

/**
 * @param {State} state
 * @param {HTMLElement} take
 * @returns {(Node | string)[]}
 */
function bannerOf(state, take) {
  if (!state.online) return ["plumbline does not answer: it was stopped. What was picked is saved; start it again."];
  if (!state.holds) return ["These picks are open on another page. ", take];
  if (state.unsaved) return [sentence(state.unsaved)];
  if (state.trouble) return [sentence(state.trouble)];
  return [];
}

/** @param {State} state */
function modeOf(state) {
  if (state.show.corrected) return "corrected photo: C goes back to picking";
  if (state.hovered !== null) return "click takes this edge; Shift and a click rejects it";
  if (!state.pending) return state.snapping && !state.free ? "click near one end of an edge" : "free picks: click along an edge";
  if (state.pending.snap) return "click near its other end";
  return `${state.pending.clicks.length} picks: Enter ends the line`;
}

/** @param {State} state */
function speak({ lines, fit, judgement, revision }) {
  const count = `${lines.length} line${lines.length === 1 ? "" : "s"}`;
  if (fit.failure) return `${count}. ${fit.failure}`;
  return `${count}. ${fit.finding}.${judgement.revision === revision ? ` Error to quote ${judgement.quote}` : ""}`;
}

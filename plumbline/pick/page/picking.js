/** @file What clicks and drags on the photo mean: picking, selecting, extending, moving. */

import { photoAt } from "./camera.js";
import { continues, distance, distanceTo, ends, inOrder } from "./geometry.js";

/** @typedef {import("./types.js").State} State */
/** @typedef {import("./types.js").Point} Point */
/** @typedef {import("./types.js").Line} Line */
/** @typedef {import("./store.js").Store} Store */
/** @typedef {import("./server.js").Server} Server */
/** @typedef {{photo: number, point: Point}} Place */

const NEAR = 8; // screen pixels within which something is meant
const ON = 5; // screen pixels within which a proposal is meant, fewer so that one can pick beside it
const TWICE = 3; // screen pixels within which a click is the second of a double click
const SLACK = 14; // screen pixels off its way that still continue a line that was clicked
const BEYOND = 24; // screen pixels beyond its end from which a line goes on without being clicked

/**
 * @param {Store} store
 * @param {Server} server
 */
export function createPicking(store, server) {
  /** @returns {number} Photo pixels of so many screen pixels. */
  const inPhoto = (/** @type {number} */ screen) => screen / store.get().view.scale;

  /** @param {Place} place */
  function lineAt({ photo, point }) {
    const { lines } = store.get();
    const near = lines.filter((line) => line.photo === photo)
      .map((line) => ({ line, away: distanceTo(point, inOrder(line.points)) }))
      .filter(({ away }) => away <= inPhoto(NEAR));
    return near.sort((a, b) => a.away - b.away)[0]?.line ?? null;
  }

  /**
   * The proposal that a click would answer: none where it would do something to a line.
   *
   * @param {Place} place
   * @param {boolean} free
   */
  function proposalAt(place, free) {
    const { proposals, show, selected, lines } = store.get();
    const { photo, point } = place;
    const chosen = lines.find((line) => line.number === selected && line.photo === photo);
    if (free || clickAt(place) || lineAt(place) || (chosen && goesOn(chosen, place))) return null;
    const near = (show.proposals ? proposals : []).filter((each) => each.photo === photo)
      .map((each) => ({ each, away: distanceTo(point, each.points) }))
      .filter(({ away }) => away <= inPhoto(ON));
    return near.sort((a, b) => a.away - b.away)[0]?.each ?? null;
  }

  /**
   * The click of a line at a place; those of the selected line come first.
   *
   * @param {Place} place
   */
  function clickAt({ photo, point }) {
    const { lines, selected } = store.get();
    const mine = lines.filter((line) => line.photo === photo)
      .sort((a, b) => Number(b.number === selected) - Number(a.number === selected));
    for (const line of mine) {
      const index = line.clicks.findIndex((click) => distance(click, point) <= inPhoto(NEAR));
      if (index >= 0) return { line: line.number, index };
    }
    return null;
  }

  /**
   * The first click of a line. One that falls on another line selects that too: the next click
   * then extends it or, off its way, ends a new line that crosses it.
   *
   * @param {Place} place
   * @param {boolean} free
   */
  function beginAt(place, free) {
    const handle = clickAt(place);
    const on = handle?.line ?? lineAt(place)?.number ?? null;
    const snap = store.get().snapping && !free;
    store.set({ pending: { photo: place.photo, clicks: [place.point], snap, on }, selected: on,
      click: handle?.index ?? null, reason: null });
  }

  /**
   * Take a proposal, or reject it.
   *
   * @param {number} proposal
   * @param {Place} place
   * @param {boolean} rejecting
   */
  async function answer(proposal, { point }, rejecting) {
    const told = await server.act(rejecting ? { do: "reject", proposal } : { do: "accept", proposals: [proposal] });
    store.set({ hovered: null, taken: told && !rejecting ? { line: told.selected, at: point } : null });
  }

  /**
   * Whether a click is the second of somebody who clicks both ends of an edge, of which the first
   * took the edge as it was proposed.
   *
   * @param {Line} line
   * @param {Place} place
   * @param {State["taken"]} taken
   */
  function repeats(line, { point }, taken) {
    if (taken?.line !== line.number) return false;
    const far = distance(point, taken.at) > distance(...ends(line.points)) / 2;
    return far && distanceTo(point, inOrder(line.points)) <= inPhoto(SLACK);
  }

  /**
   * @param {Line} line
   * @param {Place} place
   */
  function extend(line, { point }) {
    return server.act({ do: "extend", line: line.number, click: point });
  }

  /**
   * Whether a click well beyond a line's end goes on with it.
   *
   * @param {Line} line
   * @param {Place} place
   */
  function goesOn(line, { point }) {
    const far = Math.min(...line.points.map((each) => distance(each, point)));
    return far > inPhoto(BEYOND) && distanceTo(point, inOrder(line.points)) === far
      && continues(point, line.points, inPhoto(NEAR));
  }

  /**
   * One more click of the line that is being drawn; a traced line is complete with two.
   *
   * @param {Place} place
   * @param {boolean} free
   */
  async function goOn({ photo, point }, free) {
    const { pending } = store.get();
    if (!pending || photo !== pending.photo) return;
    if (distance(point, pending.clicks[pending.clicks.length - 1]) < inPhoto(TWICE)) return;
    const snap = pending.snap && !free;
    const clicks = [...pending.clicks, point];
    store.set({ pending: { ...pending, clicks, snap } });
    if (snap && clicks.length >= 2) await complete();
  }

  /**
   * The next click of a line that is being drawn, or of the line that its first click fell on.
   *
   * @param {import("./types.js").Pending} pending
   * @param {Line | undefined} chosen
   * @param {Place} place
   * @param {boolean} free
   */
  async function goOnOrExtend(pending, chosen, place, free) {
    const onIt = chosen && pending.clicks.length === 1 && pending.on === chosen.number;
    if (!onIt || !continues(place.point, chosen.points, inPhoto(SLACK))) return goOn(place, free);
    store.set({ pending: null });
    await extend(chosen, place);
  }

  /** Give the line that is being drawn to the server. */
  async function complete() {
    const { pending } = store.get();
    if (!pending) return;
    const enough = pending.clicks.length >= (pending.snap ? 2 : 3);
    store.set({ pending: null });
    if (!enough) return;
    const told = await server.act({ do: "draw", photo: pending.photo, clicks: pending.clicks, snap: pending.snap });
    // Where no edge was found the clicks stay: one more may tell which edge is meant.
    if (!told?.refusal || store.get().pending) return;
    const { reason } = store.get();
    store.set({ pending, reason: reason && { ...reason, text: `${reason.text}. One more click along it may tell; Esc gives up` } });
  }

  return {
    complete,
    clickAt,

    /**
     * The number of the proposal that a click would take.
     *
     * @param {Point} world
     * @param {boolean} alt
     */
    offered(world, alt) {
      const state = store.get();
      const place = photoAt(world, state.photos);
      if (!place || state.pending || state.show.corrected) return null;
      return proposalAt(place, alt !== state.free)?.number ?? null;
    },

    /**
     * @param {Point} world
     * @param {{alt?: boolean, shift?: boolean, add?: boolean}} how Add: to the selected line, whatever is there.
     */
    async click(world, { alt = false, shift = false, add = false }) {
      const state = store.get();
      const place = photoAt(world, state.photos);
      const free = alt !== state.free;
      if (state.show.corrected || !place) {
        store.set({ selected: null, click: null, reason: null });
        return;
      }
      const chosen = state.lines.find((line) => line.number === state.selected && line.photo === place.photo);
      store.set({ taken: null });
      if (state.pending) return goOnOrExtend(state.pending, chosen, place, free);
      const proposal = add ? null : proposalAt(place, free);
      if (proposal) return answer(proposal.number, place, shift);
      if (chosen && (shift || add || goesOn(chosen, place))) return extend(chosen, place);
      if (!chosen || !repeats(chosen, place, state.taken)) beginAt(place, free);
    },

    /**
     * @param {{line: number, index: number, to: Point}} moved
     */
    async move({ line, index, to }) {
      await server.act({ do: "move", line, index, to });
      store.set({ dragged: null });
    },

    /** Delete what is selected: a click, else a line. */
    async remove() {
      const { selected, click, lines } = store.get();
      if (selected === null || !lines.some((line) => line.number === selected)) return;
      store.set({ pending: null, click: null });
      await server.act({ do: "remove", line: selected, index: click });
    },

    /** Take back the last click of the line that is being drawn; whether there was one. */
    unclick() {
      const { pending } = store.get();
      if (!pending) return false;
      const clicks = pending.clicks.slice(0, -1);
      store.set({ pending: clicks.length ? { ...pending, clicks } : null });
      return true;
    },
  };
}

/** @typedef {ReturnType<typeof createPicking>} Picking */

/** @file The stage: draws the photos and what is picked whenever something changed. */

import { matrix, toWorld } from "./camera.js";
import { paintLoupe, paintStrip, prepared } from "./closeups.js";
import { find, px } from "./dom.js";
import { paintMap } from "./errormap.js";
import { apply, distance } from "./geometry.js";
import { paint, paintGuide } from "./paint.js";
import { penFor } from "./pen.js";
import { Tiles } from "./tiles.js";

/** @typedef {import("./store.js").Store} Store */
/** @typedef {import("./types.js").State} State */

/** @param {Store} store */
export function createStage(store) {
  const stage = find("stage", HTMLElement);
  const photoCanvas = find("photo", HTMLCanvasElement);
  const overlay = find("overlay", HTMLCanvasElement);
  const loupe = find("loupe", HTMLCanvasElement);
  const strip = find("strip", HTMLCanvasElement);
  let [photoStale, overlayStale, asked] = [true, true, false];
  const tiles = new Tiles(() => {
    photoStale = true;
    overlayStale = true;
    ask();
  });
  const size = () => ({ width: stage.clientWidth, height: stage.clientHeight });

  function ask() {
    if (asked) return;
    asked = true;
    requestAnimationFrame(() => {
      asked = false;
      draw(store.get());
    });
  }

  /** @param {State} state */
  function draw(state) {
    if (!state.photos.length) return;
    if (photoStale) drawPhotos(state);
    if (overlayStale) {
      drawOverlay(state);
      paintLoupe(loupe, state, size(), tiles);
      find("strip-note", HTMLElement).textContent = paintStrip(strip, state, size(), tiles);
    }
    photoStale = overlayStale = false;
    const { x, y, scale } = state.view;
    Object.assign(stage.dataset, { drawn: String(state.revision), view: `${x} ${y} ${scale}`,
      ready: state.ready ? "yes" : "no", proposed: String(state.proposals.length), judged: String(state.judgement.revision ?? "") });
    stage.dataset.settled = String(tiles.settled);
  }

  /** @param {State} state */
  function drawPhotos(state) {
    const { context, ratio, size: canvas } = prepared(photoCanvas);
    const m = matrix(state.view, size(), ratio);
    const query = state.show.corrected ? `?corrected=${state.revision}` : "";
    state.photos.forEach((photo, index) => {
      tiles.draw(context, m, canvas, photo, index, query);
      const { map } = state.judgement;
      if (state.show.map && map && map.size[0] === photo.width && map.size[1] === photo.height) {
        paintMap(context, map, state.settings.goal_px, apply(m, [photo.x - 0.5, -0.5]),
          apply(m, [photo.x + photo.width - 0.5, photo.height - 0.5]));
      }
    });
  }

  /** @param {State} state */
  function drawOverlay(state) {
    const { context, ratio } = prepared(overlay);
    const m = matrix(state.view, size(), ratio);
    const pen = penFor(context, state, m, ratio);
    paint(pen, state);
    if (state.guide) paintGuide(pen, [apply(m, state.guide[0]), apply(m, state.guide[1])]);
    find("view-note", HTMLElement).textContent = noteOf(state);
  }

  /** @param {State} state */
  function noteOf({ guide, show, settings, judgement }) {
    const goal = settings.goal_px;
    return [guide ? `guide: ${px(distance(...guide))} long` : "",
      show.map && judgement.map && !show.corrected ? `error: dark ${px(goal / 2)} or less, yellow ${px(goal * 4)} or more` : "",
    ].filter(Boolean).join("; ");
  }

  store.subscribe((state, before) => {
    if (state === before) return;
    const corrected = state.show.corrected && state.revision !== before.revision;
    if (corrected || state.show.corrected !== before.show.corrected) tiles.forgetCorrected();
    photoStale ||= state.view !== before.view || state.photos !== before.photos
      || state.show !== before.show || state.judgement !== before.judgement || corrected
      || state.settings !== before.settings;
    overlayStale = true;
    ask();
  });
  new ResizeObserver(() => {
    photoStale = overlayStale = true;
    ask();
  }).observe(stage);

  return { element: stage, size, world: (/** @type {[number, number]} */ at) => toWorld(store.get().view, size(), at) };
}

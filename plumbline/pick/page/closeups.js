/** @file Two close views: a loupe at the pointer, and a strip stretched across a line. */

import { photoAt, toWorld } from "./camera.js";
import { apply, distance, ends, inOrder } from "./geometry.js";
import { COLOURS, dot, trail } from "./pen.js";

/** @typedef {import("./types.js").State} State */
/** @typedef {import("./types.js").Point} Point */
/** @typedef {import("./types.js").Matrix} Matrix */
/** @typedef {import("./tiles.js").Tiles} Tiles */
/** @typedef {{width: number, height: number}} Size */

const MAGNIFIED = 8;
const AWAY = 28; // screen pixels from the pointer to the loupe
const CLEAR = 12; // screen pixels about the loupe's centre that no mark covers
const TICK = 14;
const ROOM = 6; // photo pixels beside the bend that a strip shows at least
const STEEPEST = 24; // times that a strip stretches at most

/**
 * Draw the loupe, and put it beside the pointer.
 *
 * @param {HTMLCanvasElement} canvas
 * @param {State} state
 * @param {Size} stage
 * @param {Tiles} tiles
 */
export function paintLoupe(canvas, state, stage, tiles) {
  const at = state.pointer && photoAt(toWorld(state.view, stage, state.pointer), state.photos);
  const wanted = state.show.loupe && !state.show.corrected && at && state.view.scale < MAGNIFIED;
  canvas.hidden = !wanted;
  if (!wanted || !state.pointer) return;
  const { context, ratio, size } = prepared(canvas);
  const scale = MAGNIFIED * ratio;
  const photo = state.photos[at.photo];
  const [cx, cy] = [at.point[0] + photo.x, at.point[1]];
  /** @type {Matrix} */
  const m = [scale, 0, 0, scale, size.width / 2 - cx * scale, size.height / 2 - cy * scale];
  tiles.draw(context, m, size, photo, at.photo, "");
  paintCross(context, size, ratio, edgeDirection(context, size));
  beside(canvas, state.pointer, stage);
}

/**
 * Four ticks that leave the centre free and stand beside the edge that runs through it.
 *
 * @param {CanvasRenderingContext2D} context
 * @param {Size} size
 * @param {number} ratio
 * @param {number} direction Of the edge, in radians.
 */
function paintCross(context, size, ratio, direction) {
  context.save();
  context.translate(size.width / 2, size.height / 2);
  context.rotate(direction);
  for (const [width, colour] of /** @type {[number, string][]} */ ([[4, COLOURS.casing], [1.5, "#fff"]])) {
    context.lineWidth = width * ratio;
    context.strokeStyle = colour;
    context.beginPath();
    for (const side of [-1, 1]) {
      context.moveTo(0, side * CLEAR * ratio);
      context.lineTo(0, side * (CLEAR + TICK) * ratio);
      for (const end of [-1, 1]) {
        context.moveTo(end * CLEAR * ratio, side * CLEAR * ratio);
        context.lineTo(end * (CLEAR + TICK) * ratio, side * CLEAR * ratio);
      }
    }
    context.stroke();
  }
  context.restore();
}

/**
 * The direction of the edge in the middle of a canvas, by the structure tensor of its grey values
 * (Förstner and Gülch 1987).
 *
 * @param {CanvasRenderingContext2D} context
 * @param {Size} size
 */
function edgeDirection(context, size) {
  const side = Math.round(Math.min(size.width, size.height) / 2);
  const data = context.getImageData(Math.round((size.width - side) / 2),
    Math.round((size.height - side) / 2), side, side).data;
  const step = 4;
  let [xx, xy, yy] = [0, 0, 0];
  for (let y = step; y < side - step; y += step) {
    for (let x = step; x < side - step; x += step) {
      const green = (/** @type {number} */ dx, /** @type {number} */ dy) => data[4 * ((y + dy) * side + x + dx) + 1];
      const [gx, gy] = [green(step, 0) - green(-step, 0), green(0, step) - green(0, -step)];
      xx += gx * gx;
      xy += gx * gy;
      yy += gy * gy;
    }
  }
  return 0.5 * Math.atan2(2 * xy, xx - yy) + Math.PI / 2;
}

/**
 * @param {HTMLCanvasElement} canvas
 * @param {Point} pointer
 * @param {Size} stage
 */
function beside(canvas, [x, y], stage) {
  const [w, h] = [canvas.clientWidth, canvas.clientHeight];
  const left = x + AWAY + w < stage.width ? x + AWAY : x - AWAY - w;
  const top = y + AWAY + h < stage.height ? y + AWAY : y - AWAY - h;
  canvas.style.transform = `translate(${Math.max(0, left)}px, ${Math.max(0, top)}px)`;
}

/**
 * Draw the strip along the selected line, or along the one that is being drawn.
 *
 * @param {HTMLCanvasElement} canvas
 * @param {State} state
 * @param {Size} stage
 * @param {Tiles} tiles
 * @returns {string} What the strip shows, in words; empty where there is none.
 */
export function paintStrip(canvas, state, stage, tiles) {
  const shown = state.show.strip && !state.show.corrected ? strip(state, stage) : null;
  canvas.hidden = !shown;
  if (!shown) return "";
  const { context, ratio, size } = prepared(canvas);
  const photo = state.photos[shown.photo];
  const [p, q] = ends(shown.points);
  const length = Math.max(distance(p, q), 1);
  const [ux, uy] = [(q[0] - p[0]) / length, (q[1] - p[1]) / length];
  const away = shown.points.map(([x, y]) => (y - p[1]) * ux - (x - p[0]) * uy);
  const [low, high] = [Math.min(...away, 0), Math.max(...away, 0)];
  const along = (size.width - 24 * ratio) / length;
  const across = Math.min(size.height / (high - low + 2 * ROOM), STEEPEST * ratio);
  const middle = (low + high) / 2;
  const [x0, y0] = [p[0] + photo.x, p[1]];
  /** @type {Matrix} */
  const m = [along * ux, -across * uy, along * uy, across * ux,
    12 * ratio - along * (ux * x0 + uy * y0),
    size.height / 2 - across * (middle + ux * y0 - uy * x0)];
  tiles.draw(context, m, size, photo, shown.photo, "");
  const pen = { context, ratio, place: (/** @type {number} */ _, /** @type {Point} */ [x, y]) => apply(m, [x + photo.x, y]) };
  trail(pen, shown.photo, [p, q], "#ffffff", 0.75, [6, 5]);
  if (shown.curve) trail(pen, shown.photo, shown.curve, COLOURS.selected, 1, []);
  for (const point of shown.points) dot(pen, pen.place(0, point), COLOURS.selected, 1.75);
  return `stretched ${(across / along).toFixed(across > 3 * along ? 0 : 1)} × across`;
}

/**
 * @param {State} state
 * @param {Size} stage
 * @returns {{photo: number, points: Point[], curve?: Point[]} | null}
 */
function strip(state, stage) {
  if (state.pending && state.pointer) {
    const at = photoAt(toWorld(state.view, stage, state.pointer), state.photos);
    if (at?.photo !== state.pending.photo) return null;
    return { photo: at.photo, points: [...state.pending.clicks, at.point] };
  }
  const line = state.lines.find((each) => each.number === state.selected);
  if (!line || line.points.length < 2) return null;
  const fitted = state.fit.lines?.find((each) => each.number === line.number);
  const curve = fitted?.curve.every(([x]) => x !== null) ? fitted.curve : undefined;
  return { photo: line.photo, points: inOrder(line.points), curve };
}

/**
 * A canvas as large as it is shown, empty.
 *
 * @param {HTMLCanvasElement} canvas
 */
export function prepared(canvas) {
  const ratio = window.devicePixelRatio || 1;
  const [width, height] = [Math.round(canvas.clientWidth * ratio), Math.round(canvas.clientHeight * ratio)];
  if (canvas.width !== width || canvas.height !== height) Object.assign(canvas, { width, height });
  const context = /** @type {CanvasRenderingContext2D} */ (
    canvas.getContext("2d", { willReadFrequently: canvas.dataset.read === "yes" }));
  context.setTransform(1, 0, 0, 1, 0, 0);
  context.clearRect(0, 0, width, height);
  return { context, ratio, size: { width, height } };
}


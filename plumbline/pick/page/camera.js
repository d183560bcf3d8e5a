/** @file Where one looks: from the world to the screen, zooming and panning. */

import { apply, inverse } from "./geometry.js";

/** @typedef {import("./types.js").View} View */
/** @typedef {import("./types.js").Photo} Photo */
/** @typedef {import("./types.js").Point} Point */
/** @typedef {import("./types.js").Matrix} Matrix */
/** @typedef {{width: number, height: number}} Size */

const CLOSEST = 64; // screen pixels of one photo pixel: a tenth of it can be aimed at
const MARGIN = 0.96; // of the stage that photos fill when all are shown

/**
 * @param {View} view
 * @param {Size} stage
 * @param {number} [ratio] Device pixels of one screen pixel.
 * @returns {Matrix}
 */
export function matrix(view, stage, ratio = 1) {
  const scale = view.scale * ratio;
  return [scale, 0, 0, scale,
    (stage.width / 2) * ratio - view.x * scale, (stage.height / 2) * ratio - view.y * scale];
}

/**
 * @param {View} view
 * @param {Size} stage
 * @param {Point} at On the screen.
 * @returns {Point}
 */
export function toWorld(view, stage, at) {
  return apply(inverse(matrix(view, stage)), at);
}

/**
 * All photos, above what covers the foot of the stage.
 *
 * @param {readonly Photo[]} photos
 * @param {Size} stage
 * @param {number} [covered] Screen pixels.
 * @returns {View}
 */
export function whole(photos, stage, covered = 0) {
  const last = photos[photos.length - 1];
  const width = last ? last.x + last.width : 1;
  const height = Math.max(1, ...photos.map((photo) => photo.height));
  const scale = MARGIN * Math.min(stage.width / width, (stage.height - covered) / height);
  return { x: (width - 1) / 2, y: (height - 1) / 2 + covered / 2 / scale, scale };
}

/**
 * Zoom about a place of the screen, which stays where it is.
 *
 * @param {View} view
 * @param {Size} stage
 * @param {Point} at
 * @param {number} factor
 * @param {readonly Photo[]} photos
 * @returns {View}
 */
export function zoomed(view, stage, at, factor, photos) {
  const farthest = whole(photos, stage).scale / 2;
  const scale = Math.min(Math.max(view.scale * factor, farthest), CLOSEST);
  const [x, y] = toWorld(view, stage, at);
  return kept({
    x: x - (at[0] - stage.width / 2) / scale, y: y - (at[1] - stage.height / 2) / scale, scale,
  }, photos);
}

/**
 * @param {View} view
 * @param {Point} by In screen pixels.
 * @param {readonly Photo[]} photos
 * @returns {View}
 */
export function panned(view, [dx, dy], photos) {
  return kept({ ...view, x: view.x - dx / view.scale, y: view.y - dy / view.scale }, photos);
}

/**
 * The centre of the view never leaves the photos.
 *
 * @param {View} view
 * @param {readonly Photo[]} photos
 * @returns {View}
 */
function kept(view, photos) {
  const last = photos[photos.length - 1];
  if (!last) return view;
  const height = Math.max(...photos.map((photo) => photo.height));
  return { ...view, x: Math.min(Math.max(view.x, 0), last.x + last.width),
    y: Math.min(Math.max(view.y, 0), height) };
}

/**
 * The photo at a place of the world, and the place in its own pixels.
 *
 * @param {Point} world
 * @param {readonly Photo[]} photos
 * @returns {{photo: number, point: Point} | null}
 */
export function photoAt([x, y], photos) {
  const photo = photos.findIndex((each) => x >= each.x - 0.5 && x <= each.x + each.width - 0.5
    && y >= -0.5 && y <= each.height - 0.5);
  return photo < 0 ? null : { photo, point: [x - photos[photo].x, y] };
}

/** @file Tiles of the photos: fetched when seen, kept as long as there is room, drawn anywhere. */

import { apply, inverse } from "./geometry.js";

/** @typedef {import("./types.js").Photo} Photo */
/** @typedef {import("./types.js").Point} Point */
/** @typedef {import("./types.js").Matrix} Matrix */
/** @typedef {{width: number, height: number}} Size */

const SIDE = 512; // as the server has it
const MOST = 160; // tiles of 1 MiB each, more than two screens at 4K show
const AT_ONCE = 6; // requests, as many as browsers make of one server
const SHARP = 4; // device pixels of a photo pixel from which pixels are shown as squares

export class Tiles {
  /** @param {() => void} arrived Called when there is something new to draw. */
  constructor(arrived) {
    /** @type {Map<string, HTMLImageElement | null>} Null while on its way; last used last. */
    this.kept = new Map();
    /** @type {string[]} What was wanted last is fetched first. */
    this.wanted = [];
    this.busy = 0;
    this.arrived = arrived;
  }

  /** Whether all that was wanted has come. */
  get settled() {
    return !this.busy && !this.wanted.length;
  }

  /**
   * Draw what of a photo falls on a canvas.
   *
   * @param {CanvasRenderingContext2D} context
   * @param {Matrix} m From the world to the canvas.
   * @param {Size} size Of the canvas.
   * @param {Photo} photo
   * @param {number} index The photo's number.
   * @param {string} query What to ask for beside the tile: nothing, or the corrected photo.
   */
  draw(context, m, size, photo, index, query) {
    const scale = Math.max(Math.hypot(m[0], m[1]), Math.hypot(m[2], m[3]));
    const level = Math.min(Math.max(Math.floor(Math.log2(1 / scale) + 0.25), 0), photo.levels - 1);
    context.save();
    context.setTransform(...m);
    context.imageSmoothingEnabled = scale < SHARP;
    const box = visible(m, size, photo);
    for (const [column, row] of tilesIn(box, photo, level)) {
      this.place(context, photo, index, level, column, row, query);
    }
    context.restore();
  }

  /**
   * Draw one tile, or the same part of the photo from a coarser one until it comes.
   *
   * @param {CanvasRenderingContext2D} context
   * @param {Photo} photo
   * @param {number} index
   * @param {number} level
   * @param {number} column
   * @param {number} row
   * @param {string} query
   */
  place(context, photo, index, level, column, row, query) {
    const box = tileBox(photo, level, column, row);
    for (let up = level; up < photo.levels; up++) {
      const shift = up - level;
      const [c, r] = [column >> shift, row >> shift];
      const image = this.image(`tiles/${index}/${up}/${c}/${r}${query}`, up === level || up === photo.levels - 1);
      if (!image) continue;
      const from = tileBox(photo, up, c, r);
      const [sx, sy] = [image.naturalWidth / from.width, image.naturalHeight / from.height];
      context.drawImage(image, (box.x - from.x) * sx, (box.y - from.y) * sy, box.width * sx,
        box.height * sy, photo.x + box.x - 0.5, box.y - 0.5, box.width, box.height);
      return;
    }
  }

  /**
   * @param {string} path
   * @param {boolean} fetching Whether to ask for it.
   * @returns {HTMLImageElement | null}
   */
  image(path, fetching) {
    const found = this.kept.get(path);
    if (found) {
      this.kept.delete(path);
      this.kept.set(path, found);
      return found;
    }
    if (fetching && found === undefined && !this.wanted.includes(path)) {
      this.wanted.push(path);
      this.fetch();
    }
    return null;
  }

  fetch() {
    while (this.busy < AT_ONCE && this.wanted.length) {
      const path = /** @type {string} */ (this.wanted.pop());
      this.busy++;
      this.kept.set(path, null);
      const image = new Image();
      image.onload = () => this.came(path, image);
      image.onerror = () => this.came(path, null);
      image.src = path;
    }
    if (this.wanted.length > MOST) this.wanted.splice(0, this.wanted.length - MOST);
  }

  /**
   * @param {string} path
   * @param {HTMLImageElement | null} image
   */
  came(path, image) {
    this.busy--;
    this.kept.delete(path);
    if (image) this.kept.set(path, image);
    for (const old of this.kept.keys()) {
      if (this.kept.size <= MOST) break;
      if (this.kept.get(old)) this.kept.delete(old);
    }
    this.fetch();
    this.arrived();
  }

  /** Forget corrected tiles: they are of an older lens. */
  forgetCorrected() {
    for (const path of [...this.kept.keys()]) {
      if (path.includes("?") && this.kept.get(path)) this.kept.delete(path);
    }
    this.wanted = this.wanted.filter((path) => !path.includes("?"));
  }
}

/**
 * The part of a photo that a canvas shows, in its own pixels.
 *
 * @param {Matrix} m
 * @param {Size} size
 * @param {Photo} photo
 */
function visible(m, size, photo) {
  const back = inverse(m);
  /** @type {Point[]} */
  const corners = [[0, 0], [size.width, 0], [0, size.height], [size.width, size.height]];
  const world = corners.map((corner) => apply(back, corner));
  const xs = world.map(([x]) => x - photo.x + 0.5);
  const ys = world.map(([, y]) => y + 0.5);
  return { left: Math.max(0, Math.min(...xs)), top: Math.max(0, Math.min(...ys)),
    right: Math.min(photo.width, Math.max(...xs)), bottom: Math.min(photo.height, Math.max(...ys)) };
}

/**
 * @param {{left: number, top: number, right: number, bottom: number}} box
 * @param {Photo} photo
 * @param {number} level
 * @returns {Generator<[number, number]>}
 */
function* tilesIn(box, photo, level) {
  if (box.left >= box.right || box.top >= box.bottom) return;
  const [w, h] = levelSize(photo, level);
  const [sx, sy] = [photo.width / w, photo.height / h];
  const [lastColumn, lastRow] = [Math.ceil(w / SIDE) - 1, Math.ceil(h / SIDE) - 1];
  const end = (/** @type {number} */ at, /** @type {number} */ s, /** @type {number} */ last) =>
    Math.min(Math.floor(at / s / SIDE), last);
  for (let row = end(box.top, sy, lastRow); row <= end(box.bottom, sy, lastRow); row++) {
    for (let column = end(box.left, sx, lastColumn); column <= end(box.right, sx, lastColumn); column++) {
      yield [column, row];
    }
  }
}

/**
 * @param {Photo} photo
 * @param {number} level
 * @returns {[number, number]}
 */
function levelSize(photo, level) {
  return [Math.ceil(photo.width / 2 ** level), Math.ceil(photo.height / 2 ** level)];
}

/**
 * Where a tile lies in the photo, in its own pixels from the photo's edge.
 *
 * @param {Photo} photo
 * @param {number} level
 * @param {number} column
 * @param {number} row
 */
function tileBox(photo, level, column, row) {
  const [w, h] = levelSize(photo, level);
  const [sx, sy] = [photo.width / w, photo.height / h];
  const [x, y] = [column * SIDE, row * SIDE];
  return { x: x * sx, y: y * sy, width: Math.min(SIDE, w - x) * sx, height: Math.min(SIDE, h - y) * sy };
}

/** @file The pen that draws on canvases: strokes and dots that stand out from any photo. */

import { apply } from "./geometry.js";

/** @typedef {import("./types.js").State} State */
/** @typedef {import("./types.js").Point} Point */
/** @typedef {import("./types.js").Matrix} Matrix */

/** Colours that colour-blind readers tell apart (Okabe and Ito 2008), on a dark casing. */
export const COLOURS = {
  traced: "#56b4e9", free: "#e69f00", selected: "#f0e442", suspect: "#d55e00", next: "#00c896",
  proposal: "#e8a0d0", guide: "#ffffff", casing: "rgb(0 0 0 / 60%)",
};

/**
 * What drawing needs: a canvas, and the way from a photo's pixels to its device pixels.
 *
 * @typedef {object} Pen
 * @property {CanvasRenderingContext2D} context
 * @property {(photo: number, p: Point) => Point} place
 * @property {number} ratio Device pixels of one screen pixel.
 */

/**
 * @param {CanvasRenderingContext2D} context
 * @param {State} state
 * @param {Matrix} m From the world to device pixels.
 * @param {number} ratio
 * @returns {Pen}
 */
export function penFor(context, state, m, ratio) {
  return { context, ratio, place: (photo, [x, y]) => apply(m, [x + state.photos[photo].x, y]) };
}

/**
 * A polyline in a photo.
 *
 * @param {Pen} pen
 * @param {number} photo
 * @param {readonly Point[]} points
 * @param {string} colour
 * @param {number} width
 * @param {number[]} dashes
 */
export function trail(pen, photo, points, colour, width, dashes) {
  const { context, ratio } = pen;
  context.beginPath();
  points.forEach((point, index) => {
    const [x, y] = pen.place(photo, point);
    if (index) context.lineTo(x, y);
    else context.moveTo(x, y);
  });
  context.setLineDash(dashes.map((dash) => dash * ratio));
  cased(pen, colour, width * ratio);
  context.setLineDash([]);
}

/**
 * @param {Pen} pen
 * @param {Point} at
 * @param {string} colour
 * @param {number} radius
 */
export function dot({ context, ratio }, [x, y], colour, radius) {
  context.fillStyle = COLOURS.casing;
  context.beginPath();
  context.arc(x, y, (radius + 0.75) * ratio, 0, 2 * Math.PI);
  context.fill();
  context.fillStyle = colour;
  context.beginPath();
  context.arc(x, y, radius * ratio, 0, 2 * Math.PI);
  context.fill();
}

/**
 * @param {Pen} pen
 * @param {Point} at
 * @param {string} colour
 * @param {number} radius
 */
export function ring(pen, [x, y], colour, radius) {
  pen.context.beginPath();
  pen.context.arc(x, y, radius * pen.ratio, 0, 2 * Math.PI);
  cased(pen, colour, 1.75 * pen.ratio);
}

/**
 * Stroke the path with a dark casing, so that it stands out from any photo.
 *
 * @param {Pen} pen
 * @param {string} colour
 * @param {number} width
 */
export function cased({ context, ratio }, colour, width) {
  context.strokeStyle = COLOURS.casing;
  context.lineWidth = width + 1.5 * ratio;
  context.stroke();
  context.strokeStyle = colour;
  context.lineWidth = width;
  context.stroke();
}

/**
 * @param {Pen} pen
 * @param {Point} at
 * @param {string} text
 * @param {string} colour
 */
export function label({ context, ratio }, [x, y], text, colour) {
  context.font = `600 ${13 * ratio}px system-ui, sans-serif`;
  const width = context.measureText(text).width;
  const room = context.canvas.width - width - 16 * ratio;
  const [left, top] = [Math.max(4 * ratio, Math.min(x - width / 2 - 6 * ratio, room)), y - 12 * ratio];
  context.fillStyle = "rgb(0 0 0 / 75%)";
  context.fillRect(left, top, width + 12 * ratio, 24 * ratio);
  context.fillStyle = colour;
  context.textBaseline = "middle";
  context.fillText(text, left + 6 * ratio, top + 12 * ratio);
}

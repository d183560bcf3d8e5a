/** @file The map of what is still uncertain, as colours over a photo. */

/** @typedef {import("./types.js").ErrorMap} ErrorMap */
/** @typedef {import("./types.js").Point} Point */

/** Cividis, which colour-blind readers see alike (Nuñez, Anderton and Renslow 2018), in steps. */
const RAMP = [[0, 34, 78], [53, 69, 108], [102, 105, 112], [148, 142, 119], [198, 184, 99], [254, 232, 56]];

const OPACITY = 0.6;

/** @type {{map: ErrorMap, goal: number, canvas: OffscreenCanvas} | null} */
let last = null;

/**
 * Draw a map over a photo: dark where the error is below half the goal, bright from four times it.
 *
 * @param {CanvasRenderingContext2D} context
 * @param {ErrorMap} map
 * @param {number} goal In pixels.
 * @param {Point} from The photo's top left corner on the canvas.
 * @param {Point} to Its bottom right corner.
 */
export function paintMap(context, map, goal, from, to) {
  if (last?.map !== map || last.goal !== goal) last = { map, goal, canvas: coloured(map, goal) };
  // Values stand for the middles of cells that reach half a cell over the photo's edge.
  const [w, h] = [(to[0] - from[0]) / (map.columns - 1), (to[1] - from[1]) / (map.rows - 1)];
  context.save();
  context.beginPath();
  context.rect(from[0], from[1], to[0] - from[0], to[1] - from[1]);
  context.clip();
  context.globalAlpha = OPACITY;
  context.imageSmoothingQuality = "high";
  context.drawImage(last.canvas, from[0] - w / 2, from[1] - h / 2, w * map.columns, h * map.rows);
  context.restore();
}

/**
 * @param {ErrorMap} map
 * @param {number} goal
 */
function coloured(map, goal) {
  const canvas = new OffscreenCanvas(map.columns, map.rows);
  const context = /** @type {OffscreenCanvasRenderingContext2D} */ (canvas.getContext("2d"));
  const image = context.createImageData(map.columns, map.rows);
  map.values.forEach((value, index) => {
    image.data.set([...colour(Math.log2(value / goal / 0.5) / 3), 255], 4 * index);
  });
  context.putImageData(image, 0, 0);
  return canvas;
}

/**
 * @param {number} share 0 to 1.
 * @returns {number[]}
 */
function colour(share) {
  const at = Math.min(Math.max(share || 0, 0), 1) * (RAMP.length - 1);
  const i = Math.min(Math.floor(at), RAMP.length - 2);
  return RAMP[i].map((low, channel) => low + (RAMP[i + 1][channel] - low) * (at - i));
}

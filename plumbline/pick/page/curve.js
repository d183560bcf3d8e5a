/** @file The distortion curve: displacement over the distance from the centre. */

import { px, svg } from "./dom.js";

/** @typedef {import("./types.js").Fit} Fit */

const [WIDTH, HEIGHT, LEFT, BOTTOM, TOP] = [288, 132, 40, 20, 8];

/**
 * @param {NonNullable<Fit["radial"]>} radial
 * @returns {SVGElement}
 */
export function curveOf({ radius, shift, reached }) {
  const corner = radius[radius.length - 1] ?? 1;
  const [low, high] = range(shift);
  const x = (/** @type {number} */ r) => LEFT + (WIDTH - LEFT - 6) * (r / corner);
  const y = (/** @type {number} */ s) => TOP + (HEIGHT - TOP - BOTTOM) * ((high - s) / (high - low));
  const path = [[0, 0], ...radius.map((r, index) => [r, shift[index]])]
    .map(([r, s], index) => `${index ? "L" : "M"}${x(r).toFixed(1)} ${y(s).toFixed(1)}`).join("");
  const beyond = Math.min(reached, corner);
  const title = `Displacement outwards: ${px(shift[shift.length - 1] ?? 0)} at the corner`;
  return svg("svg", { viewBox: `0 0 ${WIDTH} ${HEIGHT}`, role: "img", "aria-label": title, class: "curve" },
    svg("title", {}, title),
    svg("rect", { x: x(beyond), y: TOP, width: x(corner) - x(beyond), height: HEIGHT - TOP - BOTTOM, class: "beyond" }),
    ...[low, 0, high].filter((s, i, all) => all.indexOf(s) === i).flatMap((s) => [
      svg("line", { x1: LEFT, x2: WIDTH - 6, y1: y(s), y2: y(s), class: s === 0 ? "axis" : "grid" }),
      svg("text", { x: LEFT - 5, y: y(s) + 4, "text-anchor": "end" }, s.toLocaleString("en")),
    ]),
    svg("path", { d: path, class: "line" }),
    svg("text", { x: LEFT, y: HEIGHT - 5 }, "centre"),
    svg("text", { x: WIDTH - 6, y: HEIGHT - 5, "text-anchor": "end" }, "corner"));
}

/**
 * Round bounds that hold all values and 0.
 *
 * @param {readonly number[]} values
 * @returns {[number, number]}
 */
function range(values) {
  const [low, high] = [Math.min(0, ...values), Math.max(0, ...values)];
  const step = 10 ** Math.floor(Math.log10(Math.max(high - low, 1e-3)));
  const unit = (high - low) / step > 4 ? step : step / 2;
  const round = (/** @type {number} */ v) => Number((Math.sign(v) * Math.ceil(Math.abs(v) / unit) * unit).toPrecision(3));
  return low === high ? [-1, 1] : [round(low), round(high)];
}

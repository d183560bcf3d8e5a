/** @file Points, polylines and affine matrices. */

/** @typedef {import("./types.js").Point} Point */
/** @typedef {import("./types.js").Matrix} Matrix */

/**
 * @param {Matrix} m
 * @param {Point} p
 * @returns {Point}
 */
export function apply(m, [x, y]) {
  return [m[0] * x + m[2] * y + m[4], m[1] * x + m[3] * y + m[5]];
}

/**
 * @param {Matrix} m
 * @returns {Matrix}
 */
export function inverse([a, b, c, d, e, f]) {
  const det = a * d - b * c;
  return [d / det, -b / det, -c / det, a / det, (c * f - d * e) / det, (b * e - a * f) / det];
}

/**
 * @param {Point} p
 * @param {Point} q
 */
export function distance(p, q) {
  return Math.hypot(p[0] - q[0], p[1] - q[1]);
}

/**
 * How far a point is from a polyline.
 *
 * @param {Point} p
 * @param {readonly Point[]} line
 */
export function distanceTo(p, line) {
  let least = line.length ? distance(p, line[0]) : Infinity;
  for (let i = 1; i < line.length; i++) {
    const [a, b] = [line[i - 1], line[i]];
    const length = distance(a, b) || 1e-9;
    const [ux, uy] = [(b[0] - a[0]) / length, (b[1] - a[1]) / length];
    const along = Math.min(Math.max((p[0] - a[0]) * ux + (p[1] - a[1]) * uy, 0), length);
    least = Math.min(least, distance(p, [a[0] + ux * along, a[1] + uy * along]));
  }
  return least;
}

/**
 * The two points that are farthest apart along a line's direction, the left or upper one first.
 *
 * @param {readonly Point[]} points
 * @returns {[Point, Point]}
 */
export function ends(points) {
  let far = /** @type {[Point, Point]} */ ([points[0], points[points.length - 1]]);
  for (const p of points) {
    if (distance(p, far[0]) > distance(...far)) far = [far[0], p];
    if (distance(p, far[1]) > distance(...far)) far = [p, far[1]];
  }
  const [p, q] = far;
  const horizontal = Math.abs(q[0] - p[0]) >= Math.abs(q[1] - p[1]);
  return (horizontal ? p[0] <= q[0] : p[1] <= q[1]) ? [p, q] : [q, p];
}

/**
 * The same points in their order along the line through them.
 *
 * @param {readonly Point[]} points
 * @returns {Point[]}
 */
export function inOrder(points) {
  if (points.length < 3) return [...points];
  const [p, q] = ends(points);
  const along = (/** @type {Point} */ r) => (r[0] - p[0]) * (q[0] - p[0]) + (r[1] - p[1]) * (q[1] - p[1]);
  return [...points].sort((r, s) => along(r) - along(s));
}

/**
 * Whether a point continues a line beyond one of its ends, given how far off that may be.
 *
 * The line is taken on as the parabola through its ends and middle, which is how a lens bends it.
 *
 * @param {Point} point
 * @param {readonly Point[]} points
 * @param {number} slack
 */
export function continues(point, points, slack) {
  const line = inOrder(points);
  const [p, q] = [line[0], line[line.length - 1]];
  const length = distance(p, q);
  if (length < 1e-6) return false;
  const [ux, uy] = [(q[0] - p[0]) / length, (q[1] - p[1]) / length];
  /** @type {(r: Point) => Point} */
  const local = (r) => {
    const [x, y] = [r[0] - p[0], r[1] - p[1]];
    return [x * ux + y * uy, y * ux - x * uy];
  };
  const [along, away] = local(point);
  const [middle, sag] = local(line[Math.floor(line.length / 2)]);
  const room = middle * (length - middle) || 1;
  const expected = (sag / room) * along * (length - along);
  const beyond = Math.max(-along, along - length, 0);
  return Math.abs(away - expected) <= slack + 0.05 * beyond;
}

/** @file Draws lines, picks, residuals, suspects, proposals and guides on the stage. */

import { ends, inOrder } from "./geometry.js";
import { cased, COLOURS, dot, label, ring, trail } from "./pen.js";

/** @typedef {import("./types.js").State} State */
/** @typedef {import("./types.js").Point} Point */
/** @typedef {import("./types.js").FittedLine} FittedLine */
/** @typedef {import("./pen.js").Pen} Pen */

/**
 * @param {Pen} pen
 * @param {State} state
 */
export function paint(pen, state) {
  if (state.show.corrected) {
    paintCorrected(pen, state);
    return;
  }
  if (state.show.proposals) {
    for (const each of state.proposals) {
      const meant = each.number === state.hovered;
      trail(pen, each.photo, each.points, COLOURS.proposal, meant ? 3 : 1.5, meant ? [] : [5, 4]);
    }
  }
  if (state.show.next && state.judgement.next && !state.pending) paintNext(pen, state);
  const fitted = new Map((state.fit.lines ?? []).map((line) => [line.number, line]));
  for (const line of state.lines) paintLine(pen, state, line, fitted.get(line.number));
  for (const suspect of state.judgement.suspects ?? []) paintSuspect(pen, state, suspect);
  if (state.pending) paintPending(pen, state, state.pending);
}

/**
 * @param {Pen} pen
 * @param {State} state
 * @param {import("./types.js").Line} line
 * @param {FittedLine | undefined} fitted
 */
function paintLine(pen, state, line, fitted) {
  const chosen = state.selected === line.number;
  const colour = chosen ? COLOURS.selected : line.snapped ? COLOURS.traced : COLOURS.free;
  const curve = fitted?.curve.every(([x]) => x !== null) ? fitted.curve : inOrder(line.points);
  trail(pen, line.photo, curve, colour, chosen ? 2.5 : 1.75, line.snapped ? [] : [7, 4]);
  if (fitted && state.show.residuals) paintResiduals(pen, state, line.photo, fitted);
  for (const point of line.points) {
    if (line.snapped) dot(pen, pen.place(line.photo, point), colour, chosen ? 1.75 : 1.25);
  }
  line.clicks.forEach((click, index) => {
    const dragged = state.dragged?.line === line.number && state.dragged.index === index;
    const at = pen.place(line.photo, dragged && state.dragged ? state.dragged.to : click);
    ring(pen, at, colour, chosen && state.click === index ? 6 : line.snapped ? 4.5 : 3.5);
  });
}

/**
 * Whiskers from where a pick would lie to where it lies, magnified.
 *
 * @param {Pen} pen
 * @param {State} state
 * @param {number} photo
 * @param {FittedLine} fitted
 */
function paintResiduals(pen, state, photo, fitted) {
  const { context, ratio } = pen;
  context.beginPath();
  fitted.points.forEach((point, index) => {
    const foot = fitted.feet[index];
    if (!foot || foot[0] === null) return;
    const [x, y] = pen.place(photo, foot);
    const [px, py] = pen.place(photo, point);
    context.moveTo(x, y);
    context.lineTo(x + (px - x) * state.magnified, y + (py - y) * state.magnified);
  });
  cased(pen, "#ffffff", 1.25 * ratio);
}

/**
 * @param {Pen} pen
 * @param {State} state
 * @param {import("./types.js").Suspect} suspect
 */
function paintSuspect(pen, state, suspect) {
  const line = state.lines.find((each) => each.number === suspect.line);
  if (!line) return;
  const { context, ratio } = pen;
  for (const point of suspect.points) {
    const [x, y] = pen.place(line.photo, point);
    const r = 7 * ratio;
    context.beginPath();
    context.moveTo(x - r, y - r);
    context.lineTo(x + r, y + r);
    context.moveTo(x + r, y - r);
    context.lineTo(x - r, y + r);
    cased(pen, COLOURS.suspect, 2.5 * ratio);
  }
  if (suspect.whole) trail(pen, line.photo, inOrder(line.points), COLOURS.suspect, 2.5, [2, 4]);
}

/**
 * @param {Pen} pen
 * @param {State} state
 */
function paintNext(pen, state) {
  const next = state.judgement.next;
  if (!next) return;
  trail(pen, next.photo, next.points, COLOURS.next, 2.5, [12, 8]);
  label(pen, pen.place(next.photo, next.points[Math.floor(next.points.length / 2)]), next.label,
    COLOURS.next);
}

/**
 * @param {Pen} pen
 * @param {State} state
 * @param {import("./types.js").Pending} pending
 */
function paintPending(pen, state, pending) {
  const { context, ratio } = pen;
  const placed = pending.clicks.map((click) => pen.place(pending.photo, click));
  if (state.pointer) placed.push([state.pointer[0] * ratio, state.pointer[1] * ratio]);
  context.beginPath();
  placed.forEach(([x, y], index) => (index ? context.lineTo(x, y) : context.moveTo(x, y)));
  context.setLineDash([4 * ratio, 4 * ratio]);
  cased(pen, COLOURS.selected, 1.25 * ratio);
  context.setLineDash([]);
  for (const click of pending.clicks) ring(pen, pen.place(pending.photo, click), COLOURS.selected, 4.5);
}

/**
 * In the corrected photo lines are straight, and picks lie where the lens was undone.
 *
 * @param {Pen} pen
 * @param {State} state
 */
function paintCorrected(pen, state) {
  for (const fitted of state.fit.lines ?? []) {
    const line = state.lines.find((each) => each.number === fitted.number);
    const seen = fitted.ideal.filter(([x]) => x !== null);
    if (!line || seen.length < 2) continue;
    const chosen = state.selected === line.number;
    trail(pen, line.photo, ends(seen), chosen ? COLOURS.selected : COLOURS.traced, 1.25, []);
    for (const point of seen) dot(pen, pen.place(line.photo, point), COLOURS.traced, 1.5);
  }
}

/**
 * @param {Pen} pen
 * @param {[Point, Point]} guide In device pixels.
 */
export function paintGuide(pen, guide) {
  const { context, ratio } = pen;
  const [[ax, ay], [bx, by]] = guide;
  const [dx, dy] = [(bx - ax) * 20, (by - ay) * 20];
  context.beginPath();
  context.moveTo(ax - dx, ay - dy);
  context.lineTo(bx + dx, by + dy);
  cased(pen, COLOURS.guide, ratio);
  for (const end of guide) ring(pen, end, COLOURS.guide, 8);
}

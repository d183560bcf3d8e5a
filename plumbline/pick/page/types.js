/**
 * @file The shapes of what the server tells and the page remembers; nothing runs here.
 *
 * Points are [x, y] in a photo's own pixels, (0, 0) the centre of its top-left pixel. "World" is
 * the plane that photos stand on side by side.
 */

/** @typedef {[number, number]} Point */

/** @typedef {[number, number, number, number, number, number]} Matrix As a canvas has it. */

/**
 * @typedef {object} Photo
 * @property {string} name
 * @property {number} width
 * @property {number} height
 * @property {number} levels Levels of its pyramid of tiles.
 * @property {number} x Where its top-left pixel is in the world.
 */

/**
 * @typedef {object} Line
 * @property {number} number
 * @property {number} photo
 * @property {Point[]} clicks
 * @property {Point[]} points
 * @property {boolean} [snapped]
 * @property {number} [rival]
 * @property {number} [rivals]
 * @property {string} [label]
 */

/**
 * @typedef {object} FittedLine
 * @property {number} number
 * @property {number} rms_px
 * @property {Point[]} points
 * @property {Point[]} ideal
 * @property {Point[]} feet Where the points would lie without an error.
 * @property {Point[]} curve
 * @property {number[]} residuals
 */

/** @typedef {{name: string, value: number, error: number | null}} Coefficient */

/**
 * @typedef {object} Fit
 * @property {string} failure Why there is no fit; empty where there is one.
 * @property {string} hint
 * @property {string} [finding]
 * @property {string} [model]
 * @property {Coefficient[]} [coefficients]
 * @property {number} [sigma_px]
 * @property {number} [rms_px]
 * @property {FittedLine[]} [lines]
 * @property {{radius: number[], shift: number[], reached: number}} [radial]
 */

/** @typedef {{line: number, points: Point[], whole: boolean, text: string}} Suspect */

/** @typedef {{columns: number, rows: number, size: Point, values: number[]}} ErrorMap */

/** @typedef {{photo: number, points: Point[], text: string, label: string}} NextLine */

/**
 * @typedef {object} Judgement
 * @property {string} [failure]
 * @property {number} [revision] What was judged.
 * @property {Suspect[]} [suspects]
 * @property {{good: boolean, text: string}[]} [checks]
 * @property {string} [quote] The error to quote.
 * @property {ErrorMap | null} [map]
 * @property {NextLine | null} [next]
 * @property {{share: number, reached: boolean, text: string} | null} [goal]
 */

/** @typedef {{model: string, free: string[] | null, goal_px: number}} Settings */

/** @typedef {{number: number, photo: number, points: Point[]}} Proposal */

/**
 * @typedef {object} Facts What LensFun calls the lens by.
 * @property {string} maker
 * @property {string} model
 * @property {string} mount
 * @property {number | null} focal_mm
 * @property {number | null} crop_factor
 */

/**
 * @typedef {object} Pending A line that is being clicked.
 * @property {number} photo
 * @property {Point[]} clicks
 * @property {boolean} snap
 * @property {number | null} on The line that its first click fell on.
 */

/** @typedef {{x: number, y: number, scale: number}} View World centre, and screen px per pixel. */

/** @typedef {{text: string, x: number, y: number}} Reason What is told at the pointer. */

/**
 * @typedef {object} State All that the page remembers.
 * @property {Photo[]} photos
 * @property {string} file
 * @property {boolean} snapping Whether edges can be traced.
 * @property {{name: string, coefficients: string[]}[]} models
 * @property {Line[]} lines
 * @property {Proposal[]} proposals
 * @property {Settings} settings
 * @property {string} undo
 * @property {string} redo
 * @property {Fit} fit
 * @property {Judgement} judgement
 * @property {number} revision
 * @property {string} unsaved
 * @property {string} trouble What is wrong with the photos.
 * @property {Facts} facts
 * @property {string} progress
 * @property {boolean} ready Whether the server has its programs compiled.
 * @property {boolean} online
 * @property {boolean} holds Whether this page may pick.
 * @property {number} waiting Requests that are under way.
 * @property {number | null} selected
 * @property {number | null} click Which click of the selected line is selected.
 * @property {{line: number, index: number, to: Point} | null} dragged
 * @property {number | null} hovered The proposal that a click would take.
 * @property {{line: number, at: Point} | null} taken The proposal that the last click took, now a line.
 * @property {Pending | null} pending
 * @property {Point | null} pointer On the stage, in screen pixels.
 * @property {boolean} free Whether clicks are free picks although edges could be traced.
 * @property {View} view
 * @property {{residuals: boolean, map: boolean, corrected: boolean, loupe: boolean,
 *   strip: boolean, proposals: boolean, next: boolean}} show
 * @property {number} magnified
 * @property {[Point, Point] | null} guide In the world.
 * @property {Reason | null} reason
 */

export {};

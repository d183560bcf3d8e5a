/** @file The panel beside the photo: the finding, the goal, the lines, what is doubtful. */

import { curveOf } from "./curve.js";
import { find, make, px } from "./dom.js";

/** @typedef {import("./types.js").State} State */
/** @typedef {import("./store.js").Store} Store */
/** @typedef {import("./server.js").Server} Server */

/**
 * Show the state in the panel, and let its controls change the state.
 *
 * @param {Store} store
 * @param {Server} server
 */
export function createPanel(store, server) {
  const model = find("model", HTMLSelectElement);
  const goal = find("goal", HTMLInputElement);
  model.addEventListener("change", () => {
    void server.act({ do: "set", ...store.get().settings, model: model.value, free: null });
  });
  goal.addEventListener("change", () => {
    const goal_px = Number(goal.value);
    if (goal_px > 0) void server.act({ do: "set", ...store.get().settings, goal_px });
  });
  find("lines", HTMLTableSectionElement).addEventListener("click", (event) => {
    const row = /** @type {HTMLElement} */ (event.target).closest("tr");
    if (row) store.set({ selected: Number(row.dataset.number), click: null });
  });

  store.subscribe((state, before) => {
    if (state.fit !== before.fit) showFit(state);
    if (state.fit !== before.fit || state.lines !== before.lines || state.selected !== before.selected
      || state.judgement !== before.judgement) showLines(state);
    if (state.judgement !== before.judgement || state.fit !== before.fit) showJudgement(state);
    if (state.models !== before.models) {
      model.replaceChildren(...state.models.map(({ name }) => make("option", { value: name }, name)));
    }
    if (state.settings !== before.settings || state.models !== before.models) {
      model.value = state.settings.model;
      if (document.activeElement !== goal) goal.value = String(state.settings.goal_px);
    }
  });
}

/** @param {State} state */
function showFit({ fit, settings }) {
  const failed = Boolean(fit.failure);
  const [finding, straight] = (fit.finding ?? "").split("; ");
  find("finding", HTMLElement).textContent = failed ? sentence(fit.failure) : finding;
  find("straight", HTMLElement).textContent = sentence(failed ? fit.hint : straight ?? "");
  find("sigma", HTMLElement).textContent = failed || fit.sigma_px === undefined ? "" : px(fit.sigma_px);
  find("numbers", HTMLElement).hidden = failed;
  const freed = settings.free;
  find("coefficients", HTMLElement).replaceChildren(...(failed ? [] : fit.coefficients ?? [])
    .filter((each) => each.error !== null)
    .map((each) => make("div", {}, make("b", {}, each.name), ` ${number(each.value)} ± ${number(each.error ?? 0)}`)),
  ...(freed ? [make("div", {}, `free: ${freed.join(", ")}`)] : []));
  find("curve", HTMLElement).replaceChildren(...(fit.radial && !failed ? [curveOf(fit.radial)] : []));
}

/** @param {number} value */
function number(value) {
  return Math.abs(value) >= 1 ? value.toFixed(1) : value.toFixed(5).replace("-", "−");
}

/** @param {string} text */
export function sentence(text) {
  return text ? `${text[0].toUpperCase()}${text.slice(1)}.` : "";
}

/** @param {State} state */
function showLines({ lines, fit, selected, judgement }) {
  const fitted = new Map((fit.lines ?? []).map((line) => [line.number, line]));
  const accused = new Map((judgement.suspects ?? []).map((suspect) => [suspect.line, suspect]));
  const worst = Math.max(0.1, ...(fit.lines ?? []).map((line) => line.rms_px));
  find("lines", HTMLTableSectionElement).replaceChildren(...lines.map((line) => {
    const rms = fitted.get(line.number)?.rms_px;
    const name = line.label || String(line.number);
    const meter = make("meter", { max: String(worst), value: String(rms ?? 0), "aria-hidden": "true" });
    const button = make("button", { type: "button", "aria-pressed": String(line.number === selected) },
      `${line.snapped ? "traced" : "free"} ${name}`);
    const row = make("tr", { "data-number": String(line.number) },
      make("td", {}, button), make("td", { class: "number" }, rms === undefined ? "–" : px(rms)), make("td", {}, meter),
      make("td", {}, accused.has(line.number) ? make("span", { class: "wrong", role: "img",
        title: accused.get(line.number)?.text ?? "", "aria-label": "suspicious" }, "✗") : ""));
    row.classList.toggle("selected", line.number === selected);
    return row;
  }));
  find("count", HTMLElement).textContent = `${lines.length} line${lines.length === 1 ? "" : "s"}`;
}

/** @param {State} state */
function showJudgement({ judgement, fit, settings, revision }) {
  const { suspects = [], checks = [], next, goal } = judgement;
  find("suspects", HTMLElement).replaceChildren(...suspects.map((suspect) =>
    make("li", { class: "wrong" }, `✗ ${sentence(suspect.text)}`)));
  const quote = find("quote", HTMLElement);
  quote.textContent = fit.failure ? "" : judgement.quote ?? "…";
  quote.classList.toggle("muted", judgement.revision !== revision); // of the lines before
  const doubts = fit.failure ? [] : checks.filter((check) => !check.good);
  find("mind", HTMLElement).hidden = !doubts.length;
  find("checks", HTMLElement).replaceChildren(...doubts.map((check) => make("li", {}, `? ${sentence(check.text)}`)));
  find("next", HTMLElement).textContent = next && !fit.failure ? sentence(next.text) : "";
  const meter = find("progress", HTMLProgressElement);
  meter.value = goal && !fit.failure ? goal.share : 0;
  find("goal-text", HTMLElement).textContent = goal && !fit.failure ? goal.text
    : `the error to reach: ${px(settings.goal_px)}`;
}

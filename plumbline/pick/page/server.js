/** @file Talks with the server: requests that change something, and the stream of its events. */

/** @typedef {import("./store.js").Store} Store */
/** @typedef {import("./types.js").Photo} Photo */

const GAP = 0.04; // of a photo's width, between photos side by side

/** The page's name. A reload keeps it, so that a page does not lock itself out. */
const PAGE = pageName();

/** @returns {string} */
function pageName() {
  const [entry] = performance.getEntriesByType("navigation");
  const reloaded = entry instanceof PerformanceNavigationTiming && entry.type === "reload";
  const before = reloaded ? sessionStorage.getItem("page") : null;
  const name = before ?? Array.from(crypto.getRandomValues(new Uint32Array(3)), String).join("-");
  sessionStorage.setItem("page", name.slice(0, 40));
  return name.slice(0, 40);
}

/**
 * What of the server's answer belongs to the state.
 *
 * @param {any} told
 * @param {Store} store
 */
function taken(told, store) {
  const { lines, settings, undo, redo, fit, unsaved, revision, proposals, facts } = told;
  store.set({ lines, settings: { free: null, goal_px: 0.5, model: "ptlens", ...settings },
    undo, redo, fit, unsaved, revision, proposals, facts });
}

/**
 * Ask the server; what goes wrong is told at the pointer.
 *
 * @param {string} what
 * @param {object} body
 * @returns {Promise<any>}
 */
async function post(what, body) {
  const answer = await fetch(what, {
    method: "POST",
    headers: { "content-type": "application/json" },
    body: JSON.stringify({ page: PAGE, ...body }),
  });
  const told = await answer.json();
  if (!answer.ok) throw new Refused(told.error, told.hint);
  return told;
}

/** The server's refusal, in words. */
export class Refused extends Error {
  /**
   * @param {string} message
   * @param {string} [hint]
   */
  constructor(message, hint) {
    super(hint ? `${message}: ${hint}` : message);
  }
}

/**
 * The server, for one store.
 *
 * @param {Store} store
 */
export function createServer(store) {
  /**
   * @template T
   * @param {() => Promise<T>} work
   * @returns {Promise<T | null>}
   */
  async function guarded(work) {
    store.set({ waiting: store.get().waiting + 1 });
    try {
      return await work();
    } catch (error) {
      const text = error instanceof Refused ? error.message
        : "plumbline does not answer: is it still running? What was saved is safe";
      const [x, y] = store.get().pointer ?? [40, 40];
      store.set({ reason: { text, x, y }, online: error instanceof Refused });
      return null;
    } finally {
      store.set({ waiting: store.get().waiting - 1 });
    }
  }

  return {
    /** Load everything, and listen. */
    async open() {
      const told = await (await fetch("state")).json();
      let x = 0;
      const photos = told.photos.map((/** @type {Photo} */ photo) => {
        const placed = { ...photo, x };
        x += photo.width * (1 + GAP);
        return placed;
      });
      taken(told, store);
      store.set({ photos, file: told.file, snapping: told.snapping, models: told.models,
        judgement: told.judgement, ready: told.ready, trouble: told.trouble,
        reason: told.notes.length ? { text: told.notes.join("; "), x: 0, y: 0 } : null });
      listen(store);
    },

    /**
     * Do something to the lines; resolves to the server's answer, or null.
     *
     * @param {{do: string, [key: string]: unknown}} action
     */
    act(action) {
      return guarded(async () => {
        const told = await post("act", { action });
        taken(told, store);
        const [x, y] = store.get().pointer ?? [40, 40];
        store.set({ selected: told.selected ?? store.get().selected,
          reason: told.refusal || told.doubt ? { text: told.refusal || `${told.doubt}: Tab takes it`, x, y } : null,
          online: true });
        return told;
      });
    },
    take: () => guarded(() => post("take", {})),
    compare: () => guarded(() => post("compare", {})),
    finish: () => guarded(() => post("finish", {})),
  };
}

/** @typedef {ReturnType<typeof createServer>} Server */

/** @param {Store} store */
function listen(store) {
  const events = new EventSource(`events/${PAGE}`);
  /** @type {[string, (told: any) => void][]} */
  const heard = [
    ["state", (told) => taken(told, store)],
    ["judgement", (told) => {
      if (told.revision === store.get().revision) store.set({ judgement: told });
    }],
    ["holder", (told) => store.set({ holds: told === PAGE })],
    ["unsaved", (told) => store.set({ unsaved: told })],
    ["trouble", (told) => store.set({ trouble: told })],
    ["progress", (told) => store.set({ progress: told })],
    ["ready", () => store.set({ ready: true })],
  ];
  for (const [name, hear] of heard) {
    events.addEventListener(name, (event) => hear(JSON.parse(event.data)));
  }
  events.onopen = () => store.set({ online: true });
  events.onerror = () => store.set({ online: false });
}

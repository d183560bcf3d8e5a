/** @file Puts the page together. */

import { createActions, listenToKeys, STRIP } from "./actions.js";
import { whole } from "./camera.js";
import { createDialogs } from "./dialogs.js";
import { find, keyLabel } from "./dom.js";
import { listenTo } from "./gestures.js";
import { createPanel } from "./panel.js";
import { createPicking } from "./picking.js";
import { createServer } from "./server.js";
import { createStage } from "./stage.js";
import { createStatus } from "./status.js";
import { createStore } from "./store.js";

const store = createStore();
const server = createServer(store);
const picking = createPicking(store, server);
const stage = createStage(store);
const dialogs = createDialogs(store, server);
createPanel(store, server);
createStatus(store, server);

/** @type {import("./actions.js").Action[]} */
const actions = createActions({
  store, server, picking, size: stage.size,
  open: (name) => (name === "help" ? dialogs.help(actions) : void dialogs[name]()),
});
listenTo(stage.element, store, picking);
listenToKeys(actions, store, stage.element);

for (const button of document.querySelectorAll("button[data-action]")) {
  const action = actions.find((each) => each.id === /** @type {HTMLElement} */ (button).dataset.action);
  if (!(button instanceof HTMLButtonElement) || !action) continue;
  button.title = `${action.text} (${keyLabel(action.keys[0])})`;
  button.addEventListener("click", () => action.run(action.keys[0]));
  store.subscribe((state) => {
    button.disabled = Boolean(action.useful && !action.useful(state));
    const shown = /** @type {Record<string, boolean>} */ ({ ...state.show, free: state.free })[action.id];
    if (shown !== undefined) button.setAttribute("aria-pressed", String(shown));
  });
}

await server.open();
const { photos } = store.get();
document.title = `${photos.map((photo) => photo.name).join(", ")} – plumbline`;
find("title", HTMLElement).textContent = photos.map((photo) => photo.name).join(", ");
store.set({ view: whole(photos, stage.size(), STRIP) });
stage.element.focus();
document.documentElement.dataset.ready = "yes";

// Keys, and the dialog that lists them.
import { $, el } from './dom.js';
import { layerKeys } from './layers.js';

const help = [
  ['1 … 9, 0', 'layers on and off'],
  ['C', 'next colouring of the coverage map'],
  [', .', 'iteration before, after'],
  ['Space', 'play the time line'],
  ['F T G', 'view: everything, from above, from the side'],
  ['Arrow keys', 'turn the view (when it has the focus)'],
  ['W A S D', 'move the view'],
  ['+ −', 'zoom'],
  ['[ ]', 'photo before, after'],
  ['V', 'look through the selected photo'],
  ['E', 'enlarge it'],
  ['M N', 'its superpixels, its confidence'],
  ['L', 'light or dark'],
  ['P', 'pause the flight'],
  ['Esc', 'leave, deselect'],
  ['?', 'this list'],
];

function viewKey(app, event) {
  if (document.activeElement !== app.viewer.canvas) return false;
  const turn = 0.12;
  const move = {
    ArrowLeft: { turn: -turn },
    ArrowRight: { turn },
    ArrowUp: { tilt: turn },
    ArrowDown: { tilt: -turn },
    w: { ahead: 0.06 },
    s: { ahead: -0.06 },
    a: { right: -0.06 },
    d: { right: 0.06 },
  }[event.key];
  if (!move) return false;
  app.viewer.nudge(move);
  return true;
}

function pageKey(app, key) {
  const digit = '1234567890'.indexOf(key);
  if (key.length === 1 && digit >= 0) {
    const input = document.querySelector(`#layers [data-layer="${layerKeys[digit]}"] input`);
    if (!input.disabled) app.setLayer(layerKeys[digit], !app.viewer.shown[layerKeys[digit]]);
    return true;
  }
  const actions = {
    '+': () => app.viewer.nudge({ zoom: 0.88 }),
    '=': () => app.viewer.nudge({ zoom: 0.88 }),
    '-': () => app.viewer.nudge({ zoom: 1 / 0.88 }),
    ',': () => app.show(app.index - 1),
    '.': () => app.show(app.index + 1),
    ' ': () => app.play(),
    f: () => app.viewer.fit('fit'),
    t: () => app.viewer.fit('top'),
    g: () => app.viewer.fit('side'),
    c: () => app.nextColoring(),
    '[': () => app.stepPhoto(-1),
    ']': () => app.stepPhoto(1),
    v: () => app.lookThrough(),
    e: () => $('enlarge')?.click(),
    m: () => app.setOverlay({ mesh: !app.overlay.mesh }),
    n: () => app.setOverlay({ confidence: !app.overlay.confidence }),
    l: () => app.toggleTheme(),
    p: () => app.flight.pause(),
    '?': () => $('help').showModal(),
    Escape: () => (app.leaveThrough() ? null : app.clearSelection()),
  };
  const action = actions[key] ?? actions[key.toLowerCase()];
  action?.();
  return Boolean(action);
}

export function makeKeys(app) {
  const dialog = $('help');
  dialog.replaceChildren(
    el('h2', { id: 'help-title' }, 'Keys'),
    el(
      'p',
      {},
      'Drag turns the view, the wheel or two fingers zoom, the right button moves. Click a point of the map, the surface or a photo.',
    ),
    el(
      'dl',
      { class: 'facts keys' },
      ...help.flatMap(([key, text]) => [el('dt', {}, el('kbd', {}, key)), el('dd', {}, text)]),
    ),
    el('button', { type: 'button', onclick: () => dialog.close() }, 'Close'),
  );
  $('help-open').addEventListener('click', () => dialog.showModal());
  for (const each of document.querySelectorAll('dialog')) {
    each.addEventListener('click', (event) => {
      if (event.target === each) each.close();
    });
  }
  document.addEventListener('keydown', (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey || document.querySelector('dialog[open]'))
      return;
    const { tagName, type } = event.target;
    if (
      (tagName === 'INPUT' && type === 'range' && event.key.startsWith('Arrow')) ||
      (event.key === ' ' && ['BUTTON', 'INPUT', 'A', 'SUMMARY'].includes(tagName))
    )
      return;
    if (viewKey(app, event) || pageKey(app, event.key)) event.preventDefault();
  });
}

// The card of layers and the legend of the coverage map.
import { el, $, arrowKeys, grouped, percent } from './dom.js';
import { colorings, errorRange, hasColoring, maxViewsShown, rampOf } from './clouds.js';
import { classes, css } from './palette.js';

const layerNames = [
  ['surface', 'Surface'],
  ['color', 'Photo colours'],
  ['coverage', 'Coverage map'],
  ['points', 'Sparse points'],
  ['fused', 'Dense points'],
  ['photos', 'Photos'],
  ['views', 'Next views'],
  ['path', 'Path'],
  ['drone', 'Drone'],
  ['ground', 'Grid'],
];
export const layerKeys = layerNames.map(([name]) => name);
const coloringNames = { class: 'Class', error: 'Error', score: 'Score', views: 'Views' };
const coloringTitles = {
  class: 'covered, uncovered, ignored',
  error: 'predicted error of the final model',
  score: 'how sure it is that the final model will be good there',
  views: 'photos that see it well',
};

export function makeLayers(app) {
  const box = $('layers');
  const details = el('div', { class: 'layerlist' });
  layerNames.forEach(([name, label], i) => {
    const key = String((i + 1) % 10);
    details.append(
      el(
        'label',
        { 'data-layer': name },
        el('input', {
          type: 'checkbox',
          onchange: (event) => app.setLayer(name, event.target.checked),
        }),
        el('span', {}, label),
        el('kbd', { 'aria-hidden': 'true' }, key),
      ),
    );
  });
  const toggle = el(
    'button',
    {
      type: 'button',
      class: 'fold',
      'aria-expanded': 'true',
      'aria-label': 'Show or hide the list of layers',
      onclick: () => {
        const open = toggle.getAttribute('aria-expanded') !== 'true';
        toggle.setAttribute('aria-expanded', String(open));
        details.hidden = !open;
      },
    },
    'Layers',
  );
  box.replaceChildren(el('legend', { class: 'hidden' }, 'Layers'), toggle, details);
  if (matchMedia('(max-width: 760px)').matches) toggle.click();
}

/** Ticks and greys out what the iteration has not. */
export function showLayers(app) {
  const { viewer, data } = app;
  const there = {
    surface: data.surface,
    color: data.surface?.color,
    coverage: data.coverage,
    points: data.points.position.length,
    fused: app.links().fused,
    photos: data.photos.length,
    views: data.views.length,
    path: data.path,
    drone: data.path || app.vehicle,
    ground: true,
  };
  for (const label of document.querySelectorAll('#layers label')) {
    const name = label.dataset.layer;
    const input = label.querySelector('input');
    input.checked = viewer.shown[name];
    input.disabled = !there[name];
    label.classList.toggle('off', !there[name]);
  }
}

function bar(share, color) {
  return el('i', {
    class: 'bar',
    style: `width:${(100 * share).toFixed(1)}%;background:${css(color)}`,
  });
}

function classRows(app, coverage) {
  const total = coverage.counts.reduce((a, b) => a + b, 0) || 1;
  return classes.map((kind, k) =>
    el(
      'label',
      { class: 'row' },
      el('input', {
        type: 'checkbox',
        checked: app.viewer.classShown[k],
        onchange: (event) => app.setClass(k, event.target.checked),
      }),
      el('b', { class: 'swatch', style: `background:${css(kind.color)}` }),
      el('span', {}, kind.name),
      el('output', {}, grouped(coverage.counts[k])),
      bar(coverage.counts[k] / total, kind.color),
    ),
  );
}

function ramp(stops, ticks, note) {
  const colors = stops.map((c, i) => `${css(c)} ${(100 * i) / (stops.length - 1)}%`).join(',');
  return [
    el('div', { class: 'ramp', style: `background:linear-gradient(90deg,${colors})` }),
    el('div', { class: 'ticks' }, ...ticks.map((tick) => el('span', {}, tick))),
    el('p', { class: 'note' }, note),
  ];
}

// Share of the points that have to be covered in each of `bins`, as small bars above the ramp.
function histogram(coverage, binOf, bins) {
  const counts = new Array(bins).fill(0);
  coverage.kind.forEach((kind, i) => {
    const b = kind === 2 ? -1 : binOf(i);
    if (b >= 0) counts[Math.min(bins - 1, b)]++;
  });
  const most = Math.max(1, ...counts);
  return el(
    'div',
    { class: 'histogram', 'aria-hidden': 'true' },
    ...counts.map((c) => el('i', { style: `height:${((100 * c) / most).toFixed(1)}%` })),
  );
}

// Two digits, never with an exponent.
function short(value) {
  const unit = 10 ** (Math.floor(Math.log10(value)) - 1);
  return String(+(Math.round(value / unit) * unit).toFixed(Math.max(0, -Math.log10(unit))));
}

function errorLegend(coverage) {
  const range = errorRange(coverage);
  if (!range) return [el('p', { class: 'note' }, 'This map has no predicted errors.')];
  const [low, high] = range;
  const tick = (share) => short(low * (high / low) ** share);
  const bin = (i) =>
    coverage.errorUm[i] < 0
      ? -1
      : Math.max(
          0,
          Math.floor((24 * Math.log(coverage.errorUm[i] / 1000 / low)) / Math.log(high / low)),
        );
  return [
    histogram(coverage, bin, 24),
    ...ramp(
      rampOf('error'),
      [tick(0), tick(0.5), `${tick(1)} mm`],
      'predicted error · bright: small · grey: unknown or not asked for',
    ),
  ];
}

function scoreLegend(coverage) {
  return [
    histogram(coverage, (i) => Math.floor((24 * coverage.score[i]) / 256), 24),
    ...ramp(
      rampOf('score'),
      ['0', '50 %', '100 %'],
      'how sure it is that the model will be good · grey: not asked for',
    ),
  ];
}

function viewsLegend(coverage) {
  return [
    histogram(coverage, (i) => coverage.views[i], maxViewsShown + 1),
    ...ramp(
      rampOf('views'),
      ['0', String(maxViewsShown / 2), `${maxViewsShown} or more`],
      'photos that see it well · grey: not asked for',
    ),
  ];
}

export function showLegend(app) {
  const box = $('legend');
  const { coverage } = app.data;
  box.hidden = !coverage || !app.viewer.shown.coverage;
  if (box.hidden) return;
  const choice = el('div', {
    class: 'choice',
    role: 'radiogroup',
    'aria-label': 'Colour of the coverage map',
  });
  for (const name of colorings) {
    const has = hasColoring(coverage, name);
    const on = app.viewer.coloring === name;
    choice.append(
      el(
        'button',
        {
          type: 'button',
          role: 'radio',
          'aria-checked': String(on),
          tabindex: on ? 0 : -1,
          'data-coloring': name,
          disabled: !has,
          title: has
            ? `${coloringTitles[name]} (C: next one)`
            : 'this map was made without such numbers',
          onclick: () => app.setColoring(name),
        },
        coloringNames[name],
      ),
    );
  }
  arrowKeys(choice, 'button');
  const required = coverage.counts[0] + coverage.counts[1];
  const rows = {
    class: () => classRows(app, coverage),
    error: () => errorLegend(coverage),
    score: () => scoreLegend(coverage),
    views: () => viewsLegend(coverage),
  };
  const focused = choice.contains(document.activeElement);
  box.replaceChildren(
    el('h2', {}, 'Coverage ', el('b', {}, required ? percent(coverage.counts[1] / required) : '–')),
    choice,
    el('div', { class: 'rows' }, ...rows[app.viewer.coloring]()),
  );
  if (focused) choice.querySelector('[aria-checked=true]').focus();
}

// The tab "Inspect": the selected point or photo, else all photos.
import { $, el, metres, percent } from './dom.js';
import { classes, css } from './palette.js';
import { facts, photoCard, photoLink } from './photo.js';

// A thumbnail; with `mark` (0 … 1 of width and height) where a point is in it.
function thumbnail(app, index, { mark, text, good } = {}) {
  const photo = app.data.photos[index];
  const cross = mark
    ? el('i', { class: 'cross', style: `left:${100 * mark.x}%;top:${100 * mark.y}%` })
    : null;
  const image = el('img', {
    src: photoLink(app, photo),
    alt: '',
    loading: 'lazy',
    decoding: 'async',
    draggable: 'false',
  });
  image.addEventListener('error', () => image.classList.add('missing'));
  return el(
    'button',
    {
      type: 'button',
      class: `thumb${good === false ? ' weak' : ''}`,
      'data-photo': index,
      'aria-label': `Photo ${photo.name}${text ? `, ${text}` : ''}`,
      onclick: () => app.selectPhoto(index, { keepPoint: Boolean(mark) }),
      onmouseenter: () => app.hoverPhoto(index),
      onmouseleave: () => app.hoverPhoto(-1),
    },
    el(
      'span',
      { class: 'frame', style: `aspect-ratio:${photo.camera.width}/${photo.camera.height}` },
      image,
      cross,
    ),
    el('span', { class: 'name' }, photo.name),
    text ? el('span', { class: 'sub' }, text) : null,
  );
}

// Arrow keys move among the thumbnails.
function gridKeys(grid) {
  grid.addEventListener('keydown', (event) => {
    const buttons = [...grid.querySelectorAll('button')];
    const at = buttons.indexOf(document.activeElement);
    const columns = getComputedStyle(grid).gridTemplateColumns.split(' ').length;
    const step = { ArrowRight: 1, ArrowLeft: -1, ArrowDown: columns, ArrowUp: -columns }[event.key];
    if (at < 0 || !step) return;
    event.preventDefault();
    event.stopPropagation();
    buttons[Math.min(buttons.length - 1, Math.max(0, at + step))].focus();
  });
  return grid;
}

function pointCard(app) {
  const { iso, point, seen } = app.selection;
  const { coverage } = app.data;
  const rows = [];
  let title = 'A place on the surface';
  let color = null;
  if (iso >= 0) {
    title = `Iso-point ${iso}`;
    color = classes[coverage.kind[iso]].color;
    rows.push(
      ['Class', classes[coverage.kind[iso]].name],
      ['Good views (stage)', String(coverage.views[iso])],
    );
    if (coverage.errorUm) {
      rows.push([
        'Predicted error',
        coverage.errorUm[iso] < 0
          ? 'unknown: no photo sees it'
          : metres(coverage.errorUm[iso] / 1e6),
      ]);
    }
    if (coverage.score) rows.push(['Score', percent(coverage.score[iso] / 255)]);
  }
  const world = point.toArray().map((v, k) => (v + app.iterations.origin[k]).toFixed(2));
  rows.push(['Position (E, N, up)', `${world.join(', ')} m`]);
  const good = seen.filter((s) => s.good).length;
  rows.push(['Photos that see it', `${seen.length}, ${good} of them well enough`]);
  return el(
    'section',
    { class: 'card', id: 'point-card' },
    el(
      'div',
      { class: 'head' },
      color ? el('b', { class: 'swatch', style: `background:${css(color)}` }) : null,
      el('h2', {}, title),
      el(
        'button',
        {
          type: 'button',
          title: 'Close (Esc)',
          'aria-label': 'Close',
          onclick: () => app.clearSelection(),
        },
        '×',
      ),
    ),
    facts(rows),
  );
}

function seenGrid(app) {
  const { seen } = app.selection;
  if (seen.length === 0) return el('p', { class: 'hint' }, 'No photo sees this place.');
  return gridKeys(
    el(
      'div',
      { class: 'grid', id: 'seen' },
      ...seen.slice(0, 60).map((s) =>
        thumbnail(app, s.index, {
          mark: { x: s.pixel.x / s.photo.camera.width, y: s.pixel.y / s.photo.camera.height },
          text: `${s.gsdMm.toFixed(0)} mm/px · ${metres(s.distance)} · ${s.incidenceDeg.toFixed(0)}°`,
          good: s.good,
        }),
      ),
    ),
  );
}

let turn = 0; // of the last drawing: a slower, older one must not replace it

export async function showInspect(app) {
  const mine = ++turn;
  const box = $('inspect');
  const { photo, point } = app.selection;
  const parts = [];
  if (photo >= 0) parts.push(await photoCard(app, photo));
  if (mine !== turn) return;
  if (point) parts.push(pointCard(app), seenGrid(app));
  if (photo < 0 && !point) {
    parts.push(
      el(
        'p',
        { class: 'hint' },
        'Click a point of the coverage map or surface to see which photos show it, a photo to see what the fast stereo made of it.',
      ),
      gridKeys(
        el(
          'div',
          { class: 'grid', id: 'photos' },
          ...app.data.photos.map((p, i) => thumbnail(app, i)),
        ),
      ),
    );
    const names = app.session.iterations[app.index].unregistered ?? [];
    if (names.length) {
      parts.push(
        el(
          'details',
          { class: 'card' },
          el('summary', {}, `${names.length} photos without a pose`),
          el('ul', {}, ...names.map((name) => el('li', {}, name))),
        ),
      );
    }
  }
  box.replaceChildren(...parts);
  box.scrollTop = 0;
}

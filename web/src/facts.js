// Tiles at the top of the panel and the table of iterations.
import { $, el, grouped, metres, percent, seconds } from './dom.js';

function tile(value, label, change) {
  const delta = change ? el('em', {}, change) : null;
  return el('div', { class: 'tile' }, el('b', {}, value), el('span', {}, label, ' ', delta));
}

// "+3.2" against the iteration before; nothing when one of both is unknown.
function changed(now, before, text) {
  if (now === undefined || before === undefined || now === before) return null;
  return `${now > before ? '+' : '−'}${text(Math.abs(now - before))}`;
}

export function showTiles(app) {
  const { iterations } = app.session;
  const it = iterations[app.index];
  const before = iterations[app.index - 1] ?? {};
  const tiles = [];
  if (it.covered_ratio !== undefined)
    tiles.push(
      tile(
        percent(it.covered_ratio),
        'covered',
        changed(it.covered_ratio, before.covered_ratio, (v) => (100 * v).toFixed(1)),
      ),
    );
  if (it.reachable_covered_ratio !== undefined)
    tiles.push(
      tile(
        percent(it.reachable_covered_ratio),
        'of the reachable',
        changed(it.reachable_covered_ratio, before.reachable_covered_ratio, (v) =>
          (100 * v).toFixed(1),
        ),
      ),
    );
  tiles.push(
    tile(
      `${it.registered}`,
      it.registered === it.photos ? 'photos' : `of ${it.photos} photos registered`,
      changed(it.registered, before.registered, String),
    ),
  );
  if (it.mean_error_m !== undefined)
    tiles.push(
      tile(
        metres(it.mean_error_m),
        'mean error',
        changed(it.mean_error_m, before.mean_error_m, metres),
      ),
    );
  if (it.planned_views !== undefined) {
    const isFlown = !app.session.finished || app.index < iterations.length - 1;
    const label = isFlown ? 'views planned next' : 'views planned, not flown';
    tiles.push(tile(String(it.planned_views), label));
  }
  const path = app.data?.path;
  if (path?.waypoints?.length > 1)
    tiles.push(
      tile(
        metres(path.length_m),
        `path, ${seconds(path.duration_s)}, ${metres(path.min_clearance_m)} clear`,
      ),
    );
  if (app.data) tiles.push(tile(grouped(app.data.points.position.length / 3), 'sparse points'));
  tiles.push(tile(seconds(it.wall_s), 'this iteration'));
  $('tiles').replaceChildren(...tiles);
}

export function showTable(app) {
  const { iterations } = app.session;
  const keys = Object.keys(iterations.at(-1)?.completeness ?? {});
  const columns = [
    ['#', (it, i) => String(i)],
    ['Photos', (it) => String(it.photos)],
    ['Registered', (it) => String(it.registered)],
    ['Covered', (it) => it.covered_ratio !== undefined && percent(it.covered_ratio)],
    [
      'Reachable',
      (it) => it.reachable_covered_ratio !== undefined && percent(it.reachable_covered_ratio),
    ],
    ['Mean error', (it) => it.mean_error_m !== undefined && metres(it.mean_error_m)],
    ['RMS', (it) => it.rms_error_m !== undefined && metres(it.rms_error_m)],
    ...keys.map((key) => [
      `≤ ${key.replace('mm', ' mm')}`,
      (it) => it.completeness?.[key] !== undefined && percent(it.completeness[key]),
    ]),
    ['Views', (it) => String(it.planned_views)],
    ['Time', (it) => seconds(it.wall_s)],
  ].filter(([, get]) => iterations.some((it, i) => get(it, i)));
  const rows = iterations.map((it, i) =>
    el(
      'tr',
      { class: i === app.index ? 'now' : '', onclick: () => app.show(i) },
      ...columns.map(([, get], k) =>
        k === 0
          ? el(
              'th',
              { scope: 'row' },
              el(
                'button',
                {
                  type: 'button',
                  'aria-label': `Show iteration ${i}`,
                  'aria-current': i === app.index ? 'true' : null,
                },
                get(it, i),
              ),
            )
          : el('td', {}, get(it, i) || '–'),
      ),
    ),
  );
  const stages = Object.entries(iterations[app.index].stage_wall_s ?? {}).sort(
    (a, b) => b[1] - a[1],
  );
  const longest = stages[0]?.[1] ?? 1;
  $('table').replaceChildren(
    el(
      'div',
      { class: 'scroll', tabindex: 0, role: 'region', 'aria-label': 'Table of iterations' },
      el(
        'table',
        {},
        el(
          'thead',
          {},
          el('tr', {}, ...columns.map(([title]) => el('th', { scope: 'col' }, title))),
        ),
        el('tbody', {}, ...rows),
      ),
    ),
    stages.length
      ? el(
          'section',
          { class: 'card' },
          el('h2', {}, `Where the time of iteration ${app.index} went`),
          el(
            'div',
            { class: 'rows stages' },
            ...stages.map(([name, s]) =>
              el(
                'div',
                { class: 'row' },
                el('span', {}, name),
                el('output', {}, seconds(s)),
                el('i', { class: 'bar', style: `width:${((100 * s) / longest).toFixed(1)}%` }),
              ),
            ),
          ),
        )
      : '',
  );
}

// The time line: one stop an iteration, the covered part as a curve behind.
import { $, el, percent, svg } from './dom.js';

export function makeTimeline(app) {
  const box = $('timeline');
  const count = app.session.iterations.length;
  const play = el(
    'button',
    {
      type: 'button',
      id: 'play',
      class: 'play',
      title: 'Play (space)',
      'aria-label': 'Play',
      onclick: () => app.play(),
    },
    '▶',
  );
  const range = el('input', {
    type: 'range',
    id: 'scrub',
    min: 0,
    max: Math.max(0, count - 1),
    step: 1,
    value: app.index,
    'aria-label': 'Iteration',
    oninput: () => app.show(Number(range.value)),
  });
  const curve = svg('svg', {
    viewBox: '0 0 100 100',
    preserveAspectRatio: 'none',
    'aria-hidden': 'true',
  });
  const at = (i) => (count < 2 ? 50 : (100 * i) / (count - 1));
  const known = app.session.iterations
    .map((it, i) => [at(i), it.covered_ratio])
    .filter(([, v]) => v !== undefined);
  if (known.length > 1) {
    const line = known.map(([x, v]) => `${x} ${100 - 92 * v}`).join(' L ');
    curve.append(
      svg('path', {
        class: 'area',
        d: `M ${known[0][0]} 100 L ${line} L ${known.at(-1)[0]} 100 Z`,
      }),
      svg('path', { class: 'line', d: `M ${line}`, 'vector-effect': 'non-scaling-stroke' }),
    );
  }
  const stops = el('div', { class: 'stops', 'aria-hidden': 'true' });
  app.session.iterations.forEach((it, i) => {
    const label =
      count <= 24 || i % Math.ceil(count / 12) === 0 || i === count - 1 ? String(i) : '';
    stops.append(el('span', { style: `left:${at(i)}%`, 'data-stop': i }, label));
  });
  const text = el('output', { id: 'now', for: 'scrub' });
  const step = (by, name, label) =>
    el(
      'button',
      {
        type: 'button',
        id: name,
        title: `${label} (${by < 0 ? ',' : '.'})`,
        'aria-label': label,
        onclick: () => app.show(app.index + by),
      },
      by < 0 ? '‹' : '›',
    );
  box.replaceChildren(
    el(
      'div',
      { class: 'buttons' },
      step(-1, 'previous', 'Previous iteration'),
      play,
      step(1, 'next', 'Next iteration'),
    ),
    el('div', { class: 'track' }, curve, range, stops),
    text,
  );
  box.classList.toggle('single', count < 2);
}

export function showTimeline(app) {
  const it = app.session.iterations[app.index];
  const last = app.session.iterations.length - 1;
  $('scrub').value = app.index;
  $('scrub').setAttribute(
    'aria-valuetext',
    `iteration ${app.index}, ${it.photos} photos${it.covered_ratio === undefined ? '' : `, ${percent(it.covered_ratio)} covered`}`,
  );
  $('previous').disabled = app.index === 0;
  $('next').disabled = app.index === last;
  $('play').textContent = app.playing ? '❚❚' : '▶';
  $('play').setAttribute('aria-label', app.playing ? 'Pause the time line' : 'Play');
  $('now').replaceChildren(
    el('b', {}, `Iteration ${app.index}`),
    ` of ${last}`,
    el('br'),
    `${it.photos} photos`,
  );
  for (const stop of document.querySelectorAll('.stops span')) {
    stop.classList.toggle('now', Number(stop.dataset.stop) === app.index);
  }
}

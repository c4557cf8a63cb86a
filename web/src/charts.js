// Curves over the iterations; a click on one shows that iteration.
import uPlot from 'uplot';
import { el } from './dom.js';

const color = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();

function pick(iterations, get) {
  return iterations.map((it) => {
    const value = get(it);
    return value === undefined ? null : value;
  });
}

function definitions(iterations) {
  const completeness = Object.keys(iterations.at(-1)?.completeness ?? {});
  const stages = [...new Set(iterations.flatMap((it) => Object.keys(it.stage_wall_s ?? {})))];
  const total = (stage) => iterations.reduce((sum, it) => sum + (it.stage_wall_s?.[stage] ?? 0), 0);
  const longest = stages.sort((a, b) => total(b) - total(a)).slice(0, 3);
  return [
    {
      title: 'Covered',
      unit: ' %',
      max: 100,
      series: [
        ['covered', pick(iterations, (it) => it.covered_ratio * 100 || undefined)],
        [
          'of the reachable',
          pick(iterations, (it) => it.reachable_covered_ratio * 100 || undefined),
        ],
      ],
    },
    {
      title: 'Error against the truth',
      unit: ' mm',
      series: [
        ['mean', pick(iterations, (it) => it.mean_error_m * 1000 || undefined)],
        ['RMS', pick(iterations, (it) => it.rms_error_m * 1000 || undefined)],
      ],
    },
    {
      title: 'Completeness',
      unit: ' %',
      max: 100,
      series: completeness.map((key) => [
        `within ${key.replace('mm', ' mm')}`,
        pick(iterations, (it) => it.completeness?.[key] * 100 || undefined),
      ]),
    },
    {
      title: 'Photos',
      unit: '',
      series: [
        ['taken', pick(iterations, (it) => it.photos)],
        ['registered', pick(iterations, (it) => it.registered)],
      ],
    },
    {
      title: 'Time of an iteration',
      unit: ' s',
      series: [
        ['all', pick(iterations, (it) => it.wall_s)],
        ...longest.map((stage) => [stage, pick(iterations, (it) => it.stage_wall_s?.[stage])]),
      ],
    },
  ];
}

const dashes = [[], [7, 4], [2, 4], [10, 4, 2, 4]];

function options(chart, width, app) {
  const ink = color('--soft');
  const axis = {
    stroke: ink,
    font: '11px system-ui, sans-serif',
    grid: { stroke: color('--line'), width: 1 },
    ticks: { show: false },
  };
  return {
    width,
    height: 168,
    padding: [10, 8, 0, 0],
    cursor: {
      y: false,
      sync: { key: 'iterations' },
      drag: { x: false, y: false },
      points: { size: 7 },
    },
    legend: { live: true },
    scales: {
      x: {
        time: false,
        range: (u, low, high) => (low === high ? [low - 0.5, high + 0.5] : [low, high]),
      },
      y: { range: (u, low, high) => [0, chart.max ?? Math.max(high * 1.08, 1e-9)] },
    },
    axes: [
      { ...axis, incrs: [1, 2, 5, 10, 20, 50], grid: { show: false }, size: 26 },
      {
        ...axis,
        size: 46,
        values: (u, ticks) =>
          ticks.map((tick) => `${tick}${chart.unit.trim() === '%' ? ' %' : ''}`),
      },
    ],
    series: [
      { label: 'Iteration', value: (u, v) => (v === null ? '–' : String(v)) },
      ...chart.series.map(([label], i) => ({
        label,
        stroke: color(`--s${i + 1}`),
        width: 2,
        dash: dashes[i],
        points: { show: true, size: 5, fill: color('--card') },
        spanGaps: true,
        value: (u, v) =>
          v === null || v === undefined ? '–' : `${+v.toPrecision(4)}${chart.unit}`,
      })),
    ],
    hooks: {
      draw: [
        (u) => {
          // the iteration that is shown
          const x = u.valToPos(app.index, 'x', true);
          u.ctx.save();
          u.ctx.strokeStyle = color('--accent');
          u.ctx.lineWidth = devicePixelRatio;
          u.ctx.setLineDash([4 * devicePixelRatio, 3 * devicePixelRatio]);
          u.ctx.beginPath();
          u.ctx.moveTo(x, u.bbox.top);
          u.ctx.lineTo(x, u.bbox.top + u.bbox.height);
          u.ctx.stroke();
          u.ctx.restore();
        },
      ],
      ready: [
        (u) =>
          u.over.addEventListener('click', () => {
            if (u.cursor.idx !== null) app.show(u.cursor.idx);
          }),
      ],
    },
  };
}

export class Charts {
  constructor(box, app) {
    this.box = box;
    this.app = app;
    this.plots = [];
    new ResizeObserver(() => this.#resize()).observe(box);
  }

  draw() {
    for (const plot of this.plots) plot.destroy();
    this.plots = [];
    const { iterations } = this.app.session;
    const x = iterations.map((it, i) => i);
    this.box.replaceChildren();
    const width = this.box.clientWidth - 18; // of the frame
    if (width <= 0) return; // drawn when its tab is opened
    for (const chart of definitions(iterations)) {
      chart.series = chart.series.filter(([, values]) => values.some((v) => v !== null));
      if (chart.series.length === 0) continue;
      const frame = el('figure', { class: 'chart' }, el('figcaption', {}, chart.title));
      this.box.append(frame);
      this.plots.push(
        new uPlot(
          options(chart, width, this.app),
          [x, ...chart.series.map(([, values]) => values)],
          frame,
        ),
      );
    }
  }

  refresh() {
    for (const plot of this.plots) plot.redraw(false);
  }

  #resize() {
    const width = this.box.clientWidth - 18; // of the frame
    if (width <= 0) return;
    if (this.plots.length === 0) this.draw();
    for (const plot of this.plots) if (plot.width !== width) plot.setSize({ width, height: 168 });
  }
}

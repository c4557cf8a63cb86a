// How the page bears a large session: node bench.js [photos] [points]. Makes a session (one
// iteration of a hall on a lawn), opens it in chromium without a GPU (the worst case) and prints a
// Markdown table. Environment as of the tests, and WEB: folder with page.html, page.js, page.css.
import { cpSync, mkdirSync, readFileSync, writeFileSync } from 'node:fs';
import path from 'node:path';
import { pathToFileURL } from 'node:url';
import { deflateSync } from 'node:zlib';
import { firstPaint, launch, open, screenshot, settle, shown } from './tests/browser.js';

const [photos, points] = [Number(process.argv[2] ?? 500), Number(process.argv[3] ?? 2000000)];
const folder = path.join(process.env.OUTPUT, 'bench');

let seed = 1; // the same numbers at every run
const random = () => {
  seed = (Math.imul(seed, 1664525) + 1013904223) >>> 0;
  return seed / 4294967296;
};

function pack(values, components) {
  const bytes = [];
  const chunks = [];
  for (let i = 0; i < values.length; ++i) {
    const difference = values[i] - (i < components ? 0 : values[i - components]);
    let code = difference < 0 ? -2 * difference - 1 : 2 * difference;
    while (code >= 128) {
      bytes.push((code % 128) + 128);
      code = Math.floor(code / 128);
    }
    bytes.push(code);
    if (bytes.length > 1e6) chunks.push(Buffer.from(bytes.splice(0)));
  }
  chunks.push(Buffer.from(bytes));
  return {
    components,
    count: values.length / components,
    data: deflateSync(Buffer.concat(chunks)).toString('base64'),
  };
}

const height = (x, y) =>
  Math.abs(x) < 15 && Math.abs(y) < 25
    ? 9 + 0.15 * (15 - Math.abs(x))
    : 0.3 * Math.sin(x / 7) * Math.cos(y / 5);
const step = 0.002;
const put = (name, key, value) =>
  writeFileSync(
    path.join(folder, 'data', name),
    `colmapExt.put(${JSON.stringify(key)}, ${JSON.stringify(value)});\n`,
  );

// Points row by row, so that neighbours are near, as a Z-curve gives them.
function cloud(count) {
  const side = Math.ceil(Math.sqrt(count));
  const position = new Int32Array(3 * count);
  const color = new Int32Array(3 * count);
  for (let i = 0; i < count; ++i) {
    const x = -45 + (90 * (i % side)) / side + 0.05 * random();
    const y = -45 + (90 * Math.floor(i / side)) / side + 0.05 * random();
    const z = height(x, y);
    [x, y, z].forEach((v, k) => {
      position[3 * i + k] = Math.round(v / step);
    });
    const base = z > 5 ? [150, 90, 70] : [90, 125, 75];
    base.forEach((v, k) => {
      color[3 * i + k] = v + Math.floor(30 * random());
    });
  }
  return { position: { ...pack(position, 3), step }, color: pack(color, 3) };
}

function grid(cells) {
  const position = [];
  const face = [];
  for (let j = 0; j <= cells; ++j) {
    for (let i = 0; i <= cells; ++i) {
      const [x, y] = [-45 + (90 * i) / cells, -45 + (90 * j) / cells];
      position.push(...[x, y, height(x, y)].map((v) => Math.round(v / step)));
      if (i < cells && j < cells) {
        const a = j * (cells + 1) + i;
        face.push(a, a + 1, a + cells + 2, a, a + cells + 2, a + cells + 1);
      }
    }
  }
  return { position: { ...pack(position, 3), step }, face: pack(face, 3) };
}

function coverage(count) {
  const [position, normal, kind, views, error] = [[], [], [], [], []];
  for (let i = 0; i < count; ++i) {
    const [x, y] = [-40 + 80 * random(), -40 + 80 * random()];
    position.push(...[x, y, height(x, y)].map((v) => Math.round(v / step)));
    normal.push(0, 0, 127);
    const far = Math.hypot(x, y) / 40;
    kind.push(far > 1 ? 2 : random() > far ? 1 : 0);
    views.push(Math.round(8 * (1 - far) + 3));
    error.push(Math.round(4000 * (1 + 3 * far) * (0.7 + 0.6 * random())));
  }
  const counts = [0, 1, 2].map((k) => kind.filter((v) => v === k).length);
  return {
    position: { ...pack(position, 3), step },
    normal: pack(normal, 3),
    class: pack(kind, 1),
    good_views: pack(views, 1),
    predicted_error_um: pack(error, 1),
    disk_radius_m: 0.25,
    counts,
  };
}

function pictures(count) {
  return Array.from({ length: count }, (_, i) => {
    const [angle, z] = [0.13 * i, 16 + (i % 5)];
    const center = [42 * Math.cos(angle), 42 * Math.sin(angle), z];
    const yaw = Math.atan2(-center[0], -center[1]);
    const pitch = -0.35; // camera from world: level, then down
    const [cy, sy] = [Math.cos(yaw / 2), Math.sin(yaw / 2)];
    const [ct, st] = [Math.cos(Math.PI / 4 - pitch / 2), Math.sin(Math.PI / 4 - pitch / 2)];
    return {
      name: `photo_${String(i).padStart(4, '0')}.jpg`,
      camera: 0,
      center,
      rotation: [ct * cy, st * cy, -st * sy, ct * sy],
    };
  });
}

mkdirSync(path.join(folder, 'data'), { recursive: true });
mkdirSync(path.join(folder, 'assets'), { recursive: true });
for (const name of ['page.js', 'page.css'])
  cpSync(path.join(process.env.WEB, name), path.join(folder, 'assets', name));
writeFileSync(
  path.join(folder, 'index.html'),
  readFileSync(path.join(process.env.WEB, 'page.html'), 'utf8')
    .replaceAll('{{TITLE}}', 'bench')
    .replaceAll('{{STATUS}}', ''),
);
put('session.js', 'session', {
  title: 'bench',
  finished: '',
  sentence: 'A made-up large session',
  photo_folder: 'photos',
  iterations: [
    {
      photos,
      registered: photos,
      covered_ratio: 0.7,
      planned_views: 0,
      wall_s: 1,
      pictures: [],
      data: { scene: 'data/000.js', fused: 'data/000_fused.js', overlays: null },
    },
  ],
});
put('000.js', 'iteration/000', {
  origin: [0, 0, 0],
  frame: { metric: true },
  photos: {
    cameras: [{ width: 1600, height: 1064, fx: 1300, fy: 1300, cx: 800, cy: 532 }],
    list: pictures(photos),
  },
  points: cloud(100000),
  surface: grid(400),
  coverage: coverage(30000),
});
put('000_fused.js', 'fused/000', { origin: [0, 0, 0], total: points, ...cloud(points) });

const browser = await launch();
const page = await open(browser, pathToFileURL(path.join(folder, 'index.html')).href, {
  reducedMotion: 'no-preference',
});
await shown(page, 0);

const processes = await browser.newBrowserCDPSession();
/** CPU seconds of the browser so far, and the memory of its processes, MB. */
async function usage() {
  const { processInfo } = await processes.send('SystemInfo.getProcessInfo');
  const kib = processInfo.map(({ id }) => {
    try {
      return Number(/^Pss:\s+(\d+)/m.exec(readFileSync(`/proc/${id}/smaps_rollup`, 'utf8'))[1]);
    } catch {
      return 0; // it has ended
    }
  });
  return {
    cpu: processInfo.reduce((sum, { cpuTime }) => sum + cpuTime, 0),
    memory: kib.reduce((a, b) => a + b) / 1000,
  };
}
/** Waits until all that is shown is drawn. Returns the longest pause between two frames, ms. */
const complete = () =>
  page.evaluate(async () => {
    const { viewer } = colmapExt.app;
    const gl = viewer.renderer.getContext();
    let last = performance.now();
    let pause = 0;
    for (let still = 0; still < 3; ) {
      await new Promise((resolve) => requestAnimationFrame(resolve));
      still = viewer.pending ? 0 : still + 1;
      gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, new Uint8Array(4)); // waits for the drawing
      pause = Math.max(pause, performance.now() - last);
      last = performance.now();
    }
    return pause;
  });
/** Turns the view: ms from frame to frame (the middle one), CPU ms a frame. */
async function turning(frames) {
  const before = await usage();
  const ms = await page.evaluate(async (count) => {
    const { viewer } = colmapExt.app;
    const gl = viewer.renderer.getContext();
    const times = [];
    for (let i = 0; i < count; ++i) {
      const t = performance.now();
      viewer.nudge({ turn: 0.02 });
      await new Promise((resolve) => requestAnimationFrame(resolve));
      await new Promise((resolve) => setTimeout(resolve)); // the frame's commands are given
      gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, new Uint8Array(4));
      times.push(performance.now() - t);
    }
    return times.slice(count / 3).sort((a, b) => a - b)[Math.floor(count / 3)];
  }, frames);
  return [ms, (1000 * ((await usage()).cpu - before.cpu)) / frames];
}

const rows = [];
const row = (what, value, unit = 'ms') => rows.push([what, value, unit]);
row('first paint', await firstPaint(page));
const opened = await page.evaluate(() => performance.now());
row('page open: 100,000 sparse points, 320,000 faces, 30,000 iso-points, photos', opened);
await complete();
row('memory then, all processes of the browser', (await usage()).memory, 'MB');
const begun = Date.now();
await page.evaluate(() => colmapExt.app.setLayer('fused', true));
await page.waitForFunction(() => document.documentElement.dataset.fused === 'true');
row(`load and decode ${points.toLocaleString('en')} points`, Date.now() - begun);
await complete();
row('… until all of them are drawn', Date.now() - begun);
row('memory then', (await usage()).memory, 'MB');
const all = await turning(15);
row('turning the view, everything shown: a frame', all[0]);
row('CPU time of such a frame (the machine has other work)', all[1]);
const rested = Date.now();
const pause = await complete();
row('from the last turn until all points are drawn again', Date.now() - rested);
row('longest pause between frames meanwhile', pause);
await page.evaluate(() => colmapExt.app.setLayer('fused', false));
await complete();
const few = await turning(15);
row('turning without the dense points: a frame', few[0]);
row('CPU time of such a frame', few[1]);
await complete();
const click = await page.evaluate(() => {
  const t = performance.now();
  const box = colmapExt.app.viewer.canvas.getBoundingClientRect();
  colmapExt.app.viewer.pick(box.left + box.width / 2, box.top + box.height / 2);
  const first = performance.now() - t;
  const u = performance.now();
  const { point, normal } = colmapExt.app.viewer.isoPoint(100);
  const seen = colmapExt.app.viewer.photosThatSee(point, normal).length;
  return [first, performance.now() - u, seen];
});
row('first click: search tree over 320,000 faces and what is there', click[0]);
row(`photos that see a point, of ${photos} (${click[2]} do)`, click[1]);
await settle(page);
await screenshot(page, 'bench');
console.log(
  `| what | value |\n|---|---|\n${rows.map(([what, value, unit]) => `| ${what} | ${value.toFixed(0)} ${unit} |`).join('\n')}`,
);
const problems = page.problems.filter((text) => !/photos\/|ERR_FILE_NOT_FOUND/.test(text)); // it has no photos
if (problems.length) console.log(problems.join('\n'));
await browser.close();

// A browser, a workspace with its page, and what tests of the page have in common. Environment:
// CHROMIUM, MODULES (node_modules), MAKE_WORKSPACE, OUTPUT (screenshots and the workspace).
import { spawn, execFileSync } from 'node:child_process';
import { mkdirSync } from 'node:fs';
import { createRequire } from 'node:module';
import { createInterface } from 'node:readline';
import { pathToFileURL } from 'node:url';
import path from 'node:path';

const { CHROMIUM = '/usr/bin/chromium', MODULES, MAKE_WORKSPACE, OUTPUT } = process.env;
const { chromium } = createRequire(path.join(MODULES, 'browser.js'))('playwright-core');

mkdirSync(OUTPUT, { recursive: true });
export const screenshot = (page, name) =>
  page.screenshot({ path: path.join(OUTPUT, `${name}.png`) });

/** Makes the workspace and returns the address of its page on disk. */
export function makePage(name) {
  const folder = path.join(OUTPUT, name);
  execFileSync(MAKE_WORKSPACE, [folder], { stdio: ['ignore', 'ignore', 'inherit'] });
  return pathToFileURL(path.join(folder, 'report', 'index.html')).href;
}

/** The same workspace served live: {url, folder, say(word), end()}. */
export async function serveWorkspace(name) {
  const folder = path.join(OUTPUT, name);
  const child = spawn(MAKE_WORKSPACE, [folder, '--serve'], { stdio: ['pipe', 'pipe', 'inherit'] });
  const lines = createInterface({ input: child.stdout })[Symbol.asyncIterator]();
  const next = async () => (await lines.next()).value;
  const url = await next();
  return {
    url,
    folder,
    say(word) {
      child.stdin.write(`${word}\n`);
      return next();
    },
    end() {
      child.stdin.end();
      return new Promise((resolve) => child.on('exit', resolve));
    },
  };
}

export async function launch() {
  return chromium.launch({
    executablePath: CHROMIUM,
    args: [
      '--no-sandbox',
      '--disable-quic',
      '--no-first-run',
      '--disable-background-networking',
      '--disable-component-update',
      '--disable-sync',
      '--use-gl=angle',
      '--use-angle=swiftshader',
      '--enable-unsafe-swiftshader',
    ],
  });
}

/** A page whose console errors and failed requests are in `page.problems`. */
export async function open(browser, url, options = {}) {
  const context = await browser.newContext({
    viewport: { width: 1280, height: 800 },
    reducedMotion: 'reduce',
    colorScheme: 'light',
    ...options,
  });
  const page = await context.newPage();
  page.problems = [];
  page.on('console', (message) => {
    if (
      ['error', 'warning'].includes(message.type()) &&
      !/GPU stall|GL Driver Message|willReadFrequently/.test(message.text())
    )
      page.problems.push(message.text());
  });
  page.on('pageerror', (error) => page.problems.push(String(error)));
  page.on('requestfailed', (request) => {
    const closed = request.failure()?.errorText === 'net::ERR_ABORTED'; // a stream, by the page
    if (!(closed && request.url().includes('/api/events')))
      page.problems.push(`failed: ${request.url()}`);
  });
  await page.goto(url);
  return page;
}

/** Waits until iteration `index` is drawn. */
export async function shown(page, index) {
  await page.waitForFunction((i) => document.documentElement.dataset.shown === String(i), index, {
    timeout: 60000,
  });
  await settle(page);
}

/** Waits for two frames. */
export const settle = (page) =>
  page.evaluate(
    () => new Promise((resolve) => requestAnimationFrame(() => requestAnimationFrame(resolve))),
  );

/** Pixels of the 3D view alone, as a string that changes when the picture does. */
export async function picture(page) {
  await settle(page);
  return page.evaluate(() => {
    const { viewer } = globalThis.colmapExt.app;
    viewer.renderer.render(viewer.scene, viewer.camera);
    return viewer.canvas.toDataURL();
  });
}

/** How many pixels of two screenshots differ by more than the browser's own dithering. */
export const differing = (page, ...pngs) =>
  page.evaluate(
    async (texts) => {
      const [a, b] = await Promise.all(
        texts.map(async (text) => {
          const image = await createImageBitmap(
            new Blob([Uint8Array.from(atob(text), (c) => c.charCodeAt(0))], { type: 'image/png' }),
          );
          const canvas = new OffscreenCanvas(image.width, image.height);
          const context = canvas.getContext('2d');
          context.drawImage(image, 0, 0);
          return context.getImageData(0, 0, image.width, image.height).data;
        }),
      );
      let count = 0;
      for (let i = 0; i < a.length; i += 4) {
        if ([0, 1, 2].some((k) => Math.abs(a[i + k] - b[i + k]) > 16)) ++count;
      }
      return count;
    },
    pngs.map((png) => png.toString('base64')),
  );

/** Where a world position (on the page's axes) is in the window. */
export const placeOf = (page, xyz) =>
  page.evaluate(([x, y, z]) => {
    const { viewer } = globalThis.colmapExt.app;
    const p = viewer.camera.position.clone().set(x, y, z).project(viewer.camera);
    const box = viewer.canvas.getBoundingClientRect();
    return { x: box.left + ((p.x + 1) / 2) * box.width, y: box.top + ((1 - p.y) / 2) * box.height };
  }, xyz);

/** Milliseconds from the navigation to the first paint with content. */
export async function firstPaint(page) {
  const entry = await page.waitForFunction(
    () => performance.getEntriesByName('first-contentful-paint')[0]?.startTime,
  );
  return entry.jsonValue();
}

// The page as report_generator writes it, opened from a file.
import assert from 'node:assert/strict';
import { after, before, beforeEach, describe, it } from 'node:test';
import {
  differing,
  firstPaint,
  launch,
  makePage,
  open,
  picture,
  placeOf,
  screenshot,
  settle,
  shown,
} from './browser.js';

const last = 2; // the made-up session's last iteration: 14 photos
let browser, url, page;

before(async () => {
  url = makePage('workspace');
  browser = await launch();
});
after(() => browser.close());

const app = (body) => page.evaluate(`(() => { const app = colmapExt.app; return ${body}; })()`);

describe('the page', () => {
  beforeEach(async () => {
    await page?.context().close();
    page = await open(browser, url);
    await shown(page, last);
  });

  it('loads from a file without errors and paints within 2 s', async (t) => {
    // The best of three, so that a machine that was busy for a moment does not count against the
    // page; where even a page of one word is slow, the page may be slower by as much.
    const paints = { word: [], page: [] };
    for (let i = 0; i < 3; ++i) {
      for (const [name, address] of [
        ['word', 'data:text/html,word'],
        ['page', url],
      ]) {
        const loaded = await open(browser, address);
        paints[name].push(await firstPaint(loaded));
        await loaded.context().close();
      }
    }
    const [word, paint] = [Math.min(...paints.word), Math.min(...paints.page)];
    t.diagnostic(`first paint after ${paint} ms, of a page of one word after ${word} ms`);
    assert.ok(paint < 2000 + 5 * word, `first paint after ${paint} ms`);
    assert.equal(await page.title(), 'workspace');
    assert.match(await page.textContent('#status'), /covered/);
    const outside = await page.evaluate(() =>
      performance
        .getEntriesByType('resource')
        .map((r) => r.name)
        .filter((n) => /^https?:/.test(n)),
    );
    assert.deepEqual(outside, []);
    await screenshot(page, 'made_up_light');
    assert.deepEqual(page.problems, []);
  });

  it('shows and hides every layer', async () => {
    for (const layer of [
      'surface',
      'color',
      'coverage',
      'points',
      'fused',
      'photos',
      'views',
      'path',
      'drone',
      'ground',
    ]) {
      if (layer === 'color' || layer === 'points')
        await app(`(app.setLayer('coverage', false), 0)`);
      const box = page.locator(`[data-layer=${layer}] input`);
      const [on, first] = [await box.isChecked(), await picture(page)];
      await box.setChecked(!on);
      if (layer === 'fused')
        await page.waitForFunction(() => document.documentElement.dataset.fused === 'true');
      assert.notEqual(await picture(page), first, `${layer} changes nothing`);
      await box.setChecked(on);
      assert.equal(await picture(page), first, `${layer} does not come back`);
    }
    assert.deepEqual(page.problems, []);
  });

  it('colours the coverage map by class, error, score and views, with legends', async () => {
    const pictures = [await picture(page)];
    const legend = () => page.textContent('#legend');
    assert.match(await legend(), /uncovered.*covered.*ignored/s);
    await page.click('[data-coloring=error]');
    assert.match(await legend(), /mm.*unknown/s);
    pictures.push(await picture(page));
    await page.keyboard.press('c');
    assert.match(await legend(), /50 %.*how sure/s);
    pictures.push(await picture(page));
    await page.keyboard.press('c');
    assert.match(await legend(), /10 or more/);
    pictures.push(await picture(page));
    assert.equal(new Set(pictures).size, 4);
    await page.keyboard.press('c'); // the last one is followed by the first
    assert.equal(await picture(page), pictures[0]);
    await page.focus('[data-coloring=class]');
    await page.keyboard.press('ArrowRight');
    assert.equal(await page.getAttribute('[data-coloring=error]', 'aria-checked'), 'true');
    await page.click('[data-coloring=class]');
    for (const [k, row] of (await page.locator('#legend .row input').all()).entries()) {
      await row.uncheck();
      assert.notEqual(await picture(page), pictures[0], `class ${k}`);
      await row.check();
    }
    assert.equal(await picture(page), pictures[0]);
    const score = await app('app.data.coverage.score[0]');
    await app('app.selectPoint(0)');
    await page.waitForSelector('#point-card');
    const shares = `${((100 * score) / 255).toFixed(1)} %`;
    assert.ok((await page.textContent('#point-card')).includes(`Score${shares}`));
  });

  it('colours amounts by lightness, and classes so that any eyes tell them apart', async () => {
    // Vienot, Brettel and Mollon's (1999) simulation of the two red-green blindnesses in linear
    // RGB; a difference of colours as weighted distance. The classes on both backgrounds.
    const colors = await page.evaluate(() =>
      [...document.querySelectorAll('#legend .swatch')].map(
        (each) => getComputedStyle(each).backgroundColor,
      ),
    );
    const linear = (text) => text.match(/\d+/g).map((v) => (Number(v) / 255) ** 2.2);
    const blind = {
      protan: ([r, g, b]) => [0.1124 * r + 0.8876 * g, 0.1124 * r + 0.8876 * g, b],
      deutan: ([r, g, b]) => [0.2927 * r + 0.7073 * g, 0.2927 * r + 0.7073 * g, b],
    };
    assert.equal(colors.length, 3);
    for (const [name, see] of Object.entries(blind)) {
      const seen = colors.map((text) => see(linear(text)).map((v) => 255 * v ** (1 / 2.2)));
      for (const [i, j] of [
        [0, 1],
        [0, 2],
        [1, 2],
      ]) {
        const apart = Math.hypot(...seen[i].map((v, k) => v - seen[j][k]));
        assert.ok(apart > 40, `${name}: classes ${i} and ${j} are ${apart} apart`);
      }
    }
    for (const coloring of ['error', 'score', 'views']) {
      await page.click(`[data-coloring=${coloring}]`);
      const stops = await page
        .locator('#legend .ramp')
        .evaluate((each) => each.style.background.match(/rgb\([^)]*\)/g));
      const light = stops.map((text) => {
        const [r, g, b] = linear(text);
        return 0.2126 * r + 0.7152 * g + 0.0722 * b;
      });
      const steps = light.slice(1).map((v, i) => v - light[i]);
      assert.ok(
        steps.every((v) => v > 0) || steps.every((v) => v < 0),
        `${coloring}: lightness ${light}`,
      );
    }
  });

  it('draws a large cloud bit by bit, and fewer points while the view moves', async () => {
    await page.evaluate(() => {
      const { viewer } = colmapExt.app;
      const [count, position, color] = [200000, new Float32Array(600000), new Uint8Array(600000)];
      for (let i = 0; i < count; ++i) {
        const [a, r] = [2.4 * i, 9 * Math.sqrt(i / count)];
        position.set([r * Math.cos(a), r * Math.sin(a), 6 * Math.exp((-r * r) / 9)], 3 * i);
        color.set([80 + 20 * r, 200 - 15 * r, 90], 3 * i);
      }
      Object.assign(viewer.painter.pace, { share: 0.05, coarse: true }); // as on a slow machine
      viewer.setFused({ position, color });
      viewer.shown.fused = true;
      viewer.apply();
    });
    const drawn = () =>
      page.waitForFunction(
        () => colmapExt.app.viewer.painter.complete && !colmapExt.app.viewer.pending,
      );
    await drawn();
    const first = await page.locator('#canvas').screenshot();
    const moving = await page.evaluate(async () => {
      const { viewer } = colmapExt.app;
      viewer.nudge({ turn: 0.5 });
      await new Promise((resolve) => requestAnimationFrame(() => setTimeout(resolve)));
      const { count } = viewer.layers.fused.geometry.drawRange;
      viewer.nudge({ turn: -0.5 });
      return count;
    });
    assert.ok(moving > 0 && moving < 20000, `${moving} points`);
    await drawn();
    assert.ok((await differing(page, first, await page.locator('#canvas').screenshot())) < 20);
    const pieces = await page.evaluate(() => {
      const { viewer } = colmapExt.app;
      Object.assign(viewer.painter.pace, { share: 1, coarse: false }); // all at once
      viewer.invalidate();
      return viewer.painter.growing.cloud;
    });
    assert.equal(pieces, 1, 'the cloud was drawn in pieces');
    await drawn();
    const atOnce = await page.locator('#canvas').screenshot();
    assert.ok((await differing(page, first, atOnce)) < 20, 'another picture than at once');
    await app(`(app.setLayer('coverage', false), 0)`);
    const other = await page.locator('#canvas').screenshot();
    assert.ok((await differing(page, first, other)) > 2000, 'the comparison sees nothing');
    assert.deepEqual(page.problems, []);
  });

  it('goes through the iterations by slider, buttons, keys, table and curve', async () => {
    const photos = () => app('app.data.photos.length');
    assert.equal(await photos(), 14);
    await page.locator('#scrub').fill('0');
    await shown(page, 0);
    assert.equal(await photos(), 6);
    assert.match(await page.textContent('#now'), /Iteration 0 of 2.*6 photos/s);
    assert.match(await page.textContent('#tiles'), /50\.0 %.*views planned next/s);
    await page.click('#next');
    await shown(page, 1);
    await page.keyboard.press('.');
    await shown(page, 2);
    assert.match(await page.textContent('#tiles'), /views planned, not flown/);
    await page.keyboard.press(',');
    await shown(page, 1);
    await page.click('#tab-table');
    await page.click('#table tbody tr:nth-child(3)');
    await shown(page, 2);
    await page.click('#tab-progress');
    assert.equal(await page.locator('#progress figure').count(), 5);
    const curve = await page.locator('#progress .u-over').first().boundingBox();
    await page.mouse.move(curve.x + 3, curve.y + 40);
    await page.mouse.click(curve.x + 2, curve.y + 40);
    await shown(page, 0);
    await page.click('#play');
    await shown(page, 1);
    await shown(page, 2);
    await page.waitForFunction(() => document.getElementById('play').textContent === '▶');
    assert.deepEqual(page.problems, []);
  });

  it('tells which photos see an iso-point', async () => {
    // On the ridge side of the roof that faces +x.
    const index = await app(`(() => { const c = app.data.coverage, o = app.iterations.origin;
      let best = 0, d = 1e9; for (let i = 0; i < c.kind.length; ++i) {
        const p = [1, 0, 4].map((v, k) => c.position[3 * i + k] + o[k] - v); const l = Math.hypot(...p);
        if (l < d) { d = l; best = i; } } return best; })()`);
    const at = await app(
      `Array.from(app.data.coverage.position.subarray(3 * ${index}, 3 * ${index} + 3))`,
    );
    await app(`(app.viewer.fit('side', false), app.viewer.nudge({ turn: 1.0 }), 0)`);
    await settle(page);
    const place = await placeOf(page, at);
    await page.mouse.click(place.x, place.y);
    await page.waitForSelector('#point-card');
    assert.equal(await app('app.selection.iso'), index);
    const seen = await app('app.selection.seen.map((s) => s.index)');
    // The house is convex: a photo sees this side of the roof if and only if it is above its plane
    // (normal (1, 0, 1)) by 10 degrees, and the point is in its picture.
    const truth = await app(`(() => { const c = app.data.coverage, i = ${index}, out = [];
      const p = app.viewer.camera.position.clone().fromArray(c.position, 3 * i);
      app.data.photos.forEach((photo, k) => { const way = photo.center.clone().sub(p);
        const sin = (way.x + way.z) / Math.SQRT2 / way.length(); const px = app.viewer.projectTo(photo, p);
        if (sin > Math.cos(80 * Math.PI / 180) && px && px.x > 4 && px.y > 4 && px.x < 476 && px.y < 316) out.push(k); }); return out; })()`);
    assert.ok(truth.length > 2 && truth.length < 14, `${truth.length} photos`);
    assert.deepEqual(
      [...seen].sort((a, b) => a - b),
      truth,
    );
    assert.equal(await page.locator('#seen .thumb').count(), seen.length);
    await screenshot(page, 'made_up_point');
    await page.locator('#seen .thumb').first().click();
    await page.waitForSelector('.photo-card');
    assert.equal(await app('app.selection.photo'), seen[0]);
    await page.keyboard.press('Escape');
    await page.waitForSelector('#photos');
    assert.deepEqual(page.problems, []);
  });

  it('shows a photo with its superpixels and confidence', async () => {
    const at = await app(
      '(() => { const p = app.data.photos[3]; return p.center.clone().addScaledVector(p.forward, 0.55 * app.viewer.unit).toArray(); })()',
    );
    const place = await placeOf(page, at);
    await page.mouse.click(place.x, place.y);
    await page.waitForSelector('.photo-card');
    assert.equal(await app('app.selection.photo'), 3);
    const canvas = page.locator('.photo-card canvas');
    // Colour of the overlay in a triangle (share of width, height).
    const color = (x, y) =>
      canvas.evaluate(
        (c, [u, v]) =>
          Array.from(c.getContext('2d').getImageData(u * c.width, v * c.height, 1, 1).data),
        [x, y],
      );
    assert.equal(await canvas.getAttribute('data-drawn'), 'mesh');
    assert.equal((await color(0.4, 0.2))[3], 0);
    const edge = await color(0.5, 0.3); // between the two superpixels
    assert.ok(edge[0] > 200 && edge[3] > 100, `edge ${edge}`);
    await page.click('[data-overlay=confidence]');
    await page.waitForSelector('canvas[data-drawn="mesh confidence"]');
    const sure = await color(0.4, 0.2);
    const unsure = await color(0.9, 0.2);
    assert.ok(sure[0] > unsure[0] + 60, `${sure} ${unsure}`);
    assert.equal((await color(0.7, 0.8))[3], 0, 'no support, no colour');
    await page.keyboard.press('m');
    await page.waitForSelector('canvas[data-drawn=confidence]');
    await page.keyboard.press(']');
    await page.waitForFunction(() => colmapExt.app.selection.photo === 4);
    await page.click('#enlarge');
    await page.waitForSelector('#viewer[open]');
    await page.keyboard.press('Escape');
    const natural = await page.locator('.photo-card img').evaluate((image) => image.naturalWidth);
    assert.equal(natural, 480);
    assert.deepEqual(page.problems, []);
  });

  it('looks through a photo, which lies where the model is', async () => {
    await app('app.selectPhoto(5)');
    await page.click('#look-through');
    await page.waitForSelector('#through:not([hidden]) img');
    const box = await page.locator('#through img').boundingBox();
    const at = await app(
      '(() => { const p = app.data.photos[5]; const x = app.viewer.camera.position.clone().set(0, 0, 0); return [x.toArray(), app.viewer.projectTo(p, x)]; })()',
    );
    const place = await placeOf(page, at[0]);
    assert.ok(
      Math.abs(box.x + (at[1].x / 480) * box.width - place.x) < 2,
      'the photo is beside the model',
    );
    assert.ok(
      Math.abs(box.y + (at[1].y / 320) * box.height - place.y) < 2,
      'the photo is above or below the model',
    );
    await screenshot(page, 'made_up_look_through');
    await page.keyboard.press('Escape');
    assert.equal(await page.locator('#through').isHidden(), true);
  });

  it('can be used by keyboard alone', async () => {
    await page.focus('#canvas');
    const where = () => app('app.viewer.camera.position.toArray()');
    let old = await where();
    for (const key of ['ArrowLeft', 'ArrowUp', '+', '-', 'w', 'a', 't', 'g', 'f']) {
      await page.keyboard.press(key);
      await settle(page);
      assert.notDeepEqual(await where(), old, key);
      old = await where();
    }
    await page.keyboard.press('3');
    assert.equal(await app('app.viewer.shown.coverage'), false);
    await page.keyboard.press('?');
    assert.equal(await page.locator('#help').isVisible(), true);
    await page.keyboard.press('Escape');
    await page.focus('#tab-inspect');
    await page.keyboard.press('ArrowRight');
    assert.equal(await page.getAttribute('#tab-progress', 'aria-selected'), 'true');
    await page.keyboard.press('ArrowLeft');
    await page.focus('#photos .thumb');
    await page.keyboard.press('ArrowRight');
    await page.keyboard.press('Enter');
    await page.waitForSelector('.photo-card');
    assert.equal(await app('app.selection.photo'), 1);
  });

  it('does by its buttons what its keys do', async () => {
    const where = () => app('app.viewer.camera.position.toArray()');
    let old = await where();
    for (const view of ['top', 'side', 'fit']) {
      await page.click(`[data-view=${view}]`);
      await settle(page);
      assert.notDeepEqual(await where(), old, view);
      old = await where();
    }
    const fold = page.locator('#layers .fold');
    await fold.click();
    assert.equal(await page.locator('#layers .layerlist').isVisible(), false);
    assert.equal(await fold.getAttribute('aria-expanded'), 'false');
    await fold.click();
    assert.equal(await page.locator('#layers .layerlist').isVisible(), true);
    await page.click('#help-open');
    assert.match(await page.textContent('#help'), /Space.*play/s);
    await page.click('#help button');
    assert.equal(await page.locator('#help').isVisible(), false);
    await page.locator('#photos .thumb').nth(2).hover();
    assert.equal(await app('app.viewer.selectedPhoto'), 2);
    await page.locator('#photos .thumb').nth(2).click();
    await page.click('.photo-card [aria-label="Next photo"]');
    await page.waitForFunction(() => colmapExt.app.selection.photo === 3);
    await page.click('.photo-card [aria-label="Photo before"]');
    await page.waitForFunction(() => colmapExt.app.selection.photo === 2);
    await page.click('#enlarge');
    await page.waitForSelector('#viewer[open]');
    await page.click('#viewer [aria-label="Next photo"]');
    await page.waitForFunction(() => document.getElementById('viewer').textContent.includes('103'));
    await page.click('#viewer button:has-text("Close")');
    assert.equal(await page.locator('#viewer').isVisible(), false);
    await page.click('#look-through');
    await page.waitForSelector('#through:not([hidden]) img');
    await page.locator('#through input').fill('25');
    assert.equal(
      await page.locator('#through img').evaluate((image) => image.style.opacity),
      '0.25',
    );
    await page.click('#through button');
    assert.equal(await page.locator('#through').isHidden(), true);
    await page.click('.photo-card [aria-label=Close]');
    await page.waitForSelector('#photos');
    await page.locator('#canvas').dblclick({ position: { x: 640 - 180, y: 400 } });
    await page.click('#tab-table');
    assert.match(await page.textContent('#table'), /Where the time of iteration 2 went/);
    await page.click('a[href="pictures.html"]');
    await page.waitForLoadState();
    assert.match(page.url(), /pictures\.html$/);
    assert.deepEqual(page.problems, []);
  });

  it('names every control, and keeps the focus in sight', async () => {
    const nameless = await page.evaluate(() =>
      [...document.querySelectorAll('button, a[href], input, [role=tab], [role=radio]')]
        .filter((each) => each.checkVisibility())
        .filter(
          (each) =>
            !each.textContent.trim() &&
            !each.getAttribute('aria-label') &&
            !each.labels?.[0]?.textContent.trim(),
        )
        .map((each) => each.outerHTML),
    );
    assert.deepEqual(nameless, []);
    const seen = new Set();
    for (let i = 0; i < 20; ++i) {
      await page.keyboard.press('Tab');
      const [what, ring] = await page.evaluate(() => {
        const { activeElement: e } = document;
        const style = getComputedStyle(e);
        const name = e.labels?.[0]?.textContent || e.textContent.trim() || e.id;
        return [name, style.outlineStyle];
      });
      seen.add(what);
      assert.notEqual(ring, 'none', `${what} shows no focus`);
    }
    assert.ok(seen.size >= 15, `only ${seen.size} places are reached by Tab`);
  });

  it('has a light and a dark face', async () => {
    const background = () => page.evaluate(() => getComputedStyle(document.body).backgroundColor);
    const light = await background();
    await page.click('#theme');
    assert.notEqual(await background(), light);
    await screenshot(page, 'made_up_dark');
    await page.keyboard.press('l');
    assert.equal(await background(), light);
    await page.emulateMedia({ colorScheme: 'dark' });
  });

  it('fits a phone', async () => {
    await page.context().close();
    page = await open(browser, url, {
      viewport: { width: 390, height: 844 },
      deviceScaleFactor: 2,
      hasTouch: true,
      isMobile: true,
      colorScheme: 'dark',
    });
    await shown(page, last);
    assert.equal(await page.evaluate(() => document.documentElement.scrollWidth), 390);
    await screenshot(page, 'made_up_phone');
    const canvas = await page.locator('#canvas').boundingBox();
    await page.touchscreen.tap(canvas.x + canvas.width / 2, canvas.y + canvas.height / 2);
    await page.waitForSelector('#point-card, .photo-card');
    assert.deepEqual(page.problems, []);
  });
});

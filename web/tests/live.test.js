// The page as active_capture --serve shows it: iterations arrive, messages, the flight; and what the
// server refuses.
import assert from 'node:assert/strict';
import { writeFileSync } from 'node:fs';
import http from 'node:http';
import { after, before, describe, it } from 'node:test';
import path from 'node:path';
import { launch, open, screenshot, serveWorkspace, shown } from './browser.js';

let browser, site, page, daemon;
const heard = []; // requests to the daemon
const status = {
  state: 'flying',
  reason: '',
  revision: 1,
  next_stop: 2,
  stops: 4,
  flights: 1,
  vehicle: {
    stack: 'px4',
    description: 'PX4 v1.14',
    armed: true,
    mode: 'Offboard',
    landed: false,
    battery_percent: 71,
    relative_height_m: 12.3,
    speed_m_s: 2.9,
    yaw_deg: 90,
    position_enu_m: [4, 8, 7],
  },
  views: [
    { view_id: 0, photo: 'a.jpg', status: 'stored' },
    { view_id: 1, photo: 'b.jpg', status: 'asked' },
    { view_id: 2, photo: 'c.jpg', status: 'pending' },
  ],
};

before(async () => {
  site = await serveWorkspace('live');
  browser = await launch();
  daemon = http.createServer((request, response) => {
    let body = '';
    request.on('data', (part) => {
      body += part;
    });
    request.on('end', () => {
      heard.push({
        call: `${request.method} ${request.url}`,
        body,
        authorization: request.headers.authorization,
      });
      if (request.url === '/v1/pause') status.state = 'paused';
      const refused = request.url === '/v1/resume';
      response.writeHead(refused ? 409 : 200, { 'Content-Type': 'application/json' });
      response.end(JSON.stringify(refused ? { error: 'a pilot has the sticks' } : status));
    });
  });
  await new Promise((resolve) => daemon.listen(0, '127.0.0.1', resolve));
});
after(async () => {
  daemon.close();
  await browser.close();
  assert.equal(await site.end(), 0);
});

// One request without a browser: {status, body, headers}.
function ask(target, { method = 'GET', headers = {}, body } = {}) {
  const { port } = new URL(site.url);
  return new Promise((resolve, reject) => {
    const request = http.request(
      {
        host: '127.0.0.1',
        port,
        path: target,
        method,
        headers: { Host: `127.0.0.1:${port}`, ...headers },
      },
      (response) => {
        let text = '';
        response.on('data', (part) => {
          text += part;
        });
        response.on('end', () =>
          resolve({ status: response.statusCode, body: text, headers: response.headers }),
        );
      },
    );
    request.on('error', reject);
    request.end(body);
  });
}

describe('the live page', () => {
  it('shows messages, progress and each new iteration', async () => {
    page = await open(browser, site.url);
    await shown(page, 0);
    await page.waitForFunction(
      () => document.getElementById('activity-text').textContent === 'matching 25 %',
    );
    assert.equal(await page.locator('#flight').isHidden(), true);
    await page.click('#tab-log');
    assert.match(await page.textContent('#log'), /Iteration 1/);
    await site.say('next');
    await shown(page, 1); // follows the newest
    assert.match(await page.textContent('#now'), /of 1/);
    await page.locator('#scrub').fill('0');
    await shown(page, 0);
    await site.say('next');
    await page.waitForFunction(() => document.getElementById('now').textContent.includes('of 2'));
    assert.equal(
      await page.evaluate(() => colmapExt.app.index),
      0,
      'who looks at an older one stays there',
    );
    await page.waitForFunction(() =>
      document.getElementById('log').textContent.includes('did: next'),
    );
    assert.deepEqual(page.problems, []);
  });

  it('is told by server-sent events, and asks again after a lost connection', async () => {
    const { events, type } = await new Promise((resolve, reject) => {
      const { port } = new URL(site.url);
      http
        .get({ host: '127.0.0.1', port, path: '/api/events?since=0' }, (response) => {
          let text = '';
          response.on('data', (part) => {
            text += part;
            if (!text.includes('\n\n')) return;
            response.destroy();
            resolve({ events: text, type: response.headers['content-type'] });
          });
        })
        .on('error', reject);
    });
    assert.match(type, /text\/event-stream/);
    assert.equal(JSON.parse(events.split('\n')[0].slice(6)).messages[0].text, 'Iteration 1');
    const asked = await page.evaluate(
      () => performance.getEntriesByType('resource').filter((r) => /api\/live/.test(r.name)).length,
    );
    assert.equal(asked, 1, 'it does not poll');
    const told = () => page.locator('#log li').count();
    const before = await told();
    await page.evaluate(() => {
      colmapExt.app.live.events.dispatchEvent(new Event('error'));
    });
    await site.say('hello');
    await page.waitForFunction((n) => document.querySelectorAll('#log li').length > n, before);
    await page.waitForTimeout(1000);
    assert.equal(await told(), before + 1, 'no message comes twice');
    assert.deepEqual(page.problems, []);
  });

  it('shows the flight, and pauses, resumes and aborts it', async () => {
    writeFileSync(
      path.join(site.folder, 'flightd.json'),
      JSON.stringify({ port: daemon.address().port, pid: process.pid, token: 'secret' }),
    );
    await page.waitForSelector('#flight:not([hidden])');
    assert.match(
      await page.textContent('#flight'),
      /flying.*71 %.*1 stored · 1 being taken · 1 to come.*PX4/s,
    );
    const drone = await page.evaluate(() =>
      colmapExt.app.viewer.drone.position
        .toArray()
        .map((v, k) => v + colmapExt.app.iterations.origin[k]),
    );
    [4, 8, 7].forEach((v, k) => assert.ok(Math.abs(drone[k] - v) < 1e-6));
    await page.click('[data-do=pause]');
    await page.waitForFunction(
      () => document.querySelector('#flight .state').textContent === 'paused',
    );
    assert.ok(
      heard.some((h) => h.call === 'POST /v1/pause' && h.authorization === 'Bearer secret'),
    );
    await screenshot(page, 'made_up_flight');
    const known = page.problems.length;
    await page.click('[data-do=resume]');
    await page.waitForFunction(
      () => document.querySelector('#flight .error')?.textContent === 'a pilot has the sticks',
    );
    page.problems.length = known; // the browser logs the 409
    await page.click('[data-do=abort]');
    assert.ok(!heard.some((h) => h.call === 'POST /v1/abort'), 'it asks first');
    await page.click('[data-do=no]');
    await page.click('[data-do=abort]');
    assert.equal(await page.locator('[data-do=abort-rtl]').count(), 1);
    await page.click('[data-do=abort-land]');
    await page.waitForFunction(() => document.querySelector('[data-do=abort]'));
    assert.deepEqual(
      heard.filter((h) => h.call === 'POST /v1/abort').map((h) => h.body),
      ['{"how":"land"}'],
    );
    assert.deepEqual(page.problems, []);
  });

  it('refuses what does not come from the page', async () => {
    const { token } = JSON.parse((await ask('/api/live')).body);
    const calls = heard.length;
    const post = (headers) =>
      ask('/api/flight/abort', { method: 'POST', headers, body: '{"how":"land"}' });
    assert.equal((await post({})).status, 403);
    assert.equal((await post({ 'X-Colmap-Ext-Token': 'guess' })).status, 403);
    assert.equal(
      (await post({ 'X-Colmap-Ext-Token': token, Origin: 'http://evil.example' })).status,
      403,
    );
    assert.equal((await post({ 'X-Colmap-Ext-Token': token, Host: 'evil.example' })).status, 403);
    assert.equal((await ask('/api/live', { headers: { Host: 'evil.example' } })).status, 403);
    assert.equal((await ask('/api/live', { headers: { Origin: 'null' } })).status, 403);
    assert.equal((await ask('/', { method: 'PUT' })).status, 405);
    for (const target of [
      '/../summary.json',
      '/%2e%2e/summary.json',
      '/data/..%2f..%2fsummary.json',
      '/.hidden',
      '//etc/passwd',
      '/nothing',
    ]) {
      assert.ok([403, 404].includes((await ask(target)).status), target);
    }
    const good = heard.slice(calls).filter((h) => h.call.startsWith('POST'));
    assert.deepEqual(good, []);
    const index = await ask('/');
    assert.match(index.headers['content-security-policy'], /frame-ancestors 'none'/);
  });

  it('stays when the session ends', async () => {
    await site.say('finish');
    await page.waitForFunction(() => document.getElementById('activity').hidden);
    assert.match(await page.textContent('#status'), /covered/);
    assert.deepEqual(page.problems, []);
  });
});

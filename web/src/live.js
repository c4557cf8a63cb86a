// Talks to the server of a running session; a page that was opened from a file has none.
import { $, el } from './dom.js';
import { load } from './data.js';

const everyMs = 1000;

export class Live {
  constructor(app) {
    this.app = app;
    this.next = 0; // number of the first message not seen yet
    this.token = '';
    this.version = null;
  }

  /** Asks until the page is closed; ends at once when nobody answers as our server does. */
  async start() {
    if (!location.protocol.startsWith('http')) return;
    for (let missed = 0; ;) {
      try {
        await this.#poll();
        missed = 0;
      } catch (error) {
        if (this.version === null) return; // some other web server
        missed++;
        if (missed === 2)
          this.#activity('The session’s program has ended or does not answer', false);
      }
      await new Promise((resolve) => setTimeout(resolve, missed > 1 ? 3000 : everyMs));
    }
  }

  async #poll() {
    const answer = await fetch(`/api/live?since=${this.next}`, { cache: 'no-store' });
    if (!answer.ok || !answer.headers.get('content-type')?.includes('json'))
      throw new Error('no live session');
    const live = await answer.json();
    this.token = live.token;
    this.#messages(live.messages);
    this.next = live.next;
    if (live.running) {
      const share = live.total > 0 ? ` ${Math.round((100 * live.done) / live.total)} %` : '';
      this.#activity(live.stage ? `${live.stage}${share}` : 'working', true);
    } else {
      this.#activity('', false);
    }
    if (this.version !== null && live.version !== this.version) {
      this.app.update(await load('session', `data/session.js?${live.version}`));
    }
    this.version = live.version;
    const flight = await fetch('/api/flight', { cache: 'no-store' });
    this.app.flight.show(flight.ok ? await flight.json() : null);
  }

  #activity(text, running) {
    $('activity').hidden = text === '';
    $('activity').classList.toggle('idle', !running);
    if ($('activity-text').textContent !== text) $('activity-text').textContent = text;
  }

  #messages(messages) {
    $('tab-log').hidden = false;
    if (messages.length === 0) return;
    let list = $('log').querySelector('ol');
    if (!list)
      $('log').replaceChildren(
        (list = el('ol', { class: 'log', tabindex: 0, 'aria-label': 'Messages' })),
      );
    const atEnd = $('log').scrollTop + $('log').clientHeight > $('log').scrollHeight - 30;
    for (const { level, text } of messages) list.append(el('li', { class: level }, text));
    while (list.children.length > 1000) list.firstChild.remove();
    if (atEnd) $('log').scrollTop = $('log').scrollHeight;
  }

  /** Sends a command; its answer, or an Error with the server's reason. */
  async post(path, body) {
    const answer = await fetch(path, {
      method: 'POST',
      body: JSON.stringify(body),
      headers: { 'Content-Type': 'application/json', 'X-Colmap-Ext-Token': this.token },
    });
    const json = await answer.json().catch(() => ({}));
    if (!answer.ok) throw new Error(json.error ?? `the server answered ${answer.status}`);
    return json;
  }
}

// Talks to the server of a running session; a page that was opened from a file has none.
import { $, el } from './dom.js';
import { load } from './data.js';

const flightEveryMs = 1000;
const againMs = 3000; // after a lost connection

export class Live {
  constructor(app) {
    this.app = app;
    this.next = 0; // number of the first message not seen yet
    this.token = '';
    this.version = null;
    this.missed = 0; // tries in a row that nobody answered
  }

  /** Listens until the page is closed; ends at once when nobody answers as our server does. */
  async start() {
    if (!location.protocol.startsWith('http')) return;
    try {
      const answer = await fetch('/api/live', { cache: 'no-store' });
      if (!answer.ok || !answer.headers.get('content-type')?.includes('json')) return;
      await this.#take(await answer.json());
    } catch {
      return; // some other web server
    }
    this.#listen();
    // Browsers open few connections to one server: a hidden page gives its own up.
    document.addEventListener('visibilitychange', () =>
      document.hidden ? this.#hangUp() : this.#listen(),
    );
    this.#watchFlight();
  }

  #hangUp() {
    clearTimeout(this.again);
    this.events?.close();
    this.events = null;
  }

  #listen() {
    this.#hangUp();
    this.events = new EventSource(`/api/events?since=${this.next}`);
    this.events.onmessage = (event) => {
      this.missed = 0;
      this.told = (this.told ?? Promise.resolve()) // one after the other
        .then(() => this.#take(JSON.parse(event.data)))
        .catch((error) => this.app.complain(error));
    };
    this.events.onerror = () => {
      this.#hangUp(); // the browser's own new try would ask for old messages again
      if (++this.missed === 2)
        this.#activity('The session’s program has ended or does not answer', false);
      this.again = setTimeout(() => this.#listen(), this.missed > 1 ? againMs : 500);
    };
  }

  async #watchFlight() {
    for (;;) {
      if (!document.hidden) {
        const flight = await fetch('/api/flight', { cache: 'no-store' }).catch(() => null);
        if (flight) this.app.flight.show(flight.ok ? await flight.json() : null);
      }
      await new Promise((resolve) => setTimeout(resolve, flightEveryMs));
    }
  }

  async #take(live) {
    this.token = live.token;
    this.#messages(live.messages);
    this.next = live.next;
    if (live.running) {
      const share = live.total > 0 ? ` ${Math.round((100 * live.done) / live.total)} %` : '';
      this.#activity(live.stage ? `${live.stage}${share}` : 'working', true);
    } else {
      this.#activity('', false);
    }
    const changed = this.version !== null && live.version !== this.version;
    this.version = live.version;
    if (changed) this.app.update(await load('session', `data/session.js?${live.version}`));
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

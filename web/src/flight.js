// State of the flight, and pause, resume, abort: shown when the session's server reaches a daemon.
import { Vector3 } from 'three';
import { $, el, metres } from './dom.js';
import { facts } from './photo.js';

const statusNames = {
  stored: 'stored',
  captured: 'captured',
  asked: 'being taken',
  failed: 'failed',
  pending: 'to come',
};

function progress(views) {
  const count = {};
  for (const view of views) count[view.status] = (count[view.status] ?? 0) + 1;
  const total = views.length || 1;
  const parts = ['stored', 'captured', 'asked', 'failed', 'pending'].filter((name) => count[name]);
  return el(
    'div',
    {},
    el(
      'div',
      {
        class: 'progress',
        role: 'img',
        'aria-label': parts.map((name) => `${count[name]} ${statusNames[name]}`).join(', '),
      },
      ...parts.map((name) =>
        el('i', { class: name, style: `width:${(100 * count[name]) / total}%` }),
      ),
    ),
    el(
      'p',
      { class: 'note' },
      views.length
        ? parts.map((name) => `${count[name]} ${statusNames[name]}`).join(' · ')
        : 'no mission loaded',
    ),
  );
}

export class Flight {
  constructor(app) {
    this.app = app;
    this.box = $('flight');
    this.confirming = false;
  }

  /** Takes the daemon's status; null: there is no daemon. */
  show(status) {
    this.box.hidden = !status;
    const { app } = this;
    if (!status) {
      if (app.vehicle) app.setVehicle(null);
      return;
    }
    this.status = status;
    const vehicle = status.vehicle ?? {};
    if (vehicle.position_enu_m && app.iterations.origin) {
      const at = new Vector3(...vehicle.position_enu_m.map((v, k) => v - app.iterations.origin[k]));
      app.setVehicle({ at, yaw_deg: vehicle.yaw_deg });
    }
    const text = JSON.stringify([status, this.confirming, this.error]);
    if (text === this.drawn) return;
    this.drawn = text;
    this.#draw(status, vehicle);
  }

  #draw(status, vehicle) {
    const battery = vehicle.battery_percent;
    const state = String(status.state).replaceAll('_', ' ');
    const focus = document.activeElement?.dataset?.do;
    const button = (name, label, title) =>
      el(
        'button',
        { type: 'button', 'data-do': name, class: name, title, onclick: () => this.#ask(name) },
        label,
      );
    const buttons = this.confirming
      ? [
          el('span', { class: 'question' }, 'End this flight?'),
          button('abort-rtl', 'Return home', 'Fly home and land'),
          button('abort-land', 'Land here', 'Land where it is'),
          button('no', 'Go on', 'Do not abort'),
        ]
      : [
          button('pause', 'Pause', 'Stop and hover (P)'),
          button('resume', 'Resume', 'Go on'),
          button('abort', 'Abort…', 'Return home or land'),
        ];
    this.box.replaceChildren(
      el(
        'div',
        { class: 'head' },
        el('h2', {}, 'Flight'),
        el('b', { class: `state ${status.state}`, role: 'status' }, state),
        battery === undefined
          ? null
          : el('span', { class: 'battery', title: 'Battery' }, `${Math.round(battery)} %`),
      ),
      status.reason ? el('p', { class: 'note' }, status.reason) : '',
      progress(status.views ?? []),
      facts([
        [
          'Vehicle',
          `${vehicle.description || vehicle.stack || 'unknown'}${vehicle.mode ? `, ${vehicle.mode}` : ''}${vehicle.armed ? ', armed' : ''}`,
        ],
        ...(vehicle.relative_height_m === undefined
          ? []
          : [
              [
                'Height, speed',
                `${metres(vehicle.relative_height_m)}, ${(vehicle.speed_m_s ?? 0).toFixed(1)} m/s`,
              ],
            ]),
        ...(vehicle.silent_s > 3 ? [['Link', `silent for ${vehicle.silent_s.toFixed(0)} s`]] : []),
      ]),
      el('div', { class: 'choice' }, ...buttons),
      this.error ? el('p', { class: 'error', role: 'alert' }, this.error) : '',
    );
    if (focus) this.box.querySelector(`[data-do="${focus}"]`)?.focus();
  }

  async #ask(name) {
    this.error = '';
    if (name === 'abort' || name === 'no') {
      this.confirming = name === 'abort';
    } else {
      const [action, how] = name.split('-');
      this.confirming = false;
      try {
        this.status = await this.app.live.post(`/api/flight/${action}`, how ? { how } : {});
      } catch (error) {
        this.error = error.message;
      }
    }
    this.show(this.status);
  }

  pause() {
    if (this.status && !this.box.hidden) this.#ask('pause');
  }
}

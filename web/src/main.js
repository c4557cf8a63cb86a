// The page of a session: state, and what happens when it changes.
import { Charts } from './charts.js';
import { colorings, hasColoring } from './clouds.js';
import { take } from './data.js';
import { $, arrowKeys, el, linkOf, metres } from './dom.js';
import { showTable, showTiles } from './facts.js';
import { Flight } from './flight.js';
import { showInspect } from './inspect.js';
import { makeKeys } from './keys.js';
import { makeLayers, showLayers, showLegend } from './layers.js';
import { Live } from './live.js';
import { Iterations } from './model.js';
import { makeTimeline, showTimeline } from './timeline.js';
import { Viewer } from './viewer.js';

const nothing = { photo: -1, iso: -1, point: null, normal: null, seen: [] };

class App {
  constructor(session) {
    this.session = session;
    this.iterations = new Iterations();
    this.selection = { ...nothing };
    this.overlay = { mesh: true, confidence: false };
    this.index = this.#lastWithData();
    this.flight = new Flight(this);
    this.live = new Live(this);
    this.viewer = new Viewer($('canvas'), () => this.#gauge());
    this.viewer.onLeave = () => this.leaveThrough();
    this.charts = new Charts($('progress'), this);
    makeLayers(this);
    makeTimeline(this);
    makeKeys(this);
    this.#makeTabs();
    this.#makePointer();
    $('theme').addEventListener('click', () => this.toggleTheme());
    for (const button of document.querySelectorAll('[data-view]')) {
      button.addEventListener('click', () => this.viewer.fit(button.dataset.view));
    }
    const through = $('through');
    through.querySelector('button').addEventListener('click', () => this.leaveThrough());
    through.querySelector('input').addEventListener('input', (event) => {
      through.querySelector('img').style.opacity = event.target.value / 100;
    });
  }

  #lastWithData() {
    return Math.max(
      0,
      this.session.iterations.findLastIndex((it) => it.data),
    );
  }

  links(index = this.index) {
    return this.session.iterations[index]?.data ?? {};
  }

  complain(error) {
    $('notice').hidden = false;
    $('notice').textContent = error.message;
  }

  // ---- iterations

  /** Shows an iteration. What is selected stays selected where that makes sense. */
  async show(index) {
    const { iterations } = this.session;
    if (iterations.length === 0) return;
    this.index = Math.min(iterations.length - 1, Math.max(0, index));
    const wanted = this.index;
    showTimeline(this);
    showTiles(this);
    this.charts.refresh();
    if (!$('table').hidden) showTable(this);
    const links = this.links();
    if (!links.scene) {
      this.complain(new Error(`Iteration ${this.index} has no model.`));
      return;
    }
    const begun = setTimeout(() => $('stage').classList.add('loading'), 120);
    try {
      const data = await this.iterations.scene(this.index, links);
      if (wanted !== this.index) return;
      const first = !this.data;
      const name = this.data?.photos[this.selection.photo]?.name;
      this.data = data;
      if (!hasColoring(data.coverage, this.viewer.coloring)) this.viewer.coloring = 'class';
      this.viewer.setScene(data);
      if (first) {
        this.#firstLook();
        this.viewer.fit('fit', false);
      }
      $('notice').hidden = true;
      this.#keepSelection(name);
      showLayers(this);
      showLegend(this);
      showTiles(this);
      await this.#showFused();
      await showInspect(this);
      document.documentElement.dataset.shown = String(this.index);
    } catch (error) {
      this.complain(error);
    } finally {
      clearTimeout(begun);
      if (wanted === this.index) $('stage').classList.remove('loading');
    }
  }

  // An unfinished or bare session: show what there is.
  #firstLook() {
    if (!this.data.surface && !this.data.coverage) this.viewer.shown.points = true;
    if (!this.data.coverage) this.viewer.shown.color = true;
    this.viewer.apply();
  }

  #keepSelection(name) {
    const { point, normal } = this.selection;
    const photo = name ? this.data.photos.findIndex((p) => p.name === name) : -1;
    this.selection = { ...nothing, photo };
    if (point)
      Object.assign(this.selection, {
        point,
        normal,
        seen: this.viewer.photosThatSee(point, normal),
      });
    this.#markSelection();
  }

  async #showFused() {
    if (!this.viewer.shown.fused || !this.links().fused) {
      this.viewer.setFused(null);
      return;
    }
    const wanted = this.index;
    const cloud = await this.iterations.fused(this.index, this.links());
    if (wanted === this.index && this.viewer.shown.fused) this.viewer.setFused(cloud);
  }

  play() {
    const { length } = this.session.iterations;
    if (this.playing || length < 2) {
      clearTimeout(this.playing);
      this.playing = null;
      showTimeline(this);
      return;
    }
    const step = async () => {
      await this.show(this.index + 1 < length ? this.index + 1 : 0);
      if (!this.playing) return;
      if (this.index === length - 1) this.play();
      else this.playing = setTimeout(step, 900);
    };
    this.playing = setTimeout(step, this.index === length - 1 ? 0 : 500);
    showTimeline(this);
  }

  /** A new state of the session: another iteration is done, or it ended. */
  async update(session) {
    const follows = this.index === this.#lastWithData();
    const before = JSON.stringify(this.links());
    this.session = session;
    $('status').textContent = session.sentence;
    makeTimeline(this);
    this.charts.draw();
    const next = follows ? this.#lastWithData() : this.index;
    if (next !== this.index || JSON.stringify(this.links()) !== before) await this.show(next);
    else showTimeline(this);
  }

  // ---- choices

  async setLayer(name, on) {
    if (!this.data) return;
    this.viewer.shown[name] = on;
    this.viewer.apply();
    showLayers(this);
    showLegend(this);
    if (name === 'fused') {
      await this.#showFused().catch((error) => this.complain(error));
      document.documentElement.dataset.fused = String(on);
    }
  }

  setClass(k, on) {
    this.viewer.classShown[k] = on;
    this.viewer.apply();
  }

  /** The next colouring that the map has. */
  nextColoring() {
    const there = colorings.filter((name) => hasColoring(this.data?.coverage, name));
    this.setColoring(there[(there.indexOf(this.viewer.coloring) + 1) % there.length]);
  }

  setColoring(name) {
    if (!this.data) return;
    if (!hasColoring(this.data.coverage, name)) return;
    this.viewer.coloring = name;
    this.viewer.apply();
    showLegend(this);
  }

  async setOverlay(change) {
    Object.assign(this.overlay, change);
    if (this.selection.photo >= 0) await showInspect(this);
  }

  toggleTheme() {
    const root = document.documentElement;
    const dark = getComputedStyle(root).getPropertyValue('--dark').trim() === '1';
    root.dataset.theme = dark ? 'light' : 'dark';
    try {
      localStorage.setItem('colmap_ext_theme', root.dataset.theme);
    } catch {
      /* pages opened from files may keep nothing */
    }
    this.charts.draw();
  }

  setVehicle(vehicle) {
    this.vehicle = vehicle;
    this.viewer.vehicle = vehicle;
    const start = this.viewer.layers.route?.start;
    this.viewer.placeDrone(vehicle ?? start, vehicle?.yaw_deg ?? start?.yaw_deg);
  }

  // ---- selection

  #markSelection() {
    const { photo, point, normal, seen } = this.selection;
    this.viewer.selectedPhoto = photo;
    this.viewer.seeing = new Set(seen.map((s) => s.index));
    this.viewer.mark(point, normal);
    this.viewer.apply();
  }

  async #select(selection) {
    this.leaveThrough();
    this.selection = { ...nothing, ...selection };
    this.#markSelection();
    this.openTab('inspect');
    await showInspect(this);
  }

  selectPhoto(photo, { keepPoint = false } = {}) {
    return this.#select(keepPoint ? { ...this.selection, photo } : { photo });
  }

  // The width of photos in the coverage stage; the overlays know it.
  async #learnDenseWidth() {
    if (!this.links().overlays) return;
    const all = await this.iterations.overlays(this.index, this.links()).catch(() => ({}));
    this.viewer.denseWidth = Object.values(all)[0]?.width;
  }

  async selectPoint(iso) {
    await this.#learnDenseWidth();
    const { point, normal } = this.viewer.isoPoint(iso);
    return this.#select({ iso, point, normal, seen: this.viewer.photosThatSee(point, normal) });
  }

  async selectPlace(point, normal) {
    await this.#learnDenseWidth();
    return this.#select({ point, normal, seen: this.viewer.photosThatSee(point, normal) });
  }

  clearSelection() {
    if (!this.data) return null;
    return this.#select({});
  }

  stepPhoto(by) {
    if (!this.data) return null;
    const { length } = this.data.photos;
    const { photo, seen } = this.selection;
    const among = seen.length ? seen.map((s) => s.index) : null;
    if (among)
      return this.selectPhoto(
        among[(Math.max(0, among.indexOf(photo)) + by + among.length) % among.length],
        { keepPoint: true },
      );
    return this.selectPhoto(photo < 0 ? (by > 0 ? 0 : length - 1) : (photo + by + length) % length);
  }

  hoverPhoto(i) {
    if (this.selection.photo >= 0) return;
    this.viewer.selectedPhoto = i;
    this.viewer.apply();
  }

  // ---- looking through a photo

  lookThrough() {
    const photo = this.data?.photos[this.selection.photo];
    if (!photo) return;
    this.leaveThrough();
    this.back = {
      position: this.viewer.camera.position.clone(),
      target: this.viewer.controls.target.clone(),
    };
    this.viewer.lookThrough(photo, (box) => {
      const through = $('through');
      const image = through.querySelector('img');
      image.src = linkOf(this.session.photo_folder, `${photo.name}.jpg`);
      image.alt = `Photo ${photo.name}`;
      image.style.cssText = `left:${box.left}px;top:${box.top}px;width:${box.width}px;height:${box.height}px;opacity:${through.querySelector('input').value / 100}`;
      through.hidden = false;
      this.viewer.looking = true;
      this.viewer.apply();
      $('stage').classList.add('looking');
    });
  }

  /** Returns whether there was a photo to leave. */
  leaveThrough() {
    if ($('through').hidden) return false;
    $('through').hidden = true;
    this.viewer.looking = false;
    this.viewer.apply();
    $('stage').classList.remove('looking');
    if (this.back) this.viewer.flyTo(this.back.position, this.back.target);
    this.back = null;
    return true;
  }

  // ---- tabs, pointer, gauge

  #makeTabs() {
    const tabs = document.querySelector('.tabs');
    tabs.addEventListener('click', (event) => {
      const tab = event.target.closest('[role=tab]');
      if (tab) this.openTab(tab.getAttribute('aria-controls'));
    });
    arrowKeys(tabs, '[role=tab]');
    this.openTab('inspect');
  }

  openTab(name) {
    for (const tab of document.querySelectorAll('[role=tab]')) {
      const on = tab.getAttribute('aria-controls') === name;
      tab.setAttribute('aria-selected', String(on));
      tab.tabIndex = on ? 0 : -1;
      $(tab.getAttribute('aria-controls')).hidden = !on;
    }
    if (name === 'table') showTable(this);
    if (name === 'progress') this.charts.draw();
  }

  #makePointer() {
    const canvas = $('canvas');
    let down = null;
    canvas.addEventListener('pointerdown', (event) => {
      down = event.isPrimary && event.button === 0 ? [event.clientX, event.clientY] : null;
    });
    canvas.addEventListener('pointerup', (event) => {
      if (!down || Math.hypot(event.clientX - down[0], event.clientY - down[1]) > 5 || !this.data)
        return;
      const hit = this.viewer.pick(event.clientX, event.clientY);
      if (!hit) return;
      if (hit.photo !== undefined) this.selectPhoto(hit.photo);
      else if (hit.point !== undefined) this.selectPoint(hit.point);
      else this.selectPlace(hit.place, hit.normal);
    });
    canvas.addEventListener('dblclick', () => {
      if (this.selection.point)
        this.viewer.flyTo(
          this.selection.point
            .clone()
            .addScaledVector(this.viewer.camera.position.clone().sub(this.selection.point), 0.45),
          this.selection.point.clone(),
        );
    });
  }

  #gauge() {
    const { northDeg, metresPerPixel } = this.viewer.gauge();
    $('compass').style.transform = `rotate(${northDeg}deg)`;
    const length = 10 ** Math.floor(Math.log10(90 * metresPerPixel));
    const nice = [5, 2, 1].find((f) => f * length <= 90 * metresPerPixel) * length;
    $('scale').querySelector('i').style.width = `${nice / metresPerPixel}px`;
    const text = this.data?.frame.metric === false ? '' : metres(nice).replace(/\.0\b/, '');
    const label = $('scale').querySelector('span');
    if (label.textContent !== text) label.textContent = text;
  }
}

function restoreTheme() {
  try {
    const theme = localStorage.getItem('colmap_ext_theme');
    if (theme) document.documentElement.dataset.theme = theme;
  } catch {
    /* pages opened from files may keep nothing */
  }
}

// Lets the browser paint what is there; a tab in the background paints nothing and is not waited
// for.
const painted = () =>
  new Promise((resolve) => {
    requestAnimationFrame(() => setTimeout(resolve));
    setTimeout(resolve, 500);
  });

async function main() {
  restoreTheme();
  await painted();
  const session = await take('session');
  try {
    const app = new App(session);
    globalThis.colmapExt.app = app;
    if (session.iterations.length === 0)
      app.complain(new Error('No iteration is finished yet. What the session does is in the log.'));
    await app.show(app.index);
    app.live.start();
  } catch (error) {
    $('notice').hidden = false;
    $('notice').replaceChildren(
      `This browser cannot draw the 3D view (${error.message}). `,
      el('a', { href: 'pictures.html' }, 'The session as pictures and tables.'),
    );
  }
}

main();

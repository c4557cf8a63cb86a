// Small helpers for making elements.

export const $ = (id) => document.getElementById(id);

/** el('button', {class: 'x', onclick: f, 'aria-label': 't'}, 'text', child, …) */
export function el(tag, attributes = {}, ...children) {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (value === null || value === undefined || value === false) continue;
    if (name.startsWith('on')) element.addEventListener(name.slice(2), value);
    else if (name === 'style') element.style.cssText = value;
    else element.setAttribute(name, value === true ? '' : value);
  }
  element.append(...children.filter((child) => child !== null && child !== undefined));
  return element;
}

export function svg(tag, attributes = {}, ...children) {
  const element = document.createElementNS('http://www.w3.org/2000/svg', tag);
  for (const [name, value] of Object.entries(attributes)) element.setAttribute(name, value);
  element.append(...children);
  return element;
}

/** A path of the page's folders: every part escaped. */
export const linkOf = (...parts) =>
  parts
    .flatMap((part) => part.split('/'))
    .map(encodeURIComponent)
    .join('/');

export const percent = (share) => `${(100 * share).toFixed(1)} %`;
export const seconds = (s) =>
  s < 120 ? `${s.toFixed(s < 10 ? 1 : 0)} s` : `${(s / 60).toFixed(1)} min`;

/** Metres for people: 4.2 mm, 3.1 cm, 12.4 m, 1.2 km. */
export function metres(m) {
  const a = Math.abs(m);
  if (a < 0.01) return `${(1000 * m).toFixed(1)} mm`;
  if (a < 1) return `${(100 * m).toFixed(1)} cm`;
  return a < 1000 ? `${m.toFixed(a < 100 ? 1 : 0)} m` : `${(m / 1000).toFixed(1)} km`;
}
export const grouped = (n) => String(n).replace(/\B(?=(\d{3})+$)/g, '\u202f');

/** Texts of a radio group or tab list: arrows move between its buttons. */
export function arrowKeys(container, selector) {
  container.addEventListener('keydown', (event) => {
    const step = { ArrowRight: 1, ArrowDown: 1, ArrowLeft: -1, ArrowUp: -1 }[event.key];
    if (!step) return;
    const buttons = [...container.querySelectorAll(selector)].filter(
      (b) => !b.hidden && !b.disabled,
    );
    const at = buttons.indexOf(document.activeElement);
    if (at < 0) return;
    event.preventDefault();
    event.stopPropagation();
    const next = buttons[(at + step + buttons.length) % buttons.length];
    next.focus();
    next.click();
  });
}

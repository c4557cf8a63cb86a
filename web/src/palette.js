// Colours that people with any colour vision tell apart: Okabe and Ito's for classes, viridis and
// cividis (rising lightness) for amounts. sRGB, 0 … 1.

const hex = (text) => [1, 3, 5].map((i) => parseInt(text.slice(i, i + 2), 16) / 255);
export const css = (rgb) => `rgb(${rgb.map((v) => Math.round(255 * v)).join(' ')})`;

export const classes = [
  { name: 'uncovered', color: hex('#e0671a') },
  { name: 'covered', color: hex('#2f8fd0') },
  { name: 'ignored', color: hex('#a3abb5') },
];
export const unknown = hex('#a3abb5');

export const viridis = ['#440154', '#414487', '#2a788e', '#22a884', '#7ad151', '#fde725'].map(hex);
export const cividis = ['#00224e', '#35456c', '#666970', '#948e77', '#c8b866', '#fee838'].map(hex);

/** Colour at `share` (0 … 1) of evenly spaced stops. */
export function scale(stops, share) {
  const position = Math.min(Math.max(share, 0), 1) * (stops.length - 1);
  const below = Math.min(Math.floor(position), stops.length - 2);
  const part = position - below;
  return stops[below].map((v, k) => v + part * (stops[below + 1][k] - v));
}

export const accent = {
  photo: hex('#7c8794'),
  sees: hex('#e69f00'),
  selected: hex('#d81b60'),
  next: hex('#8e44ad'),
  path: hex('#8e44ad'),
  drone: hex('#d81b60'),
};

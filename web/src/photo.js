// A photo with its superpixel mesh and confidence, drawn over it.
import { decodeOverlay } from './model.js';
import { $, el, linkOf, metres } from './dom.js';
import { css, scale, viridis } from './palette.js';

export const photoLink = (app, photo) => linkOf(app.session.photo_folder, `${photo.name}.jpg`);

/** The photo's mesh at the shown iteration; null when there is none. */
async function overlayOf(app, photo) {
  const { overlays } = app.links();
  if (!overlays) return null;
  const all = await app.iterations.overlays(app.index, app.links());
  return all[photo.name] ? decodeOverlay(all[photo.name]) : null;
}

function drawConfidence(ctx, mesh) {
  const { vertices: v, triangles: t, confidence } = mesh;
  for (let i = 0; i < confidence.length; ++i) {
    if (confidence[i] < 0) continue;
    ctx.fillStyle = css(scale(viridis, confidence[i] / 100));
    ctx.strokeStyle = ctx.fillStyle; // closes the seams
    ctx.beginPath();
    for (let k = 0; k < 3; ++k) ctx.lineTo(v[2 * t[3 * i + k]], v[2 * t[3 * i + k] + 1]);
    ctx.closePath();
    ctx.fill();
    ctx.stroke();
  }
}

// Edges between superpixels strong, those inside one faint.
function drawMesh(ctx, mesh) {
  const { vertices: v, triangles: t, superpixel } = mesh;
  const owner = new Map();
  const inner = new Path2D();
  const outer = new Path2D();
  const line = (path, a, b) => {
    path.moveTo(v[2 * a], v[2 * a + 1]);
    path.lineTo(v[2 * b], v[2 * b + 1]);
  };
  const total = v.length / 2;
  for (let i = 0; i < superpixel.length; ++i) {
    for (let k = 0; k < 3; ++k) {
      const a = t[3 * i + k];
      const b = t[3 * i + ((k + 1) % 3)];
      const key = Math.min(a, b) * total + Math.max(a, b);
      const other = owner.get(key);
      if (other === undefined) owner.set(key, superpixel[i]);
      else {
        line(other === superpixel[i] ? inner : outer, a, b);
        owner.delete(key);
      }
    }
  }
  ctx.strokeStyle = 'rgb(255 255 255 / .28)';
  ctx.stroke(inner);
  ctx.strokeStyle = 'rgb(255 214 64 / .95)';
  ctx.stroke(outer);
}

function drawPoint(canvas, photo, pixel) {
  const ctx = canvas.getContext('2d');
  const x = (pixel.x / photo.camera.width) * canvas.width;
  const y = (pixel.y / photo.camera.height) * canvas.height;
  const r = 0.018 * canvas.width;
  for (const [width, color] of [
    [6, '#fff'],
    [3, '#d81b60'],
  ]) {
    ctx.lineWidth = width;
    ctx.strokeStyle = color;
    ctx.beginPath();
    ctx.arc(x, y, r, 0, 2 * Math.PI);
    ctx.stroke();
  }
}

/**
 * A frame with the photo and a canvas over it. `overlay`: {mesh, confidence} booleans. Resolves to
 * {frame, has}: whether there is a mesh.
 */
export async function photoFrame(app, photo, overlay, width) {
  const { camera } = photo;
  const canvas = el('canvas', {
    width,
    height: Math.round((width * camera.height) / camera.width),
    'data-drawn': 'none',
  });
  const image = el('img', {
    src: photoLink(app, photo),
    alt: `Photo ${photo.name}`,
    draggable: 'false',
  });
  const frame = el(
    'div',
    { class: 'photo', style: `aspect-ratio:${camera.width}/${camera.height}` },
    image,
    canvas,
  );
  image.addEventListener('error', () => frame.classList.add('missing'));
  let mesh = null;
  try {
    mesh = await overlayOf(app, photo);
  } catch (error) {
    app.complain(error);
  }
  if (mesh) {
    const ctx = canvas.getContext('2d');
    ctx.setTransform(canvas.width / mesh.width, 0, 0, canvas.height / mesh.height, 0, 0);
    ctx.lineWidth = (1.1 * mesh.width) / canvas.width;
    if (overlay.confidence) {
      ctx.globalAlpha = 0.68;
      drawConfidence(ctx, mesh);
      ctx.globalAlpha = 1;
    }
    if (overlay.mesh) drawMesh(ctx, mesh);
    ctx.resetTransform();
    canvas.dataset.drawn =
      `${overlay.mesh ? 'mesh ' : ''}${overlay.confidence ? 'confidence' : ''}`.trim() || 'none';
  }
  const { point } = app.selection;
  const pixel = point && app.viewer.projectTo(photo, point);
  if (pixel) drawPoint(canvas, photo, pixel);
  return { frame, mesh };
}

function meshFacts(mesh) {
  const known = mesh.confidence.filter((c) => c >= 0);
  const mean = known.reduce((a, b) => a + b, 0) / Math.max(1, known.length) / 100;
  const superpixels = new Set(mesh.superpixel).size;
  return [
    ['Superpixels', `${superpixels} (${mesh.confidence.length} triangles)`],
    [
      'Mean confidence',
      `${mean.toFixed(2)}, ${Math.round((100 * known.length) / mesh.confidence.length)} % supported`,
    ],
  ];
}

export function facts(rows) {
  return el(
    'dl',
    { class: 'facts' },
    ...rows.flatMap(([name, value]) => [el('dt', {}, name), el('dd', {}, value)]),
  );
}

function confidenceKey() {
  const colors = viridis.map((c, i) => `${css(c)} ${20 * i}%`).join(',');
  return el(
    'div',
    { class: 'rows key' },
    el('div', { class: 'ramp', style: `background:linear-gradient(90deg,${colors})` }),
    el(
      'div',
      { class: 'ticks' },
      el('span', {}, '0'),
      el('span', {}, 'confidence Γ'),
      el('span', {}, '1'),
    ),
  );
}

/** The details of one photo. */
export async function photoCard(app, index) {
  const photo = app.data.photos[index];
  const { frame, mesh } = await photoFrame(app, photo, app.overlay, 800);
  const toggle = (name, label) =>
    el(
      'button',
      {
        type: 'button',
        'data-overlay': name,
        'aria-pressed': String(app.overlay[name]),
        disabled: !mesh,
        onclick: () => app.setOverlay({ [name]: !app.overlay[name] }),
      },
      label,
    );
  frame.addEventListener('click', () => enlarge(app, index));
  const height = photo.center.z + (app.iterations.origin?.[2] ?? 0);
  const pitch = (Math.asin(photo.forward.z) * 180) / Math.PI;
  const yaw = ((Math.atan2(photo.forward.x, photo.forward.y) * 180) / Math.PI + 360) % 360;
  return el(
    'section',
    { class: 'card photo-card' },
    el(
      'div',
      { class: 'head' },
      el('h2', { title: photo.name }, photo.name),
      el(
        'button',
        {
          type: 'button',
          title: 'Photo before ([)',
          'aria-label': 'Photo before',
          onclick: () => app.stepPhoto(-1),
        },
        '‹',
      ),
      el(
        'button',
        {
          type: 'button',
          title: 'Next photo (])',
          'aria-label': 'Next photo',
          onclick: () => app.stepPhoto(1),
        },
        '›',
      ),
      el(
        'button',
        {
          type: 'button',
          title: 'Close (Esc)',
          'aria-label': 'Close',
          onclick: () => app.clearSelection(),
        },
        '×',
      ),
    ),
    frame,
    el(
      'div',
      { class: 'choice' },
      toggle('mesh', 'Superpixels'),
      toggle('confidence', 'Confidence'),
      el(
        'button',
        {
          type: 'button',
          id: 'look-through',
          title: 'Look through this photo (V)',
          onclick: () => app.lookThrough(),
        },
        'Look through',
      ),
      el(
        'button',
        { type: 'button', id: 'enlarge', title: 'Enlarge (E)', onclick: () => enlarge(app, index) },
        'Enlarge',
      ),
    ),
    mesh && app.overlay.confidence ? confidenceKey() : null,
    facts([
      [
        'Camera',
        `${photo.camera.width} × ${photo.camera.height}, f ${photo.camera.fx.toFixed(0)} px`,
      ],
      ['Height', app.data.frame.metric === false ? height.toFixed(2) : metres(height)],
      ['Direction', `${yaw.toFixed(0)}° from north, pitch ${pitch.toFixed(0)}°`],
      ...(mesh ? meshFacts(mesh) : [['Mesh', 'not kept for this iteration']]),
    ]),
  );
}

/** The photo as large as the window. */
export async function enlarge(app, index) {
  const dialog = $('viewer');
  const photo = app.data.photos[index];
  const { frame, mesh } = await photoFrame(
    app,
    photo,
    app.overlay,
    Math.min(2048, Math.max(photo.camera.width, 1280)),
  );
  const again = (name) => async () => {
    await app.setOverlay({ [name]: !app.overlay[name] });
    enlarge(app, index);
  };
  const toggle = (name, label) =>
    el(
      'button',
      {
        type: 'button',
        'aria-pressed': String(app.overlay[name]),
        disabled: !mesh,
        onclick: again(name),
      },
      label,
    );
  const step = (by, text, label) =>
    el(
      'button',
      {
        type: 'button',
        'aria-label': label,
        onclick: () => {
          app.stepPhoto(by);
          enlarge(app, app.selection.photo);
        },
      },
      text,
    );
  dialog.replaceChildren(
    frame,
    el(
      'div',
      { class: 'choice' },
      step(-1, '‹', 'Photo before'),
      el('span', {}, photo.name),
      step(1, '›', 'Next photo'),
      toggle('mesh', 'Superpixels'),
      toggle('confidence', 'Confidence'),
      el('button', { type: 'button', autofocus: true, onclick: () => dialog.close() }, 'Close'),
    ),
  );
  const ratio = photo.camera.width / photo.camera.height;
  frame.style.width = `min(94vw, calc(84vh * ${ratio}))`;
  if (!dialog.open) dialog.showModal();
}

// Iterations as the page uses them: decoded, in metres from one origin for the whole session.
import { Quaternion, Vector3 } from 'three';
import { load } from './data.js';
import { unpack, unpackPositions } from './packed.js';

const minus = (a, b) => a.map((v, k) => v - b[k]);

function photoOf(raw, cameras, origin) {
  const [w, x, y, z] = raw.rotation;
  const worldFromCam = new Quaternion(x, y, z, w).invert();
  return {
    name: raw.name,
    camera: cameras[raw.camera],
    center: new Vector3(...minus(raw.center, origin)),
    worldFromCam,
    forward: new Vector3(0, 0, 1).applyQuaternion(worldFromCam),
    right: new Vector3(1, 0, 0).applyQuaternion(worldFromCam),
    down: new Vector3(0, 1, 0).applyQuaternion(worldFromCam),
  };
}

const strides = 64;
const unpainted = 128; // grey, to be seen on light and dark

// Every prefix of the result is an even sample of the whole: what a slow machine draws while the
// view moves.
async function decodeCloud(raw, shift) {
  const steps = await unpack(raw.position);
  const bytes = await unpack(raw.color);
  const count = steps.length / 3;
  const stride = count > strides * strides ? strides : 1;
  const position = new Float32Array(steps.length);
  const color = new Uint8Array(steps.length);
  let to = 0;
  for (let s = 0; s < stride; ++s) {
    for (let i = s; i < count; i += stride, ++to) {
      for (let k = 0; k < 3; ++k) {
        position[3 * to + k] = steps[3 * i + k] * raw.position.step + shift[k];
        color[3 * to + k] = bytes[3 * i + k];
      }
    }
  }
  if (!color.some((v) => v > 0)) color.fill(unpainted); // nobody took them from the photos
  return { position, color };
}

async function decodeSurface(raw, shift) {
  return {
    position: await unpackPositions(raw.position, shift),
    face: new Uint32Array(await unpack(raw.face)),
    color: raw.color ? new Uint8Array(await unpack(raw.color)) : null,
  };
}

async function decodeCoverage(raw, shift) {
  return {
    position: await unpackPositions(raw.position, shift),
    normal: new Int8Array(await unpack(raw.normal)),
    kind: new Uint8Array(await unpack(raw.class)),
    views: await unpack(raw.good_views),
    errorUm: raw.predicted_error_um ? await unpack(raw.predicted_error_um) : null,
    score: raw.score_255 ? new Uint8Array(await unpack(raw.score_255)) : null,
    radius: raw.disk_radius_m,
    counts: raw.counts,
  };
}

function stopOf(raw, origin) {
  return { ...raw, at: new Vector3(...minus(raw.position_enu_m, origin)) };
}

/** Decoded iterations, each loaded once; the least recently used are dropped. */
export class Iterations {
  #loaded = new Map(); // link → promise
  #limit;
  origin = null; // of everything on the page, in the world

  constructor(limit = 6) {
    this.#limit = limit;
  }

  #once(link, make) {
    const known = this.#loaded.get(link);
    if (known) this.#loaded.delete(link);
    const promise = known ?? make();
    this.#loaded.set(link, promise);
    promise.catch(() => this.#loaded.delete(link));
    const clouds = [...this.#loaded.keys()].filter((key) => key.startsWith('fused '));
    if (clouds.length > 2) this.#loaded.delete(clouds[0]);
    while (this.#loaded.size > 3 * this.#limit) {
      this.#loaded.delete(this.#loaded.keys().next().value);
    }
    return promise;
  }

  #number(index) {
    return String(index).padStart(3, '0');
  }

  scene(index, links) {
    return this.#once(links.scene, async () => {
      const raw = await load(`iteration/${this.#number(index)}`, links.scene);
      this.origin ??= raw.origin;
      const shift = minus(raw.origin, this.origin);
      return {
        index,
        frame: raw.frame ?? {},
        summary: raw.summary ?? null,
        photos: raw.photos.list.map((photo) => photoOf(photo, raw.photos.cameras, this.origin)),
        points: await decodeCloud(raw.points, shift),
        surface: raw.surface ? await decodeSurface(raw.surface, shift) : null,
        coverage: raw.coverage ? await decodeCoverage(raw.coverage, shift) : null,
        views: (raw.views ?? []).map((view) => stopOf(view, this.origin)),
        path: raw.path
          ? { ...raw.path, waypoints: raw.path.waypoints.map((w) => stopOf(w, this.origin)) }
          : null,
      };
    });
  }

  /** Of dense clouds only the last two are kept: 30 MB for 2 million points. */
  fused(index, links) {
    return this.#once(`fused ${links.fused}`, async () => {
      const raw = await load(`fused/${this.#number(index)}`, links.fused);
      const shift = minus(raw.origin, this.origin);
      return { total: raw.total, ...(await decodeCloud(raw, shift)) };
    });
  }

  overlays(index, links) {
    return this.#once(links.overlays, () =>
      load(`overlays/${this.#number(index)}`, links.overlays),
    );
  }
}

/** The superpixel mesh of a photo; pixel coordinates of the dense photo. */
export async function decodeOverlay(raw) {
  const steps = await unpack(raw.vertices);
  return {
    width: raw.width,
    height: raw.height,
    vertices: Float32Array.from(steps, (v) => v / raw.steps_per_pixel),
    triangles: await unpack(raw.triangles),
    superpixel: await unpack(raw.superpixel),
    confidence: await unpack(raw.confidence),
  };
}

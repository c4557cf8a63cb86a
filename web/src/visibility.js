// Which photos see a point: the rules of the coverage stage (VisibilityEngine, ProjectionRatio).
import { DoubleSide, Ray, Vector3 } from 'three';

const borderPx = 4;
const median = (values) => [...values].sort((a, b) => a - b)[values.length >> 1] ?? 0;

// min(median edge, 0.2 % of the diagonal), as the coverage stage chooses it.
export function automaticEpsilon(surface) {
  const { position, face } = surface;
  const edges = [];
  const step = Math.max(3, 3 * Math.floor(face.length / 3 / 5000));
  for (let f = 0; f + 2 < face.length; f += step) {
    for (let k = 0; k < 3; ++k) {
      const a = 3 * face[f + k];
      const b = 3 * face[f + ((k + 1) % 3)];
      edges.push(
        Math.hypot(
          position[a] - position[b],
          position[a + 1] - position[b + 1],
          position[a + 2] - position[b + 2],
        ),
      );
    }
  }
  const low = [Infinity, Infinity, Infinity];
  const high = [-Infinity, -Infinity, -Infinity];
  for (let i = 0; i < position.length; ++i) {
    low[i % 3] = Math.min(low[i % 3], position[i]);
    high[i % 3] = Math.max(high[i % 3], position[i]);
  }
  return Math.min(median(edges), 0.002 * Math.hypot(...high.map((v, k) => v - low[k])));
}

/** Pixel (of the photo's own size) and depth of a world point; null behind the camera. */
export function project(photo, point) {
  const d = point.clone().sub(photo.center);
  const z = d.dot(photo.forward);
  if (z <= 0) return null;
  const c = photo.camera;
  return { x: (c.fx * d.dot(photo.right)) / z + c.cx, y: (c.fy * d.dot(photo.down)) / z + c.cy, z };
}

/**
 * The photos that see `point` with `normal`: [{photo, index, pixel, distance, incidenceDeg, gsdMm,
 * good}], best resolution first. `tree`: the surface's, or null. `thresholds`: of coverage.json.
 * `denseWidth`: photos were at most so wide when the coverage stage looked at them, px.
 */
export function photosThatSee(photos, point, normal, tree, epsilon, thresholds, denseWidth) {
  const maxIncidence = thresholds?.max_incidence_deg ?? 80;
  const minRatio = thresholds?.min_projection_ratio ?? 0;
  const target = point.clone().addScaledVector(normal, epsilon);
  const shrunk = (camera) => Math.min(1, (denseWidth ?? camera.width) / camera.width);
  const seen = [];
  photos.forEach((photo, index) => {
    const pixel = project(photo, point);
    if (!pixel) return;
    const { camera } = photo;
    if (pixel.x < borderPx || pixel.y < borderPx) return;
    if (pixel.x > camera.width - borderPx || pixel.y > camera.height - borderPx) return;
    const toCamera = photo.center.clone().sub(point);
    const distance = toCamera.length();
    const facing = toCamera.dot(normal);
    if (facing <= 0 || facing / distance < Math.cos((maxIncidence * Math.PI) / 180)) return;
    if (tree) {
      const way = target.clone().sub(photo.center);
      const length = way.length();
      const hit = tree.raycastFirst(new Ray(photo.center, way.normalize()), DoubleSide);
      if (hit && hit.distance < length - epsilon) return;
    }
    const ratio = (camera.fx * camera.fy * facing) / pixel.z ** 3;
    seen.push({
      photo,
      index,
      pixel,
      distance,
      incidenceDeg: (Math.acos(Math.min(1, facing / distance)) * 180) / Math.PI,
      gsdMm: 1000 / Math.sqrt(ratio),
      good: ratio * shrunk(camera) ** 2 > minRatio,
    });
  });
  return seen.sort((a, b) => a.gsdMm - b.gsdMm);
}

/** The nearest iso-point to a ray, within its disc: index, or −1. `reach`: metres the ray is free. */
export function pickIsoPoint(coverage, shown, ray, reach) {
  const { position, kind, radius } = coverage;
  const o = ray.origin;
  const d = ray.direction;
  let best = -1;
  let bestAlong = Infinity;
  for (let i = 0; i < kind.length; ++i) {
    if (!shown[kind[i]]) continue;
    const x = position[3 * i] - o.x;
    const y = position[3 * i + 1] - o.y;
    const z = position[3 * i + 2] - o.z;
    const along = x * d.x + y * d.y + z * d.z;
    if (along <= 0 || along > reach + 2 * radius || along - radius > bestAlong) continue;
    const off2 = x * x + y * y + z * z - along * along;
    if (off2 < radius * radius && along < bestAlong) {
      best = i;
      bestAlong = along;
    }
  }
  return best;
}

export const vectorAt = (array, i, factor = 1) =>
  new Vector3(array[3 * i] * factor, array[3 * i + 1] * factor, array[3 * i + 2] * factor);

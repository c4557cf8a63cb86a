// Points and iso-points: one buffer each, drawn by one call; colours change by a uniform.
import { BufferAttribute, BufferGeometry, Points, ShaderMaterial, Vector3 } from 'three';
import { classes, cividis, unknown, viridis } from './palette.js';

const pointVertex = `
uniform float size;
attribute vec3 rgb;
varying vec3 vColor;
void main() {
  vColor = rgb;
  gl_Position = projectionMatrix * modelViewMatrix * vec4(position, 1.0);
  gl_PointSize = size;
}`;
const pointFragment = `
varying vec3 vColor;
void main() {
#ifdef ROUND
  vec2 at = 2.0 * gl_PointCoord - 1.0;
  if (dot(at, at) > 1.0) discard;
#endif
  gl_FragColor = vec4(vColor, 1.0);
}`;

const largeFrom = 30000; // points: a slow machine draws them bit by bit
const roundFromPx = 4; // below, nobody tells a disc from a square, which is drawn in half the time

/**
 * Coloured points. `source`: {position Float32Array, color Uint8Array}, of which every prefix is an
 * even sample of the whole (model.js); both are used as they are. `size`: pixels of the canvas.
 */
export class PointCloud extends Points {
  constructor(source, size) {
    const geometry = new BufferGeometry();
    geometry.setAttribute('position', new BufferAttribute(source.position, 3));
    geometry.setAttribute('rgb', new BufferAttribute(source.color, 3, true));
    super(
      geometry,
      new ShaderMaterial({
        vertexShader: pointVertex,
        fragmentShader: pointFragment,
        defines: size >= roundFromPx ? { ROUND: 1 } : {},
        uniforms: { size: { value: size } },
      }),
    );
    this.count = source.position.length / 3;
    this.large = this.count > largeFrom;
    this.frustumCulled = false;
  }

  /** Draws `count` points from `first` on. */
  range(first, count) {
    this.geometry.setDrawRange(first, Math.min(count, this.count - first));
  }

  /** Draws the first part (0 … 1) of the points. */
  set share(value) {
    this.range(0, Math.ceil(value * this.count));
  }

  dispose() {
    this.geometry.dispose();
    this.material.dispose();
  }
}

// A disc seen at an angle, as a point with a hole around it and its own depth.
const discVertex = `
uniform float radius, pixelsPerUnit, mode, low, high;
uniform vec3 classColors[3];
uniform vec3 stops[6];
uniform vec3 unknownColor;
uniform bvec3 shown;
attribute vec3 normal8;
attribute float kind, views, error, score;
varying vec3 vNormal, vColor;
varying float vZ, vRadius;
vec3 ramp(float share) {
  float at = clamp(share, 0.0, 1.0) * 5.0;
  int below = int(min(floor(at), 4.0));
  return mix(stops[below], stops[below + 1], at - float(below));
}
void main() {
  vNormal = normalize(normalMatrix * normal8);
  vec4 center = modelViewMatrix * vec4(position, 1.0);
  if (dot(vNormal, center.xyz) > 0.0) vNormal = -vNormal;
  int k = int(kind + 0.5);
  bool visible = k == 0 ? shown.x : (k == 1 ? shown.y : shown.z);
  if (mode < 0.5) vColor = classColors[k];
  else if (k == 2) vColor = unknownColor; // nobody asks for it
  else if (mode < 1.5) vColor = error < 0.0 ? unknownColor : ramp((log(error) - low) / (high - low));
  else vColor = ramp(((mode < 2.5 ? views : score) - low) / (high - low));
  vRadius = radius;
  vZ = center.z;
  gl_Position = visible ? projectionMatrix * center : vec4(2.0, 2.0, 2.0, 1.0);
  gl_PointSize = max(2.0, 2.0 * radius * pixelsPerUnit / max(-center.z, 1e-6));
}`;
const discFragment = `
uniform mat4 projectionMatrix;
uniform float lift;
varying vec3 vNormal, vColor;
varying float vZ, vRadius;
void main() {
  vec2 at = vec2(2.0 * gl_PointCoord.x - 1.0, 1.0 - 2.0 * gl_PointCoord.y);
  float facing = max(abs(vNormal.z), 0.15);
  float dz = -(vNormal.x * at.x + vNormal.y * at.y) / facing;
  float r2 = dot(at, at) + dz * dz;
  if (r2 > 1.0) discard;
  float z = vZ + (clamp(dz, -1.0, 1.0) + lift) * vRadius;
  vec4 clip = projectionMatrix * vec4(0.0, 0.0, z, 1.0);
  gl_FragDepth = 0.5 + 0.5 * clip.z / clip.w;
  float light = 0.72 + 0.28 * abs(vNormal.z) + 0.10 * vNormal.y;
  gl_FragColor = vec4(vColor * light * (r2 > 0.8 ? 0.86 : 1.0), 1.0);
}`;

export const colorings = ['class', 'error', 'score', 'views'];
const modes = { class: 0, error: 1, views: 2, score: 3 };
export const maxViewsShown = 10;

/** Colours of an amount, for numbers that rise. Dark is bad in all: few views, large errors. */
export const rampOf = (coloring) =>
  ({ error: [...viridis].reverse(), score: viridis, views: cividis })[coloring] ?? cividis;

/** Whether a map can be coloured so. */
export const hasColoring = (coverage, coloring) =>
  (coloring !== 'error' || Boolean(coverage?.errorUm)) &&
  (coloring !== 'score' || Boolean(coverage?.score));

const quantile = (sorted, share) =>
  sorted[Math.min(sorted.length - 1, Math.floor(share * sorted.length))];

/** Range of predicted errors, mm, that most of the map has; null when it has none. */
export function errorRange(coverage) {
  if (coverage.range === undefined) coverage.range = findErrorRange(coverage);
  return coverage.range;
}

function findErrorRange(coverage) {
  if (!coverage.errorUm) return null;
  const known = coverage.errorUm.filter((v) => v >= 0).sort();
  if (known.length === 0) return null;
  const low = Math.max(quantile(known, 0.02) / 1000, 0.01);
  return [low, Math.max(quantile(known, 0.98) / 1000, 1.5 * low)];
}

/** The coverage map as discs. */
export class CoverageCloud extends Points {
  constructor(coverage) {
    const geometry = new BufferGeometry();
    const count = coverage.kind.length;
    const error = Float32Array.from({ length: count }, (_, i) =>
      coverage.errorUm && coverage.errorUm[i] >= 0
        ? Math.max(coverage.errorUm[i] / 1000, 0.001)
        : -1,
    );
    geometry.setAttribute('position', new BufferAttribute(coverage.position, 3));
    geometry.setAttribute('normal8', new BufferAttribute(coverage.normal, 3, true));
    geometry.setAttribute('kind', new BufferAttribute(coverage.kind, 1));
    geometry.setAttribute('views', new BufferAttribute(Float32Array.from(coverage.views), 1));
    geometry.setAttribute('error', new BufferAttribute(error, 1));
    const score = coverage.score ?? new Uint8Array(count);
    geometry.setAttribute('score', new BufferAttribute(score, 1, true));
    const vectors = (colors) => colors.map((c) => new Vector3(...c));
    super(
      geometry,
      new ShaderMaterial({
        vertexShader: discVertex,
        fragmentShader: discFragment,
        uniforms: {
          radius: { value: coverage.radius * 1.3 },
          pixelsPerUnit: { value: 500 },
          lift: { value: 0.35 },
          mode: { value: 0 },
          low: { value: 0 },
          high: { value: 1 },
          shown: { value: [true, true, true] },
          classColors: { value: vectors(classes.map((c) => c.color)) },
          stops: { value: vectors(viridis) },
          unknownColor: { value: new Vector3(...unknown) },
        },
      }),
    );
    this.frustumCulled = false;
    this.coverage = coverage;
  }

  /** `coloring`: one of colorings. */
  set coloring(coloring) {
    const u = this.material.uniforms;
    u.mode.value = modes[coloring];
    const range = coloring === 'error' ? errorRange(this.coverage) : null;
    u.low.value = range ? Math.log(range[0]) : 0;
    u.high.value = range ? Math.log(range[1]) : coloring === 'score' ? 1 : maxViewsShown;
    const stops = rampOf(coloring);
    u.stops.value = stops.map((c) => new Vector3(...c));
  }

  set shown(three) {
    this.material.uniforms.shown.value = three;
  }

  set pixelsPerUnit(value) {
    this.material.uniforms.pixelsPerUnit.value = value;
  }

  dispose() {
    this.geometry.dispose();
    this.material.dispose();
  }
}

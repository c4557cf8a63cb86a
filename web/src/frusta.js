// Photos and planned views as viewing pyramids: all of a kind in one instanced draw.
import {
  BufferAttribute,
  DoubleSide,
  InstancedBufferAttribute,
  InstancedBufferGeometry,
  LineSegments,
  Mesh,
  ShaderMaterial,
} from 'three';

const vertexShader = `
uniform float size;
attribute vec3 at, right, down, forward, tint;
attribute float scale;
varying vec3 vColor;
void main() {
  vColor = tint;
  vec3 p = at + size * scale * (position.x * right + position.y * down + position.z * forward);
  gl_Position = projectionMatrix * modelViewMatrix * vec4(p, 1.0);
}`;
const fragmentShader = `
uniform float opacity;
varying vec3 vColor;
void main() { gl_FragColor = vec4(vColor, opacity); }`;

// Apex, the four corners of the picture one unit away, and a mark on its upper edge.
function corners(camera) {
  const x = [-camera.cx / camera.fx, (camera.width - camera.cx) / camera.fx];
  const y = [-camera.cy / camera.fy, (camera.height - camera.cy) / camera.fy];
  const middle = (x[0] + x[1]) / 2;
  const up = y[0] - 0.35 * (y[1] - y[0]);
  return new Float32Array([
    0,
    0,
    0,
    x[0],
    y[0],
    1,
    x[1],
    y[0],
    1,
    x[1],
    y[1],
    1,
    x[0],
    y[1],
    1,
    middle - 0.18 * (x[1] - x[0]),
    y[0],
    1,
    middle + 0.18 * (x[1] - x[0]),
    y[0],
    1,
    middle,
    up,
    1,
  ]);
}
const edges = [0, 1, 0, 2, 0, 3, 0, 4, 1, 2, 2, 3, 3, 4, 4, 1, 5, 7, 7, 6];
const sides = [0, 1, 2, 0, 2, 3, 0, 3, 4, 0, 4, 1];
const picture = [1, 2, 3, 1, 3, 4, 5, 7, 6];

function makeGeometry(camera, index, shared) {
  const geometry = new InstancedBufferGeometry();
  geometry.setAttribute('position', new BufferAttribute(corners(camera), 3));
  geometry.setIndex(index);
  for (const [name, attribute] of Object.entries(shared)) geometry.setAttribute(name, attribute);
  return geometry;
}

function material(opacity, uniforms) {
  return new ShaderMaterial({
    vertexShader,
    fragmentShader,
    side: DoubleSide,
    transparent: opacity < 1,
    depthWrite: opacity === 1,
    uniforms: { ...uniforms, opacity: { value: opacity } },
  });
}

/**
 * `poses`: [{center, right, down, forward}]; `fill`: opacity of the picture, `body`: of the sides.
 * Add `lines` and `faces` to a scene.
 */
export class Frusta {
  constructor(camera, poses, { fill = 0.18, body = 0 } = {}) {
    const count = poses.length;
    const pack = (get) => {
      const array = new Float32Array(3 * count);
      poses.forEach((pose, i) => get(pose).toArray(array, 3 * i));
      return new InstancedBufferAttribute(array, 3);
    };
    // Other cameras' pictures are wider or higher than the first one's.
    const wider = (c) => (c ? (c.width * camera.fx) / (c.fx * camera.width) : 1);
    const higher = (c) => (c ? (c.height * camera.fy) / (c.fy * camera.height) : 1);
    this.shared = {
      at: pack((p) => p.center),
      right: pack((p) => p.right.clone().multiplyScalar(wider(p.camera))),
      down: pack((p) => p.down.clone().multiplyScalar(higher(p.camera))),
      forward: pack((p) => p.forward),
      tint: new InstancedBufferAttribute(new Float32Array(3 * count), 3),
      scale: new InstancedBufferAttribute(new Float32Array(count).fill(1), 1),
    };
    this.uniforms = { size: { value: 1 } };
    this.lines = new LineSegments(
      makeGeometry(camera, edges, this.shared),
      material(1, this.uniforms),
    );
    this.faces = new Mesh(
      makeGeometry(camera, body > 0 ? [...picture, ...sides] : picture, this.shared),
      material(Math.max(fill, body), this.uniforms),
    );
    this.faces.renderOrder = 2;
    for (const part of [this.lines, this.faces]) {
      part.frustumCulled = false;
      part.geometry.instanceCount = count;
    }
    this.poses = poses;
  }

  /** Metres from the apex to the picture. */
  set size(metres) {
    this.uniforms.size.value = metres;
  }

  /** `look(i)` → {color: [r, g, b], scale}. */
  paint(look) {
    const { tint, scale } = this.shared;
    for (let i = 0; i < this.poses.length; ++i) {
      const { color, scale: factor = 1 } = look(i);
      tint.setXYZ(i, ...color);
      scale.setX(i, factor);
    }
    tint.needsUpdate = true;
    scale.needsUpdate = true;
  }

  set visible(value) {
    this.lines.visible = value;
    this.faces.visible = value;
  }

  dispose() {
    for (const part of [this.lines, this.faces]) {
      part.geometry.dispose();
      part.material.dispose();
    }
  }
}

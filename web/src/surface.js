// The fast surface: a mesh in the colours of the photos, or neutral.
import { BufferAttribute, BufferGeometry, DoubleSide, Mesh, ShaderMaterial, Vector3 } from 'three';
import { MeshBVH } from 'three-mesh-bvh';

const vertexShader = `
attribute vec3 rgb;
varying vec3 vColor, vNormal;
void main() {
  vColor = rgb;
  vNormal = normalize(normalMatrix * normal);
  gl_Position = projectionMatrix * modelViewMatrix * vec4(position, 1.0);
}`;
const fragmentShader = `
uniform float colored;
uniform vec3 neutral;
varying vec3 vColor, vNormal;
void main() {
  vec3 n = normalize(gl_FrontFacing ? vNormal : -vNormal);
  float key = max(dot(n, normalize(vec3(-0.4, 0.7, 0.6))), 0.0);
  float light = 0.52 + 0.22 * n.z + 0.34 * key;
  vec3 base = mix(neutral, vColor, colored);
  gl_FragColor = vec4(base * mix(light, 0.62 + 0.38 * light, 0.6 * colored), 1.0);
}`;

const coarseFaces = 30000;

/** About `faces` faces: vertices in the same cell of a grid become one, the first of them. */
export function clustered(geometry, faces) {
  geometry.computeBoundingBox();
  const position = geometry.getAttribute('position').array;
  const index = geometry.index.array;
  const { min, max } = geometry.boundingBox;
  // A surface that crosses n cells leaves about two faces in each: area / (faces / 2), where the
  // area of a closed or open sheet is of the order of the box's two largest sides.
  const sides = [max.x - min.x, max.y - min.y, max.z - min.z].sort((a, b) => b - a);
  const cell = Math.sqrt((2 * (sides[0] * sides[1] + sides[0] * sides[2])) / faces) || 1;
  const [nx, ny] = [Math.ceil(sides[0] / cell) + 1, Math.ceil(sides[0] / cell) + 1];
  const first = new Map(); // of each cell
  const merged = new Uint32Array(position.length / 3);
  for (let i = 0; i < merged.length; ++i) {
    const key =
      Math.floor((position[3 * i] - min.x) / cell) +
      nx *
        (Math.floor((position[3 * i + 1] - min.y) / cell) +
          ny * Math.floor((position[3 * i + 2] - min.z) / cell));
    const known = first.get(key);
    if (known === undefined) first.set(key, i);
    merged[i] = known ?? i;
  }
  const kept = [];
  for (let f = 0; f < index.length; f += 3) {
    const [a, b, c] = [merged[index[f]], merged[index[f + 1]], merged[index[f + 2]]];
    if (a !== b && b !== c && c !== a) kept.push(a, b, c);
  }
  const coarse = new BufferGeometry();
  for (const name of ['position', 'normal', 'rgb'])
    coarse.setAttribute(name, geometry.getAttribute(name)); // the same memory
  coarse.setIndex(new BufferAttribute(new Uint32Array(kept), 1));
  return coarse;
}

export class SurfaceMesh extends Mesh {
  constructor(surface) {
    const geometry = new BufferGeometry();
    geometry.setAttribute('position', new BufferAttribute(surface.position, 3));
    geometry.setIndex(new BufferAttribute(surface.face, 1));
    geometry.computeVertexNormals();
    const color = surface.color ?? new Uint8Array(surface.position.length);
    geometry.setAttribute('rgb', new BufferAttribute(color, 3, true));
    super(
      geometry,
      new ShaderMaterial({
        vertexShader,
        fragmentShader,
        side: DoubleSide,
        uniforms: {
          colored: { value: surface.color ? 1 : 0 },
          neutral: { value: new Vector3(0.74, 0.75, 0.77) },
        },
      }),
    );
    this.full = geometry;
    this.hasColor = surface.color !== null;
    this.frustumCulled = false;
  }

  set colored(value) {
    this.material.uniforms.colored.value = value && this.hasColor ? 1 : 0;
  }

  /** Search tree over the faces (which it reorders), built at the first use. */
  get tree() {
    this.bvh ??= new MeshBVH(this.full, { indirect: true });
    return this.bvh;
  }

  /** Draws a coarser surface, made at the first use; a small one stays as it is. */
  set coarse(value) {
    if (value && !this.simple && this.full.index.count / 3 > 2 * coarseFaces) {
      this.simple = clustered(this.full, coarseFaces);
    }
    this.geometry = (value && this.simple) || this.full;
  }

  dispose() {
    this.full.dispose();
    this.simple?.dispose();
    this.material.dispose();
  }
}

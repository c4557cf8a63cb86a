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
    this.hasColor = surface.color !== null;
    this.frustumCulled = false;
  }

  set colored(value) {
    this.material.uniforms.colored.value = value && this.hasColor ? 1 : 0;
  }

  /** Search tree over the faces (which it reorders), built at the first use. */
  get tree() {
    this.bvh ??= new MeshBVH(this.geometry, { indirect: true });
    return this.bvh;
  }

  dispose() {
    this.geometry.dispose();
    this.material.dispose();
  }
}

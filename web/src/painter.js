// Draws the scene as finely as the machine can. While the view moves, a slow one draws a part of the
// points and a coarser surface; when it stands still, it adds the missing points piece by piece, so
// that no frame blocks the page.
import {
  AlwaysDepth,
  DepthTexture,
  Mesh,
  NoBlending,
  PlaneGeometry,
  ShaderMaterial,
  UnsignedIntType,
  WebGLRenderTarget,
} from 'three';

const goalMs = 45; // of a frame
const fastMs = 24;
const leastShare = 1 / 64;
const restMs = 150; // stillness before a slow machine draws everything
const pieceMs = [120, 250]; // a piece is made larger below, smaller above
const mostPieces = 12;
const leastPiece = 50000; // points

/** Whether WebGL is emulated on the CPU. */
export function isEmulated() {
  const gl = document.createElement('canvas').getContext('webgl2');
  if (!gl) return true;
  const names = gl.getExtension('WEBGL_debug_renderer_info');
  const name = gl.getParameter(names ? names.UNMASKED_RENDERER_WEBGL : gl.RENDERER);
  gl.getExtension('WEBGL_lose_context')?.loseContext();
  return /swiftshader|llvmpipe|softpipe|software|basic render/i.test(name);
}

/** Which part of the points a moving view shows, from how long its frames took. */
export class Pace {
  constructor(slow) {
    this.share = slow ? 0.1 : 1;
    this.coarse = slow;
    this.moving = 0; // frames in a row
  }

  frame(now, moving) {
    const took = now - this.last;
    this.last = now;
    this.moving = moving ? this.moving + 1 : 0;
    if (this.moving < 3) return; // the time before was not that of a moving frame
    if (took > goalMs) {
      if (this.share === leastShare) this.coarse = true;
      this.share = Math.max(leastShare, this.share * Math.max(0.3, goalMs / took));
    } else if (took < fastMs) this.share = Math.min(1, 1.15 * this.share);
  }
}

const vertexShader = `
varying vec2 at;
void main() {
  at = uv;
  gl_Position = vec4(position.xy, 0.0, 1.0);
}`;
const fragmentShader = `
uniform sampler2D color, depth;
varying vec2 at;
void main() {
  vec4 c = texture2D(color, at);
  if (c.a == 0.0) discard;
  gl_FragColor = c;
  gl_FragDepth = texture2D(depth, at).x;
}`;

const layer = { solid: 0, clouds: 1, sheer: 2 };

// A picture that grows: everything solid, then the clouds piece by piece; the transparent over it.
class Growing {
  constructor(renderer, scene, camera) {
    Object.assign(this, { renderer, scene, camera });
    this.material = new ShaderMaterial({
      vertexShader,
      fragmentShader,
      uniforms: { color: { value: null }, depth: { value: null } },
      blending: NoBlending,
      depthFunc: AlwaysDepth,
    });
    this.sheet = new Mesh(new PlaneGeometry(2, 2), this.material);
    this.sheet.frustumCulled = false;
  }

  #target() {
    const { width, height } = this.renderer.domElement;
    if (this.target?.width === width && this.target?.height === height) return;
    this.target?.dispose();
    this.target = new WebGLRenderTarget(width, height, {
      samples: this.renderer.getContextAttributes().antialias ? 4 : 0,
      depthTexture: new DepthTexture(width, height, UnsignedIntType),
    });
    this.material.uniforms.color.value = this.target.texture;
    this.material.uniforms.depth.value = this.target.depthTexture;
  }

  #pass(which, target, clear) {
    this.renderer.setRenderTarget(target);
    this.renderer.autoClear = clear;
    this.camera.layers.set(which);
    this.renderer.render(this.scene, this.camera);
  }

  #show() {
    this.renderer.setRenderTarget(null);
    this.renderer.autoClear = true;
    this.camera.layers.enableAll();
    this.renderer.render(this.sheet, this.camera);
    this.#pass(layer.sheer, null, false);
    this.camera.layers.enableAll();
    this.renderer.autoClear = true;
  }

  begin(clouds) {
    this.clouds = clouds;
    this.cloud = 0;
    this.done = 0;
    this.#target();
    this.scene.traverse((object) => {
      if (clouds.includes(object)) object.layers.set(layer.clouds);
      else object.layers.set(object.material?.transparent ? layer.sheer : layer.solid);
    });
    this.#pass(layer.solid, this.target, true);
  }

  /** Adds up to `count` points. Returns whether some are missing. */
  add(count) {
    const cloud = this.clouds[this.cloud];
    for (const other of this.clouds) other.range(0, 0);
    cloud.range(this.done, count);
    this.#pass(layer.clouds, this.target, false);
    this.#show();
    this.done += count;
    if (this.done >= cloud.count) {
      this.cloud++;
      this.done = 0;
    }
    return this.cloud < this.clouds.length;
  }
}

export class Painter {
  constructor(renderer, scene, camera, slow) {
    Object.assign(this, { renderer, scene, camera });
    camera.layers.enableAll();
    this.pace = new Pace(slow);
    this.slow = slow;
    this.growing = new Growing(renderer, scene, camera);
    this.stillSince = -Infinity;
    this.complete = false; // whether all that is shown has been drawn
  }

  /** `clouds`: PointCloud; `surface`: SurfaceMesh or undefined. */
  setContent(clouds, surface) {
    this.clouds = clouds;
    this.surface = surface;
    this.pace.coarse = this.slow;
    this.restart();
  }

  /** Something has changed: what was drawn is old. */
  restart() {
    this.complete = false;
    this.piece = 0;
  }

  #everything(share) {
    for (const cloud of this.clouds) cloud.share = cloud.large ? share : 1;
    if (this.surface) this.surface.coarse = share < 1 && this.pace.coarse;
    this.renderer.render(this.scene, this.camera);
  }

  // The next piece is larger or smaller by how long the last one took.
  #grow(now, clouds) {
    if (this.piece === 0) {
      if (this.surface) this.surface.coarse = false;
      this.growing.begin(clouds);
      const most = Math.max(...clouds.map((cloud) => cloud.count));
      this.least = Math.max(most / mostPieces, leastPiece);
      this.piece = this.least;
    } else {
      const took = now - this.lastPiece;
      if (took > pieceMs[1]) this.piece = Math.max(this.least, 0.7 * this.piece);
      else if (took < pieceMs[0]) this.piece *= 1.6;
    }
    this.lastPiece = now;
    this.complete = !this.growing.add(Math.ceil(this.piece));
  }

  /** One frame. Returns whether another one is needed to show everything. */
  draw(now, moving) {
    this.pace.frame(now, moving);
    const behind = this.pace.share < 1 || this.pace.coarse;
    if (moving) {
      this.stillSince = now;
      this.#everything(behind ? Math.min(this.pace.share, 0.999) : 1);
      return behind;
    }
    if (this.complete) return false;
    if (behind && now - this.stillSince < restMs) return true;
    const large = this.clouds.filter((cloud) => cloud.visible && cloud.large);
    if (behind && large.length > 0) {
      this.#grow(now, large);
      return !this.complete;
    }
    this.#everything(1);
    this.complete = true;
    return false;
  }
}

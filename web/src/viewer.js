// The 3D view: what is drawn, from where, and what is under the pointer. Draws only when something
// has changed.
import {
  ColorManagement,
  GridHelper,
  LinearSRGBColorSpace,
  PerspectiveCamera,
  Raycaster,
  RingGeometry,
  Mesh,
  MeshBasicMaterial,
  Color,
  DoubleSide,
  Scene,
  Vector2,
  Vector3,
  WebGLRenderer,
} from 'three';
import { OrbitControls } from 'three/addons/controls/OrbitControls.js';
import { CoverageCloud, PointCloud } from './clouds.js';
import { Frusta } from './frusta.js';
import { Painter, isEmulated } from './painter.js';
import { accent } from './palette.js';
import { makeDrone, placeDrone, Route } from './route.js';
import { SurfaceMesh } from './surface.js';
import { automaticEpsilon, photosThatSee, pickIsoPoint, project, vectorAt } from './visibility.js';

// Colours are what the palette says, in sRGB, through and through.
ColorManagement.enabled = false;

const fovDeg = 42;
const up = new Vector3(0, 0, 1);

// Middle 96 % of the positions along each axis.
function robustBounds(position) {
  const count = position.length / 3;
  const step = Math.max(1, Math.floor(count / 20000));
  const low = new Vector3();
  const high = new Vector3();
  ['x', 'y', 'z'].forEach((axis, k) => {
    const values = new Float32Array(Math.ceil(count / step));
    for (let i = 0, n = 0; i < count; i += step) values[n++] = position[3 * i + k];
    values.sort();
    low[axis] = values[Math.floor(0.02 * (values.length - 1))];
    high[axis] = values[Math.ceil(0.98 * (values.length - 1))];
  });
  return { low, high };
}

export class Viewer {
  constructor(canvas, onView) {
    this.canvas = canvas;
    this.onView = onView; // called after every frame
    const emulated = isEmulated();
    this.renderer = new WebGLRenderer({
      canvas,
      antialias: !emulated, // costs a CPU more than half of its frames
      alpha: true,
      powerPreference: 'high-performance',
    });
    this.renderer.outputColorSpace = LinearSRGBColorSpace;
    this.renderer.setPixelRatio(Math.min(devicePixelRatio, 2));
    this.scene = new Scene();
    this.camera = new PerspectiveCamera(fovDeg, 1, 0.1, 1000);
    this.camera.up.copy(up);
    this.painter = new Painter(this.renderer, this.scene, this.camera, emulated);
    this.controls = new OrbitControls(this.camera, canvas);
    this.controls.enableDamping = true;
    this.controls.dampingFactor = 0.12;
    this.controls.zoomToCursor = true;
    this.controls.addEventListener('change', () => this.invalidate());
    this.controls.addEventListener('start', () => {
      this.flight = null;
      this.onLeave?.();
    });
    this.drone = makeDrone();
    this.scene.add(this.drone);
    this.marker = new Mesh(
      new RingGeometry(0.8, 1, 40),
      new MeshBasicMaterial({
        color: new Color(...accent.selected),
        side: DoubleSide,
        depthTest: false,
        transparent: true,
      }),
    );
    this.marker.renderOrder = 6;
    this.marker.visible = false;
    this.scene.add(this.marker);
    this.layers = {};
    this.shown = {
      surface: true,
      color: false,
      coverage: true,
      points: false,
      fused: false,
      photos: true,
      views: true,
      path: true,
      drone: true,
      ground: true,
    };
    this.classShown = [true, true, true];
    this.coloring = 'class';
    this.selectedPhoto = -1;
    this.seeing = new Set();
    new ResizeObserver(() => this.resize()).observe(canvas.parentElement);
    this.resize();
  }

  // ---- content

  setScene(scene) {
    for (const layer of Object.values(this.layers)) {
      this.scene.remove(layer, layer.lines, layer.faces, layer.views, layer.path);
      layer.dispose();
    }
    const layers = {};
    this.data = scene;
    const basis = scene.coverage?.position.length
      ? this.#required(scene.coverage)
      : scene.points.position;
    this.bounds = robustBounds(basis.length ? basis : new Float32Array([-1, -1, -1, 1, 1, 1]));
    this.size = Math.max(1e-6, this.bounds.high.distanceTo(this.bounds.low));
    this.unit = this.size / 45; // of frusta, arrows, the drone
    if (scene.surface) layers.surface = new SurfaceMesh(scene.surface);
    if (scene.coverage) layers.coverage = new CoverageCloud(scene.coverage);
    layers.points = new PointCloud(scene.points, 3 * this.renderer.getPixelRatio());
    const camera = scene.photos[0]?.camera;
    if (camera) {
      layers.photos = new Frusta(camera, scene.photos);
      layers.photos.size = this.unit;
    }
    layers.route = new Route(scene, camera, this.unit);
    for (const layer of Object.values(layers)) {
      if (layer.isObject3D) this.scene.add(layer);
      else this.scene.add(...[layer.lines, layer.faces, layer.views, layer.path].filter(Boolean));
    }
    this.layers = layers;
    this.#tellPainter();
    this.epsilon = scene.surface ? automaticEpsilon(scene.surface) : 0;
    this.#makeGround();
    this.placeDrone(
      this.vehicle ?? layers.route.start,
      this.vehicle?.yaw_deg ?? layers.route.start?.yaw_deg,
    );
    this.resize();
    this.apply();
  }

  // Positions of the iso-points that have to be covered; all of them when there are none.
  #required(coverage) {
    const kept = [];
    coverage.kind.forEach((kind, i) => {
      if (kind !== 2) kept.push(...coverage.position.subarray(3 * i, 3 * i + 3));
    });
    return kept.length ? Float32Array.from(kept) : coverage.position;
  }

  #makeGround() {
    this.grid?.dispose();
    this.scene.remove(this.grid);
    const step = 10 ** Math.round(Math.log10(this.size / 8));
    const cells = 2 * Math.ceil((0.9 * this.size) / step);
    const grid = new GridHelper(cells * step, cells, 0x8a94a0, 0x8a94a0);
    grid.rotation.x = Math.PI / 2;
    const { low, high } = this.bounds;
    grid.position.set((low.x + high.x) / 2, (low.y + high.y) / 2, low.z - 0.02 * this.size);
    grid.material.transparent = true;
    grid.material.opacity = 0.22;
    grid.material.depthWrite = false;
    this.grid = grid;
    this.scene.add(grid);
  }

  setFused(cloud) {
    if (this.layers.fused) {
      this.scene.remove(this.layers.fused);
      this.layers.fused.dispose();
      delete this.layers.fused;
    }
    if (cloud) {
      this.layers.fused = new PointCloud(cloud, 2 * this.renderer.getPixelRatio());
      this.scene.add(this.layers.fused);
    }
    this.#tellPainter();
    this.apply();
  }

  #tellPainter() {
    const { points, fused, surface } = this.layers;
    this.painter.setContent([points, fused].filter(Boolean), surface);
  }

  placeDrone(at, yawDeg) {
    this.drone.userData.placed = Boolean(at);
    if (at) placeDrone(this.drone, at.at ?? at, yawDeg, this.unit);
    this.apply();
  }

  /** Takes over shown, coloring, classShown, selection. */
  apply() {
    const { layers, shown } = this;
    if (layers.surface) {
      layers.surface.visible = shown.surface;
      layers.surface.colored = shown.color;
    }
    if (layers.coverage) {
      layers.coverage.visible = shown.coverage;
      layers.coverage.coloring = this.coloring;
      layers.coverage.shown = this.classShown;
    }
    if (layers.points) layers.points.visible = shown.points;
    if (layers.fused) layers.fused.visible = shown.fused;
    if (layers.photos) {
      layers.photos.visible = shown.photos && !this.looking;
      layers.photos.paint((i) => {
        if (i === this.selectedPhoto) return { color: accent.selected, scale: 1.8 };
        return this.seeing.has(i) ? { color: accent.sees, scale: 1.25 } : { color: accent.photo };
      });
    }
    if (layers.route) {
      layers.route.views.visible = shown.views && !this.looking;
      layers.route.path.visible = shown.path && !this.looking;
    }
    this.drone.visible = shown.drone && !this.looking && this.drone.userData.placed === true;
    if (this.grid) this.grid.visible = shown.ground;
    this.invalidate();
  }

  /** A ring around a point, or none. */
  mark(point, normal) {
    this.marker.visible = Boolean(point);
    if (point) {
      this.marker.position.copy(point).addScaledVector(normal, 0.002 * this.size);
      this.marker.quaternion.setFromUnitVectors(up, normal);
      this.marker.scale.setScalar(
        Math.max(2 * (this.data.coverage?.radius ?? 0), 0.012 * this.size),
      );
    }
    this.invalidate();
  }

  // ---- viewpoint

  resize() {
    const { clientWidth: width, clientHeight: height } = this.canvas.parentElement;
    if (width === 0 || height === 0) return;
    this.renderer.setSize(width, height, false);
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
    this.layers.route?.resize(width, height);
    this.onLeave?.();
    this.invalidate();
  }

  #setFov(deg) {
    this.camera.fov = deg;
    this.camera.near = this.size / 2000;
    this.camera.far = 60 * this.size;
    this.camera.updateProjectionMatrix();
    const pixels = this.canvas.height / (2 * Math.tan((deg * Math.PI) / 360));
    if (this.layers.coverage) this.layers.coverage.pixelsPerUnit = pixels;
  }

  /** Looks along `direction` ("fit", "top", "side") at everything that has to be covered. */
  fit(direction = 'fit', animate = true) {
    if (!this.data) return;
    const { low, high } = this.bounds;
    const target = low.clone().add(high).multiplyScalar(0.5);
    const way = {
      fit: new Vector3(-0.62, -0.78, 0.62),
      top: new Vector3(0, -0.001, 1),
      side: new Vector3(0, -1, 0.12),
    }[direction].normalize();
    const vertical = Math.tan((fovDeg * Math.PI) / 360);
    const narrow = Math.min(vertical, vertical * this.camera.aspect);
    const distance = (0.5 * this.size) / narrow + 0.15 * this.size;
    this.flyTo(target.clone().addScaledVector(way, distance), target, fovDeg, animate);
  }

  /** Moves the camera there within a third of a second. */
  flyTo(position, target, fov = fovDeg, animate = true, done = null) {
    const from = {
      position: this.camera.position.clone(),
      target: this.controls.target.clone(),
      fov: this.camera.fov,
    };
    const still = matchMedia('(prefers-reduced-motion: reduce)').matches;
    const length = animate && !still && this.data ? 350 : 0;
    const start = performance.now();
    this.flight = (now) => {
      const t = length === 0 ? 1 : Math.min(1, (now - start) / length);
      const ease = t * t * (3 - 2 * t);
      this.camera.position.lerpVectors(from.position, position, ease);
      this.controls.target.lerpVectors(from.target, target, ease);
      this.#setFov(from.fov + (fov - from.fov) * ease);
      if (t === 1) {
        this.flight = null;
        this.controls.update();
        done?.();
      }
    };
    this.invalidate();
  }

  /** Looks through a photo; `done` gets the photo's rectangle on the canvas, CSS pixels. */
  lookThrough(photo, done) {
    const c = photo.camera;
    const { clientWidth: width, clientHeight: height } = this.canvas;
    // The photo takes 88 % of the canvas along the axis that limits it.
    const scale = 0.88 * Math.min(width / c.width, height / c.height);
    const fov = (2 * Math.atan(height / 2 / (c.fy * scale)) * 180) / Math.PI;
    const ahead = this.bounds.low
      .clone()
      .add(this.bounds.high)
      .multiplyScalar(0.5)
      .sub(photo.center)
      .dot(photo.forward);
    const distance = Math.max(0.2 * this.size, ahead);
    this.flyTo(
      photo.center.clone(),
      photo.center.clone().addScaledVector(photo.forward, distance),
      fov,
      true,
      () =>
        done({
          left: width / 2 - c.cx * scale,
          top: height / 2 - c.cy * scale,
          width: c.width * scale,
          height: c.height * scale,
        }),
    );
  }

  /** Keyboard: turns by radians, zooms by a factor, moves by shares of the distance. */
  nudge({ turn = 0, tilt = 0, zoom = 1, right = 0, ahead = 0 }) {
    if (!this.data) return;
    const offset = this.camera.position.clone().sub(this.controls.target);
    offset.applyAxisAngle(up, turn);
    const flat = new Vector3(offset.x, offset.y, 0);
    const angle = Math.atan2(offset.z, flat.length());
    const next = Math.min(1.55, Math.max(-1.2, angle + tilt));
    const length = offset.length() * zoom;
    flat.normalize();
    offset
      .set(flat.x * Math.cos(next), flat.y * Math.cos(next), Math.sin(next))
      .multiplyScalar(length);
    const move = new Vector3(-flat.y, flat.x, 0)
      .multiplyScalar(right * length)
      .addScaledVector(flat, -ahead * length);
    this.controls.target.add(move);
    this.camera.position.copy(this.controls.target).add(offset);
    this.flight = null;
    this.onLeave?.();
    this.controls.update();
    this.nudged = true;
    this.invalidate();
  }

  // ---- picking

  #rayAt(x, y) {
    const box = this.canvas.getBoundingClientRect();
    const ray = new Raycaster();
    ray.setFromCamera(
      new Vector2((2 * (x - box.left)) / box.width - 1, 1 - (2 * (y - box.top)) / box.height),
      this.camera,
    );
    return ray.ray;
  }

  /** What is at a place of the window: {photo: i}, {point: i}, {place, normal} or null. */
  pick(x, y) {
    const photo = this.shown.photos ? this.#pickPhoto(x, y) : -1;
    const ray = this.#rayAt(x, y);
    const hit =
      this.layers.surface && (this.shown.surface || this.shown.coverage)
        ? this.layers.surface.tree.raycastFirst(ray, DoubleSide)
        : null;
    const reach = hit?.distance ?? Infinity;
    if (photo >= 0 && this.data.photos[photo].center.distanceTo(ray.origin) < reach)
      return { photo };
    if (this.shown.coverage && this.data.coverage) {
      const point = pickIsoPoint(this.data.coverage, this.classShown, ray, reach);
      if (point >= 0) return { point };
    }
    if (!hit) return photo >= 0 ? { photo } : null;
    const normal = hit.face.normal.clone();
    if (normal.dot(ray.direction) > 0) normal.negate();
    return { place: hit.point.clone(), normal };
  }

  #pickPhoto(x, y) {
    const box = this.canvas.getBoundingClientRect();
    let best = -1;
    let bestOff = 13;
    const place = new Vector3();
    this.data.photos.forEach((photo, i) => {
      // The middle between apex and picture.
      place
        .copy(photo.center)
        .addScaledVector(photo.forward, 0.55 * this.unit)
        .project(this.camera);
      if (place.z > 1) return;
      const off = Math.hypot(
        box.left + ((place.x + 1) / 2) * box.width - x,
        box.top + ((1 - place.y) / 2) * box.height - y,
      );
      if (off < bestOff) {
        best = i;
        bestOff = off;
      }
    });
    return best;
  }

  photosThatSee(point, normal) {
    return photosThatSee(
      this.data.photos,
      point,
      normal,
      this.layers.surface?.tree ?? null,
      this.epsilon,
      this.data.summary?.thresholds,
      this.denseWidth,
    );
  }

  isoPoint(i) {
    const { position, normal } = this.data.coverage;
    return { point: vectorAt(position, i), normal: vectorAt(normal, i, 1 / 127).normalize() };
  }

  projectTo(photo, point) {
    return project(photo, point);
  }

  // ---- frames

  invalidate() {
    this.painter.restart();
    this.#ask();
  }

  #ask() {
    if (this.pending) return;
    this.pending = true;
    requestAnimationFrame((now) => this.#frame(now));
  }

  #frame(now) {
    this.pending = false;
    if (!this.data) return;
    this.flight?.(now);
    const moving = this.flight ? true : this.controls.update() || this.nudged;
    this.nudged = false;
    const more = this.painter.draw(now, Boolean(moving));
    this.onView?.(this);
    if (moving || more) this.#ask();
  }

  /** Degrees that north is turned on the screen, and metres a CSS pixel at the target. */
  gauge() {
    const way = this.controls.target.clone().sub(this.camera.position);
    const metres =
      (2 * Math.tan((this.camera.fov * Math.PI) / 360) * way.length()) / this.canvas.clientHeight;
    return { northDeg: (-Math.atan2(way.x, way.y) * 180) / Math.PI, metresPerPixel: metres };
  }
}

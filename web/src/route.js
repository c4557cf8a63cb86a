// The next flight: path with arrows, planned views with numbers, the drone.
import {
  CanvasTexture,
  Color,
  ConeGeometry,
  Group,
  InstancedMesh,
  Matrix4,
  Mesh,
  MeshBasicMaterial,
  Quaternion,
  Sprite,
  SpriteMaterial,
  TorusGeometry,
  BoxGeometry,
  Vector3,
  SphereGeometry,
} from 'three';
import { Line2 } from 'three/addons/lines/Line2.js';
import { LineGeometry } from 'three/addons/lines/LineGeometry.js';
import { LineMaterial } from 'three/addons/lines/LineMaterial.js';
import { Frusta } from './frusta.js';
import { accent, css, unknown } from './palette.js';

const up = new Vector3(0, 0, 1);
const radians = (deg) => (deg * Math.PI) / 180;

/** Axes of a camera without roll: yaw clockwise from north, pitch up (as CamFromWorld). */
export function poseOf(stop) {
  const yaw = radians(stop.yaw_deg);
  const pitch = radians(stop.pitch_deg);
  const forward = new Vector3(
    Math.cos(pitch) * Math.sin(yaw),
    Math.cos(pitch) * Math.cos(yaw),
    Math.sin(pitch),
  );
  const right = new Vector3(Math.cos(yaw), -Math.sin(yaw), 0);
  return { center: stop.at, forward, right, down: forward.clone().cross(right) };
}

// Raw colours, as the other layers have them.
const flat = (rgb, options = {}) =>
  new MeshBasicMaterial({ color: new Color().setRGB(...rgb), toneMapped: false, ...options });

function badge(text) {
  const canvas = document.createElement('canvas');
  canvas.width = canvas.height = 64;
  const ctx = canvas.getContext('2d');
  ctx.fillStyle = css(accent.next);
  ctx.strokeStyle = '#fff';
  ctx.lineWidth = 5;
  ctx.beginPath();
  ctx.arc(32, 32, 26, 0, 2 * Math.PI);
  ctx.fill();
  ctx.stroke();
  ctx.fillStyle = '#fff';
  ctx.font = `600 ${text.length > 2 ? 22 : 30}px system-ui, sans-serif`;
  ctx.textAlign = 'center';
  ctx.textBaseline = 'middle';
  ctx.fillText(text, 32, 34);
  const sprite = new Sprite(
    new SpriteMaterial({
      map: new CanvasTexture(canvas),
      sizeAttenuation: false,
      depthTest: false,
      toneMapped: false,
    }),
  );
  sprite.scale.setScalar(0.034);
  sprite.center.set(0.5, -0.4);
  sprite.renderOrder = 5;
  return sprite;
}

function arrows(points, size) {
  const legs = [];
  for (let i = 0; i + 1 < points.length; ++i) {
    const way = points[i + 1].clone().sub(points[i]);
    if (way.length() > 2 * size)
      legs.push([points[i].clone().addScaledVector(way, 0.55), way.normalize()]);
  }
  const mesh = new InstancedMesh(
    new ConeGeometry(0.3 * size, size, 12),
    flat(accent.path),
    Math.max(1, legs.length),
  );
  mesh.count = legs.length;
  const matrix = new Matrix4();
  legs.forEach(([at, way], i) => {
    const turn = new Quaternion().setFromUnitVectors(new Vector3(0, 1, 0), way);
    mesh.setMatrixAt(i, matrix.compose(at, turn, new Vector3(1, 1, 1)));
  });
  mesh.frustumCulled = false;
  return mesh;
}

/** A quadrotor of one metre. */
export function makeDrone() {
  const drone = new Group();
  const body = flat(accent.drone);
  const ring = flat([0.2, 0.22, 0.26]);
  drone.add(new Mesh(new SphereGeometry(0.15, 16, 12), body));
  for (const angle of [45, 135]) {
    const arm = new Mesh(new BoxGeometry(1.05, 0.06, 0.05), body);
    arm.rotation.z = radians(angle);
    drone.add(arm);
  }
  for (const x of [-0.38, 0.38]) {
    for (const y of [-0.38, 0.38]) {
      const rotor = new Mesh(new TorusGeometry(0.25, 0.035, 8, 24), ring);
      rotor.position.set(x, y, 0.06);
      drone.add(rotor);
    }
  }
  const nose = new Mesh(new ConeGeometry(0.09, 0.3, 12), flat([1, 0.75, 0.1]));
  nose.position.set(0, 0.3, 0); // north when yaw is 0
  drone.add(nose);
  return drone;
}

/** Everything of one iteration's plan. Groups: views, path. */
export class Route {
  constructor(scene, camera, size) {
    this.views = new Group();
    this.path = new Group();
    const numbers = new Map();
    for (const stop of scene.path?.waypoints ?? []) {
      if (stop.view_id >= 0) numbers.set(stop.view_id, numbers.size + 1);
    }
    this.frusta = null;
    if (scene.views.length > 0 && camera) {
      this.frusta = new Frusta(camera, scene.views.map(poseOf), { fill: 0.34, body: 0.2 });
      this.frusta.size = 1.25 * size;
      this.frusta.paint((i) => ({
        color: numbers.has(scene.views[i].id) || !scene.path ? accent.next : unknown,
      }));
      this.views.add(this.frusta.lines, this.frusta.faces);
    }
    for (const view of scene.views) {
      if (!numbers.has(view.id)) continue;
      const sprite = badge(String(numbers.get(view.id)));
      sprite.position.copy(view.at);
      this.views.add(sprite);
    }
    const points = (scene.path?.waypoints ?? []).map((stop) => stop.at);
    this.line = null;
    if (points.length > 1) {
      const geometry = new LineGeometry();
      geometry.setPositions(points.flatMap((p) => p.toArray()));
      this.line = new Line2(
        geometry,
        new LineMaterial({
          linewidth: 3,
          toneMapped: false,
        }),
      );
      this.line.material.color.setRGB(...accent.path);
      this.line.frustumCulled = false;
      this.path.add(this.line, arrows(points, 0.55 * size));
    }
    this.start = scene.path?.waypoints[0] ?? null;
  }

  resize(width, height) {
    this.line?.material.resolution.set(width, height);
  }

  dispose() {
    for (const group of [this.views, this.path]) {
      group.traverse((object) => {
        object.geometry?.dispose();
        object.material?.map?.dispose();
        object.material?.dispose();
      });
    }
  }
}

/** Puts the drone at `at`, its nose along `yawDeg`. */
export function placeDrone(drone, at, yawDeg, size) {
  drone.position.copy(at);
  drone.quaternion.setFromAxisAngle(up, -radians(yawDeg ?? 0));
  drone.scale.setScalar(1.1 * size);
}

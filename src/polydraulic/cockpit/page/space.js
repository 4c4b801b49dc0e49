// The machine in space: from the cab, from the side of its arm, from above.

import {
  BufferGeometry, Color, CylinderGeometry, DirectionalLight, EdgesGeometry, ExtrudeGeometry, Float32BufferAttribute, Group,
  HemisphereLight, Line, LineBasicMaterial, LineSegments, Matrix4, Mesh, MeshBasicMaterial, MeshLambertMaterial, PCFShadowMap, PlaneGeometry,
  Scene, Shape, SphereGeometry, Vector3, WebGLRenderer,
} from "./three.js";
import { Eye } from "./eye.js";
import { heading, hull, linkFrames, spotAt } from "./kinematics.js";
import { ALARM, BARREL, EARTH, GHOST, GROUND_GRID, INK, STAND, STEEL, TARGET, TRAIL, paint } from "./paint.js";

const ROOM = 0.05; // of the reach, round what a view must show: see `clear` of a drawing
const MOVED = 1e-3; // m, from which on a body between two links is made anew
const SOFTWARE = /swiftshader|llvmpipe|software|basic render/i;
const UP = new Vector3(0, 1, 0);

/** Between two points: a cylinder of length 1 along y, stretched. */
function span(mesh, from, to, along = 1) {
  const a = new Vector3(...from), way = new Vector3(...to).sub(a);
  const length = way.length() * along;
  way.normalize();
  mesh.position.copy(a).addScaledVector(way, length / 2);
  mesh.quaternion.setFromUnitVectors(UP, way);
  mesh.scale.set(1, Math.max(length, 1e-4), 1);
}

/** A polygon of the plane of x and z, from y = low to y = high. */
function slab(corners, [low, high]) {
  const shape = new Shape();
  corners.forEach(([x, z], k) => (k ? shape.lineTo(x, z) : shape.moveTo(x, z)));
  const made = new ExtrudeGeometry(shape, { depth: high - low, bevelEnabled: false });
  return made.rotateX(Math.PI / 2).translate(0, high, 0);
}

/** Lines at every metre, in short pieces: some drivers lose lines that pass behind the eye. */
function gridPoints(half, z) {
  const found = [], piece = Math.max(1, Math.round(half / 6));
  for (let at = -half; at <= half; at++) {
    for (let from = -half; from < half; from += piece) {
      const to = Math.min(from + piece, half);
      found.push(at, from, z, at, to, z, from, at, z, to, at, z);
    }
  }
  return found;
}

const inFrame = ([x, y, z, origin], point) => {
  const away = point.map((value, n) => value - origin[n]);
  return [x, y, z].map((axis) => axis[0] * away[0] + axis[1] * away[1] + axis[2] * away[2]);
};

export class SpaceView {
  /** Throws where a browser has no WebGL. */
  constructor(canvas, machine) {
    this.drawing = machine.drawing;
    this.reach = machine.drawing.clear[0][1] / ROOM;
    this.renderer = new WebGLRenderer({ canvas, antialias: true, alpha: true, powerPreference: "high-performance" });
    this.software = SOFTWARE.test(this.#hardware());
    this.renderer.setPixelRatio(this.software ? 1 : Math.min(devicePixelRatio, 2));
    this.renderer.shadowMap.enabled = !this.software;
    this.renderer.shadowMap.type = PCFShadowMap;
    this.scene = new Scene();
    this.links = new Map();
    this.ghosts = new Map(); // links as a shadow has them, in outlines
    this.shadowed = machine.shadow;
    this.joined = []; // bodies between two links
    this.eye = new Eye(canvas, machine, this.reach);
    this.#light();
    this.#earth();
    for (const body of this.drawing.bodies) if (body.across.length) this.#body(body);
    this.#cylinders();
    this.#marks();
  }

  #hardware() {
    const gl = this.renderer.getContext(), asked = gl.getExtension("WEBGL_debug_renderer_info");
    return asked ? String(gl.getParameter(asked.UNMASKED_RENDERER_WEBGL)) : "";
  }

  #light() {
    this.scene.add(new HemisphereLight("#ffffff", "#b9ad98", 2.1));
    const sun = new DirectionalLight("#fff6e6", 2.0), r = this.reach;
    sun.position.set(-0.6 * r, -1.1 * r, 1.9 * r);
    sun.castShadow = !this.software;
    Object.assign(sun.shadow.camera, { left: -1.5 * r, right: 1.5 * r, top: 1.5 * r, bottom: -1.5 * r, near: 0.1, far: 6 * r });
    sun.shadow.mapSize.set(2048, 2048);
    this.scene.add(sun);
  }

  #earth() {
    const size = 12 * Math.ceil(this.reach), { ground } = this.drawing;
    const earth = new Mesh(new PlaneGeometry(size, size), new MeshLambertMaterial({ color: EARTH, transparent: true, opacity: 0.72, depthWrite: false }));
    earth.position.z = ground;
    earth.receiveShadow = true;
    earth.renderOrder = 2;
    const grid = new LineSegments(new BufferGeometry(), new LineBasicMaterial({ color: GROUND_GRID, transparent: true, depthWrite: false }));
    grid.geometry.setAttribute("position", new Float32BufferAttribute(gridPoints(Math.ceil(2.5 * this.reach), ground), 3));
    grid.renderOrder = 3; // on the earth, which hides nothing
    this.scene.add(earth, grid);
  }

  #link(name) {
    if (!this.links.has(name)) {
      const group = new Group();
      group.matrixAutoUpdate = false;
      this.links.set(name, group);
      this.scene.add(group);
    }
    return this.links.get(name);
  }

  #body(body) {
    const [first] = body.spots[0], color = new Color(paint(body.fill));
    const glass = body.edge === "none";
    const material = new MeshLambertMaterial({ color, transparent: glass, opacity: glass ? 0.55 : 1 });
    const lines = new LineBasicMaterial({ color: INK, transparent: true, opacity: 0.55 });
    const parts = body.across.map(() => {
      const mesh = new Mesh(new BufferGeometry(), material);
      mesh.castShadow = !glass;
      const edges = glass ? null : new LineSegments(new BufferGeometry(), lines);
      this.#link(first).add(mesh, ...(edges ? [edges] : []));
      return { mesh, edges };
    });
    const fill = (points) => {
      const corners = body.radii.length ? hull(points, body.radii) : points;
      parts.forEach(({ mesh, edges }, k) => {
        mesh.geometry.dispose();
        mesh.geometry = slab(corners, body.across[k]);
        if (!edges) return;
        edges.geometry.dispose();
        edges.geometry = new EdgesGeometry(mesh.geometry, 24);
      });
    };
    if (body.spots.every(([link]) => link === first)) {
      fill(body.spots.map(([, [x, , z]]) => [x, z]));
      if (this.shadowed && !glass) this.#ghostly(first, parts);
    }
    else this.joined.push({ body, first, fill, before: null });
  }

  /** Outlines of a body once more, where a shadow has it. */
  #ghostly(name, parts) {
    const group = this.ghosts.get(name) ?? new Group(), lines = new LineBasicMaterial({ color: GHOST, transparent: true, depthTest: false });
    if (!this.ghosts.has(name)) {
      group.matrixAutoUpdate = false;
      this.ghosts.set(name, group);
      this.scene.add(group);
    }
    for (const { edges } of parts) {
      const made = new LineSegments(edges.geometry, lines);
      made.renderOrder = 4;
      group.add(made);
    }
  }

  #cylinders() {
    const r = this.reach, make = (radius, color) => {
      const mesh = new Mesh(new CylinderGeometry(radius, radius, 1, 18), new MeshLambertMaterial({ color }));
      mesh.castShadow = true;
      this.scene.add(mesh);
      return mesh;
    };
    this.rams = this.drawing.rams.flatMap((ram) => [-1, 1].map((side) =>
      ({ ram, aside: 0.026 * side * r, barrel: make(0.0095 * r, BARREL), rod: make(0.0055 * r, STEEL) })));
    this.pins = Object.entries(this.drawing.pins).filter(([name]) => name !== "tip").map(([, spot]) => ({ spot, mesh: make(0.006 * r, INK) }));
  }

  #marks() {
    const r = this.reach, above = { transparent: true, depthTest: false }; // seen through the earth and the machine
    const flat = (color, opacity, more = {}) => new MeshBasicMaterial({ color, transparent: true, opacity, ...more });
    const line = (n, color, more = {}) => {
      const geometry = new BufferGeometry();
      geometry.setAttribute("position", new Float32BufferAttribute(new Float32Array(3 * n), 3));
      const made = new Line(geometry, new LineBasicMaterial({ color, ...more }));
      made.frustumCulled = false;
      made.renderOrder = 4;
      this.scene.add(made);
      return made;
    };
    this.trail = line(600, TRAIL);
    this.plumb = line(2, TRAIL);
    this.tip = new Mesh(new SphereGeometry(0.008 * r, 16, 12), flat(TRAIL, 1));
    this.target = new Mesh(new SphereGeometry(0.022 * r, 20, 14), flat(TARGET, 0.7, above));
    this.target.renderOrder = 5;
    this.targetPlumb = line(2, TARGET, above);
    this.way = line(400, TARGET, above);
    this.weight = new Mesh(new SphereGeometry(0.016 * r, 18, 12), flat(STAND, 0.9, above));
    this.weight.renderOrder = 6;
    this.polygon = line(9, STAND, above);
    this.edge = new Mesh(new CylinderGeometry(0.008 * r, 0.008 * r, 1, 10), flat(STAND, 0.9, above));
    this.edge.renderOrder = 5;
    this.scene.add(this.tip, this.target, this.weight, this.edge);
  }

  setView(name) {
    this.eye.view = name;
  }

  resize(width, height) {
    this.renderer.setSize(width, height, false);
    this.eye.resize(width, height);
  }

  /** @param state {positions, tip, trail: [{at, turn}], target: point or null, way: points} */
  draw(state) {
    const frames = linkFrames(this.drawing, state.positions);
    this.#place(this.links, frames);
    if (state.ghost) this.#place(this.ghosts, linkFrames(this.drawing, state.ghost));
    for (const part of this.joined) this.#join(part, frames);
    for (const { ram, aside, barrel, rod } of this.rams) {
      const beside = frames.get(ram.base[0])[1], [from, to] = [ram.base, ram.rod].map((spot) => spotAt(frames, spot).map((v, n) => v + aside * beside[n]));
      const length = Math.hypot(...to.map((v, n) => v - from[n]));
      span(barrel, from, to, Math.min(ram.barrel / length, 1));
      span(rod, from, to);
    }
    for (const { spot, mesh } of this.pins) {
      const at = spotAt(frames, spot), [, y] = frames.get(spot[0]), half = 0.034 * this.reach;
      span(mesh, at.map((v, n) => v - half * y[n]), at.map((v, n) => v + half * y[n]));
    }
    this.#mark(state);
    this.eye.look(frames, heading(this.drawing, state.positions), state.tip);
    this.renderer.render(this.scene, this.eye.camera);
  }

  #place(groups, frames) {
    const matrix = new Matrix4();
    for (const [name, group] of groups) {
      const [x, y, z, o] = frames.get(name);
      matrix.set(x[0], y[0], z[0], o[0], x[1], y[1], z[1], o[1], x[2], y[2], z[2], o[2], 0, 0, 0, 1);
      group.matrix.copy(matrix);
      group.matrixWorldNeedsUpdate = true;
    }
  }

  #join(part, frames) {
    const frame = frames.get(part.first);
    const points = part.body.spots.map((spot) => {
      const [x, , z] = inFrame(frame, spotAt(frames, spot));
      return [x, z];
    });
    if (part.before?.every(([x, z], k) => Math.hypot(x - points[k][0], z - points[k][1]) < MOVED)) return;
    part.before = points;
    part.fill(points);
  }

  /** What the machine stands on, the edge over which it would tip, and where its weight acts. */
  #stand(standing) {
    this.weight.visible = this.edge.visible = this.polygon.visible = standing !== null;
    if (!standing) return;
    const { corners, edge, weight, warns } = standing, color = warns ? ALARM : STAND;
    for (const mark of [this.weight, this.edge, this.polygon]) mark.material.color.set(color);
    this.weight.position.set(...weight);
    this.#points(this.polygon, [...corners, corners[0]]);
    span(this.edge, ...edge);
  }

  #mark({ tip, trail, target, way, standing }) {
    const below = ([x, y]) => [x, y, this.drawing.ground];
    this.tip.position.set(...tip);
    this.#points(this.trail, trail.map(({ at }) => at));
    this.#points(this.plumb, [tip, below(tip)]);
    this.target.visible = this.targetPlumb.visible = target !== null;
    if (target) {
      this.target.position.set(...target);
      this.#points(this.targetPlumb, [target, below(target)]);
    }
    this.#points(this.way, way);
    this.#stand(standing);
  }

  #points(line, points) {
    const place = line.geometry.getAttribute("position"), shown = points.slice(-place.count);
    shown.forEach((point, k) => place.setXYZ(k, ...point));
    place.needsUpdate = true;
    line.geometry.setDrawRange(0, shown.length);
  }

  dispose() {
    this.renderer.dispose();
  }
}

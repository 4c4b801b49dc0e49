// The machine as lines and areas, from the side of its arm or from above, where a browser has no WebGL.

import { heading, hull, linkFrames, seenFromSide, spotAt, viewLimits } from "./kinematics.js";
import { ALARM, BARREL, EARTH, GHOST, GROUND_GRID, GROUND_LINE, INK, STAND, STEEL, STOP, TARGET, TRAIL, paint } from "./paint.js";

const AT_STOP = 2e-3; // rad or m
const LOW = 0.17; // share of the picture's height that levers cover

export class FlatView {
  constructor(canvas, machine) {
    this.canvas = canvas;
    this.machine = machine;
    this.drawing = machine.drawing;
    this.context = canvas.getContext("2d");
    this.limits = Object.fromEntries(["side", "top"].map((view) => [view, viewLimits(this.drawing, machine.functions, view)]));
    this.setView("side");
  }

  /** A cab has no view in a plane: it is the side's. */
  setView(name) {
    this.view = name === "top" ? "top" : "side";
  }

  resize(width, height) {
    this.ratio = Math.min(devicePixelRatio, 2);
    this.size = [width, height];
    this.canvas.width = Math.round(width * this.ratio);
    this.canvas.height = Math.round(height * this.ratio);
  }

  draw(state) {
    const c = this.context, [width, height] = this.size, { low, high } = this.limits[this.view];
    const scale = Math.min(width / (high[0] - low[0]), ((1 - LOW) * height) / (high[1] - low[1]));
    const left = (low[0] + high[0] - width / scale) / 2, bottom = low[1] - (LOW * height) / scale;
    c.setTransform(1, 0, 0, 1, 0, 0);
    c.clearRect(0, 0, this.canvas.width, this.canvas.height);
    c.setTransform(this.ratio * scale, 0, 0, -this.ratio * scale, -left * this.ratio * scale, this.ratio * (height + bottom * scale));
    c.lineJoin = "round";
    this.px = 1 / scale;
    this.edges = { left, bottom, right: left + width / scale, top: bottom + height / scale };
    const frames = linkFrames(this.drawing, state.positions), turn = heading(this.drawing, state.positions);
    this.seen = (point) => (this.view === "side" ? seenFromSide(this.drawing, turn, point) : point.slice(0, 2));
    this.at = (spot) => (spot[0] === this.drawing.plane ? [spot[1][0], spot[1][2]] : this.seen(spotAt(frames, spot)));
    if (this.view === "side") this.#earth();
    else this.#plan();
    for (const body of this.drawing.bodies) if (body.views.includes(this.view)) this.#body(body);
    if (this.view === "side") for (const ram of this.drawing.rams) this.#ram(ram);
    for (const stop of this.drawing.stops) if (stop.view === this.view) this.#stop(stop, state.positions);
    if (state.standing) this.#standing(state.standing);
    if (state.ghost) this.#ghost(state.ghost);
    this.#line(state.trail.map(({ at, turn: then }) => (this.view === "side" ? seenFromSide(this.drawing, then, at) : at)), TRAIL, 1.5);
    this.#line(state.way.map(this.seen), TARGET, 2);
    this.#dot(this.seen(state.tip), 4, TRAIL);
    if (state.target) this.#dot(this.seen(state.target), 8, TARGET, 0.75);
  }

  /** What the machine stands on, the edge over which it would tip, and where its weight acts. */
  #standing({ corners, edge, weight, warns }) {
    const color = warns ? ALARM : STAND, seen = this.seen;
    this.#line([...corners, corners[0]].map(seen), color, 1.6);
    this.#line(edge.map(seen), warns ? ALARM : INK, 4);
    this.#dot(seen(weight), 7, color, 0.85);
    this.#dot(seen(weight), 2.5, "#fff");
  }

  /** The machine as the shadow has it, in outlines. */
  #ghost(positions) {
    const frames = linkFrames(this.drawing, positions), turn = heading(this.drawing, positions), { at } = this;
    const seen = (point) => (this.view === "side" ? seenFromSide(this.drawing, turn, point) : point.slice(0, 2));
    this.at = (spot) => (spot[0] === this.drawing.plane ? [spot[1][0], spot[1][2]] : seen(spotAt(frames, spot)));
    this.context.setLineDash([5 * this.px, 3 * this.px]);
    for (const body of this.drawing.bodies) {
      if (!body.views.includes(this.view) || body.edge === "none") continue;
      const points = body.spots.map(this.at), corners = body.radii.length ? hull(points, body.radii) : points;
      this.#line([...corners, corners[0]], GHOST, 1.6);
    }
    this.context.setLineDash([]);
    this.at = at;
  }

  #earth() {
    const { left, right, bottom } = this.edges, { ground } = this.drawing;
    this.context.fillStyle = EARTH;
    this.context.fillRect(left, bottom, right - left, ground - bottom);
    this.#line([[left, ground], [right, ground]], GROUND_LINE, 1);
  }

  #plan() {
    const { left, right, bottom, top } = this.edges;
    this.context.fillStyle = EARTH;
    this.context.fillRect(left, bottom, right - left, top - bottom);
    for (let x = Math.ceil(left); x < right; x++) this.#line([[x, bottom], [x, top]], GROUND_GRID, 1);
    for (let y = Math.ceil(bottom); y < top; y++) this.#line([[left, y], [right, y]], GROUND_GRID, 1);
  }

  #body(body) {
    const points = body.spots.map(this.at), corners = body.radii.length ? hull(points, body.radii) : points;
    this.#path(corners);
    this.context.closePath();
    this.context.fillStyle = paint(body.fill);
    this.context.fill();
    if (body.edge === "none") return;
    this.context.strokeStyle = INK;
    this.context.lineWidth = 1.2 * this.px;
    this.context.stroke();
  }

  #ram(ram) {
    const from = this.at(ram.base), to = this.at(ram.rod), part = Math.min(ram.barrel / Math.hypot(to[0] - from[0], to[1] - from[1]), 1);
    this.#line([from, to], STEEL, 4);
    this.#line([from, [from[0] + part * (to[0] - from[0]), from[1] + part * (to[1] - from[1])]], BARREL, 9);
    for (const end of [from, to]) this.#dot(end, 3, INK);
  }

  #stop(stop, positions) {
    const joint = this.drawing.links.find((link) => link.name === stop.link).function, c = this.context;
    c.setLineDash([2 * this.px, 3 * this.px]);
    this.#line(stop.path.map(this.at), INK, 0.8);
    c.setLineDash([]);
    [stop.low, stop.high].forEach((end, k) => this.#line(stop.ticks[k].map(this.at), Math.abs(positions[joint] - end) <= AT_STOP ? STOP : INK, 2.4));
  }

  #path(points) {
    this.context.beginPath();
    points.forEach((point, k) => (k ? this.context.lineTo(...point) : this.context.moveTo(...point)));
  }

  #line(points, color, width) {
    this.#path(points);
    this.context.strokeStyle = color;
    this.context.lineWidth = width * this.px;
    this.context.stroke();
  }

  #dot([x, y], radius, color, opacity = 1) {
    const c = this.context;
    c.globalAlpha = opacity;
    c.beginPath();
    c.arc(x, y, radius * this.px, 0, 2 * Math.PI);
    c.fillStyle = color;
    c.fill();
    c.globalAlpha = 1;
  }

  dispose() {}
}

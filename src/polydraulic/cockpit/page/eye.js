// Where one looks from.

import { PerspectiveCamera } from "./three.js";
import { viewLimits } from "./kinematics.js";

const ANGLE = 30; // deg, of the camera outside
const WIDE = 62; // deg, of a driver
const CAB = "#f4f6f8"; // what a drawing fills a cab with
const MOST_ASIDE = 0.35, MOST_DOWN = -0.7, MOST_UP = 0.4; // rad
const LOW = 0.17; // share of the picture's height that levers cover

export class Eye {
  constructor(canvas, machine, reach) {
    this.machine = machine;
    this.reach = reach;
    this.view = "side";
    this.turn = -0.3; // rad, how far one has walked round the machine
    this.rise = 0.2; // rad
    this.zoom = 1;
    this.camera = new PerspectiveCamera(ANGLE, 1, 0.05, 60 * reach);
    this.limits = Object.fromEntries(["side", "top"].map((view) => [view, viewLimits(machine.drawing, machine.functions, view)]));
    this.#drag(canvas);
  }

  #drag(canvas) {
    let from = null;
    canvas.addEventListener("pointerdown", (event) => {
      from = [event.clientX, event.clientY];
      canvas.setPointerCapture(event.pointerId);
    });
    canvas.addEventListener("pointermove", (event) => {
      if (!from || !event.buttons) return;
      this.turn -= 0.006 * (event.clientX - from[0]);
      this.rise = Math.min(Math.max(this.rise + 0.006 * (event.clientY - from[1]), 0.02), 1.4);
      from = [event.clientX, event.clientY];
    });
    canvas.addEventListener("pointerup", () => { from = null; });
    canvas.addEventListener("wheel", (event) => {
      event.preventDefault();
      this.zoom = Math.min(Math.max(this.zoom * Math.exp(-0.001 * event.deltaY), 0.4), 4);
    }, { passive: false });
  }

  resize(width, height) {
    this.camera.aspect = width / height;
  }

  look(frames, turn, tip) {
    const camera = this.camera;
    camera.fov = this.view === "cab" ? WIDE : ANGLE;
    camera.up.set(0, 0, 1);
    if (this.view === "cab") this.#fromCab(frames, turn, tip);
    else this.#fromOutside(turn);
    camera.updateProjectionMatrix();
  }

  #fromOutside(turn) {
    const { drawing } = this.machine, { low, high } = this.limits[this.view];
    const [ax, ay] = drawing.slews ? drawing.links[0].origin : [0, 0];
    const tall = Math.tan((ANGLE * Math.PI) / 360), size = [high[0] - low[0], high[1] - low[1]];
    const free = 1 - LOW;
    const distance = Math.max(size[1] / free, size[0] / this.camera.aspect) / (2 * tall * this.zoom);
    const middle = [(low[0] + high[0]) / 2, (low[1] + high[1]) / 2 - LOW * distance * tall];
    if (this.view === "top") {
      this.camera.up.set(0, 1, 0);
      this.camera.position.set(middle[0], middle[1], (drawing.ground + this.limits.side.high[1]) / 2 + distance);
      this.camera.lookAt(middle[0], middle[1], drawing.ground);
      return;
    }
    const out = drawing.slews ? turn : 0, c = Math.cos(out), s = Math.sin(out);
    const seen = [ax + middle[0] * c, ay + middle[0] * s, middle[1]];
    const from = out - Math.PI / 2 + this.turn, flat = distance * Math.cos(this.rise);
    this.camera.position.set(seen[0] + flat * Math.cos(from), seen[1] + flat * Math.sin(from), seen[2] + distance * Math.sin(this.rise));
    this.camera.lookAt(...seen);
  }

  /** From the seat: in the cab that is drawn, or above what the arm stands on. */
  #fromCab(frames, turn, tip) {
    const { drawing } = this.machine, cab = drawing.bodies.find((body) => body.fill === CAB && body.across.length);
    const c = Math.cos(turn), s = Math.sin(turn), r = this.reach;
    const [ax, ay, az] = drawing.links[0].origin;
    let ahead = -0.12 * r, left = 0.1 * r, height = az + 0.28 * r;
    if (cab) {
      const xs = cab.spots.map(([, at]) => at[0]), zs = cab.spots.map(([, at]) => at[2]);
      ahead = 0.62 * Math.max(...xs) + 0.38 * Math.min(...xs);
      left = (cab.across[0][0] + cab.across[0][1]) / 2;
      height = frames.get(cab.spots[0][0])[3][2] + 0.85 * Math.max(...zs) + 0.15 * Math.min(...zs);
    } else if (!drawing.slews) {
      ahead = -0.35 * r;
      left = 0;
    }
    const at = (x, y, z) => [ax + x * c - y * s, ay + x * s + y * c, z];
    this.camera.position.set(...at(ahead, left, height));
    // a driver's head follows the tip, within what a neck does
    const away = tip.map((value, n) => value - this.camera.position.getComponent(n)), flat = Math.hypot(away[0], away[1]);
    const aside = Math.atan2(away[1] * c - away[0] * s, away[0] * c + away[1] * s), up = Math.atan2(away[2], flat);
    const yaw = turn + Math.min(Math.max(0.5 * aside, -MOST_ASIDE), MOST_ASIDE), pitch = Math.min(Math.max(0.7 * up - 0.05, MOST_DOWN), MOST_UP);
    const seen = [Math.cos(yaw) * Math.cos(pitch), Math.sin(yaw) * Math.cos(pitch), Math.sin(pitch)];
    this.camera.lookAt(...seen.map((value, n) => this.camera.position.getComponent(n) + value));
  }
}

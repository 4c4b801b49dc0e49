// All that a hand can be on, as six axes: left stick right and forward, right stick right and forward, two more.
// Whatever takes the hand away - a lost focus, a hidden page, a lost line - lets all of them go.

import { Gamepads } from "./gamepad.js";
import { Keyboard } from "./keyboard.js";

const POLL = 8; // ms
const HELD = 60; // ms between messages while a lever is out of its centre: the server takes silence for release
const QUIET = 500; // ms between messages while all are centred

export class Levers {
  /**
   * @param {{sticks: Array, wheels: Array, send: Function, drives: Function, onCommand: Function, onMove: Function}} parts
   *   `sticks` on the screen, left and right, `wheels` for the other axes; `send` takes axes; `drives` says whether they count here
   */
  constructor(parts) {
    this.parts = parts;
    this.keyboard = new Keyboard(parts.onCommand);
    this.gamepads = new Gamepads();
    this.axes = [0, 0, 0, 0, 0, 0];
    this.told = [0, 0, 0, 0, 0, 0];
    this.at = -Infinity;
    this.source = "none";
    addEventListener("blur", () => this.release());
    addEventListener("pagehide", () => this.release());
    addEventListener("gamepaddisconnected", () => this.release());
    document.addEventListener("visibilitychange", () => {
      if (document.hidden) this.release();
    });
    setInterval(() => this.poll(), POLL);
  }

  /** Let go of everything, and say so at once. */
  release() {
    this.keyboard.release();
    this.gamepads.release();
    for (const stick of [...this.parts.sticks, ...this.parts.wheels]) stick.release();
    this.poll();
  }

  #hands() {
    const [left, right] = this.parts.sticks.map((stick) => stick.value);
    return {
      touch: [...left, ...right, ...this.parts.wheels.map((wheel) => wheel.value)],
      keys: this.keyboard.axes(),
      pad: this.gamepads.axes(),
    };
  }

  poll() {
    const hands = this.#hands();
    this.source = "none";
    this.axes = this.axes.map((_, place) => {
      let largest = 0;
      for (const [name, axes] of Object.entries(hands)) {
        if (Math.abs(axes[place]) > Math.abs(largest)) {
          largest = axes[place];
          this.source = name;
        }
      }
      return largest;
    });
    this.parts.onMove(this.axes);
    if (!this.parts.drives()) {
      this.told.fill(0);
      return;
    }
    const now = performance.now();
    const changed = this.axes.some((value, place) => value !== this.told[place]);
    const pause = this.axes.some((value) => value !== 0) ? HELD : QUIET;
    if (!changed && now - this.at < pause) return;
    this.told = [...this.axes];
    this.at = now;
    this.parts.send(this.told);
  }
}

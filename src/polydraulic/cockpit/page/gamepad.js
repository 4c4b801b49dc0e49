// Gamepads, and joysticks in pairs. A pad is a snapshot: it is asked anew each time. Its axes count down and right as positive.

const DEAD = 0.12; // of full travel round the centre, which worn pads do not find

/** A stick's value without its dead zone, from there to its end as from 0 to 1. */
export const rescaled = (value, dead = DEAD) =>
  Math.abs(value) <= dead ? 0 : (Math.sign(value) * Math.min(Math.abs(value) - dead, 1 - dead)) / (1 - dead);

const finite = (value) => (Number.isFinite(value) ? value : 0);

export class Gamepads {
  constructor() {
    this.armed = true;
    this.names = [];
  }

  /** From now on nothing counts until all sticks have been let go. */
  release() {
    this.armed = false;
  }

  axes() {
    const pads = [...(navigator.getGamepads?.() ?? [])].filter((pad) => pad?.connected);
    this.names = pads.map((pad) => pad.id);
    const found = this.#read(pads);
    if (!this.armed && found.every((value) => value === 0)) this.armed = true;
    return this.armed ? found : found.map(() => 0);
  }

  #read(pads) {
    if (!pads.length) return [0, 0, 0, 0, 0, 0];
    const both = pads.find((pad) => pad.mapping === "standard") ?? pads.find((pad) => pad.axes.length >= 4);
    const [left, right] = both ? [both.axes.slice(0, 2), both.axes.slice(2, 4)] : [pads[0].axes, pads[1]?.axes ?? [0, 0]];
    const button = (place) => finite(both?.buttons?.[place]?.value ?? 0);
    const trigger = [button(7) - button(6), button(5) - button(4)]; // right minus left: triggers, then shoulders
    return [left[0], -left[1], right[0], -right[1], ...trigger].map((value) => rescaled(finite(value)) + 0);
  }
}

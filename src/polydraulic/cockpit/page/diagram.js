// What each end of each lever does, written beside it.

import { made, say } from "./dom.js";
import { KEY_NAMES } from "./keyboard.js";

/**
 * What the axes do: six of {low, high}, null where nothing is.
 * @param {"joint"|"coordinated"} mode
 */
export function axisWords(machine, mode, pattern) {
  const found = Array(6).fill(null);
  for (const f of machine.functions) {
    const { axis, sign, positive, negative } = machine.patterns[pattern][f.name];
    const [more, less] = sign > 0 ? ["+", "−"] : ["−", "+"];
    found[axis] = { high: positive ?? `${f.label} ${more}`, low: negative ?? `${f.label} ${less}` };
  }
  if (mode !== "coordinated" || !machine.coordinated?.able) return found;
  for (const [name, { axis, sign }] of Object.entries(machine.coordinated.axes)) {
    if (!(name in MOVES)) continue; // the bucket moves as it does joint by joint
    const [more, less] = MOVES[name];
    found[axis] = sign > 0 ? { high: more, low: less } : { high: less, low: more };
  }
  return found;
}

const MOVES = { reach: ["reach out", "reach in"], height: ["tip up", "tip down"], swing: ["swing left", "swing right"] }; // of positive speeds
const ENDS = [["west", "east"], ["south", "north"]];

/** Labels round two sticks on the screen, and beside the wheels for further axes. */
export class Diagram {
  constructor(machine, levers, wheels) {
    this.machine = machine;
    this.ends = levers.map((lever) => ENDS.map((names) => names.map((name) => lever.querySelector(`.${name}`)))).flat();
    this.wheels = wheels;
  }

  /** @param {"joint"|"coordinated"} mode */
  show(mode, pattern) {
    axisWords(this.machine, mode, pattern).forEach((words, axis) => {
      const [low, high] = this.ends[axis] ?? this.wheels[axis - 4] ?? [];
      if (!low) return;
      this.#write(low, words?.low, KEY_NAMES[axis][0]);
      this.#write(high, words?.high, KEY_NAMES[axis][1]);
    });
  }

  #write(element, words, key) {
    if (element.dataset.words === (words ?? "")) return;
    element.dataset.words = words ?? "";
    element.replaceChildren(...(words ? [made("span", "", words), made("kbd", "", key)] : []));
    if (!words) say(element, "");
  }
}

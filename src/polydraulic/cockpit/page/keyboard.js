// Keys as sticks, by where they are on the keyboard and not by what is printed on them.

export const KEYS = {
  KeyA: [0, -1], KeyD: [0, 1], KeyS: [1, -1], KeyW: [1, 1],
  ArrowLeft: [2, -1], ArrowRight: [2, 1], ArrowDown: [3, -1], ArrowUp: [3, 1],
  KeyJ: [2, -1], KeyL: [2, 1], KeyK: [3, -1], KeyI: [3, 1],
  KeyF: [4, -1], KeyR: [4, 1], KeyG: [5, -1], KeyT: [5, 1],
};
/** What is written next to the ends of each axis: low, high. */
export const KEY_NAMES = [["A", "D"], ["S", "W"], ["←", "→"], ["↓", "↑"], ["F", "R"], ["G", "T"]];
const FINE = 0.35; // of full travel, while Shift is held

const takesText = (element) => element.matches?.("input:not([type=range]):not([type=checkbox]), select, textarea, [contenteditable]") ?? false;

export class Keyboard {
  /** @param {(code: string) => void} onCommand told of every other key */
  constructor(onCommand) {
    this.held = new Set();
    this.fine = false;
    addEventListener("keydown", (event) => {
      this.fine = event.shiftKey;
      if (event.repeat || takesText(event.target) || event.ctrlKey || event.altKey || event.metaKey) return;
      if (event.code in KEYS) {
        event.preventDefault();
        this.held.add(event.code);
      } else onCommand(event);
    });
    addEventListener("keyup", (event) => {
      this.fine = event.shiftKey;
      this.held.delete(event.code);
    });
  }

  release() {
    this.held.clear();
  }

  axes() {
    const found = [0, 0, 0, 0, 0, 0];
    for (const code of this.held) found[KEYS[code][0]] += KEYS[code][1] * (this.fine ? FINE : 1);
    return found.map((value) => Math.max(-1, Math.min(1, value)));
  }
}

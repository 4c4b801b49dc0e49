// Sticks on the screen, for fingers and the mouse; they also show what pads and keys do.

const SVG = "http://www.w3.org/2000/svg";
const REACH = 40; // of the knob from the centre, in units of the drawing

function shape(parent, name, attributes) {
  const made = document.createElementNS(SVG, name);
  for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
  parent.append(made);
  return made;
}

/** A stick with two axes: `x` to the right, `y` forward, both -1 to 1. */
export class ScreenStick {
  constructor(element) {
    this.element = element;
    this.value = [0, 0];
    this.pointer = null;
    const svg = shape(element, "svg", { viewBox: "-60 -60 120 120", "aria-hidden": "true" });
    shape(svg, "circle", { r: 52, class: "stick-base" });
    shape(svg, "path", { d: "M-46 0H46M0 -46V46", class: "stick-cross" });
    this.rod = shape(svg, "line", { x1: 0, y1: 0, x2: 0, y2: 0, class: "stick-rod" });
    this.knob = shape(svg, "circle", { r: 17, class: "stick-knob" });
    element.addEventListener("pointerdown", (event) => {
      if (this.pointer !== null) return;
      event.preventDefault();
      this.pointer = event.pointerId;
      try {
        element.setPointerCapture(event.pointerId);
      } catch {
        // a pointer that has gone already: its end releases the stick
      }
      this.#take(event);
    });
    element.addEventListener("pointermove", (event) => {
      if (event.pointerId === this.pointer) this.#take(event);
    });
    for (const end of ["pointerup", "pointercancel", "lostpointercapture"]) {
      element.addEventListener(end, (event) => {
        if (event.pointerId === this.pointer) this.release();
      });
    }
  }

  #take(event) {
    const box = this.element.getBoundingClientRect(), half = (box.width / 2) * (REACH / 60);
    const x = (event.clientX - box.left - box.width / 2) / half, y = (box.top + box.height / 2 - event.clientY) / half;
    const size = Math.max(1, Math.hypot(x, y));
    this.value = [x / size, y / size];
  }

  release() {
    this.pointer = null;
    this.value = [0, 0];
  }

  show(x, y) {
    this.knob.setAttribute("transform", `translate(${x * REACH} ${-y * REACH})`);
    this.rod.setAttribute("x2", x * REACH);
    this.rod.setAttribute("y2", -y * REACH);
  }
}

/** A lever of one axis that springs back, for what two sticks have no room for. */
export class ScreenWheel {
  constructor(element) {
    this.value = 0;
    this.input = document.createElement("input");
    Object.assign(this.input, { type: "range", min: -1, max: 1, step: "any", value: 0 });
    this.input.setAttribute("aria-label", "another lever");
    element.append(this.input);
    this.input.addEventListener("input", () => {
      this.value = Number(this.input.value);
    });
    for (const end of ["pointerup", "pointercancel", "change", "blur"]) this.input.addEventListener(end, () => this.release());
  }

  release() {
    this.value = 0;
    this.input.value = 0;
  }

  show(value) {
    if (Number(this.input.value) !== value) this.input.value = value;
  }
}

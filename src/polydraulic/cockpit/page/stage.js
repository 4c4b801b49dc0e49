// The picture of the machine: in space where that works, else in the plane.

import { FlatView } from "./flat.js";
import { SpaceView } from "./space.js";

export class Stage {
  /** @param {(text: string) => void} say told why the picture is flat */
  constructor(holder, machine, say) {
    this.holder = holder;
    this.machine = machine;
    this.say = say;
    this.name = "side";
    new ResizeObserver(() => this.#fit()).observe(holder);
    this.show(location.hash === "#flat" ? "flat" : "space");
  }

  /** @param {"space"|"flat"} kind */
  show(kind) {
    this.view?.dispose();
    this.canvas?.remove();
    this.canvas = document.createElement("canvas");
    this.holder.prepend(this.canvas);
    this.kind = kind;
    try {
      this.view = kind === "space" ? new SpaceView(this.canvas, this.machine) : new FlatView(this.canvas, this.machine);
    } catch (error) {
      if (kind === "flat") throw error;
      this.say("This browser shows no 3-D (WebGL): the machine is drawn flat.");
      this.show("flat");
      return;
    }
    this.canvas.addEventListener("webglcontextlost", (event) => {
      event.preventDefault();
      this.say("The browser has lost its 3-D picture: the machine is drawn flat.");
      this.show("flat");
    });
    this.holder.dataset.kind = kind;
    this.view.setView(this.name);
    this.#fit();
  }

  setView(name) {
    this.name = name;
    this.view.setView(name);
    this.holder.dataset.view = name;
  }

  #fit() {
    const { clientWidth, clientHeight } = this.holder;
    if (clientWidth && clientHeight) this.view.resize(clientWidth, clientHeight);
  }

  draw(state) {
    this.view.draw(state);
  }

  get software() {
    return this.kind === "space" && this.view.software;
  }
}

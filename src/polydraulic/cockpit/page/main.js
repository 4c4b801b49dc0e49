// The cockpit: what the machine does is shown, what the driver does is sent.

import { Charts } from "./charts.js";
import { Connection, FLAGS } from "./connection.js";
import { Diagram } from "./diagram.js";
import { $, button, made, say } from "./dom.js";
import { Face } from "./face.js";
import { Instruments } from "./instruments.js";
import { heading } from "./kinematics.js";
import { Levers } from "./levers.js";
import { Exercises, Faults, Recordings, ReplayBar, Study } from "./panels.js";
import { Readings } from "./readings.js";
import { Results } from "./results.js";
import { Stage } from "./stage.js";
import { ScreenStick, ScreenWheel } from "./sticks.js";

const TRAIL = 600, APART = 0.02; // points of the tip's way, m between them
const TEXTS = 100; // ms between texts that people read
const VIEWS = { Digit1: "cab", Digit2: "side", Digit3: "top" };

class Cockpit {
  constructor(machine) {
    this.machine = machine;
    this.readings = new Readings(machine);
    this.state = { positions: [...machine.drawing.initial], tip: [0, 0, 0], trail: [], target: null, way: [], standing: null, ghost: null };
    this.status = { driver: "nobody", locked: true, mode: "joint", pattern: "iso", rate: 0 };
    this.frame = null;
    this.asked = false;
    this.face = new Face(machine);
    this.stage = new Stage($("stage"), machine, (text) => this.face.notice(text));
    this.#panels();
    this.#levers();
    this.connection = new Connection({
      columns: machine.columns.length,
      onFrame: (frame) => this.#take(frame),
      onText: (text) => this.#hear(text),
      onState: (open) => this.#line(open),
    });
    this.#buttons();
    this.face.status(this.status, false);
    this.pictures = 0;
    this.told = 0;
    requestAnimationFrame((now) => this.#picture(now));
  }

  get drives() {
    return this.status.driver === "you";
  }

  /** Ask the server for something; a page that watches asks for nothing but the seat. */
  send(message) {
    if (!this.drives && message.type !== "drive") this.face.notice("This page watches: take the controls first.");
    else this.connection.send(message);
  }

  #panels() {
    const { machine } = this, send = (message) => this.send(message);
    this.instruments = new Instruments(machine);
    this.charts = new Charts(machine, this.readings);
    this.exercises = machine.study ? new Study(send) : new Exercises(machine, send);
    this.informed = [this.exercises, new Recordings(send), new Faults(machine, send)];
    this.replay = new ReplayBar($("replay-bar"), send);
    this.results = new Results($("results"));
    $("lamps").append(...this.instruments.lamps.map((lamp) => lamp.element));
    const [exercises, recordings, faults] = this.informed.map((panel) => panel.element);
    const panels = { Instruments: made("div", "panel", this.instruments.element, this.charts.element), [machine.study ? "Study" : "Exercises"]: exercises, Recordings: recordings, Faults: faults };
    const tabs = Object.entries(panels).map(([name, panel]) => {
      const tab = button(name, () => open(name));
      tab.setAttribute("role", "tab");
      $("tabs").append(tab);
      $("panels").append(panel);
      return { name, tab, panel };
    });
    const open = (name) => tabs.forEach((one) => {
      one.tab.classList.toggle("on", one.name === name);
      one.panel.hidden = one.name !== name;
    });
    open(machine.study ? "Study" : "Instruments");
  }

  #levers() {
    const { machine } = this;
    const used = new Set(Object.values(machine.patterns).flatMap((pattern) => Object.values(pattern).map((axis) => axis.axis)));
    const sticks = [...document.querySelectorAll(".stick")].map((element) => new ScreenStick(element));
    const wheels = [4, 5].map((axis) => {
      const holder = made("div", "wheel"), ends = [made("span"), made("span")];
      holder.append(ends[0]);
      const wheel = new ScreenWheel(holder);
      holder.append(ends[1]);
      if (used.has(axis)) $("wheels").append(holder);
      return { wheel, ends };
    });
    this.diagram = new Diagram(machine, [...document.querySelectorAll(".lever")], wheels.map(({ ends }) => ends));
    this.levers = new Levers({
      sticks,
      wheels: wheels.map(({ wheel }) => wheel),
      drives: () => this.drives,
      send: (axes) => this.connection.sendSticks(axes),
      onCommand: (event) => this.#command(event),
      onMove: (axes) => {
        sticks.forEach((stick, k) => stick.show(axes[2 * k], axes[2 * k + 1]));
        wheels.forEach(({ wheel }, k) => wheel.show(axes[4 + k]));
      },
    });
  }

  #buttons() {
    document.addEventListener("click", (event) => {
      const pressed = event.target.closest("button");
      if (!pressed) return;
      pressed.blur(); // keys belong to the levers
      const { view, pattern, mode } = pressed.dataset;
      if (view) this.#view(view);
      if (pattern) this.send({ type: "mode", mode: "joint", pattern });
      if (mode) this.send({ type: "mode", mode, pattern: this.status.pattern });
    });
    $("lock").addEventListener("click", () => this.#lock(!this.status.locked));
    $("guard").addEventListener("click", () => this.send({ type: "guard", on: !this.status.guard }));
    $("reset").addEventListener("click", () => this.send({ type: "reset" }));
    $("drive").addEventListener("click", () => this.send({ type: "drive" }));
    $("results-open").addEventListener("click", () => {
      if (this.drives) this.#lock(true);
      this.results.open();
    });
    const kind = () => say($("kind"), this.stage.kind === "space" ? "3-D" : "2-D");
    $("kind").addEventListener("click", () => {
      this.stage.show(this.stage.kind === "space" ? "flat" : "space");
      kind();
    });
    kind();
  }

  #view(name) {
    this.stage.setView(name);
    for (const one of document.querySelectorAll("[data-view]")) one.classList.toggle("on", one.dataset.view === name);
  }

  #lock(on) {
    this.levers.release();
    this.send({ type: "lock", on });
  }

  #command(event) {
    if ($("results").open) return;
    if (event.code in VIEWS) this.#view(VIEWS[event.code]);
    else if (event.code === "Enter") this.#lock(false);
    else if (event.code === "Space" || event.code === "Escape") this.#lock(true);
    else return;
    event.preventDefault();
  }

  #line(open) {
    if (!open) this.status = { ...this.status, driver: "nobody", locked: true };
    this.asked = false;
    this.levers.release();
    this.face.status(this.status, open);
  }

  #hear(text) {
    if (text.type === "status") {
      this.status = text;
      if (!this.asked && text.driver === "nobody") this.connection.send({ type: "drive" });
      this.asked = true; // once: a page that watches stays a page that watches until somebody says otherwise
      for (const panel of [...this.informed, this.replay]) panel.status(text);
      const exercise = text.exercise && this.machine.exercises.find((one) => one.name === text.exercise.name);
      this.state.way = exercise?.path ?? [];
      if (text.shadow) this.face.notice(text.shadow);
      this.face.status(text, true);
      this.diagram.show(text.mode, text.pattern);
    } else if (text.type === "events") this.face.events(text.events);
    else if (text.type === "score") this.exercises.scored(text);
    else if (text.type === "error") this.face.notice(text.text);
  }

  #take(frame) {
    const { readings, state, machine } = this;
    this.frame = frame;
    if (frame.time < readings.time) state.trail = [];
    readings.take(frame);
    this.charts.take(readings);
    state.positions = machine.functions.map((f) => readings.si(f.position));
    state.tip = readings.point("effector");
    state.standing = machine.chassis && this.#standing(frame);
    state.ghost = machine.shadow ? machine.functions.map((f) => readings.si(`shadow.${f.position}`)) : null;
    state.target = frame.flags & FLAGS.target ? readings.point("target") : null;
    const last = state.trail.at(-1);
    if (!last || Math.hypot(...last.at.map((value, n) => value - state.tip[n])) > APART) {
      state.trail.push({ at: state.tip, turn: heading(machine.drawing, state.positions) });
    }
    if (state.trail.length > TRAIL) state.trail.shift();
    this.instruments.light(frame.flags);
  }

  /** The contact polygon, the edge over which the machine would tip, and where its weight meets the ground. */
  #standing({ flags }) {
    const { readings, machine } = this, edge = readings.si("tipping.edge"), { ground } = machine.drawing;
    const corners = machine.chassis.corners.map(([x, y]) => [x, y, ground]); // where the drawing has the ground
    const weight = [readings.si("tipping.gravity_x"), readings.si("tipping.gravity_y"), ground];
    return { corners, edge: [corners[edge], corners[(edge + 1) % corners.length]], weight, warns: (flags & FLAGS.tipping) !== 0 };
  }

  #picture(now) {
    requestAnimationFrame((then) => this.#picture(then));
    this.pictures += 1;
    if (!this.stage.software || this.pictures % 2) this.stage.draw(this.state);
    this.charts.draw();
    if (now - this.told < TEXTS) return;
    this.told = now;
    const { connection, levers, state, status, frame } = this;
    this.instruments.update(this.readings);
    this.face.texts({ tip: state.tip, rate: status.rate, overruns: frame?.overruns ?? 0, latency: connection.latency(), source: levers.source, seq: connection.seq }, this.readings);
  }
}

async function begin() {
  const answer = await fetch("/machine.json");
  if (!answer.ok) throw new Error(await answer.text());
  window.cockpit = new Cockpit(await answer.json()); // for whoever looks in
}

begin().catch((error) => {
  console.error(error);
  say($("notice"), `The cockpit cannot start: ${error.message}`);
});

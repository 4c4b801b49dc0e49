// The cockpit: what the machine does is shown, what the driver does is sent.

import { Charts } from "./charts.js";
import { Connection, FLAGS } from "./connection.js";
import { Diagram } from "./diagram.js";
import { $, made, say } from "./dom.js";
import { Instruments } from "./instruments.js";
import { heading } from "./kinematics.js";
import { Levers } from "./levers.js";
import { Exercises, Faults, Recordings, ReplayBar } from "./panels.js";
import { Readings, number } from "./readings.js";
import { Results } from "./results.js";
import { Stage } from "./stage.js";
import { ScreenStick, ScreenWheel } from "./sticks.js";

const TRAIL = 600; // points of the tip's way
const TEXTS = 100; // ms between texts that people read

async function begin() {
  const answer = await fetch("/machine.json");
  if (!answer.ok) throw new Error(await answer.text());
  const machine = await answer.json(), readings = new Readings(machine);
  document.title = machine.title;
  say($("title"), machine.title);

  const instruments = new Instruments(machine), charts = new Charts(machine, readings);
  const state = { positions: [...machine.drawing.initial], tip: [0, 0, 0], trail: [], target: null, way: [] };
  let status = { driver: "nobody", locked: true, mode: "joint", pattern: "iso", rate: 0 }, frame = null, asked = false;

  const notice = (text) => {
    say($("notice"), text);
    clearTimeout(notice.timer);
    notice.timer = setTimeout(() => say($("notice"), ""), 6000);
  };
  const stage = new Stage($("stage"), machine, notice);
  const drives = () => status.driver === "you";
  const connection = new Connection({
    columns: machine.columns.length,
    onFrame: take,
    onText: hear,
    onState: (open) => {
      if (!open) status = { ...status, driver: "nobody", locked: true };
      asked = false;
      levers?.release();
      showStatus(open);
    },
  });
  const send = (message) => {
    if (!drives() && message.type !== "drive") notice("This page watches: take the controls first.");
    else connection.send(message);
  };

  const sticks = [...document.querySelectorAll(".stick")].map((element) => new ScreenStick(element));
  const used = new Set(Object.values(machine.patterns).flatMap((pattern) => Object.values(pattern).map((axis) => axis.axis)));
  const wheels = [4, 5].map(() => {
    const holder = made("div", "wheel"), low = made("span"), high = made("span");
    holder.append(low);
    const wheel = new ScreenWheel(holder);
    holder.append(high);
    return { holder, wheel, ends: [low, high] };
  });
  wheels.forEach(({ holder }, k) => used.has(4 + k) && $("wheels").append(holder));
  const diagram = new Diagram(machine, [...document.querySelectorAll(".lever")], wheels.map(({ ends }) => ends));
  const levers = new Levers({
    sticks,
    wheels: wheels.map(({ wheel }) => wheel),
    drives,
    send: (axes) => connection.sendSticks(axes),
    onCommand: command,
    onMove: (axes) => {
      sticks.forEach((stick, k) => stick.show(axes[2 * k], axes[2 * k + 1]));
      wheels.forEach(({ wheel }, k) => wheel.show(axes[4 + k]));
    },
  });

  const exercises = new Exercises(machine, send), recordings = new Recordings(send), faults = new Faults(machine, send);
  const replay = new ReplayBar($("replay-bar"), send), results = new Results();
  const panels = {
    Instruments: made("div", "panel", instruments.element, charts.element),
    Exercises: exercises.element,
    Record: recordings.element,
    Faults: faults.element,
    Results: results.element,
  };
  const tabs = Object.entries(panels).map(([name, panel]) => {
    const tab = made("button", "", name);
    tab.type = "button";
    tab.setAttribute("role", "tab");
    tab.addEventListener("click", () => openTab(name));
    $("tabs").append(tab);
    $("panels").append(panel);
    return { name, tab, panel };
  });
  function openTab(name) {
    for (const one of tabs) {
      one.tab.classList.toggle("on", one.name === name);
      one.panel.hidden = one.name !== name;
    }
    if (name === "Results") results.load();
  }
  openTab("Instruments");
  $("lamps").append(...instruments.lamps.map((lamp) => lamp.element));

  function setView(name) {
    stage.setView(name);
    for (const one of document.querySelectorAll("[data-view]")) one.classList.toggle("on", one.dataset.view === name);
  }
  function toggleLock(on = !status.locked) {
    levers.release();
    send({ type: "lock", on });
  }
  function command(event) {
    if (event.target.tagName === "BUTTON" && ["Enter", "Space"].includes(event.code)) return;
    const views = { Digit1: "cab", Digit2: "side", Digit3: "top" };
    if (event.code in views) setView(views[event.code]);
    else if (event.code === "Enter") toggleLock(false);
    else if (event.code === "Space" || event.code === "Escape") toggleLock(true);
    else return;
    event.preventDefault();
  }
  document.addEventListener("click", (event) => {
    const pressed = event.target.closest("button");
    if (!pressed) return;
    pressed.blur(); // keys belong to the levers
    const { view, pattern, mode } = pressed.dataset;
    if (view) setView(view);
    if (pattern) send({ type: "mode", mode: "joint", pattern });
    if (mode) send({ type: "mode", mode, pattern: status.pattern });
  });
  $("lock").addEventListener("click", () => toggleLock());
  $("reset").addEventListener("click", () => send({ type: "reset" }));
  $("drive").addEventListener("click", () => send({ type: "drive" }));
  $("kind").addEventListener("click", () => {
    stage.show(stage.kind === "space" ? "flat" : "space");
    say($("kind"), stage.kind === "space" ? "3-D" : "2-D");
  });
  say($("kind"), stage.kind === "space" ? "3-D" : "2-D");

  function hear(text) {
    if (text.type === "status") {
      status = text;
      if (status.driver === "nobody" && !asked) {
        asked = true; // once: whoever gives the seat up does not get it back unasked
        send({ type: "drive" });
      }
      for (const part of [exercises, recordings, faults, replay]) part.status(status);
      if (status.error) notice(status.error);
      showStatus(true);
    } else if (text.type === "events") {
      for (const [time, where, what] of text.events) $("events").append(made("li", "", `${number(time, 2)} s  ${where} ${what}`));
      while ($("events").children.length > 4) $("events").firstChild.remove();
    } else if (text.type === "score") {
      exercises.scored(text);
      if (text.finished) results.stale = true;
    } else if (text.type === "error") notice(text.text);
  }

  function showStatus(open) {
    const { driver, locked, mode, pattern } = status;
    document.body.dataset.driver = open ? driver : "none";
    document.body.dataset.locked = locked;
    say($("driver"), !open ? "no connection" : driver === "you" ? "You drive" : driver === "other" ? "Watching: another page drives" : "Nobody drives");
    $("drive").hidden = driver === "you";
    $("lock").setAttribute("aria-pressed", locked);
    say($("lock").querySelector("span"), locked ? "Locked" : "Unlocked");
    say($("lock").querySelector("small"), locked ? "unlock: Enter" : "lock: Space");
    for (const one of document.querySelectorAll("[data-pattern]")) one.classList.toggle("on", mode === "joint" && one.dataset.pattern === pattern);
    for (const one of document.querySelectorAll("[data-mode]")) one.classList.toggle("on", one.dataset.mode === mode);
    diagram.show(mode, pattern);
  }
  showStatus(false);

  const length = { factor: machine.display["effector.x"].factor, unit: machine.display["effector.x"].unit };
  const inUnit = (value) => `${number(value * length.factor)} ${length.unit}`;
  const vitals = ["model", "sim rate", "overruns", "lever to picture", "sticks sent", "time"].map((name) => {
    const value = made("dd");
    $("vitals").append(made("dt", "", name), value);
    return value;
  });
  function texts() {
    const [x, y, z] = state.tip, latency = connection.latency();
    say($("tip"), `tip  x ${inUnit(x)}   y ${inUnit(y)}   z ${inUnit(z)}`);
    const shown = [machine.flow, `${number(status.rate, 2)} ×`, `${frame?.overruns ?? 0} steps`, latency === null ? "–" : `${number(latency, 0)} ms`,
      `${levers.source === "none" ? "" : `${levers.source} `}${connection.seq}`, `${number(readings.time, 1)} s`];
    shown.forEach((text, k) => say(vitals[k], text));
    instruments.update(readings);
  }

  let told = 0, pictures = 0;
  function picture(now) {
    requestAnimationFrame(picture);
    pictures += 1;
    if (!stage.software || pictures % 2) stage.draw(state);
    charts.draw();
    if (now - told < TEXTS) return;
    told = now;
    texts();
  }
  function take(found) {
    frame = found;
    if (found.time < readings.time) state.trail = [];
    readings.take(found);
    charts.take(readings);
    state.positions = machine.functions.map((f) => readings.si(f.position));
    state.tip = readings.point("effector");
    state.target = found.flags & FLAGS.target ? readings.point("target") : null;
    const last = state.trail.at(-1);
    if (!last || Math.hypot(...last.at.map((value, n) => value - state.tip[n])) > 0.02) {
      state.trail.push({ at: state.tip, turn: heading(machine.drawing, state.positions) });
    }
    if (state.trail.length > TRAIL) state.trail.shift();
    instruments.light(found.flags);
    if (found.flags & FLAGS.replay) replay.at(found.time);
  }
  requestAnimationFrame(picture);
  Object.assign(window, { cockpit: { machine, readings, connection, levers, stage, state, status: () => status, frame: () => frame } }); // for whoever looks in
}

begin().catch((error) => {
  console.error(error);
  say($("notice"), `The cockpit cannot start: ${error.message}`);
});

// What is written and lit around the machine: who drives, the lockout lever, the pattern of the levers, how the simulation keeps up.

import { $, made, say } from "./dom.js";
import { number } from "./readings.js";

const DRIVERS = { you: "You drive", other: "Watching: another page drives", nobody: "Nobody drives" };
const NOTICE = 6000; // ms
const EVENTS = 4; // that are shown

export class Face {
  constructor(machine) {
    this.machine = machine;
    document.title = machine.title;
    say($("title"), machine.title);
    const coordinated = document.querySelector("[data-mode=coordinated]");
    coordinated.disabled = !machine.coordinated?.able;
    if (machine.coordinated?.why) coordinated.title = machine.coordinated.why;
    const guard = machine.coordinated?.guard;
    $("guard").disabled = !guard?.able;
    if (guard?.why) $("guard").title = `No guard: ${guard.why}`;
    const names = ["model", ...(machine.shadow ? ["shadow", "its step"] : []), "sim rate", "overruns", "lever to picture", "sticks sent", "time"];
    this.vitals = new Map(names.map((name) => {
      const value = made("dd");
      $("vitals").append(made("dt", "", name), value);
      return [name, value];
    }));
    say(this.vitals.get("model"), machine.flow);
    this.tip = ["x", "y", "z"].map(() => made("span"));
    $("tip").append(made("span", "soft", "tip"), ...this.tip);
  }

  notice(text) {
    say($("notice"), text);
    clearTimeout(this.timer);
    this.timer = setTimeout(() => say($("notice"), ""), NOTICE);
  }

  events(events) {
    for (const [time, where, what] of events) $("events").append(made("li", "", `${number(time, 2)} s  ${where} ${what}`));
    while ($("events").children.length > EVENTS) $("events").firstChild.remove();
  }

  status({ driver, locked, mode, pattern, guard }, open) {
    document.body.dataset.driver = open ? driver : "none";
    document.body.dataset.locked = locked;
    say($("driver"), open ? DRIVERS[driver] : "No connection");
    $("drive").hidden = driver === "you";
    $("lock").setAttribute("aria-pressed", locked);
    say($("lock").querySelector("span"), locked ? "Locked" : "Unlocked");
    say($("lock").querySelector("small"), locked ? "unlock: Enter" : "lock: Space");
    for (const one of document.querySelectorAll("[data-pattern]")) one.classList.toggle("on", mode === "joint" && one.dataset.pattern === pattern);
    $("guard").classList.toggle("on", Boolean(guard));
    $("guard").setAttribute("aria-pressed", Boolean(guard));
    for (const one of document.querySelectorAll("[data-mode]")) one.classList.toggle("on", one.dataset.mode === mode);
  }

  /** @param {{tip: number[], rate: number, overruns: number, latency: number|null, source: string, seq: number}} now */
  texts(now, readings) {
    const { factor, unit } = this.machine.display["effector.x"], far = readings.shown("shadow.tip_error");
    this.tip.forEach((element, k) => say(element, `${"xyz"[k]} ${number(now.tip[k] * factor)} ${unit}`));
    const texts = {
      shadow: `${number(far, far < 10 ? 2 : 0)} ${unit}`,
      "its step": this.machine.shadow ? `${number(1000 * readings.si("shadow.step_speed_error"), 2)} mm/s, ${number(readings.shown("shadow.step_flow_error"), 2)} ${readings.unit("shadow.step_flow_error")}` : "",
      "sim rate": `${number(now.rate, 2)} ×`,
      overruns: `${now.overruns} steps`,
      "lever to picture": now.latency === null ? "–" : `${number(now.latency)} ms`,
      "sticks sent": `${now.source === "none" ? "" : `${now.source} `}${now.seq}`,
      time: `${number(readings.time, 1)} s`,
    };
    for (const [name, element] of this.vitals) if (name in texts) say(element, texts[name]);
  }
}

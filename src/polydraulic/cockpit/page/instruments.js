// Who gets the flow, where joints and spools are, pressures, lamps.

import { FLAGS } from "./connection.js";
import { Bar, made, say } from "./dom.js";
import { FUNCTION_COLORS } from "./paint.js";
import { number } from "./readings.js";

const AT_STOP = 2e-3; // rad or m
const SMALL = 1e-6; // m3/s: what is shown as no flow

/** A pump: its pressure and power, and how its flow is shared out along its valves, first come, first served. */
class PumpCard {
  constructor(circuit, machine) {
    this.circuit = circuit;
    const color = (name) => FUNCTION_COLORS[machine.functions.findIndex((f) => f.name === name)];
    const label = (name) => machine.functions.find((f) => f.name === name)?.label ?? name;
    this.parts = [...circuit.functions.map((name) => ({ column: `${name}.q_in`, name: label(name), color: color(name) })),
      { column: `${circuit.name}.q_bypass`, name: "to tank", color: "#c9d1d9" }, { column: `${circuit.name}.q_relief`, name: "relief", color: "#c0392b" }];
    this.pressure = new Bar("pressure");
    this.read = made("b");
    const strip = made("div", "strip"), legend = made("div", "legend");
    this.rows = this.parts.map((part, k) => {
      const fill = made("i"), value = made("b");
      fill.style.backgroundColor = part.color;
      strip.append(fill);
      const dot = made("i");
      dot.style.backgroundColor = part.color;
      const order = k < circuit.functions.length && circuit.functions.length > 1 ? `${k + 1}. ` : "";
      legend.append(made("span", "", dot, `${order}${part.name} `, value));
      return { fill, value };
    });
    const order = circuit.functions.map(label).join(" → ");
    this.element = made("section", "card pump", made("h2", "", "Pump ", made("span", "soft", order), this.read), this.pressure.element, strip, legend);
  }

  update(readings) {
    const { name, relief } = this.circuit;
    const p = readings.si(`${name}.p_pump`), q = readings.si(`${name}.q_pump`);
    this.pressure.set(p / relief);
    const column = `${name}.p_pump`, flow = `${name}.q_pump`;
    say(this.read, `${number(readings.shown(column))} ${readings.unit(column)}  ${number(readings.shown(flow))} ${readings.unit(flow)}  ${number((p * q) / 1000)} kW`);
    const flows = this.parts.map((part) => Math.max(readings.si(part.column) || 0, 0));
    const whole = Math.max(flows.reduce((a, b) => a + b, 0), SMALL);
    this.rows.forEach(({ fill, value }, k) => {
      fill.style.flexGrow = ((100 * flows[k]) / whole).toFixed(2);
      say(value, number(readings.shown(this.parts[k].column)));
    });
  }
}

/** A function: its joint between its stops, its spool, its pressures. */
class FunctionRow {
  constructor(f, place, machine) {
    this.f = f;
    this.free = f.high - f.low > 4 * Math.PI && f.joint === "revolute";
    this.limit = Math.max(...machine.circuits.map((circuit) => circuit.relief));
    this.marker = made("i");
    this.travel = made("span", `travel${this.free ? " free" : ""}`, this.marker);
    this.position = made("b");
    this.spool = new Bar("spool", true);
    this.spool.color = FUNCTION_COLORS[place];
    this.a = new Bar("pressure");
    this.b = new Bar("pressure");
    this.pa = made("b");
    this.pb = made("b");
    const name = made("th", "", f.label);
    name.style.borderLeftColor = FUNCTION_COLORS[place];
    const cell = (...content) => made("td", "", ...content);
    this.element = made("tr", "", name, cell(this.position, this.travel), cell(this.spool.element), cell(this.pa, this.a.element), cell(this.pb, this.b.element));
  }

  update(readings) {
    const { f } = this, q = readings.si(f.position);
    const turn = ((((q + Math.PI) % (2 * Math.PI)) + 2 * Math.PI) % (2 * Math.PI)) - Math.PI;
    const share = this.free ? 0.5 - turn / (2 * Math.PI) : (q - f.low) / (f.high - f.low);
    this.marker.style.left = `${(100 * Math.max(0, Math.min(share, 1))).toFixed(1)}%`;
    this.travel.classList.toggle("stopped", !this.free && (q <= f.low + AT_STOP || q >= f.high - AT_STOP));
    const { factor, unit } = readings.display[f.position];
    say(this.position, `${number((this.free ? turn : q) * factor, f.joint === "prismatic" ? 0 : 1)} ${unit}`);
    this.spool.set(readings.si(`${f.name}.spool`) / f.travel);
    for (const [bar, text, port] of [[this.a, this.pa, "p_a"], [this.b, this.pb, "p_b"]]) {
      const column = `${f.name}.${port}`;
      bar.set(readings.si(column) / this.limit);
      say(text, number(readings.shown(column)));
    }
  }
}

/** How near the machine comes to tipping: bars of the distances, and over which edge. */
class TippingCard {
  constructor({ most, edges }) {
    this.most = most;
    this.edges = edges;
    this.read = made("b");
    this.bars = [["at rest", "tipping.distance"], ["in motion", "tipping.dynamic_distance"]].map(([text, column]) => {
      const bar = new Bar("margin"), value = made("b");
      return { column, bar, value, row: made("div", "margin-row", made("span", "soft", text), bar.element, value) };
    });
    this.soon = made("span", "soft");
    this.guard = made("p", "soft guard");
    this.element = made("section", "card tipping", made("h2", "", "Tipping ", this.soon, this.read), ...this.bars.map(({ row }) => row), this.guard);
    this.element.id = "tipping";
  }

  update(readings) {
    const warns = (readings.flags & FLAGS.tipping) !== 0, left = readings.si("tipping.dynamic_distance"), time = readings.si("tipping.time");
    this.element.classList.toggle("alarm", warns);
    for (const { column, bar, value } of this.bars) {
      bar.set(readings.si(column) / this.most);
      say(value, `${number(readings.si(column), 2)} m`);
    }
    const angle = readings.si("tipping.force_angle") / 1000;
    say(this.soon, warns ? (left <= 0 ? "TIPS" : `in ${number(time, 1)} s`) : `force-angle ${number(angle)} kN m`);
    say(this.read, this.edges[readings.si("tipping.edge")] ?? "");
    const share = readings.si("tipping.guard");
    say(this.guard, share >= 1 ? "" : share > 0 ? `Guard: slowed to ${number(100 * share)} %` : "Guard: refused; what leads away from a tip goes on");
  }
}

const LAMPS = [
  ["tipping", "tipping", "alarm"], ["guarded", "tip guard", "warn"], ["relief", "relief", "alarm"], ["stop", "end stop", "alarm"], ["outside", "out of domain", "warn"],
  ["recording", "recording", "alarm"], ["replay", "replay", "calm"],
];

export class Instruments {
  constructor(machine) {
    this.pumps = machine.circuits.map((circuit) => new PumpCard(circuit, machine));
    this.rows = machine.functions.map((f, place) => new FunctionRow(f, place, machine));
    this.tipping = machine.chassis ? [new TippingCard(machine.chassis)] : [];
    const pressure = machine.display[`${machine.functions[0].name}.p_a`].unit;
    const heads = ["", "joint", "spool", `A ${pressure}`, `B ${pressure}`].map((text) => made("th", "", text));
    const table = made("table", "card functions", made("thead", "", made("tr", "", ...heads)), made("tbody", "", ...this.rows.map((row) => row.element)));
    this.element = made("div", "instruments", ...this.tipping.map((card) => card.element), ...this.pumps.map((pump) => pump.element), table);
    this.lamps = LAMPS.filter(([flag]) => machine.chassis || !["tipping", "guarded"].includes(flag)).map(([flag, text, kind]) => ({ bit: FLAGS[flag], element: made("span", `lamp ${kind}`, made("i"), text) }));
  }

  update(readings) {
    for (const part of [...this.tipping, ...this.pumps, ...this.rows]) part.update(readings);
  }

  light(flags) {
    for (const { bit, element } of this.lamps) element.classList.toggle("lit", (flags & bit) !== 0);
  }
}

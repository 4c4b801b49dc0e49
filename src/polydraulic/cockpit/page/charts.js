// Curves of the last seconds; one of them is drawn in every second picture, so that they never take the time of the machine's own.

import uPlot from "./uplot.js";
import { made } from "./dom.js";
import { FUNCTION_COLORS, INK } from "./paint.js";

const SPAN = 20; // s
const EVERY = 1 / 30; // s between points
const ROOM = Math.ceil(SPAN / EVERY);
const DASHES = [undefined, [5, 3], [2, 3]]; // of pumps, in their order
const SHADOW = "#aa4499", GRID = "#e6eaee", SOFT = "#6b7a89";

class Chart {
  constructor(title, text, series) {
    this.series = series;
    this.data = [0, ...series].map(() => []);
    this.holder = made("div", "plot");
    this.element = made("section", "card chart", made("h2", "", title, made("span", "soft", text)), this.holder);
    this.plot = null;
  }

  take(readings) {
    const row = [readings.time, ...this.series.map((one) => readings.shown(one.column))];
    row.forEach((value, k) => {
      this.data[k].push(Number.isFinite(value) ? value : null);
      if (this.data[k].length > ROOM) this.data[k].shift();
    });
  }

  clear() {
    for (const values of this.data) values.length = 0;
  }

  draw() {
    const { clientWidth: width, clientHeight: height } = this.holder;
    if (!width || !height) return;
    if (this.plot === null) this.#make(width, height);
    else if (this.plot.width !== width || this.plot.height !== height) this.plot.setSize({ width, height });
    this.plot.setData(this.data);
  }

  #make(width, height) {
    const axis = { stroke: SOFT, grid: { stroke: GRID, width: 1 }, ticks: { show: false }, font: "11px system-ui, sans-serif" };
    this.plot = new uPlot({
      width, height,
      pxAlign: false,
      cursor: { show: false },
      legend: { show: false },
      scales: { x: { time: false, range: (_, low, high) => [Math.max(high - SPAN, Math.min(low, high - 1)), high] } },
      axes: [{ ...axis, size: 20, gap: 2 }, { ...axis, size: 44, gap: 3 }],
      series: [{}, ...this.series.map((one) => ({ stroke: one.color, width: 1.6, dash: one.dash, points: { show: false } }))],
    }, this.data, this.holder);
  }
}

export class Charts {
  constructor(machine, readings) {
    const unit = (column) => readings.unit(column), names = machine.functions.map((f) => f.name);
    const known = (series) => series.filter((one) => readings.has(one.column));
    const ofFunctions = (value) => names.map((name, k) => ({ column: `${name}.${value}`, color: FUNCTION_COLORS[k] }));
    const ofPumps = (value) => machine.circuits.map((circuit, k) => ({ column: `${circuit.name}.${value}`, color: INK, dash: DASHES[k % 3] }));
    const inlets = ofFunctions("p_in"), flows = ofFunctions("q_in"), tip = "shadow.tip_error";
    this.charts = [
      new Chart(`Pressure [${unit(inlets[0].column)}]`, "inlets; dark: pumps", known([...inlets, ...ofPumps("p_pump")])),
      new Chart(`Flow [${unit(flows[0].column)}]`, "to functions; dark: from pumps", known([...flows, ...ofPumps("q_pump")])),
      ...(readings.has(tip) ? [new Chart(`Tip of the shadow [${unit(tip)}]`, `${machine.shadow_flow}, away from the machine's`, [{ column: tip, color: SHADOW }])] : []),
    ];
    this.element = made("div", "charts", ...this.charts.map((chart) => chart.element));
    this.turn = 0;
    this.pictures = 0;
    this.last = -Infinity;
  }

  take(readings) {
    if (readings.time < this.last) this.clear();
    if (readings.time - this.last < EVERY) return;
    this.last = readings.time;
    for (const chart of this.charts) chart.take(readings);
  }

  clear() {
    this.last = -Infinity;
    for (const chart of this.charts) chart.clear();
  }

  /** Called once for each picture. */
  draw() {
    this.pictures += 1;
    if (this.pictures % 2 || this.element.offsetParent === null) return;
    this.charts[this.turn % this.charts.length].draw();
    this.turn += 1;
  }
}

// Attempts at exercises side by side: one mode against the other, one attempt after the other.

import { button, made } from "./dom.js";
import { readable, shownName } from "./readings.js";

const SVG = "http://www.w3.org/2000/svg";
const VALUES = ["time", "error_rms", "error_max", "effort", "stops", "energy", "actuator_energy"];
const TITLES = { time: "time", error_rms: "error, rms", error_max: "largest error", effort: "lever effort", stops: "stops hit", energy: "pump energy", actuator_energy: "energy into actuators" };
const DRAWN = ["time", "error_rms", "effort"];
const COLORS = { joint: "#0072b2", coordinated: "#d55e00" };
const WIDTH = 300, HEIGHT = 120, EDGE = 12;
const MOST = 200; // attempts in the table
const AGAIN = 1000; // ms, after which new ones are looked for

function drawn(parent, name, attributes) {
  const element = document.createElementNS(SVG, name);
  for (const [key, value] of Object.entries(attributes)) element.setAttribute(key, value);
  parent.append(element);
  return element;
}

export class Results {
  constructor(dialog) {
    this.dialog = dialog;
    this.choice = made("select");
    this.choice.addEventListener("change", () => this.#show());
    this.said = made("p", "soft");
    this.body = made("div", "results");
    dialog.append(made("header", "", made("h1", "", "Attempts"), this.choice, made("span", "gap"), button("Close", () => dialog.close())), this.said, this.body);
  }

  open() {
    this.dialog.showModal();
    this.#load();
    const again = setInterval(() => (this.dialog.open ? this.#load() : clearInterval(again)), AGAIN);
  }

  async #load() {
    const answer = await fetch("/results.json");
    if (!answer.ok) {
      this.said.textContent = "The results cannot be read.";
      return;
    }
    const text = await answer.text();
    if (text === this.text) return;
    this.text = text;
    this.results = JSON.parse(text);
    const names = [...new Set(this.results.attempts.map((attempt) => attempt.exercise))];
    const before = this.choice.value;
    this.choice.replaceChildren(...names.map((name) => new Option(shownName(name), name)));
    if (names.includes(before)) this.choice.value = before;
    this.#show();
  }

  #show() {
    const { attempts, file } = this.results, name = this.choice.value;
    const shown = attempts.filter((attempt) => attempt.exercise === name);
    this.said.textContent = shown.length ? `All attempts stand in ${file}, in the folder of the recordings.` : "No attempts yet: begin one under Exercises.";
    this.body.replaceChildren();
    if (!shown.length) return;
    const compared = this.results.compared.filter((group) => group.exercise === name);
    const charts = made("div", "dots", ...DRAWN.map((value) => this.#dots(shown, value)));
    this.body.append(this.#medians(compared, shown), charts, this.#table(shown));
  }

  #head(...first) {
    return made("thead", "", made("tr", "", ...[...first, ...VALUES.map((value) => TITLES[value])].map((text) => made("th", "", text))));
  }

  #medians(compared, attempts) {
    const unit = (name) => attempts.find((attempt) => name in attempt.values)?.values[name][1] ?? "";
    const rows = compared.map((group) => made("tr", "", this.#mode(group), made("td", "", group.machine), made("td", "", String(group.attempts)),
      ...VALUES.map((name) => made("td", "", readable(group.values[name], unit(name))))));
    if (!rows.length) return made("section", "card", made("h2", "", "No attempt was finished"));
    return made("section", "card", made("h2", "", "Medians of finished attempts"), made("table", "", this.#head("mode", "machine", "attempts"), made("tbody", "", ...rows)));
  }

  #mode({ mode, guard }) {
    const dot = made("i", "dot");
    dot.style.backgroundColor = COLORS[mode] ?? "#6b7a89";
    return made("td", "", dot, guard && mode === "coordinated" ? `${mode}, tip guard` : mode);
  }

  /** A value of one attempt after the other; those that were given up are hollow. */
  #dots(attempts, name) {
    const points = attempts.filter((attempt) => name in attempt.values);
    const most = Math.max(...points.map((attempt) => attempt.values[name][0]), 1e-9);
    const svg = drawn(made("div"), "svg", { viewBox: `0 0 ${WIDTH} ${HEIGHT}`, role: "img", "aria-label": TITLES[name] });
    drawn(svg, "path", { d: `M${EDGE} ${HEIGHT - EDGE}H${WIDTH - EDGE}`, class: "axis" });
    points.forEach((attempt, k) => {
      const color = COLORS[attempt.mode] ?? "#6b7a89";
      const x = EDGE + ((k + 0.5) / points.length) * (WIDTH - 2 * EDGE), y = HEIGHT - EDGE - (attempt.values[name][0] / most) * (HEIGHT - 2 * EDGE);
      drawn(svg, "circle", { cx: x.toFixed(1), cy: y.toFixed(1), r: 4.5, fill: attempt.finished ? color : "#fff", stroke: color, "stroke-width": 1.5 });
    });
    const unit = points[0]?.values[name][1] ?? "";
    return made("section", "card", made("h2", "", TITLES[name], made("span", "soft", `0 to ${readable(most, unit)}`)), svg.parentElement);
  }

  #table(attempts) {
    const rows = attempts.slice(-MOST).reverse().map((attempt) => made("tr", "", this.#mode(attempt), made("td", "", attempt.pattern?.toUpperCase() ?? ""),
      made("td", "", attempt.subject || "–"), made("td", "", attempt.when.replace("T", " ").replace("Z", "")), made("td", "", attempt.finished ? "yes" : "given up"),
      ...VALUES.map((name) => made("td", "", name in attempt.values ? readable(...attempt.values[name]) : "–"))));
    return made("section", "card", made("h2", "", "Latest first"), made("table", "", this.#head("mode", "levers", "code", "when (UTC)", "finished"), made("tbody", "", ...rows)));
  }
}

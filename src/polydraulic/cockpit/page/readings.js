// Values of a frame by the names of their columns, in SI and as people read them.

const UNKNOWN = { unit: "", factor: 1, offset: 0 }; // of a column that a flow model does not give

export class Readings {
  constructor(machine) {
    this.columns = machine.columns.map((column) => column.name);
    this.place = new Map(this.columns.map((name, place) => [name, place]));
    this.display = machine.display;
    this.values = new Float32Array(this.columns.length);
    this.time = 0;
    this.flags = 0;
  }

  take(frame) {
    this.values = frame.values;
    this.time = frame.time;
    this.flags = frame.flags;
  }

  has(name) {
    return this.place.has(name);
  }

  /** In SI. */
  si(name) {
    return this.values[this.place.get(name)] ?? NaN;
  }

  /** As people read it. */
  shown(name) {
    const { factor, offset } = this.display[name] ?? UNKNOWN;
    return this.si(name) * factor + offset;
  }

  unit(name) {
    return (this.display[name] ?? UNKNOWN).unit;
  }

  /** Three values that form a point, or null where there is none. */
  point(name) {
    if (!this.has(`${name}.x`)) return null;
    const found = ["x", "y", "z"].map((axis) => this.si(`${name}.${axis}`));
    return found.every(Number.isFinite) ? found : null;
  }
}

const MINUS = "−";

/** A number with so many decimals, its minus sign as long as a digit. */
export const number = (value, decimals = 0) => {
  if (!Number.isFinite(value)) return "–";
  const text = value.toFixed(decimals);
  return Number(text) === 0 ? text.replace("-", "") : text.replace("-", MINUS);
};

const SHOWN = { m: ["mm", 1e3], J: ["kJ", 1e-3], W: ["kW", 1e-3], 1: ["", 1] };

/** A value in SI as people read it, with its unit. */
export function readable(value, unit) {
  const [name, factor] = SHOWN[unit] ?? [unit, 1], size = Math.abs(value * factor);
  return `${number(value * factor, name === "" || size >= 100 ? 0 : 1)} ${name}`.trim();
}

export const shownName = (name) => name.replaceAll("_", " ");

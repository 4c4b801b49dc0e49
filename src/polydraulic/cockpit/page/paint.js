// Colours of the machine, by what a drawing fills its bodies with, and of what is drawn around it.

const PAINT = { run: "#eaa221", "#e3e6ea": "#f0b43a", "#f4f6f8": "#e9edf1", "#d5e6f3": "#bcd9ee", "#c9ced6": "#596470", "#34495e": "#3b4754" };

/** Colour of a body. */
export const paint = (fill) => PAINT[fill] ?? fill;

export const INK = "#2b3640", STEEL = "#c3ccd4", BARREL = "#5c6874", STOP = "#c0392b", TRAIL = "#1f78b4", TARGET = "#1a8f4c", EARTH = "#e4dccd", GROUND_LINE = "#b3a68e", GROUND_GRID = "#cdc3b0", STAND = "#5a6b7a", ALARM = "#d0342c", GHOST = "#7d3fb2";

/** Colours of functions, in their order: told apart by people who do not see red and green alike. */
export const FUNCTION_COLORS = ["#0072b2", "#d55e00", "#009e73", "#aa4499", "#7a5c00", "#56b4e9"];

// Elements, made and found.

export const $ = (id) => document.getElementById(id);

/** An element with a class, a text, and what is in it. */
export function made(name, className = "", ...content) {
  const element = document.createElement(name);
  if (className) element.className = className;
  element.append(...content);
  return element;
}

/** Set a text only where it changes. */
export function say(element, text) {
  if (element.textContent !== text) element.textContent = text;
}

/** A bar that grows from its middle or its left end by `share` of its width. */
export class Bar {
  constructor(className = "", centred = false) {
    this.fill = made("i");
    this.element = made("span", `bar ${className}${centred ? " centred" : ""}`, this.fill);
    this.centred = centred;
  }

  set(share) {
    const kept = Math.max(this.centred ? -1 : 0, Math.min(share, 1));
    this.fill.style.transform = `scaleX(${Number.isFinite(kept) ? kept.toFixed(3) : 0})`;
  }

  set color(value) {
    this.fill.style.backgroundColor = value;
  }
}

/** A button that takes a function. */
export function button(text, onClick, className = "") {
  const element = made("button", className, text);
  element.type = "button";
  element.addEventListener("click", () => {
    onClick();
    element.blur(); // keys belong to the levers
  });
  return element;
}

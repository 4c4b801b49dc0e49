// Attempts at exercises side by side.

import { made } from "./dom.js";
import { number } from "./readings.js";

export class Results {
  constructor() {
    this.body = made("div", "");
    this.element = made("div", "panel", made("section", "card", made("h2", "", "Attempts"), this.body));
    this.stale = true;
  }

  async load() {
    const answer = await fetch("/results.json");
    if (!answer.ok) {
      this.body.replaceChildren(made("p", "soft", "No results can be read."));
      return;
    }
    this.show(await answer.json());
  }

  show(results) {
    this.body.replaceChildren(made("p", "soft", `${number(results.length)} attempts`));
  }
}

// Exercises, recordings, faults: what a driver asks of the server, and what it says of them.

import { button, made, say } from "./dom.js";
import { number, readable, shownName } from "./readings.js";

/** Exercises: one is begun, its score is followed. */
export class Exercises {
  constructor(machine, send) {
    this.send = send;
    this.subject = made("input");
    Object.assign(this.subject, { maxLength: 32, placeholder: "P07", autocomplete: "off", spellcheck: false });
    this.score = made("dl", "score");
    this.said = made("p", "soft");
    this.items = machine.exercises.map((exercise) => this.#item(exercise));
    const nothing = machine.exercises.length ? [] : [made("p", "soft", "This machine has no exercises.")];
    this.element = made("div", "panel",
      made("section", "card", made("label", "row", "Code of the driver", this.subject), made("p", "soft", "A code and nothing personal: it stands in the results.")),
      ...this.items.map((item) => item.element), ...nothing, made("section", "card", made("h2", "", "Score"), this.said, this.score));
  }

  #item({ name, title }) {
    const start = button("Start", () => this.#toggle(name), "primary");
    return { name, start, element: made("section", "card exercise", made("h2", "", shownName(name), start), made("p", "soft", title)) };
  }

  #toggle(name) {
    const action = this.running === name ? "stop" : "start";
    this.send({ type: "exercise", name, action, subject: this.subject.value.trim() });
  }

  status({ exercise }) {
    this.running = exercise?.name ?? null;
    for (const item of this.items) {
      say(item.start, this.running === item.name ? "Stop" : "Start");
      item.element.classList.toggle("running", this.running === item.name);
    }
  }

  scored({ exercise, finished, values }) {
    say(this.said, `${shownName(exercise)}: ${finished ? "finished" : "running"}`);
    this.score.replaceChildren(...Object.entries(values).flatMap(([name, [value, unit]]) =>
      [made("dt", "", shownName(name)), made("dd", "", readable(value, unit))]));
  }
}

/** A study: who drives, what is to be done next, a question at the end. */
export class Study {
  constructor(send) {
    const say_ = (action, text) => send(text === undefined ? { type: "study", action } : { type: "study", action, text });
    this.choice = made("select");
    this.choose = button("Go on", () => say_("subject", this.choice.value), "primary");
    this.title = made("h2", "", "Study");
    this.step = made("p");
    this.how = made("p", "soft");
    this.start = button("Start", () => say_("start"), "primary");
    this.stop = button("Stop", () => send({ type: "exercise", name: this.exercise ?? "", action: "stop" }));
    this.skip = button("Leave out", () => say_("skip"));
    this.score = made("dl", "score");
    this.answers = made("div", "answers");
    this.task = made("section", "card", made("h2", "", "Next"), this.step, this.how, made("div", "row", this.start, this.stop, this.skip));
    this.question = made("section", "card question", this.answers);
    this.element = made("div", "panel", made("section", "card", this.title, made("label", "row", "Code of the subject", this.choice), this.choose), this.task, this.question,
      made("section", "card", made("h2", "", "Score"), this.score));
    this.element.id = "study";
    this.answer = (text) => say_("answer", text);
  }

  status({ study, exercise }) {
    if (!study) return;
    say(this.title, study.title);
    if (this.choice.options.length !== study.subjects.length) this.choice.replaceChildren(...study.subjects.map((code) => new Option(code, code)));
    if (study.subject && study.subject !== this.subject) this.choice.value = study.subject;
    this.subject = study.subject;
    this.exercise = exercise?.name;
    const { task } = study;
    this.task.hidden = !task;
    this.#enable();
    if (task) {
      say(this.step, `${task.number} of ${study.tasks}: ${shownName(task.exercise)}, ${task.mode} mode`);
      say(this.how, `${task.practice ? "Practice" : "Measured"}: ${task.block}, attempt ${task.repetition}. Unlock, then drive as soon as the target moves.`);
    }
    this.question.hidden = !study.question;
    const asked = `${study.question}|${study.answer}`;
    if (study.question && asked !== this.asked) {
      this.answers.replaceChildren(made("h2", "", study.question), ...study.answers.map((text) => button(text, () => this.answer(text), text === study.answer ? "on" : "")));
      if (study.answer) this.answers.append(made("p", "soft", "Thank you. The answer may be changed."));
    }
    this.asked = asked;
  }

  #enable() {
    const busy = this.exercise !== undefined && this.running;
    this.start.disabled = this.skip.disabled = busy;
    this.stop.hidden = !busy;
  }

  scored({ finished, running, values }) {
    this.running = running;
    this.#enable();
    this.score.replaceChildren(made("dt", "", "attempt"), made("dd", "", finished ? "finished" : running ? "running" : "stopped: it is asked for again"), ...Object.entries(values).flatMap(([name, [value, unit]]) =>
      [made("dt", "", shownName(name)), made("dd", "", readable(value, unit))]));
  }
}

/** Recordings: made, played, gone on from. */
export class Recordings {
  constructor(send) {
    this.send = send;
    this.on = false;
    this.record = button("Record", () => send({ type: "record", on: !this.on }), "primary record");
    this.said = made("p", "soft", "Every step of the levers is kept: a replay gives the same bits.");
    this.list = made("ul", "list");
    this.element = made("div", "panel", made("section", "card", made("h2", "", "Recording", this.record), this.said),
      made("section", "card", made("h2", "", "Recordings"), this.list));
    this.names = "";
  }

  status({ recording, recordings }) {
    this.on = recording !== null;
    say(this.record, this.on ? "Stop recording" : "Record");
    this.record.classList.toggle("lit", this.on);
    say(this.said, this.on ? `Recording into ${recording}.` : "Every step of the levers is kept: a replay gives the same bits.");
    const names = recordings.join("\n");
    if (names === this.names && this.list.children.length) return;
    this.names = names;
    this.list.replaceChildren(...recordings.map((name) => made("li", "", made("span", "", name),
      button("Replay", () => this.send({ type: "replay", name, action: "play" })))));
    if (!recordings.length) this.list.append(made("li", "soft", "None yet."));
  }
}

/** Faults, each on or off, and the load at the tip. */
export class Faults {
  constructor(machine, send) {
    this.boxes = machine.faults.map(({ name, title }) => {
      const box = made("input");
      box.type = "checkbox";
      box.addEventListener("change", () => {
        send({ type: "fault", name, on: box.checked });
        box.blur();
      });
      return { name, box, element: made("label", "row fault", box, made("span", "", made("b", "", shownName(name)), made("small", "soft", title))) };
    });
    this.mass = made("input");
    Object.assign(this.mass, { type: "number", min: 0, max: machine.most_payload, step: 50, value: 0 });
    this.mass.addEventListener("change", () => send({ type: "payload", mass: Math.max(0, Number(this.mass.value) || 0) }));
    const nothing = this.boxes.length ? [] : [made("p", "soft", "This machine has no faults to choose from.")];
    this.element = made("div", "panel",
      made("section", "card", made("h2", "", "Payload"), made("label", "row", `Mass at the tip, kg (at most ${number(machine.most_payload)})`, this.mass)),
      made("section", "card", made("h2", "", "Faults"), ...this.boxes.map((one) => one.element), ...nothing));
  }

  status({ faults, payload }) {
    for (const { name, box } of this.boxes) box.checked = faults.includes(name);
    if (document.activeElement !== this.mass) this.mass.value = payload;
  }
}

/** The replay's bar: played, stopped, sought in, left. */
export class ReplayBar {
  constructor(element, send) {
    this.element = element;
    this.range = element.querySelector("input");
    this.clock = element.querySelector("output");
    this.play = element.querySelector("[data-action=play]");
    this.held = false;
    this.replay = null;
    const ask = (action, more = {}) => this.replay && send({ type: "replay", name: this.replay.name, action, ...more });
    this.play.addEventListener("click", () => ask(this.replay?.playing ? "pause" : "play"));
    for (const action of ["restart", "stop"]) element.querySelector(`[data-action=${action}]`).addEventListener("click", () => ask(action));
    this.range.addEventListener("input", () => {
      this.held = true;
      ask("seek", { time: Number(this.range.value) });
    });
    this.range.addEventListener("change", () => {
      this.held = false;
      this.range.blur();
    });
  }

  status({ replay }) {
    this.replay = replay;
    this.element.hidden = !replay;
    if (!replay) return;
    say(this.play, replay.playing ? "Pause" : "Play");
    this.range.max = replay.end;
    if (!this.held) this.range.value = replay.time;
    say(this.clock, `${number(replay.time, 1)} / ${number(replay.end, 1)} s`);
  }
}

// The line to the server: frames and texts in, what the driver does out; it is opened again when it is lost.

const HEAD = 24; // bytes before the values of a frame
const SEQ_ROOM = 512; // sticks that wait to be seen applied

export const FLAGS = { locked: 1, driver: 2, relief: 4, stop: 8, outside: 16, recording: 32, replay: 64, target: 128, tipping: 256, guarded: 512 };

/** A frame, or null where its length is none that the machine's columns give. */
export function readFrame(buffer, columns) {
  if (buffer.byteLength !== HEAD + 4 * columns) return null;
  const view = new DataView(buffer);
  const values = new Float32Array(columns);
  for (let k = 0; k < columns; k++) values[k] = view.getFloat32(HEAD + 4 * k, true);
  return {
    number: view.getUint32(0, true),
    seq: view.getUint32(4, true),
    time: view.getFloat64(8, true),
    overruns: view.getUint32(16, true),
    flags: view.getUint32(20, true),
    values,
  };
}

export class Connection {
  /** @param {{columns: number, onFrame: Function, onText: Function, onState: Function}} told */
  constructor(told) {
    this.told = told;
    this.seq = 0;
    this.sent = new Map(); // seq -> when it was sent, ms
    this.latencies = [];
    this.open = false;
    this.wait = 250;
    this.#connect();
  }

  #connect() {
    const socket = new WebSocket(`${location.protocol === "https:" ? "wss" : "ws"}://${location.host}/live`);
    socket.binaryType = "arraybuffer";
    this.socket = socket;
    socket.onopen = () => {
      this.open = true;
      this.wait = 250;
      this.told.onState(true);
    };
    socket.onmessage = ({ data }) => {
      if (typeof data === "string") {
        this.told.onText(JSON.parse(data));
        return;
      }
      const frame = readFrame(data, this.told.columns);
      if (frame === null) return;
      this.#timed(frame.seq);
      this.told.onFrame(frame);
    };
    socket.onclose = () => {
      this.open = false;
      this.sent.clear();
      this.told.onState(false);
      setTimeout(() => this.#connect(), this.wait);
      this.wait = Math.min(2 * this.wait, 4000);
    };
  }

  /** Note how long it took until sticks were applied and seen. */
  #timed(seq) {
    const now = performance.now();
    for (const [sent, at] of this.sent) {
      if (sent > seq) break;
      if (sent === seq) {
        this.latencies.push(now - at);
        if (this.latencies.length > 60) this.latencies.shift();
      }
      this.sent.delete(sent);
    }
  }

  /** Median over the last sticks, ms; null before the first. */
  latency() {
    if (!this.latencies.length) return null;
    return [...this.latencies].sort((a, b) => a - b)[this.latencies.length >> 1];
  }

  send(message) {
    if (!this.open) return false;
    this.socket.send(JSON.stringify(message));
    return true;
  }

  sendSticks(axes) {
    const seq = this.seq + 1;
    if (!this.send({ type: "sticks", seq, axes })) return;
    this.seq = seq;
    this.sent.set(seq, performance.now());
    if (this.sent.size > SEQ_ROOM) this.sent.delete(this.sent.keys().next().value);
  }
}

// Where the links of a drawing are: frames [x, y, z, origin] of unit vectors and a point in the ground's axes (x ahead, y to the left, z up), m.

const DEPTH = 0.35; // of the height above the ground: what is shown below it, so that machines that dig deep are not drawn small
const GROUND = [[1, 0, 0], [0, 1, 0], [0, 0, 1], [0, 0, 0]];

const sum = (...terms) => [0, 1, 2].map((n) => terms.reduce((total, [factor, v]) => total + factor * v[n], 0));

/** A point of a frame, in the ground's axes. */
export const placed = ([x, y, z, origin], [a, b, c]) => sum([a, x], [b, y], [c, z], [1, origin]);

/** Value at `x` of a curve through points, held beyond its ends. */
function interpolated(xs, ys, x) {
  const last = xs.length - 1;
  if (x <= xs[0]) return ys[0];
  if (x >= xs[last]) return ys[last];
  const k = Math.min(Math.floor(((x - xs[0]) / (xs[last] - xs[0])) * last), last - 1);
  const part = (x - xs[k]) / (xs[k + 1] - xs[k]);
  return ys[k] + part * (ys[k + 1] - ys[k]);
}

/** Frames of all links at the positions of the functions, by name; `drawing.plane` is what turns with the first link but stays upright and still. */
export function linkFrames(drawing, positions) {
  const found = new Map([["ground", GROUND]]);
  for (const link of drawing.links) {
    const q = link.function === null
      ? interpolated(link.follows.positions, link.follows.angles, positions[link.follows.function])
      : positions[link.function];
    const parent = found.get(link.parent) ?? GROUND;
    const a = link.axis.findIndex((part) => part !== 0);
    const signed = q * link.axis[a];
    const frame = parent.slice(0, 3);
    const origin = placed(parent, link.origin);
    if (link.joint === "prismatic") {
      found.set(link.name, [...frame, sum([1, origin], [signed, parent[a]])]);
      continue;
    }
    const b = (a + 1) % 3, c = (a + 2) % 3;
    frame[b] = sum([Math.cos(signed), parent[b]], [Math.sin(signed), parent[c]]);
    frame[c] = sum([Math.cos(signed), parent[c]], [-Math.sin(signed), parent[b]]);
    found.set(link.name, [...frame, origin]);
  }
  const [x, y] = drawing.slews ? drawing.links[0].origin : [0, 0];
  found.set(drawing.plane, [...GROUND.slice(0, 3), [x, y, 0]]);
  return found;
}

/** A spot [link, point] in the ground's axes. */
export const spotAt = (frames, [link, at]) => placed(frames.get(link) ?? GROUND, at);

/** How far the plane of the arm has turned to the left, rad. */
export const heading = (drawing, positions) => (drawing.slews ? drawing.links[0].axis[2] * positions[0] : 0);

/** A point as the side view shows it: outward from the upright axis, and up. */
export function seenFromSide(drawing, turn, [x, y, z]) {
  if (!drawing.slews) return [x, z];
  const [ax, ay] = drawing.links[0].origin;
  return [(x - ax) * Math.cos(turn) + (y - ay) * Math.sin(turn), z];
}

/** Corners {low, high} of what the side view or that from above shows: each joint from stop to stop, the others where they begin. */
export function viewLimits(drawing, functions, view) {
  const low = [...drawing.corners[view][0]], high = [...drawing.corners[view][1]];
  const take = (positions) => {
    const frames = linkFrames(drawing, positions), turn = heading(drawing, positions);
    for (const [spot, room] of drawing.clear) {
      const p = spotAt(frames, spot), seen = view === "side" ? seenFromSide(drawing, turn, p) : p;
      for (const n of [0, 1]) {
        low[n] = Math.min(low[n], seen[n] - room);
        high[n] = Math.max(high[n], seen[n] + room);
      }
    }
  };
  functions.forEach((f, place) => {
    const from = Math.max(f.low, -Math.PI), to = Math.min(f.high, Math.PI);
    for (let k = 0; k <= 12; k++) {
      const positions = [...drawing.initial];
      positions[place] = from + ((to - from) * k) / 12;
      take(positions);
    }
  });
  if (view === "side") low[1] = Math.max(low[1], drawing.ground - DEPTH * (high[1] - drawing.ground));
  return { low, high };
}

/** Corners of the hull of circles round points in a plane, counter-clockwise. */
export function hull(points, radii) {
  const cloud = points.flatMap(([x, y], i) =>
    Array.from({ length: 24 }, (_, n) => [x + radii[i] * Math.cos((n * Math.PI) / 12), y + radii[i] * Math.sin((n * Math.PI) / 12)]));
  cloud.sort((p, q) => p[0] - q[0] || p[1] - q[1]);
  const left = ([ax, ay], [bx, by], [px, py]) => (bx - ax) * (py - ay) - (by - ay) * (px - ax) > 0;
  const half = (sorted) => {
    const kept = [];
    for (const p of sorted) {
      while (kept.length > 1 && !left(kept.at(-2), kept.at(-1), p)) kept.pop();
      kept.push(p);
    }
    return kept.slice(0, -1);
  };
  return [...half(cloud), ...half(cloud.reverse())];
}

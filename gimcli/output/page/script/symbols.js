// The symbols of textbook drawings, with the sizes of output/symbols.py and output/force_symbols.py.

const BLOCK_LENGTH = 20, BLOCK_HEIGHT = 12, OVERHANG = 12, LANE = 15;

// A ground line with slanting strokes on the side `away`.
function hatch(c, first, second, away) {
  const pt = camera.pt, along = unit(first, second), span = Math.hypot(second[0] - first[0], second[1] - first[1]);
  const count = Math.min(400, Math.max(2, Math.round(span / (4.2 * pt))));
  line(c, [first, second], 1.2);
  c.beginPath();
  for (let k = 0; k < count; k++) {
    const foot = plus(first, along, (span * (k + 0.8)) / count);
    c.moveTo(...foot);
    c.lineTo(foot[0] + (away[0] - along[0]) * 4 * pt, foot[1] + (away[1] - along[1]) * 4 * pt);
  }
  c.lineWidth = 0.7 * pt;
  c.stroke();
}

function fixedPivot(c, at, upward) {
  const pt = camera.pt, down = [0, upward ? -1 : 1];
  const foot = plus(at, down, 11 * pt), half = 7 * pt;
  area(c, [at, [foot[0] - half, foot[1]], [foot[0] + half, foot[1]]], theme.paper);
  hatch(c, [foot[0] - 1.5 * half, foot[1]], [foot[0] + 1.5 * half, foot[1]], down);
}

function block(c, first, second, along, face = theme.paper, edge = theme.ink, width = 1.3) {
  area(c, rectangle(first, second, (BLOCK_LENGTH / 2) * camera.pt, BLOCK_HEIGHT * camera.pt, along), face, edge, width);
}

function frameGuide(c, first, second, along, side) {
  const reach = (BLOCK_LENGTH / 2 + OVERHANG) * camera.pt, shift = (BLOCK_HEIGHT / 2) * camera.pt;
  hatch(c, plus(plus(first, along, -reach), side, shift), plus(plus(second, along, reach), side, shift), side);
}

function movingGuide(c, first, second, along) {
  const reach = (BLOCK_LENGTH / 2 + OVERHANG) * camera.pt;
  line(c, [plus(first, along, -reach), plus(second, along, reach)], 0.8);
}

function between(first, second, part) {
  return [first[0] + part * (second[0] - first[0]), first[1] + part * (second[1] - first[1])];
}

function cylinder(c, base, end) {
  const pt = camera.pt, along = unit(base, end), mouth = between(base, end, 0.6), aside = left(along);
  line(c, [base, end], 1.8);
  area(c, rectangle(between(base, end, 0.14), mouth, 0, 8 * pt, along), theme.cylinder, theme.ink, 1.2);
  const piston = plus(mouth, along, -4 * pt);
  line(c, [plus(piston, aside, -2.6 * pt), plus(piston, aside, 2.6 * pt)], 1.1);
}

// The arc of a rotary input about the angle `middle`.
function turningArrow(c, at, middle, sense) {
  const half = (52 * Math.PI) / 180;
  arrow(c, arc(at, 15 * camera.pt, middle - sense * half, middle + sense * half, 25));
}

function travelArrow(c, at, along, aside, sense) {
  const pt = camera.pt, ahead = sense >= 0 ? along : [-along[0], -along[1]];
  const start = plus(plus(at, aside, (BLOCK_HEIGHT / 2 + 5) * pt), ahead, -9 * pt);
  arrow(c, [start, plus(start, ahead, 20 * pt)]);
}

// The ends of an element that stands beside its line by `lane` widths; lines lead to the true ends.
function asideLane(c, first, second, lane) {
  const shift = left(unit(first, second)), size = lane * LANE * camera.pt;
  const ends = [plus(first, shift, size), plus(second, shift, size)];
  if (lane) {
    line(c, [first, ends[0]], 1);
    line(c, [second, ends[1]], 1);
  }
  return ends;
}

// A helical spring: its turns stretch with it.
function spring(c, first, second, lane) {
  const [start, end] = asideLane(c, first, second, lane);
  const aside = left(unit(start, end)), places = [start];
  for (let k = 0; k <= 12; k++) {
    const height = k === 12 || k === 0 ? 0 : k % 2 ? 1 : -1;
    places.push(plus(between(start, end, 0.2 + (0.6 * k) / 12), aside, height * 4.5 * camera.pt));
  }
  line(c, [...places, end], 1);
}

// A dashpot: the cylinder is fixed to the first end, the piston to the second.
function damper(c, first, second, lane) {
  const [start, end] = asideLane(c, first, second, lane), pt = camera.pt, aside = left(unit(start, end));
  const bottom = between(start, end, 0.2), mouth = between(start, end, 0.62), piston = between(start, end, 0.5);
  line(c, [start, bottom], 1);
  line(c, [plus(mouth, aside, 5 * pt), plus(bottom, aside, 5 * pt), plus(bottom, aside, -5 * pt), plus(mouth, aside, -5 * pt)], 1);
  line(c, [piston, end], 1);
  line(c, [plus(piston, aside, -3.4 * pt), plus(piston, aside, 3.4 * pt)], 1);
}

const angleOf = (from, to) => Math.atan2(from[1] - to[1], to[0] - from[0]);
const positive = angle => ((angle % (2 * Math.PI)) + 2 * Math.PI) % (2 * Math.PI);

// A spiral spring about a pivot, from the direction of the reference to that of the arm.
function torsionSpring(c, pivot, arm, reference, lane) {
  const first = angleOf(pivot, reference), turn = positive(angleOf(pivot, arm) - first) + 2 * Math.PI;
  const places = Array.from({ length: 90 }, (_, k) => {
    const radius = (6 + 7 * (1 - k / 89) + Math.abs(lane) * LANE) * camera.pt, angle = first + (turn * k) / 89;
    return [pivot[0] + radius * Math.cos(angle), pivot[1] - radius * Math.sin(angle)];
  });
  line(c, places, 1);
}

// A torsional damper: an arc with a piston about a pivot.
function torsionDamper(c, pivot, arm, reference, lane) {
  const pt = camera.pt, first = angleOf(pivot, reference);
  const turn = positive(angleOf(pivot, arm) - first) || 2 * Math.PI, radius = (16 + Math.abs(lane) * LANE) * pt;
  const part = (from, to, away = 0) => arc(pivot, radius + away * pt, first + turn * from, first + turn * to, 30);
  const outer = part(0.3, 0.7, 5), inner = part(0.3, 0.7, -5), rod = part(0.55, 1);
  line(c, part(0, 0.3), 1);
  line(c, [...outer.slice().reverse(), ...inner], 1);
  line(c, rod, 1);
  const away = unit(pivot, rod[0]);
  line(c, [plus(rod[0], away, -3.4 * pt), plus(rod[0], away, 3.4 * pt)], 1);
}

// A force at its point; `along` is its direction, `size` relative to the largest force.
function forceArrow(c, at, along, size) {
  if (size > 0) arrow(c, [at, plus(at, along, (14 + 20 * Math.min(1, size)) * camera.pt)], 1.6, theme.load, 7);
}

function torqueArrow(c, at, sense) {
  arrow(c, arc(at, 13 * camera.pt, Math.PI / 2 - 2.2 * sense, Math.PI / 2 + 2.2 * sense, 40), 1.6, theme.load, 7);
}

function centreOfMass(c, at) {
  disc(c, at, 7.2, theme.paper, theme.ink, 0.7);
  for (const from of [0, Math.PI]) area(c, [at, ...arc(at, 3.6 * camera.pt, from, from + Math.PI / 2, 9)], theme.ink, theme.ink, 0.3);
}

function cross(c, [x, y]) {
  const half = 2.5 * camera.pt;
  line(c, [[x - half, y - half], [x + half, y + half]], 1);
  line(c, [[x - half, y + half], [x + half, y - half]], 1);
}

function diamond(c, [x, y], size, face) {
  const half = (size / 2) * 1.3 * camera.pt;
  area(c, [[x, y - half], [x + half, y], [x, y + half], [x - half, y]], face, face, 0.5);
}

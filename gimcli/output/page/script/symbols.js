// The mechanism at one pose: the strokes of output/symbols.py, placed as there.

// Strokes up to this layer are below the curves: plates, gears and links.
const BELOW = 4;

// `trails` draws the curves, over plates and links, below blocks and pins.
function drawMechanism(c, scene, pose, trails) {
  drawStrokes(c, scene, pose, scene.strong.filter(one => one.layer <= BELOW));
  trails();
  drawStrokes(c, scene, pose, scene.strong.filter(one => one.layer > BELOW));
}

// Only what does not move: shown where a row is not solved.
function drawGround(c, scene, pose) {
  drawStrokes(c, scene, pose, scene.strong.filter(one => one.ground));
}

function drawGhost(c, scene, pose) {
  drawStrokes(c, scene, pose, scene.light);
}

// Decode the shapes of a scene, once.
function decodeScene(scene) {
  for (const one of [...scene.strong, ...scene.light]) if (typeof one.shape === "string") one.shape = floats(one.shape);
}

function drawStrokes(c, scene, pose, strokes) {
  const axes = scene.seats.map(seat => axesOf(seat, pose));
  c.lineJoin = "round";
  for (const one of strokes) {
    const path = one.corners ? one.corners.map(anchor => pose.place(anchor)) : placed(one.shape, axes[one.seat]);
    c.lineCap = one.dash && !one.dash.length ? "round" : "butt";
    if (one.slant[0] || one.slant[1]) hatch(c, path, turned(one.slant.map(part => part * camera.pt), axes[one.seat].axis), one);
    else if (one.dash) line(c, path, one.width, theme[one.ink], one.dash.map(part => part * one.width * camera.pt));
    else area(c, path, theme[one.face], theme[one.ink], one.width, one.face === "plate" ? 0.75 : 1);
  }
  c.lineJoin = "miter";
  c.lineCap = "butt";
}

// Start, span and x axis of a seat on the screen, and its turn; all angles are counter-clockwise.
function axesOf({ at, to, along, member, arm, turn }, pose) {
  const start = pose.place(at), end = to === null ? start : pose.place(to), axis = along ? pose.direction(member, ...along) : unit(start, end);
  if (arm === null) return { start, span: [end[0] - start[0], end[1] - start[1]], axis, turn: 0 };
  const [x, y] = unit(start, pose.place(arm)), angle = Math.atan2(axis[1] * x - axis[0] * y, axis[0] * x + axis[1] * y) - turn;
  return { start, span: [0, 0], axis, turn: turn + Math.atan2(Math.sin(angle), Math.cos(angle)) };
}

// The pixels of the points of a stroke; its shape has share, points and lengths (x, y) of each.
function placed(shape, { start, span, axis, turn }) {
  return Array.from({ length: shape.length / 5 }, (_, k) => {
    const [share, x, y, u, v] = shape.subarray(5 * k, 5 * k + 5), cos = Math.cos(share * turn), sin = Math.sin(share * turn);
    const size = [x * camera.pt + u * camera.scale, y * camera.pt + v * camera.scale];
    return plus(plus(start, span, share), turned([size[0] * cos - size[1] * sin, size[0] * sin + size[1] * cos], axis));
  });
}

// A vector along and to the left of an axis of the screen.
function turned([x, y], [ax, ay]) {
  return [x * ax + y * ay, x * ay - y * ax];
}

// Slanting strokes along a line.
function hatch(c, [first, second], slant, { width, ink }) {
  const span = [second[0] - first[0], second[1] - first[1]];
  const count = Math.min(400, Math.max(2, Math.round(Math.hypot(...span) / (4.2 * camera.pt))));
  c.beginPath();
  for (let k = 0; k < count; k++) {
    const foot = plus(first, span, (k + 0.8) / count);
    c.moveTo(...foot);
    c.lineTo(...plus(foot, slant));
  }
  c.lineWidth = width * camera.pt;
  c.strokeStyle = theme[ink];
  c.setLineDash([]);
  c.stroke();
}

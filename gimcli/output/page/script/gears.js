// Gears, belts and racks at one pose, as in output/gear_symbols.py; their data are those of output/gear_outlines.py.

const PITCH_DASH = [9, 2.5, 1.5, 2.5];
const WHEEL_TICKS = [60, 180, 300].map(angle => (angle * Math.PI) / 180);

function drawGears(c, gears, pose) {
  const dash = PITCH_DASH.map(part => part * camera.pt);
  for (const wheel of gears.wheels) {
    const at = pose.node(wheel.pivot), radius = wheel.radius * camera.scale, wall = 7 * camera.pt;
    ringLine(c, at, radius, 0.9, dash);
    if (wheel.ring) ringLine(c, at, radius + wall, 1.4, []);
    if (wheel.fixed) continue;
    const end = radius + (wheel.ring ? wall : -Math.min(6 * camera.pt, 0.4 * radius));
    for (const angle of WHEEL_TICKS) {
      const along = pose.direction(wheel.member, Math.cos(angle), Math.sin(angle));
      line(c, [plus(at, along, radius), plus(at, along, end)], 1.1);
    }
  }
  for (const belt of gears.belts) line(c, beltPath(belt, pose), 1.5);
  for (const rack of gears.racks) {
    const [first, second] = rack.ends.map(end => pose.place(end)), across = left(unit(first, second)), half = 3 * camera.pt;
    line(c, [first, second], 0.9, theme.ink, dash);
    for (const end of [first, second]) line(c, [plus(end, across, -half), plus(end, across, half)], 1.1);
  }
}

// The gears of a light pose whose pivots move.
function drawLightGears(c, scene, pose) {
  const moves = node => !scene.fixed.includes(node), dash = PITCH_DASH.map(part => part * camera.pt);
  for (const wheel of scene.gears.wheels)
    if (moves(wheel.pivot)) ringLine(c, pose.node(wheel.pivot), wheel.radius * camera.scale, 0.6, dash, theme.soft);
  for (const belt of scene.gears.belts) if (belt.pivots.some(moves)) line(c, beltPath(belt, pose), 0.7, theme.soft);
}

function ringLine(c, [x, y], radius, width, dash, colour = theme.ink) {
  c.beginPath();
  c.arc(x, y, radius, 0, 2 * Math.PI);
  c.lineWidth = width * camera.pt;
  c.strokeStyle = colour;
  c.setLineDash(dash);
  c.stroke();
}

// The closed path of a belt: an arc on each wheel between the points where the strands leave it.
function beltPath(belt, pose) {
  const [first, second] = belt.pivots.map(node => pose.node(node)), [r, s] = belt.radii.map(radius => radius * camera.scale);
  const away = Math.hypot(second[0] - first[0], second[1] - first[1]) || 1, line = Math.atan2(first[1] - second[1], second[0] - first[0]);
  const leaves = Math.acos(Math.max(-1, Math.min(1, (belt.crossed ? r + s : r - s) / away))), last = belt.crossed ? Math.PI - leaves : -leaves;
  const path = [...arc(first, r, line + leaves, line + 2 * Math.PI - leaves), ...arc(second, s, line + last, line - last)];
  return [...path, path[0]];
}

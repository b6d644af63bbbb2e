// Names beside nodes and points. Each name keeps its side during a motion: the one with most room.

const SIDES = Array.from({ length: 16 }, (_, k) => (k * Math.PI) / 8 + Math.PI / 6);

// Choose the angle of each name: away from the lines at the node in some poses, and from the names already placed.
function nameSides(scene, pose, starts, xy) {
  const named = scene.named, taken = named.map(() => []), at = [];
  for (const start of starts) {
    pose.set(xy, start);
    const lines = linesOf(scene, pose);
    named.forEach(([, anchor], k) => {
      at[k] = pose.place(anchor);
      taken[k].push(directionsAt(lines, at[k]));
    });
  }
  const placed = [];
  return named.map(([name], k) => {
    const room = side => {
      const box = nameBox(name, at[k], side), free = taken[k].map(angles => Math.min(1.1, ...angles.map(angle => angleBetween(side, angle))));
      const hits = placed.filter(other => box[0] < other[2] && other[0] < box[2] && box[1] < other[3] && other[1] < box[3]);
      return free.reduce((sum, one) => sum + one, 0) / starts.length + 0.5 * Math.min(...free) - 2 * hits.length;
    };
    const best = SIDES.reduce((chosen, side) => (room(side) > room(chosen) + 1e-6 ? side : chosen));
    placed.push(nameBox(name, at[k], best));
    return best;
  });
}

// The angle between two directions.
function angleBetween(a, b) {
  return Math.abs(Math.atan2(Math.sin(a - b), Math.cos(a - b)));
}

// Pieces of lines [from, to] near which a name would be hard to read.
function linesOf(scene, pose) {
  const found = [];
  for (const body of scene.bodies) {
    const outline = body.outline.map(anchor => pose.place(anchor));
    outline.forEach((place, k) => k + 1 < outline.length + (outline.length > 2) && found.push([place, outline[(k + 1) % outline.length]]));
  }
  for (const { ends } of scene.lines) found.push(ends.map(anchor => pose.place(anchor)));
  for (const [node, dx, dy] of scene.asides) found.push([pose.node(node), plus(pose.node(node), [dx, -dy], 9)]);
  return found;
}

// The directions in which lines leave a place.
function directionsAt(lines, at) {
  const found = [];
  for (const ends of lines)
    ends.forEach(([x, y], k) => {
      const other = ends[1 - k];
      if (Math.hypot(x - at[0], y - at[1]) < 2 && Math.hypot(other[0] - x, other[1] - y) > 0) found.push(Math.atan2(y - other[1], other[0] - x));
    });
  return found;
}

function nameBox(name, [x, y], side) {
  const half = 4 * Math.min(name.length, 40), cx = x + (10 + half) * Math.cos(side), cy = y - 15 * Math.sin(side);
  return [cx - half, cy - 8, cx + half, cy + 8];
}

function drawNames(c, scene, pose, sides) {
  scene.named.forEach(([name, anchor], k) => {
    const at = pose.place(anchor), words = shortName(name);
    const half = 0.5 * Math.min(words.length, 40) * 0.55 * Math.max(11, 9 * camera.pt);
    text(c, words, at[0] + (9 + half) * Math.cos(sides[k]), at[1] - 15 * Math.sin(sides[k]), 9, true);
  });
}

function shortName(name) {
  return name.length > 40 ? name.slice(0, 39) + "…" : name;
}

// What the pointer is at: the nearest node or point, else a member; its name, coordinates, speed or lengths.

const NEAR_NODE = 16, NEAR_MEMBER = 9; // pixels

function targets(scene) {
  const found = scene.named.map(([name, at]) => ({ kind: "point", name, at }));
  for (const body of scene.bodies) found.push({ kind: "body", name: scene.members[body.member], ends: body.outline });
  for (const one of scene.lines) found.push({ kind: "line", ...one });
  for (const { name, nodes } of scene.blocks) found.push({ kind: "block", name, ends: nodes });
  for (const load of scene.loads) found.push({ kind: "load", name: `load ${load.name}`, at: load.at });
  return found;
}

function targetAt(found, pose, x, y) {
  let best = null, least = NEAR_NODE;
  for (const one of found) {
    if (one.kind !== "point") continue;
    const [px, py] = pose.place(one.at), away = Math.hypot(px - x, py - y);
    if (away < least) [best, least] = [one, away];
  }
  if (best) return best;
  least = NEAR_MEMBER;
  for (const one of found) {
    if (one.kind !== "body" && one.kind !== "line") continue;
    const away = distanceTo(one.ends.map(anchor => pose.place(anchor)), x, y, one.kind === "body");
    if (away < least) [best, least] = [one, away];
  }
  if (best) return best;
  return found.find(one => one.kind === "block" && one.ends.some(node => Math.hypot(pose.px[node] - x, pose.py[node] - y) < 22)) || null;
}

// The distance of a place from an outline; 0 inside of a polygon is not taken, so that members over plates are found first.
function distanceTo(outline, x, y, filled) {
  let least = Infinity, inside = false;
  for (let k = 0; k < outline.length; k++) {
    const [ax, ay] = outline[k], [bx, by] = outline[(k + 1) % outline.length];
    const dx = bx - ax, dy = by - ay, size = dx * dx + dy * dy;
    const part = size ? Math.min(1, Math.max(0, ((x - ax) * dx + (y - ay) * dy) / size)) : 0;
    least = Math.min(least, Math.hypot(ax + part * dx - x, ay + part * dy - y));
    if (ay > y !== by > y && x < ((bx - ax) * (y - ay)) / (by - ay) + ax) inside = !inside;
  }
  return filled && inside && outline.length > 2 ? Math.min(least, NEAR_MEMBER - 1) : least;
}

// The lines of the note; positions are those that begin at `start` of `xy`.
function describe(target, app, xy, start, rates) {
  const { scene, unit, origin } = app.data, length = unit.length ? " " + unit.length : "";
  const place = anchor => anchorPlace(scene, xy, start, anchor);
  const size = boxSize(app.data.box), measured = value => shownLength(value, size) + length;
  const nameOf = anchor => (typeof anchor === "number" ? scene.nodes[anchor] : (scene.tracers.find(t => t.at.join() === anchor.join()) || { name: "" }).name);
  const distance = (a, b) => Math.hypot(place(a)[0] - place(b)[0], place(a)[1] - place(b)[1]);
  const lines = [target.name];
  if (target.kind === "point" || target.kind === "load") {
    const [x, y] = place(target.at);
    lines.push(`x = ${measured(x + origin[0])}`, `y = ${measured(y + origin[1])}`);
    rates.forEach((one, order) => {
      const [vx, vy] = anchorRate(scene, xy, one, start, target.at);
      if (Number.isFinite(vx)) lines.push(`${KINDS[order]} ${shown(Math.hypot(vx, vy))} ${raised(app.clip.rateUnits[order])}`);
    });
  } else if (target.kind === "line") lines.push(`length ${measured(distance(...target.ends))}`);
  else if (target.kind === "block") lines.push(`block at ${target.ends.map(node => scene.nodes[node]).join(", ")}`);
  else {
    const outline = target.ends, pairs = outline.length === 2 ? [[0, 1]] : outline.map((_, k) => [k, (k + 1) % outline.length]);
    for (const [a, b] of pairs.slice(0, 8))
      lines.push(`${shortName(nameOf(outline[a]))} – ${shortName(nameOf(outline[b]))}: ${measured(distance(outline[a], outline[b]))}`);
  }
  return lines.map(shortLine).join("\n");
}

function shortLine(words) {
  return words.length > 90 ? words.slice(0, 89) + "…" : words;
}

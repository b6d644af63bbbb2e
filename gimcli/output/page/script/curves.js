// Coupler curves: the whole path light, the path up to the present row strong; broken where rows do not continue.

// The path [x0, y0, ...] of an anchor in all rows, in coordinates of the data.
function pathOf(scene, clip, anchor) {
  const nodes = scene.nodes.length, path = new Float32Array(2 * clip.rows).fill(NaN);
  for (let row = 0; row < clip.rows; row++) {
    if (!clip.good(row)) continue;
    const [x, y] = anchorPlace(scene, clip.xy, 2 * nodes * row, anchor);
    path[2 * row] = x;
    path[2 * row + 1] = y;
  }
  return path;
}

// An anchor's place for positions that begin at `start`, in coordinates of the data.
function anchorPlace(scene, xy, start, anchor) {
  if (typeof anchor === "number") return [xy[start + 2 * anchor], xy[start + 2 * anchor + 1]];
  const [member, x, y] = anchor, [origin, towards] = scene.carriers[member];
  if (origin < 0) return [x, y];
  const ox = xy[start + 2 * origin], oy = xy[start + 2 * origin + 1];
  const dx = towards < 0 ? 1 : xy[start + 2 * towards] - ox, dy = towards < 0 ? 0 : xy[start + 2 * towards + 1] - oy;
  const size = Math.hypot(dx, dy) || 1;
  return [ox + (dx * x - dy * y) / size, oy + (dy * x + dx * y) / size];
}

// A vector quantity of an anchor (its derivative by time): linear in those of the two nodes of its carrier.
function anchorRate(scene, xy, rates, start, anchor) {
  if (typeof anchor === "number") return [rates[start + 2 * anchor], rates[start + 2 * anchor + 1]];
  const [member, x, y] = anchor, [origin, towards] = scene.carriers[member];
  if (origin < 0) return [0, 0];
  const own = [rates[start + 2 * origin], rates[start + 2 * origin + 1]];
  if (towards < 0) return own;
  const size = Math.hypot(xy[start + 2 * towards] - xy[start + 2 * origin], xy[start + 2 * towards + 1] - xy[start + 2 * origin + 1]) || 1;
  const dx = (rates[start + 2 * towards] - own[0]) / size, dy = (rates[start + 2 * towards + 1] - own[1]) / size;
  return [own[0] + dx * x - dy * y, own[1] + dy * x + dx * y];
}

// Draw the rows `from` to `to` of a path; light if `alpha` is below 1.
function drawPath(c, clip, path, from, to, pen, alpha) {
  c.beginPath();
  let drawn = false;
  for (let row = from; row <= to; row++) {
    if (!clip.good(row)) continue;
    const x = toX(path[2 * row]), y = toY(path[2 * row + 1]);
    if (row > from && continues(clip, row)) {
      c.lineTo(x, y);
      drawn = true;
    } else c.moveTo(x, y);
  }
  if (!drawn) return;
  c.globalAlpha = alpha;
  c.lineWidth = pen.width * (alpha < 1 ? 0.8 : 1.15);
  c.strokeStyle = pen.colour;
  c.setLineDash(pen.dash);
  c.lineJoin = "round";
  c.stroke();
  c.lineJoin = "miter";
  c.globalAlpha = 1;
}

// The name of a curve in the corner of the drawing.
function drawKey(c, name, pen, place) {
  const y = 18 + 18 * place;
  c.beginPath();
  c.moveTo(12, y);
  c.lineTo(40, y);
  c.lineWidth = pen.width * 1.15;
  c.strokeStyle = pen.colour;
  c.setLineDash(pen.dash);
  c.stroke();
  text(c, shortName(name), 46, y, 8);
}

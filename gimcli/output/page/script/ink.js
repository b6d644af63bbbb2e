// Lines, areas and marks on a canvas; places are pixels [x, y], sizes are typographic points (camera.pt pixels).

function line(c, places, width, colour = theme.ink, dash = []) {
  c.beginPath();
  places.forEach(([x, y], k) => (k ? c.lineTo(x, y) : c.moveTo(x, y)));
  c.lineWidth = width * camera.pt;
  c.strokeStyle = colour;
  c.setLineDash(dash);
  c.stroke();
}

function area(c, places, face, edge = theme.ink, width = 1, alpha = 1) {
  c.beginPath();
  places.forEach(([x, y], k) => (k ? c.lineTo(x, y) : c.moveTo(x, y)));
  c.closePath();
  c.setLineDash([]);
  if (face) {
    c.globalAlpha = alpha;
    c.fillStyle = face;
    c.fill();
    c.globalAlpha = 1;
  }
  if (width) {
    c.lineWidth = width * camera.pt;
    c.strokeStyle = edge;
    c.stroke();
  }
}

function disc(c, [x, y], size, face, edge = theme.ink, width = 1.1) {
  c.beginPath();
  c.arc(x, y, (size / 2) * camera.pt, 0, 2 * Math.PI);
  c.setLineDash([]);
  c.fillStyle = face;
  c.fill();
  if (width) {
    c.lineWidth = width * camera.pt;
    c.strokeStyle = edge;
    c.stroke();
  }
}

// A text with a border in the colour of the paper, so that it can be read over lines.
function text(c, words, x, y, size = 9, colour = theme.ink) {
  c.font = `${Math.max(11, size * camera.pt)}px system-ui, sans-serif`;
  c.lineJoin = "round";
  c.setLineDash([]);
  c.lineWidth = 3;
  c.strokeStyle = theme.paper;
  c.strokeText(words, x, y);
  c.fillStyle = colour;
  c.fillText(words, x, y);
  c.lineJoin = "miter";
}

const plus = ([x, y], [dx, dy], size = 1) => [x + size * dx, y + size * dy];
const left = ([dx, dy]) => [dy, -dx]; // a direction turned counter-clockwise on the screen

function unit([x, y], [tx, ty]) {
  const size = Math.hypot(tx - x, ty - y);
  return size > 0 ? [(tx - x) / size, (ty - y) / size] : [1, 0];
}

// A bar from one place to another that extends by `beyond` pixels at both ends.
function rectangle(first, second, beyond, height, along) {
  const start = plus(first, along, -beyond), end = plus(second, along, beyond), aside = left(along);
  return [plus(start, aside, -height / 2), plus(end, aside, -height / 2), plus(end, aside, height / 2), plus(start, aside, height / 2)];
}

// An arc on the screen; angles are counter-clockwise.
function arc(at, radius, from, to, count = 33) {
  return Array.from({ length: count }, (_, k) => {
    const angle = from + ((to - from) * k) / (count - 1);
    return [at[0] + radius * Math.cos(angle), at[1] - radius * Math.sin(angle)];
  });
}

function arrowHead(c, tip, along, size, colour, face = colour) {
  const back = plus(tip, along, -size * camera.pt), aside = left(along), half = 0.32 * size * camera.pt;
  area(c, [tip, plus(back, aside, half), plus(back, aside, -half)], face, colour, face === colour ? 0.3 : 0.9);
}

// A polyline with an arrowhead at its end.
function arrow(c, path, width = 1.1, colour = theme.ink, size = 6, dash = [], face = colour) {
  const tip = path[path.length - 1], along = unit(path[path.length - 2], tip);
  line(c, [...path.slice(0, -1), plus(tip, along, -0.6 * size * camera.pt)], width, colour, dash);
  arrowHead(c, tip, along, size, colour, face);
}

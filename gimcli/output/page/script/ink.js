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

const drawnTexts = new Map(); // texts as small pictures, since writing a text in each frame takes long

// A text with a border in the colour of the paper, so that it can be read over lines; the place is its left or its middle.
function text(c, words, x, y, size = 9, centred = false) {
  const pixels = Math.max(11, size * camera.pt), ratio = window.devicePixelRatio || 1;
  const key = `${words} ${pixels} ${ratio} ${theme.dark}`;
  if (!drawnTexts.has(key)) {
    if (drawnTexts.size > 2000) drawnTexts.clear();
    drawnTexts.set(key, drawnText(words, pixels, ratio));
  }
  const picture = drawnTexts.get(key), width = picture.width / ratio, height = picture.height / ratio;
  const whole = value => Math.round(value * ratio) / ratio; // on whole pixels of the screen, so that letters are sharp
  c.drawImage(picture, whole(centred ? x - width / 2 : x - 3), whole(y - height / 2), width, height);
}

function drawnText(words, pixels, ratio) {
  const canvas = document.createElement("canvas"), c = canvas.getContext("2d"), font = `${pixels}px system-ui, sans-serif`;
  c.font = font;
  canvas.width = Math.ceil((c.measureText(words).width + 6) * ratio);
  canvas.height = Math.ceil((1.5 * pixels + 4) * ratio);
  c.scale(ratio, ratio);
  c.font = font;
  c.textBaseline = "middle";
  c.lineJoin = "round";
  c.lineWidth = 3;
  c.strokeStyle = theme.paper;
  c.strokeText(words, 3, canvas.height / ratio / 2);
  c.fillStyle = theme.ink;
  c.fillText(words, 3, canvas.height / ratio / 2);
  return canvas;
}

const plus = ([x, y], [dx, dy], size = 1) => [x + size * dx, y + size * dy];
const left = ([dx, dy]) => [dy, -dx]; // a direction turned counter-clockwise on the screen

function unit([x, y], [tx, ty]) {
  const size = Math.hypot(tx - x, ty - y);
  return size > 0 ? [(tx - x) / size, (ty - y) / size] : [1, 0];
}

// Many straight arrows [start, tip, size of the head or 0], drawn with two paths: that is faster than one by one.
// The form is that of pictures: `neck` is the end of a line behind its tip, `head` the outline of a head of size 1.
function arrows(c, vectors, { neck, head }, { width, dash, edge }, colour, face) {
  const heads = [];
  c.beginPath();
  for (const [start, tip, size] of vectors) {
    const along = unit(start, tip), end = plus(tip, along, -neck * size * camera.pt);
    c.moveTo(...start);
    c.lineTo(...end);
    if (size) heads.push([tip, along, left(along), size * camera.pt]);
  }
  c.lineWidth = width * camera.pt;
  c.strokeStyle = colour;
  c.setLineDash(dash.map(part => part * width * camera.pt));
  c.stroke();
  c.beginPath();
  for (const [tip, along, aside, size] of heads) {
    head.forEach(([x, y], k) => c[k ? "lineTo" : "moveTo"](...plus(plus(tip, along, x * size), aside, y * size)));
    c.closePath();
  }
  c.fillStyle = face;
  c.fill();
  c.lineWidth = edge * camera.pt;
  c.setLineDash([]);
  c.stroke();
}

// From the coordinates of the file to pixels of the drawing.

const camera = { x: 0, y: 0, scale: 1, width: 1, height: 1, fitted: true, whole: 1, pt: 1.33 };

const toX = x => camera.width / 2 + (x - camera.x) * camera.scale;
const toY = y => camera.height / 2 - (y - camera.y) * camera.scale;
const fromX = px => camera.x + (px - camera.width / 2) / camera.scale;
const fromY = py => camera.y - (py - camera.height / 2) / camera.scale;

// Show a window [left, right, bottom, top] with a border for symbols and names.
function fitCamera(box) {
  const border = Math.min(52, 0.12 * Math.min(camera.width, camera.height));
  const wide = box[1] - box[0], high = box[3] - box[2];
  const size = Math.max(wide, high) || 1;
  camera.scale = Math.min(
    (camera.width - 2 * border) / Math.max(wide, 1e-9 * size), (camera.height - 2 * border) / Math.max(high, 1e-9 * size)
  );
  camera.x = (box[0] + box[1]) / 2;
  camera.y = (box[2] + box[3]) / 2;
  camera.whole = camera.scale;
  camera.fitted = true;
}

// Enlarge by a factor about a pixel that stays where it is.
function zoomCamera(factor, px, py) {
  const x = fromX(px), y = fromY(py);
  camera.scale = Math.min(Math.max(camera.scale * factor, camera.whole / 20), camera.whole * 2000);
  camera.x = x - (px - camera.width / 2) / camera.scale;
  camera.y = y + (py - camera.height / 2) / camera.scale;
  camera.fitted = false;
}

function panCamera(dx, dy) {
  camera.x -= dx / camera.scale;
  camera.y += dy / camera.scale;
  camera.fitted = false;
}

// A graph of chosen columns over another column, with a cursor at the present row.

const EDGE = { left: 58, right: 12, top: 22, bottom: 34 };
const TICKS = 3; // least number of ticks of an axis

class Graph {
  constructor(app, columns, over) {
    this.app = app;
    this.columns = columns; // names
    this.over = over; // name of the abscissa
    this.build();
  }

  build() {
    this.element = create("div", "graph");
    const head = this.element.appendChild(create("div", "head"));
    this.lines = head.appendChild(create("div", "lines"));
    const remove = head.appendChild(create("button", "remove", "×"));
    remove.type = "button";
    remove.setAttribute("aria-label", "Remove this graph");
    remove.onclick = () => this.app.removeGraph(this);
    this.canvas = this.element.appendChild(document.createElement("canvas"));
    this.canvas.setAttribute("role", "img");
    this.layer = document.createElement("canvas");
    this.chooser = this.element.appendChild(document.createElement("details"));
    this.chooser.appendChild(create("summary", "", "Columns"));
    this.chooser.ontoggle = () => this.chooser.open && this.fillChooser();
    const seek = event => this.seek(event);
    this.canvas.onpointerdown = event => {
      this.canvas.setPointerCapture(event.pointerId);
      seek(event);
    };
    this.canvas.onpointermove = event => event.buttons && seek(event);
  }

  // The list of columns and the abscissa; made only when it is opened.
  fillChooser() {
    while (this.chooser.children.length > 1) this.chooser.lastChild.remove();
    const over = this.chooser.appendChild(create("label", "", "x axis "));
    const select = over.appendChild(document.createElement("select"));
    for (const column of this.app.clip.columns) select.appendChild(new Option(labelled(column.name, column.unit), column.name));
    select.value = this.over;
    select.onchange = () => {
      this.over = select.value;
      this.refresh();
    };
    const search = this.chooser.appendChild(document.createElement("input"));
    search.type = "search";
    search.placeholder = "Search columns";
    search.setAttribute("aria-label", "Search columns");
    const list = this.chooser.appendChild(document.createElement("fieldset"));
    for (const column of this.app.clip.columns) {
      const label = list.appendChild(document.createElement("label")), box = label.appendChild(document.createElement("input"));
      box.type = "checkbox";
      box.checked = this.columns.includes(column.name);
      box.onchange = () => {
        this.columns = box.checked ? [...this.columns, column.name] : this.columns.filter(name => name !== column.name);
        this.refresh();
      };
      label.append(" " + labelled(column.name, column.unit));
    }
    search.oninput = () => {
      const part = search.value.toLowerCase();
      for (const label of list.children) label.hidden = !label.textContent.toLowerCase().includes(part);
    };
  }

  refresh() {
    this.measure();
    this.app.redraw();
  }

  find(name) {
    return this.app.clip.columns.find(column => column.name === name);
  }

  // Adapt to the size and to the clip; the curves are drawn anew.
  measure() {
    const box = this.canvas.getBoundingClientRect(), ratio = window.devicePixelRatio || 1;
    this.width = Math.max(120, box.width);
    this.height = Math.max(80, box.height);
    for (const canvas of [this.canvas, this.layer]) {
      canvas.width = Math.round(this.width * ratio);
      canvas.height = Math.round(this.height * ratio);
      canvas.getContext("2d").setTransform(ratio, 0, 0, ratio, 0, 0);
    }
    this.x = this.find(this.over) || this.app.clip.columns[0];
    this.curves = this.columns.map(name => this.find(name)).filter(Boolean);
    this.fresh = false;
    if (!this.x) return;
    const shows = row => !this.curves.length || this.curves.some(curve => Number.isFinite(curve.values[row]));
    const solved = this.x.values.filter((_, row) => shows(row)); // a law that is cut short ends at its limit
    this.across = span([solved, this.app.clip.events.map(event => this.between(event.row))], 0);
    this.upward = span(this.curves.map(curve => curve.shown), 0.06); // cut at poles only: output/value_window.py
    const names = this.curves.map(curve => labelled(curve.name, curve.unit)).join(", ");
    this.canvas.setAttribute("aria-label", `Graph of ${names} over ${labelled(this.x.name, this.x.unit)}`);
    this.head();
  }

  // The names of the curves, with samples of their lines; the values are written by `draw`.
  head() {
    this.lines.textContent = "";
    this.values = this.curves.map((curve, k) => {
      const row = this.lines.appendChild(document.createElement("div")), sample = row.appendChild(document.createElement("canvas"));
      sample.width = 52;
      sample.height = 20;
      const c = sample.getContext("2d"), pen = curvePen(k);
      c.scale(2, 2);
      c.setLineDash(pen.dash);
      c.strokeStyle = pen.colour;
      c.lineWidth = pen.width;
      c.beginPath();
      c.moveTo(0, 5);
      c.lineTo(26, 5);
      c.stroke();
      return row.appendChild(create("span", "value"));
    });
    if (!this.curves.length) this.lines.textContent = "Choose columns.";
  }

  // The abscissa between two rows.
  between(at) {
    const row = Math.floor(at), first = this.x.values[row], next = this.x.values[Math.min(row + 1, this.app.clip.rows - 1)];
    return first + (at - row) * (next - first);
  }

  px(value) {
    return EDGE.left + ((value - this.across[0]) / (this.across[1] - this.across[0])) * (this.width - EDGE.left - EDGE.right);
  }

  py(value) {
    return this.height - EDGE.bottom - ((value - this.upward[0]) / (this.upward[1] - this.upward[0])) * (this.height - EDGE.top - EDGE.bottom);
  }

  draw() {
    if (!this.x) return;
    if (!this.fresh) this.drawLayer();
    const c = this.canvas.getContext("2d");
    c.save();
    c.setTransform(1, 0, 0, 1, 0, 0);
    c.clearRect(0, 0, this.canvas.width, this.canvas.height);
    c.drawImage(this.layer, 0, 0);
    c.restore();
    const at = this.app.value(this.x);
    const inside = Number.isFinite(at) && at >= this.across[0] && at <= this.across[1];
    if (inside) {
      c.beginPath();
      c.moveTo(this.px(at), EDGE.top);
      c.lineTo(this.px(at), this.height - EDGE.bottom);
      c.lineWidth = 1;
      c.strokeStyle = theme.ink;
      c.stroke();
    }
    this.curves.forEach((curve, k) => {
      const value = this.app.value(curve);
      const words = quantity(curve.name, value, curve.unit);
      if (this.values[k].textContent !== words) this.values[k].textContent = words;
      if (!inside || !Number.isFinite(value)) return;
      c.beginPath();
      c.arc(this.px(at), Math.min(this.height - EDGE.bottom, Math.max(EDGE.top, this.py(value))), 4, 0, 2 * Math.PI);
      c.fillStyle = curvePen(k).colour;
      c.fill();
    });
  }

  drawLayer() {
    const c = this.layer.getContext("2d");
    this.fresh = true;
    c.clearRect(0, 0, this.width, this.height);
    this.drawAxes(c);
    c.save();
    c.beginPath();
    c.rect(EDGE.left, EDGE.top, this.width - EDGE.left - EDGE.right, this.height - EDGE.top - EDGE.bottom);
    c.clip();
    this.drawEvents(c);
    this.curves.forEach((curve, k) => this.drawCurve(c, curve, curvePen(k)));
    this.drawPoles(c);
    c.restore();
  }

  // The word "pole" where a curve leaves the axis.
  drawPoles(c) {
    c.fillStyle = theme.ink;
    c.textAlign = "center";
    for (const { values } of this.curves) {
      const sides = Array.from(values, value => Math.sign(value - Math.min(this.upward[1], Math.max(this.upward[0], value))));
      sides.forEach((side, row) => {
        if (!side || sides[row - 1] === side) return;
        const px = Math.min(this.width - EDGE.right, Math.max(EDGE.left + 34, this.px(this.x.values[row])));
        c.fillText("pole", px - 18, side > 0 ? EDGE.top + 7 : this.height - EDGE.bottom - 7);
      });
    }
  }

  // A dotted line at each event, between the rows beside it.
  drawEvents(c) {
    c.setLineDash([1, 3]);
    c.strokeStyle = theme.second;
    c.lineWidth = 1.5;
    for (const event of this.app.clip.events) {
      const px = this.px(this.between(event.row));
      this.grid(c, px, EDGE.top, px, this.height - EDGE.bottom);
    }
  }

  drawAxes(c) {
    const bottom = this.height - EDGE.bottom, right = this.width - EDGE.right;
    c.font = "12px system-ui, sans-serif";
    c.fillStyle = theme.faint;
    c.strokeStyle = theme.line;
    c.lineWidth = 1;
    c.setLineDash([]);
    c.textAlign = "center";
    c.textBaseline = "top";
    const across = ticks(...this.across, Math.max(2, Math.floor((right - EDGE.left) / 70)));
    for (const value of across) {
      this.grid(c, this.px(value), EDGE.top, this.px(value), bottom);
      c.fillText(tickText(value, across), this.px(value), bottom + 4);
    }
    c.fillText(labelled(this.x.name, this.x.unit), (EDGE.left + right) / 2, bottom + 18);
    c.textAlign = "right";
    c.textBaseline = "middle";
    const upward = ticks(...this.upward, 4);
    for (const value of upward) {
      this.grid(c, EDGE.left, this.py(value), right, this.py(value));
      c.fillText(tickText(value, upward), EDGE.left - 5, this.py(value));
    }
    const units = [...new Set(this.curves.map(curve => curve.unit))].filter(Boolean);
    c.textAlign = "left";
    if (units.length) c.fillText(`[${units.join(", ")}]`, 4, EDGE.top / 2);
    c.strokeStyle = theme.faint;
    if (this.upward[0] < 0 && this.upward[1] > 0) this.grid(c, EDGE.left, this.py(0), right, this.py(0));
  }

  grid(c, x, y, tx, ty) {
    c.beginPath();
    c.moveTo(x, y);
    c.lineTo(tx, ty);
    c.stroke();
  }

  drawCurve(c, curve, pen) {
    const { clip } = this.app, jump = 0.5 * (this.across[1] - this.across[0]), high = this.upward[1] - this.upward[0];
    c.beginPath();
    c.setLineDash(pen.dash);
    c.strokeStyle = pen.colour;
    c.lineWidth = pen.width;
    c.lineJoin = "round";
    let open = false;
    for (let row = 0; row < clip.rows; row++) {
      const x = this.x.values[row], y = curve.values[row];
      if (!Number.isFinite(x) || !Number.isFinite(y)) {
        open = false;
        continue;
      }
      const before = curve.values[row - 1];
      const joined = open && continues(clip, row) && (clip.rows < 8 || Math.abs(x - this.x.values[row - 1]) < jump) && !(Math.abs(y - before) > high && y * before < 0);
      if (joined) c.lineTo(this.px(x), this.py(y));
      else {
        c.moveTo(this.px(x), this.py(y));
        c.lineTo(this.px(x) + 0.01, this.py(y));
      }
      open = true;
    }
    c.stroke();
  }

  // Go to the row that is nearest to the pointer.
  seek(event) {
    const box = this.canvas.getBoundingClientRect(), px = event.clientX - box.left, py = event.clientY - box.top;
    let best = -1, least = Infinity;
    this.x.values.forEach((x, row) => {
      const dy = this.over === this.app.clip.axis ? 0 : Math.min(...this.curves.map(curve => Math.abs(this.py(curve.values[row]) - py)).filter(Number.isFinite));
      const away = Math.hypot(this.px(x) - px, Number.isFinite(dy) ? dy : 0);
      if (away < least) [best, least] = [row, away];
    });
    if (best >= 0) this.app.go(best);
  }
}

// The limits of values, with a margin.
function span(lists, margin) {
  const values = lists.flatMap(list => Array.from(list).filter(Number.isFinite));
  if (!values.length) return [0, 1];
  const low = values.reduce((a, b) => Math.min(a, b)), high = values.reduce((a, b) => Math.max(a, b));
  const size = Math.max(Math.abs(low), Math.abs(high)), border = margin * (high - low);
  if (high - low <= 1e-6 * size) return [low - 0.1 * size, high + 0.1 * size];
  return high > low ? [low - border, high + border] : [low - 0.5, high + 0.5];
}

// Round numbers between two limits, at least TICKS of them.
function ticks(low, high, most) {
  let found = [];
  for (; found.length < TICKS && most < 99; most++) found = roundNumbers(low, high, most);
  return found;
}

function roundNumbers(low, high, most) {
  const rough = (high - low) / most, decade = 10 ** Math.floor(Math.log10(rough));
  const turn = high - low > 170 && high - low < 4000 && decade >= 10 ? [1, 3, 4.5, 6, 9, 18, 36] : [1, 2, 5, 10];
  const step = decade * (turn.find(times => times * decade >= rough) || 10), found = [];
  for (let k = Math.ceil(low / step - 1e-9); k * step <= high + 1e-9 * step; k++) found.push(k * step);
  return found;
}

// The text of a tick with as many decimals as the step needs.
function tickText(value, all) {
  const step = all.length > 1 ? all[1] - all[0] : Math.abs(value) || 1, size = Math.max(...all.map(Math.abs));
  if (Math.abs(value) < 1e-9 * step) return "0";
  if (size >= 1e6 || step < 1e-4) return value.toExponential(Math.max(0, Math.round(Math.log10(size / step)))).replace("-", "−").replace("e+", "e");
  const decimals = Math.max(0, -Math.floor(Math.log10(step) + 1e-9));
  return value.toFixed(Math.min(8, Math.abs(step * 10 ** decimals - Math.round(step * 10 ** decimals)) > 1e-6 ? decimals + 1 : decimals)).replace("-", "−");
}

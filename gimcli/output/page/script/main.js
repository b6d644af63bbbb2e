// The page: its state, and `window.gim` for programs that show other data on it.

class App {
  constructor() {
    this.data = null;
    this.clips = [];
    this.clip = null;
    this.row = 0;
    this.posed = null;
    this.toggles = { names: true, curves: true, ghosts: false, velocity: false, acceleration: false };
    this.graphs = [];
    this.listeners = { row: [], clip: [] };
    this.asked = false;
    this.stage = new Stage(this);
    this.player = new Player(this);
  }

  // -- data ------------------------------------------------------------------------------------

  // Show other data; clip, row, toggles and graphs are kept as far as they exist.
  show(data) {
    const before = this.clip, first = !this.data, named = before && before.name;
    const share = before && before.rows > 1 ? this.row / (before.rows - 1) : 0;
    this.data = data;
    this.clips = data.clips.map(clip => this.prepared(clip));
    this.posed = null;
    document.title = data.title;
    document.getElementById("title").textContent = data.title;
    this.clip = this.clips.find(clip => clip.name === named) || this.clips[0] || null;
    this.row = this.clip ? Math.round(share * (this.clip.rows - 1)) : 0;
    const alike = before && this.clip && Math.abs(Math.log(boxSize(this.clip.box) / boxSize(before.box))) < 0.7;
    if (first && this.clip) this.player.adapt();
    this.fill(alike);
    fillNotes(this);
    fillReport(this);
    if (first || !this.graphs.length) this.setGraphs(data.graphs);
    this.message("", "error");
    if (this.player.playing) this.player.set(true);
  }

  prepared(raw) {
    const { scene, curves } = { ...this.data, ...raw.design }, clip = decodeClip(raw);
    decodeScene(scene);
    clip.scene = scene;
    clip.curves = curves.map(curve => ({ name: curve.name, path: pathOf(scene, clip, curve.at) }));
    clip.solved = [...Array(clip.rows).keys()].filter(clip.good);
    clip.moving = movingAnchors(scene);
    clip.usual = clip.rates.map((_, order) => usual(scene, clip, order));
    clip.rateUnits = this.data.rateUnits;
    clip.arrows = this.data.arrows;
    clip.longest = this.data.longest * boxSize(this.data.box);
    clip.box = this.data.box;
    clip.ground = floats(raw.design ? raw.design.ground : this.data.ground);
    return clip;
  }

  // Fill all lists for the present clip.
  fill(keepView) {
    document.getElementById("player").hidden = !this.clip;
    if (!this.clip) return;
    const single = this.clip.rows < 2;
    for (const name of ["bar", "controls"]) document.getElementById(name).hidden = single;
    const slider = document.getElementById("slider");
    slider.max = String(this.clip.rows - 1);
    slider.value = String(this.row);
    fillToggles(this);
    fillChoice(this);
    fillDesigns(this);
    fillMarks(this);
    fillEvents(this);
    this.fillSpeeds();
    document.getElementById("repeat").value = this.player.repeat;
    document.getElementById("graphs").hidden = single;
    document.getElementById("more-graphs").hidden = single;
    this.stage.show(keepView);
    for (const graph of this.graphs) graph.measure();
    this.redraw();
  }

  // What is drawn: the scene of a design, or the one of all clips.
  get scene() {
    return this.clip ? this.clip.scene : this.data.scene;
  }

  choose(index) {
    if (index < 0 || index >= this.clips.length) return;
    const share = this.clip.rows > 1 ? this.row / (this.clip.rows - 1) : 0, playing = this.player.playing;
    this.clip = this.clips[index];
    this.row = Math.round(share * (this.clip.rows - 1));
    this.posed = null;
    this.fill(true);
    this.player.set(playing);
    this.notify("clip");
  }

  setGraphs(graphs) {
    const place = document.getElementById("graphs");
    place.textContent = "";
    this.graphs = [];
    for (const columns of graphs) this.addGraph(columns.columns, columns.over);
  }

  addGraph(columns, over) {
    const graph = new Graph(this, columns, over || this.clip.axis);
    document.getElementById("graphs").appendChild(graph.element);
    this.graphs.push(graph);
    graph.measure();
    this.redraw();
    return graph;
  }

  removeGraph(graph) {
    graph.element.remove();
    this.graphs = this.graphs.filter(one => one !== graph);
  }

  // -- the present row -------------------------------------------------------------------------

  go(row) {
    if (!this.clip) return;
    this.posed = null;
    this.row = Math.min(Math.max(0, row), this.clip.rows - 1);
    if (this.player.playing) this.player.set(true);
    this.redraw();
  }

  // Step by rows; a single position steps to the next one of the list.
  step(rows) {
    if (this.clip.rows < 2) return this.choose(this.clips.indexOf(this.clip) + Math.sign(rows));
    this.player.set(false);
    this.go(this.row + rows);
  }

  nextEvent() {
    const rows = this.clip.events.map(event => Math.round(event.row)).sort((a, b) => a - b);
    if (rows.length) this.go(rows.find(row => row > this.row) ?? rows[0]);
  }

  toggle(key) {
    const button = document.getElementById(`toggle-${key}`);
    if (button.disabled) return;
    this.toggles[key] = !this.toggles[key];
    button.setAttribute("aria-pressed", String(this.toggles[key]));
    this.stage.fresh = false;
    this.redraw();
  }

  changeSpeed(by) {
    const k = SPEEDS.findIndex(speed => speed >= this.player.speed * 0.999);
    this.player.setSpeed(SPEEDS[Math.min(SPEEDS.length - 1, Math.max(0, k + by))]);
    document.getElementById("speed").value = String(this.player.speed);
  }

  fillSpeeds() {
    const select = document.getElementById("speed");
    if (!select.options.length) for (const speed of SPEEDS) select.appendChild(new Option(`× ${speed}`, speed));
    select.value = String(this.player.speed);
  }

  // -- the view --------------------------------------------------------------------------------

  zoom(factor, x = camera.width / 2, y = camera.height / 2) {
    zoomCamera(factor, x, y);
    this.stage.view();
    this.redraw();
  }

  pan(dx, dy) {
    panCamera(dx, dy);
    this.stage.view();
    this.redraw();
  }

  fit() {
    if (!this.clip) return;
    fitCamera(this.clip.box);
    this.stage.view();
    this.redraw();
  }

  resize() {
    if (!this.clip) return;
    const fitted = camera.fitted;
    this.stage.measure();
    if (fitted) fitCamera(this.clip.box);
    this.stage.view();
    for (const graph of this.graphs) graph.measure();
    this.redraw();
  }

  setTheme(dark) {
    setTheme(dark);
    this.resize();
  }

  // Draw at the next refresh of the screen.
  redraw() {
    if (this.asked) return;
    this.asked = true;
    requestAnimationFrame(now => this.frame(now));
  }

  frame(now) {
    this.asked = false;
    if (!this.clip) return;
    if (this.player.playing) this.row = this.player.tick(now);
    this.draw();
    if (this.player.playing) this.redraw();
  }

  draw() {
    this.stage.draw();
    this.stage.drawTip();
    for (const graph of this.graphs) graph.draw();
    const slider = document.getElementById("slider");
    if (slider.value !== String(this.row)) slider.value = String(this.row);
    fillReadout(this);
    fillReason(this);
    fillValues(this);
    const shown = this.posed ? null : this.row;
    if (shown !== null && this.notified !== shown) this.notify("row");
    this.notified = shown;
  }

  notify(kind) {
    for (const listener of this.listeners[kind]) listener(this.row);
  }

  message(words, kind = "info") {
    const place = document.getElementById("message");
    if (!words && kind === "error" && place.className !== "error") return;
    place.textContent = words || "";
    place.className = kind;
    place.hidden = !words;
  }

  // The value of a column that is shown: in the present row, or in a pose that is no row.
  value(column) {
    return this.posed && this.posed.values ? (this.posed.values[column.name] ?? NaN) : column.values[this.row];
  }

  // Show one pose that is not a row of the motion, with values of columns by name; null returns to the motion.
  pose(xy, { text = "", status = "ok", reason = "", values = null } = {}) {
    if (!this.clip) return;
    this.player.set(false);
    const [x, y] = this.data.origin;
    this.posed = xy === null && status === "ok" && !text ? null
      : { xy: xy && Float64Array.from(xy.flatMap(([px, py]) => [px - x, py - y])), text, status, reason, values };
    if (this.posed) this.notified = null;  // also if a row is chosen before the next refresh
    this.redraw();
  }
}

function boxSize([left, right, bottom, top]) {
  return Math.max(right - left, top - bottom) || 1;
}

function listenToControls(app) {
  const on = (id, kind, action) => document.getElementById(id).addEventListener(kind, action);
  on("slider", "input", event => {
    app.player.set(false);
    app.go(Number(event.target.value));
  });
  on("play", "click", () => app.player.set(!app.player.playing));
  on("first", "click", () => app.go(0));
  on("last", "click", () => app.go(app.clip.rows - 1));
  on("back", "click", () => app.step(-1));
  on("forth", "click", () => app.step(1));
  on("speed", "change", event => app.player.setSpeed(Number(event.target.value)));
  on("repeat", "change", event => (app.player.repeat = event.target.value));
  on("clip", "change", event => app.choose(Number(event.target.value)));
  on("nearer", "click", () => app.zoom(1.25));
  on("farther", "click", () => app.zoom(0.8));
  on("fit", "click", () => app.fit());
  on("theme", "click", () => app.setTheme(!theme.dark));
  on("keys", "click", () => document.getElementById("help").showModal());
  on("more-graphs", "click", () => {
    const graph = app.addGraph([], app.clip.axis);
    graph.chooser.open = true;
  });
  on("value-list", "toggle", () => app.redraw());
  new ResizeObserver(() => app.resize()).observe(document.getElementById("stage"));
}

// The interface for other scripts of the page, such as those of `gim view`.
function publish(app) {
  window.gim = {
    show: data => app.show(data),
    pose: (xy, options) => app.pose(xy, options),
    message: (words, kind) => app.message(words, kind),
    get data() {
      return app.data;
    },
    state: () => ({
      clip: app.clips.indexOf(app.clip), row: app.row, rows: app.clip ? app.clip.rows : 0, playing: Boolean(app.player.playing),
      speed: app.player.speed, repeat: app.player.repeat, toggles: { ...app.toggles }, theme: theme.dark ? "dark" : "light",
      status: app.clip ? app.clip.status[app.row] : null,
      graphs: app.graphs.map(graph => ({ columns: [...graph.columns], over: graph.over })),
    }),
    set: ({ clip, row, playing, speed, toggles, dark, graphs }) => {
      if (dark !== undefined) app.setTheme(dark);
      if (clip !== undefined) app.choose(clip);
      if (row !== undefined) app.go(row);
      if (speed !== undefined) app.player.setSpeed(speed);
      for (const [key, value] of Object.entries(toggles || {})) if (app.toggles[key] !== value) app.toggle(key);
      if (graphs !== undefined) app.setGraphs(graphs);
      if (playing !== undefined) app.player.set(playing);
    },
    screen: name => {
      const found = app.clip && app.scene.named.find(([own]) => own === name);
      const node = app.data ? app.scene.nodes.indexOf(name) : -1;
      if (!found && node < 0) return null;
      const box = document.getElementById("drawing").getBoundingClientRect();
      const [x, y] = app.stage.pose.set(...app.stage.positions()).place(found ? found[1] : node);
      return [box.left + x, box.top + y];
    },
    draw: () => app.draw(), // now, not at the next refresh of the screen
    addEventListener: (kind, listener) => app.listeners[kind].push(listener),
  };
}

function start() {
  const app = new App(), dark = matchMedia("(prefers-color-scheme: dark)");
  setTheme(dark.matches);
  dark.addEventListener("change", () => app.setTheme(dark.matches));
  listenToControls(app);
  listenToKeys(app);
  listenToPointer(app);
  publish(app);
  const data = JSON.parse(document.getElementById("data").textContent);
  if (data) app.show(data);
  else app.fill(false);
  const still = matchMedia("(prefers-reduced-motion: reduce)").matches;
  if (data && data.autoplay && !still && window === window.parent) app.player.set(true);
}

start();

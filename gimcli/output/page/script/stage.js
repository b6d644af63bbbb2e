// The drawing: a layer that is drawn anew only if the view changes, and over it the mechanism of the present row.

const GHOSTS = 6;
const KEYED = 12; // curves with a name in the corner
const SAMPLES = 8; // poses for which names find their sides

class Stage {
  constructor(app) {
    this.app = app;
    this.canvas = document.getElementById("drawing");
    this.context = this.canvas.getContext("2d");
    this.layer = document.createElement("canvas");
    this.paths = document.createElement("canvas"); // the whole curves, over plates and links
    this.fresh = false; // whether the layer is up to date
  }

  // Take a new scene and clip; `keep` keeps the window.
  show(keep) {
    const { scene } = this.app;
    this.pose = new Pose(scene);
    this.targets = targets(scene);
    this.target = null;
    this.measure();
    if (!keep || camera.fitted) fitCamera(this.app.clip.box);
    this.view();
  }

  // The view has changed: the layer is drawn again, and names find their sides.
  view() {
    this.fresh = false;
    const clip = this.app.clip;
    if (!clip) return;
    const each = 2 * this.app.scene.nodes.length, good = clip.solved;
    const starts = Array.from({ length: Math.min(SAMPLES, good.length) }, (_, k) => each * good[Math.floor((k * good.length) / SAMPLES)]);
    this.sides = starts.length ? nameSides(this.app.scene, this.pose, starts, clip.xy) : null;
    this.canvas.classList.toggle("near", !camera.fitted);
  }

  // Adapt to the size of the window.
  measure() {
    const box = this.canvas.getBoundingClientRect(), ratio = window.devicePixelRatio || 1;
    camera.width = Math.max(50, box.width);
    camera.height = Math.max(50, box.height);
    camera.pt = Math.min(1.7, Math.max(1.0, Math.min(camera.width, camera.height) / 400));
    for (const canvas of [this.canvas, this.layer, this.paths]) {
      canvas.width = Math.round(camera.width * ratio);
      canvas.height = Math.round(camera.height * ratio);
      canvas.getContext("2d").setTransform(ratio, 0, 0, ratio, 0, 0);
    }
    this.fresh = false;
  }

  draw() {
    const { app, context: c } = this, { clip, row, toggles } = app;
    if (!clip) return;
    if (!this.fresh) this.drawLayer();
    c.save();
    c.setTransform(1, 0, 0, 1, 0, 0);
    c.clearRect(0, 0, this.canvas.width, this.canvas.height);
    c.drawImage(this.layer, 0, 0);
    c.restore();
    const scene = app.scene, good = !app.posed && clip.good(row);
    const trails = () => {
      if (!toggles.curves) return;
      c.drawImage(this.paths, 0, 0, camera.width, camera.height);
      if (!app.posed) clip.curves.forEach((curve, k) => drawPath(c, clip, curve.path, 0, row, curvePen(k), 1));
    };
    if (app.posed ? app.posed.xy : good) this.drawPose(c, scene, good, trails);
    else {
      trails();
      drawGround(c, scene, this.pose.set(clip.ground, 0));
    }
  }

  drawPose(c, scene, good, trails) {
    const { app } = this, { clip, row, toggles } = app;
    const [xy, start] = this.positions();
    const pose = this.pose.set(xy, start);
    if (app.posed && app.posed.status !== "ok") return drawGhost(c, scene, pose);
    drawMechanism(c, scene, pose, trails);
    if (this.target) this.drawTarget(c, pose);
    if (good) {
      const orders = [0, 1].filter(order => toggles[KINDS[order]] && clip.rates[order]);
      orders.forEach((order, place) => drawVectors(c, scene, clip, row, order, pose, place));
    }
    if (toggles.names && this.sides) drawNames(c, scene, pose, this.sides);
  }

  // The present positions, and where they begin.
  positions() {
    const { app } = this;
    return app.posed && app.posed.xy ? [app.posed.xy, 0] : [app.clip.xy, 2 * app.scene.nodes.length * app.row];
  }

  drawTarget(c, pose) {
    const one = this.target;
    if (one.at !== undefined) {
      const [x, y] = pose.place(one.at);
      c.beginPath();
      c.arc(x, y, 9 * camera.pt, 0, 2 * Math.PI);
      c.setLineDash([]);
      c.lineWidth = 2;
      c.strokeStyle = theme.accent;
      c.stroke();
    } else {
      const outline = one.ends.map(anchor => pose.place(anchor));
      line(c, outline.length > 2 ? [...outline, outline[0]] : outline, 3, theme.accent);
    }
  }

  // Ghost poses, and the whole paths of all points with their names.
  drawLayer() {
    const { clip, toggles, scene } = this.app, others = clipsBeside(this.app), c = this.layer.getContext("2d"), over = this.paths.getContext("2d");
    this.fresh = true;
    for (const one of [c, over]) one.clearRect(0, 0, camera.width, camera.height);
    if (toggles.ghosts) for (const [xy, start] of this.ghosts()) drawGhost(c, scene, this.pose.set(xy, start));
    clip.curves.forEach((curve, k) => {
      const pen = curvePen(k);
      for (const other of others) drawPath(over, other, other.curves[k].path, 0, other.rows - 1, pen, 0.13);
      drawPath(over, clip, curve.path, 0, clip.rows - 1, pen, 0.4);
      if (clip.rows > 1 && k < KEYED) drawKey(over, curve.name, pen, k);
    });
  }

  // Poses at equal distances over the solved rows; of single positions those of the other clips.
  ghosts() {
    const { clip, clips, scene } = this.app, each = 2 * scene.nodes.length;
    if (clip.rows === 1) return clips.filter(other => other !== clip && other.rows === 1 && other.good(0)).map(other => [other.xy, 0]);
    const good = clip.solved;
    return Array.from({ length: Math.min(GHOSTS, good.length) }, (_, k) => [clip.xy, each * good[Math.floor((k * good.length) / GHOSTS)]]);
  }

  // Show or hide the note about the node or member that was pointed at.
  drawTip() {
    const { app } = this, tip = document.getElementById("tip"), shows = this.target && (app.posed ? app.posed.xy : app.clip.good(app.row));
    tip.hidden = !shows;
    if (!shows) return;
    const [xy, start] = this.positions();
    tip.textContent = describe(this.target, app, xy, start, app.posed ? [] : app.clip.rates);
    const width = tip.offsetWidth, height = tip.offsetHeight;
    const beside = (at, size, whole) => Math.max(2, at + 14 + size <= whole ? at + 14 : at - 14 - size);
    tip.style.left = `${beside(this.tipAt[0], width, camera.width)}px`;
    tip.style.top = `${beside(this.tipAt[1], height, camera.height)}px`;
  }

  // Point at a pixel of the drawing; the note appears there.
  point(x, y) {
    const { app } = this;
    if (!app.clip || !(app.posed ? app.posed.xy : app.clip.good(app.row))) return;
    this.tipAt = [x, y];
    const target = targetAt(this.targets, this.pose.set(...this.positions()), x, y);
    if (target !== this.target || target) app.redraw();
    this.target = target;
  }

  // Point at the next or previous node or member, for the keyboard.
  pointNext(step) {
    if (!this.app.clip || !this.targets.length) return;
    const k = this.targets.indexOf(this.target), count = this.targets.length;
    this.target = this.targets[k < 0 ? (step > 0 ? 0 : count - 1) : (k + step + count) % count];
    const pose = this.pose.set(...this.positions()), one = this.target;
    this.tipAt = one.at !== undefined ? pose.place(one.at) : pose.place(one.ends[0]);
    this.app.redraw();
  }

  pointNowhere() {
    if (this.target) this.app.redraw();
    this.target = null;
  }
}

// A pose: the pixels of all nodes and the directions of all members; anchors are placed from these.

class Pose {
  constructor(scene) {
    this.scene = scene;
    this.px = new Float64Array(scene.nodes.length);
    this.py = new Float64Array(scene.nodes.length);
    this.cos = new Float64Array(scene.carriers.length);
    this.sin = new Float64Array(scene.carriers.length);
  }

  // Take the positions [x0, y0, x1, y1, ...] that begin at `start`.
  set(xy, start) {
    for (let node = 0; node < this.px.length; node++) {
      this.px[node] = toX(xy[start + 2 * node]);
      this.py[node] = toY(xy[start + 2 * node + 1]);
    }
    this.scene.carriers.forEach(([origin, towards], member) => {
      const dx = towards < 0 ? 1 : this.px[towards] - this.px[origin];
      const dy = towards < 0 ? 0 : this.py[origin] - this.py[towards];
      const size = Math.hypot(dx, dy);
      this.cos[member] = size > 0 ? dx / size : 1;
      this.sin[member] = size > 0 ? dy / size : 0;
    });
    return this;
  }

  node(node) {
    return [this.px[node], this.py[node]];
  }

  // The pixel of an anchor: a node, or [member, x, y].
  place(anchor) {
    if (typeof anchor === "number") return this.node(anchor);
    const [member, x, y] = anchor, origin = this.scene.carriers[member][0];
    if (origin < 0) return [toX(x), toY(y)];
    const [dx, dy] = this.direction(member, x, y);
    return [this.px[origin] + camera.scale * dx, this.py[origin] + camera.scale * dy];
  }

  // A direction of a member on the screen, where y points down.
  direction(member, x, y) {
    return [this.cos[member] * x - this.sin[member] * y, -(this.sin[member] * x + this.cos[member] * y)];
  }
}

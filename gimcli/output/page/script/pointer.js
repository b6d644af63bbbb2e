// Mouse and touch on the drawing: point at nodes and members, zoom, and move the enlarged drawing.

function listenToPointer(app) {
  const canvas = document.getElementById("drawing"), down = new Map();
  const place = event => {
    const box = canvas.getBoundingClientRect();
    return [event.clientX - box.left, event.clientY - box.top];
  };
  canvas.addEventListener("wheel", event => {
    event.preventDefault();
    app.zoom(Math.exp(-Math.max(-120, Math.min(120, event.deltaY)) / 400), ...place(event));
  }, { passive: false });
  canvas.addEventListener("pointerdown", event => {
    down.set(event.pointerId, place(event));
    canvas.setPointerCapture(event.pointerId);
    app.stage.point(...place(event));
  });
  canvas.addEventListener("pointermove", event => {
    const [x, y] = place(event), before = down.get(event.pointerId);
    if (!before) return app.stage.point(x, y);
    down.set(event.pointerId, [x, y]);
    if (down.size === 1) {
      if (event.pointerType !== "touch" || !camera.fitted) app.pan(x - before[0], y - before[1]);
    } else pinch(app, [...down.entries()], event.pointerId, before);
  });
  const up = event => down.delete(event.pointerId);
  canvas.addEventListener("pointerup", up);
  canvas.addEventListener("pointercancel", up);
  canvas.addEventListener("pointerleave", () => down.size || app.stage.pointNowhere());
  canvas.addEventListener("touchmove", event => event.touches.length > 1 && event.preventDefault(), { passive: false });
  canvas.addEventListener("dblclick", () => app.fit());
}

// Two fingers: the ratio of their distances enlarges, the motion of their middle moves the drawing.
function pinch(app, fingers, moved, before) {
  const [other] = fingers.filter(([id]) => id !== moved).map(([, at]) => at), now = fingers.find(([id]) => id === moved)[1];
  const distance = at => Math.hypot(at[0] - other[0], at[1] - other[1]) || 1;
  app.zoom(distance(now) / distance(before), (now[0] + other[0]) / 2, (now[1] + other[1]) / 2);
  app.pan((now[0] - before[0]) / 2, (now[1] - before[1]) / 2);
}

// The marks over the slider: events, rows that are not solved, and breaks.

const SIGNS = { limit: "▼", "dead point": "◆", "change point": "✚", tangency: "●", stationary: "○", standstill: "■", "singular position": "◆" };

function fillMarks(app) {
  const marks = document.getElementById("marks"), { clip } = app;
  marks.textContent = "";
  const last = Math.max(1, clip.rows - 1), percent = row => `${(100 * Math.min(Math.max(row, 0), last)) / last}%`;
  for (const [from, to] of gaps(clip)) {
    const gap = marks.appendChild(create("div", "gap"));
    gap.style.left = percent(from - 0.5);
    gap.style.right = `calc(100% - ${percent(to + 0.5)})`;
  }
  for (const row of clip.breaks) marks.appendChild(create("div", "break")).style.left = percent(row - 0.5);
  for (const event of clip.events) {
    const mark = marks.appendChild(create("button", "event", SIGNS[event.kind] || "▽"));
    mark.type = "button";
    mark.style.left = percent(event.row);
    mark.title = event.text;
    mark.setAttribute("aria-label", event.text);
    mark.onclick = () => app.go(Math.round(event.row));
  }
}

// Intervals [first, last] of rows that are not solved.
function gaps(clip) {
  const found = [];
  for (let row = 0; row < clip.rows; row++) {
    if (clip.good(row)) continue;
    if (row && !clip.good(row - 1)) found[found.length - 1][1] = row;
    else found.push([row, row]);
  }
  return found;
}

// The keyboard; the list of keys is shown by "?".

const KEYS = [
  ["Space", "play or pause", app => app.player.set(!app.player.playing), [" "]],
  ["Left, Right", "one row back or forward; with Shift ten rows", null],
  ["Home, End", "first or last row", null],
  ["Page Up, Page Down", "previous or next motion of the list", null],
  ["., ,", "faster or slower", null],
  ["E", "next event", app => app.nextEvent()],
  ["I", "name, coordinates and lengths of the next node or member; with Shift of the previous one", null],
  ["N", "names", app => app.toggle("names")],
  ["C", "curves", app => app.toggle("curves")],
  ["G", "ghost poses", app => app.toggle("ghosts")],
  ["V", "velocities", app => app.toggle("velocity")],
  ["A", "accelerations", app => app.toggle("acceleration")],
  ["+, −", "enlarge or reduce", null],
  ["0", "whole drawing", app => app.fit(), ["0"]],
  ["D", "dark or light", app => app.setTheme(!theme.dark)],
  ["?", "this list", () => document.getElementById("help").showModal(), ["?"]],
  ["Esc", "close this list; hide the note", app => app.stage.pointNowhere(), ["Escape"]],
];

const MOVES = {
  ArrowLeft: (app, ten) => app.step(ten ? -10 : -1),
  ArrowRight: (app, ten) => app.step(ten ? 10 : 1),
  Home: app => app.go(0),
  End: app => app.go(app.clip.rows - 1),
  PageUp: app => app.choose(app.clips.indexOf(app.clip) - 1),
  PageDown: app => app.choose(app.clips.indexOf(app.clip) + 1),
  ".": app => app.changeSpeed(1),
  ",": app => app.changeSpeed(-1),
  "+": app => app.zoom(1.25),
  "=": app => app.zoom(1.25),
  "-": app => app.zoom(0.8),
  i: app => app.stage.pointNext(1),
  I: app => app.stage.pointNext(-1),
};

function listenToKeys(app) {
  const table = document.getElementById("key-list");
  for (const [key, words] of KEYS) {
    const row = table.insertRow();
    row.insertCell().appendChild(create("kbd", "", key));
    row.insertCell().textContent = words;
  }
  document.addEventListener("keydown", event => {
    if (event.ctrlKey || event.metaKey || event.altKey || !app.clip || document.getElementById("help").open) return;
    const own = event.target instanceof Element && event.target.closest("select, input, textarea, button, summary, a");
    if (own && takes(own, event.key)) return;
    const move = MOVES[event.key];
    if (event.key.startsWith("Page") && app.clips.length < 2) return; // these keys scroll the page
    const action = move ? () => move(app, event.shiftKey) : (KEYS.find(one => one[2] && (one[3] ? one[3].includes(event.key) : one[0].toLowerCase() === event.key.toLowerCase())) || [])[2];
    if (!action) return;
    event.preventDefault();
    action(app);
  });
}

// Whether a control uses a key itself.
function takes(control, key) {
  if (control.matches("button, summary, a")) return key === " " || key === "Enter";
  if (control.matches("select, textarea")) return key !== "?" && key !== "Escape";
  if (control.type === "range" || control.type === "checkbox") return control.type === "checkbox" ? key === " " : /^(Arrow|Home|End|Page)/.test(key) && control.id !== "slider";
  return key !== "Escape";
}

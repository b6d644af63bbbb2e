// Lists beside the drawing: clips, toggles, events, values, notes and the report. All texts are set as text.

const TOGGLES = [
  ["names", "Names", "N"], ["curves", "Curves", "C"], ["ghosts", "Ghost poses", "G"],
  ["velocity", "Velocities", "V"], ["acceleration", "Accelerations", "A"],
];

function create(kind, name = "", words = "") {
  const element = document.createElement(kind);
  if (name) element.className = name;
  element.textContent = words;
  return element;
}

function fillToggles(app) {
  const group = document.getElementById("toggles");
  group.textContent = "";
  for (const [key, words, letter] of TOGGLES) {
    const button = group.appendChild(create("button", "", words)), order = KINDS.indexOf(key);
    button.type = "button";
    button.id = `toggle-${key}`;
    const missing = order >= 0 && app.clip && !app.clip.rates[order];
    button.disabled = missing;
    button.title = missing ? app.clip.without || "not computed" : `${words} (${letter})`;
    button.setAttribute("aria-pressed", String(app.toggles[key] && !missing));
    button.onclick = () => app.toggle(key);
  }
  const why = app.clip && !app.clip.rates.length && app.clip.without;
  if (why) group.appendChild(create("span", "why", why));
}

function fillChoice(app) {
  const select = document.getElementById("clip");
  select.textContent = "";
  app.clips.forEach((clip, k) => select.appendChild(new Option(clip.name, k)));
  select.value = String(app.clips.indexOf(app.clip));
  document.getElementById("note").textContent = app.clip ? app.clip.note : "";
  document.getElementById("choice").hidden = app.clips.length < 2 && !(app.clip && app.clip.note);
  select.parentElement.hidden = app.clips.length < 2;
  document.getElementById("choice-name").textContent = app.data.choice || "Motion";
}

function fillEvents(app) {
  const list = document.getElementById("events");
  list.textContent = "";
  for (const event of app.clip.events) {
    const button = list.appendChild(document.createElement("li")).appendChild(create("button", "", `${SIGNS[event.kind] || "▽"} ${event.text}`));
    button.type = "button";
    button.onclick = () => app.go(Math.round(event.row));
  }
  document.getElementById("event-list").hidden = !app.clip.events.length;
}

function fillNotes(app) {
  const notes = document.getElementById("notes");
  notes.textContent = "";
  for (const words of app.data.notes) notes.appendChild(create("p", "", words));
}

// The values of all columns in the present row, if the list is open.
function fillValues(app) {
  if (!document.getElementById("value-list").open || !app.clip) return;
  const table = document.getElementById("values"), { columns } = app.clip;
  if (table.rows.length !== columns.length || table.dataset.clip !== app.clip.name) {
    table.textContent = "";
    table.dataset.clip = app.clip.name;
    for (const column of columns) {
      const row = table.insertRow();
      row.insertCell().textContent = labelled(column.name, column.unit);
      row.insertCell().className = "number";
    }
  }
  columns.forEach((column, k) => (table.rows[k].cells[1].textContent = shown(app.value(column))));
}

function fillReadout(app) {
  const { clip, row } = app, words = [];
  const value = name => clip.columns.find(column => column.name === name);
  if (clip.rows > 1) words.push(`row ${row + 1} of ${clip.rows}`);
  for (const name of new Set([clip.axis, ...app.data.inputs])) {
    const column = value(name);
    if (column) words.push(quantity(name, column.values[row], column.unit));
  }
  if (app.posed) words.splice(0, words.length, app.posed.text || "");
  document.getElementById("readout").textContent = words.join(" · ");
}

// Why there is no position at the present row.
function fillReason(app) {
  const { clip, row } = app, reason = document.getElementById("reason");
  let words = "";
  if (app.posed) words = app.posed.status === "ok" ? "" : `${app.posed.status}: ${app.posed.reason || app.data.reasons[app.posed.status] || ""}`;
  else if (clip && !clip.good(row)) words = `Not solved (${clip.status[row]}): ${app.data.reasons[clip.status[row]] || "no position"}`;
  if (reason.textContent !== words) reason.textContent = words;
  reason.hidden = !words;
}

function fillReport(app) {
  const report = document.getElementById("report");
  report.textContent = "";
  report.hidden = !app.data.report.length;
  document.body.classList.toggle("reported", !report.hidden);
  for (const part of app.data.report) {
    const section = report.appendChild(create("section", part.warning ? "warning" : ""));
    section.appendChild(create("h2", "", part.heading));
    for (const words of part.lines) section.appendChild(create("p", "", words));
    if (part.table) section.appendChild(create("div", "table")).appendChild(reportTable(part.table));
  }
}

function reportTable({ head, rows }) {
  const table = document.createElement("table"), first = table.createTHead().insertRow();
  head.forEach(words => first.appendChild(create("th", "", words)));
  const body = table.createTBody();
  for (const row of rows) {
    const line = body.insertRow();
    for (const words of row) line.insertCell().textContent = words;
  }
  return table;
}

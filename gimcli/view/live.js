"use strict";
// The live view: sliders for inputs and parameters, and the motion and the errors of the file as they change.
(() => {
  const section = document.getElementById("live");
  const name = Array.from(crypto.getRandomValues(new Uint32Array(2)), String).join("-");  // of this page, for /solve
  let columns = {clip: null};  // the inputs of the present clip by name, one value for each row
  let server = "";  // the run of the server
  let motion = 0;  // number of the motion that is shown
  let loading = 0;  // number of the motion that has been asked for
  let rows = [];  // one for each input: name, value, slider, number field
  let parameters = [];  // the same for each parameter, and its value in the file
  let errors = [];  // of the file
  let byHand = false;  // whether a position set by hand is shown, not a row of the motion
  let kept = null;  // the inputs set by hand, while the next motion is loaded
  let wanted = null;  // the inputs to solve next
  let asking = false;  // whether a request is on its way
  let changes = null;  // the parameters to set next
  let setting = false;  // whether they are on their way

  // -- events of the server --------------------------------------------------------------

  function listen() {
    const source = new EventSource("events");
    source.onmessage = (event) => changed(JSON.parse(event.data));
    source.onerror = () => {
      gim.message("No connection to gim view. Start it again, or close this page.", "error");
      if (source.readyState === EventSource.CLOSED) setTimeout(listen, 2000);
    };
  }

  async function changed(event) {
    if (server && event.server !== server) location.reload();  // the server was started again
    server = event.server;
    if (event.motion && event.motion !== motion) await load(event.motion);
    errors = event.errors;
    report("");
  }

  // Show the errors of the file, and that of the last request.
  function report(text) {
    document.body.classList.toggle("stale", errors.length > 0);
    const lines = text ? [...errors, text] : errors;
    gim.message(lines.length ? lines.join("\n") : null, "error");
  }

  async function load(number) {
    if (loading === number) return;
    loading = number;
    try {
      const answer = await (await fetch("data")).json();
      if (answer.motion === motion || answer.data === null) return;
      if (byHand) kept = inputs();
      leave();
      motion = loading = answer.motion;
      gim.show(answer.data);
      gim.draw();  // now: the event of the row must not come after the inputs are set by hand again
      const found = await (await fetch("inputs")).json();
      if (found.motion === motion) build(found);
    } catch {
      loading = 0;  // the connection is lost: the next event loads the data again
    }
  }

  // -- sliders ---------------------------------------------------------------------------

  // Make the sliders, and set the inputs that were set by hand in the motion before.
  function build(found) {
    const focus = document.activeElement && document.activeElement.id;
    columns = {clip: null};
    if (same(rows, found.inputs) && same(parameters, found.parameters)) {  // one of them may be dragged just now
      [...rows, ...parameters].forEach((row, k) => fit(row, [...found.inputs, ...found.parameters][k]));
    } else {
      rows = found.inputs.map((input, number) => makeRow(input, `input-${number}`, ask, settle));
      parameters = found.parameters.map((one, number) => makeRow(one, `parameter-${number}`, change));
      const own = parameters.length ? [...parameters.map((row) => row.element), resetButton] : [];
      section.replaceChildren(...rows.map((row) => row.element), reason, backButton, ...own);
    }
    section.hidden = !(rows.length || parameters.length);
    const held = section.querySelector("input:active, input[type=number]:focus");  // keeps what the user does
    if (!setting) found.parameters.forEach((one, k) => write(parameters[k], one.value, held));
    resetButton.disabled = parameters.every((row) => row.value === row.given);
    if (!byHand) follow();
    if (focus && section.querySelector(`#${CSS.escape(focus)}`)) document.getElementById(focus).focus();
    if (kept && rows.every((row) => row.name in kept)) {
      set(kept);
      ask();
    }
    kept = null;
  }

  const same = (some, found) => some.length === found.length && some.every((row, k) => row.name === found[k].name);

  // Give a slider its range.
  function fit(row, input) {
    const low = input.step * Math.floor(input.low / input.step + 1e-9);
    row.step = input.step;
    row.given = input.given;
    Object.assign(row.slider, {min: low, max: Math.max(input.high, low), step: input.step});
    write(row, row.value, row.slider);
  }

  // Make a row; `moved` is called with it for every value, `done` at the end of a drag.
  function makeRow(input, id, moved, done) {
    const element = document.createElement("div"), label = document.createElement("label");
    const slider = document.createElement("input"), field = document.createElement("input");
    const value = document.createElement("span");
    element.className = "live-row";
    label.textContent = input.name;
    label.htmlFor = slider.id = id;
    field.id = `${id}-value`;
    slider.type = "range";
    field.type = "number";
    field.setAttribute("aria-label", `${input.name}, value`);
    value.className = "value";
    field.step = "any";
    const row = {name: input.name, element, slider, field, value: input.value};
    fit(row, input);
    write(row, input.value);
    slider.addEventListener("input", () => { write(row, Number(slider.value), slider); moved(row); });
    field.addEventListener("change", () => {
      if (field.value === "" || !field.validity.valid) { write(row, row.value); return; }
      write(row, Number(field.value), field);
      moved(row);
    });
    if (done) slider.addEventListener("change", done);
    value.append(field, input.unit);
    element.append(label, slider, value);
    return row;
  }

  const backButton = document.createElement("button");
  backButton.type = "button";
  backButton.textContent = "Back to the motion";
  backButton.addEventListener("click", leave);

  const resetButton = document.createElement("button");
  resetButton.type = "button";
  resetButton.textContent = "Parameters of the file";
  resetButton.addEventListener("click", () => {
    for (const row of parameters) write(row, row.given);
    change(...parameters);
  });

  const reason = document.createElement("p");  // why the inputs were not reached
  reason.className = "reason";
  reason.setAttribute("role", "status");

  // Beside the drawing where there is room, otherwise below the time bar.
  const wide = matchMedia("(min-width: 1000px)");
  function place() {
    if (wide.matches) document.querySelector("aside").prepend(section);
    else document.getElementById("toggles").before(section);
  }
  wide.addEventListener("change", place);
  place();

  // Set the value of an input; `source` is the control that it comes from and that stays as it is.
  function write(row, value, source) {
    row.value = value;
    if (row.slider !== source) {
      row.slider.min = Math.min(row.slider.min, row.step * Math.floor(value / row.step));
      row.slider.max = Math.max(row.slider.max, value);
      row.slider.value = value;
    }
    if (row.field !== source) row.field.value = Number(value.toPrecision(7));
  }

  const inputs = () => Object.fromEntries(rows.map((row) => [row.name, row.value]));
  const set = (values) => rows.forEach((row) => { if (row.name in values) write(row, values[row.name]); });

  // -- positions by hand -----------------------------------------------------------------

  let start = null;  // the time in the motion from which the motion by hand begins; null: it continues
  let settled = null;  // the inputs of the last position

  function ask() {
    wanted = inputs();
    if (!byHand) {
      start = timeOfRow();
      byHand = true;
      gim.set({playing: false});
      backButton.disabled = false;
    }
    if (!asking) send();
  }

  // At most one request is on its way; when it is answered, the latest inputs are sent.
  async function send() {
    asking = true;
    while (wanted) pose(await solved());
    asking = false;
    if (!section.querySelector(":active")) settle();
  }

  async function solved() {
    const sent = {page: name, motion, inputs: wanted};
    if (start !== null) sent.time = start;
    wanted = start = null;
    try {
      const answer = await fetch("solve", {
        method: "POST", headers: {"Content-Type": "application/json"}, body: JSON.stringify(sent),
      });
      report(answer.ok || answer.status === 409 ? "" : await answer.text());  // 409: a new motion is on its way
      return answer.ok ? await answer.json() : null;
    } catch {
      return null;  // the connection is lost: the stream of events reports it
    }
  }

  function pose(found) {
    if (!found || found.motion !== motion || !byHand) return;
    settled = found.inputs;
    reason.textContent = found.reason;
    gim.pose(found.nodes, {text: found.text, values: found.values});
  }

  // Where the inputs could not be reached, show those of the position.
  function settle() {
    if (byHand && settled && !asking) set(settled);
  }

  // -- parameters ------------------------------------------------------------------------

  function change(...some) {
    changes = {...changes, ...Object.fromEntries(some.map((row) => [row.name, row.value]))};
    resetButton.disabled = parameters.every((one) => one.value === one.given);
    if (!setting) sendChanges();
  }

  // At most one request is on its way; the new motion is an event, as for a saved file.
  async function sendChanges() {
    setting = true;
    while (changes) {
      const sent = {parameters: changes};
      changes = null;
      try {
        const answer = await fetch("set", {
          method: "POST", headers: {"Content-Type": "application/json"}, body: JSON.stringify(sent),
        });
        if (!answer.ok) report(await answer.text());
      } catch {
        changes = null;  // the connection is lost: the stream of events reports it
      }
    }
    setting = false;
  }

  // -- rows of the motion ----------------------------------------------------------------

  function leave() {
    if (byHand) gim.pose(null);
    byHand = false;
    wanted = start = settled = null;
    reason.textContent = "";
    backButton.disabled = true;
    follow();
  }

  const clip = () => gim.data.clips[gim.state().clip];

  function floats(text) {
    const bytes = Uint8Array.from(atob(text), (sign) => sign.charCodeAt(0));
    return new Float32Array(bytes.buffer);
  }

  function timeOfRow() {
    return floats(clip().time)[gim.state().row];
  }

  // Show the inputs of the present row.
  function follow() {
    if (!gim.data) return;
    const now = clip();
    if (columns.clip !== now) {
      columns = {clip: now};
      for (const column of now.columns) {
        if (rows.some((row) => row.name === column.name)) columns[column.name] = floats(column.values);
      }
    }
    for (const row of rows) {
      const value = (columns[row.name] || [])[gim.state().row];
      if (Number.isFinite(value)) write(row, value);
    }
  }

  for (const kind of ["row", "clip"]) gim.addEventListener(kind, () => { if (byHand) leave(); else follow(); });
  listen();
})();

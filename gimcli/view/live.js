"use strict";
// The live view: sliders for the inputs, and the motion and the errors of the file as they change.
(() => {
  const section = document.getElementById("live");
  const name = Array.from(crypto.getRandomValues(new Uint32Array(2)), String).join("-");  // of this page, for /solve
  let columns = {clip: null};  // the inputs of the present clip by name, one value for each row
  let server = "";  // the run of the server
  let motion = 0;  // number of the motion that is shown
  let loading = 0;  // number of the motion that has been asked for
  let rows = [];  // one for each input: name, value, slider, number field
  let errors = [];  // of the file
  let byHand = false;  // whether a position set by hand is shown, not a row of the motion
  let wanted = null;  // the inputs to solve next
  let asking = false;  // whether a request is on its way

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
      const before = byHand ? inputs() : null;
      leave();
      motion = loading = answer.motion;
      gim.show(answer.data);
      const found = await (await fetch("inputs")).json();
      if (found.motion === motion) build(found.inputs, before);
    } catch {
      loading = 0;  // the connection is lost: the next event loads the data again
    }
  }

  // -- sliders ---------------------------------------------------------------------------

  // Make the sliders; `before` are the values that were set by hand in the motion before.
  function build(found, before) {
    const focus = document.activeElement && document.activeElement.id;
    rows = found.map(makeRow);
    columns = {clip: null};
    section.replaceChildren(...rows.map((row) => row.element), reason, backButton);
    section.hidden = !rows.length;
    follow();
    if (focus && section.querySelector(`#${CSS.escape(focus)}`)) document.getElementById(focus).focus();
    if (before && rows.every((row) => row.name in before)) {
      set(before);
      ask();
    }
  }

  function makeRow(input, number) {
    const element = document.createElement("div"), label = document.createElement("label");
    const slider = document.createElement("input"), field = document.createElement("input");
    const value = document.createElement("span");
    element.className = "live-row";
    label.textContent = input.name;
    label.htmlFor = slider.id = `input-${number}`;
    field.id = `value-${number}`;
    slider.type = "range";
    field.type = "number";
    field.setAttribute("aria-label", `${input.name}, value`);
    value.className = "value";
    const low = input.step * Math.floor(input.low / input.step + 1e-9);
    Object.assign(slider, {min: low, max: input.high, step: input.step, value: input.value});
    Object.assign(field, {step: "any", value: input.value});
    const row = {name: input.name, element, slider, field, value: input.value, step: input.step};
    slider.addEventListener("input", () => { write(row, Number(slider.value), slider); ask(); });
    field.addEventListener("change", () => {
      if (field.value === "" || !field.validity.valid) { write(row, row.value); return; }
      write(row, Number(field.value), field);
      ask();
    });
    slider.addEventListener("change", settle);
    value.append(field, input.unit);
    element.append(label, slider, value);
    return row;
  }

  const backButton = document.createElement("button");
  backButton.type = "button";
  backButton.textContent = "Back to the motion";
  backButton.addEventListener("click", leave);

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
    gim.pose(found.nodes, {text: found.text});
  }

  // Where the inputs could not be reached, show those of the position.
  function settle() {
    if (byHand && settled && !asking) set(settled);
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

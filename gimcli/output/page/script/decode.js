// The data of the page: arrays of numbers are base64 texts of little-endian float32; NaN is a gap.

function floats(text) {
  const raw = atob(text), bytes = new Uint8Array(raw.length);
  for (let k = 0; k < raw.length; k++) bytes[k] = raw.charCodeAt(k);
  return new Float32Array(bytes.buffer);
}

function decodeClip(clip) {
  const status = clip.status.flatMap(([word, count]) => new Array(count).fill(word));
  return {
    ...clip, status,
    time: floats(clip.time), xy: floats(clip.positions),
    columns: clip.columns.map(column => ({ ...column, values: floats(column.values) })),
    rates: (clip.rates || []).map(floats),
    breaks: new Set(clip.breaks),
    good: row => status[row] === "ok",
  };
}

// Whether a row continues the row before: both are solved, and there is no jump or other branch between them.
function continues(clip, row) {
  return row > 0 && clip.good(row) && clip.good(row - 1) && !clip.breaks.has(row);
}

// A number with at most six digits, as the table has it.
function shown(value) {
  return Number.isFinite(value) ? String(Number(value.toPrecision(6))) : "no value";
}

// A coordinate or length of the drawing, to 1e-6 of its size: positions are float32.
function shownLength(value, size) {
  const step = 10 ** (Math.floor(Math.log10(size)) - 6);
  return shown(Math.round(value / step) * step);
}

function labelled(name, unit) {
  return unit ? `${name} [${raised(unit)}]` : name;
}

function quantity(name, value, unit) {
  return `${name} = ${shown(value)}${unit && Number.isFinite(value) ? " " + raised(unit) : ""}`;
}

// A unit with raised exponents.
function raised(unit) {
  return unit.replace(/\^2/g, "²").replace(/\^3/g, "³");
}

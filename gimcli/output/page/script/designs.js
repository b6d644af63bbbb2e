// One slider for each dimension of a family of designs; together they choose a clip.

function fillDesigns(app) {
  const section = document.getElementById("designs"), { sliders } = app.data;
  section.hidden = !sliders.length;
  if (!sliders.length) return;
  document.getElementById("choice").hidden = !app.clip.note;
  document.getElementById("clip").parentElement.hidden = true;
  if (section.children.length !== sliders.length) section.replaceChildren(...sliders.map((slider, k) => designRow(app, slider, k)));
  placesOf(sliders, app.clips.indexOf(app.clip)).forEach((at, k) => {
    const [label, input] = section.children[k].children;
    const { name, unit, values } = sliders[k], text = `${name} = ${values[at]}${unit && ` ${unit}`}`;
    label.textContent = text;
    input.value = String(at);
    input.setAttribute("aria-valuetext", text);
  });
}

// The place of each slider for the number of a clip: the last slider changes first.
function placesOf(sliders, number) {
  const places = [];
  for (let k = sliders.length - 1; k >= 0; k--) {
    const count = sliders[k].values.length;
    places.unshift(number % count);
    number = Math.floor(number / count);
  }
  return places;
}

// The other clips whose curves are drawn light: of a family, the designs that differ in one dimension.
function clipsBeside({ clip, clips, data: { sliders } }) {
  const own = placesOf(sliders, clips.indexOf(clip));
  const differences = number => placesOf(sliders, number).filter((at, k) => at !== own[k]).length;
  return clips.filter((other, number) => other !== clip && (!sliders.length || differences(number) === 1));
}

function designRow(app, slider, k) {
  const row = create("div", "design-row"), label = row.appendChild(create("label"));
  const input = row.appendChild(create("input"));
  input.type = "range";
  input.id = `design-${k}`;
  label.htmlFor = input.id;
  input.min = "0";
  input.max = String(slider.values.length - 1);
  input.step = "1";
  input.disabled = slider.values.length < 2;
  input.addEventListener("input", () => app.choose(chosenDesign(app.data.sliders)));
  return row;
}

// The number of the clip at the present sliders.
function chosenDesign(sliders) {
  return sliders.reduce((number, { values }, k) => number * values.length + Number(document.getElementById(`design-${k}`).value), 0);
}

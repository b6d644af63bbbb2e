// The mechanism at one pose, drawn in the order of output/pose.py; the scene is that of output/scene.py.

// `trails` draws the curves, over plates and links, below blocks and pins.
function drawMechanism(c, scene, pose, trails) {
  const upper = scene.bodies.filter(body => body.above);
  for (const body of scene.bodies) if (body.kind === "plate") drawBody(c, body, pose);
  if (scene.gears) drawGears(c, scene.gears, pose);
  for (const body of scene.bodies) if (body.kind !== "plate" && !body.above) drawBody(c, body, pose);
  trails();
  for (const slider of scene.sliders) drawGuide(c, slider, pose);
  for (const support of scene.supports) fixedPivot(c, pose.node(support.node), support.upward);
  for (const element of scene.elements) drawElement(c, element, pose);
  for (const drive of scene.drives) if (drive.kind === "cylinder") cylinder(c, pose.node(drive.nodes[0]), pose.node(drive.nodes[1]));
  for (const slider of scene.sliders) drawBlock(c, slider, pose);
  for (const body of upper) drawBody(c, body, pose);
  for (const drive of scene.drives) drawDrive(c, drive, pose);
  for (const node of scene.pins) disc(c, pose.node(node), 6, theme.paper);
  for (const node of scene.plain) disc(c, pose.node(node), 3.2, theme.ink, theme.ink, 0.5);
  for (const node of scene.crosses) cross(c, pose.node(node));
  for (const tracer of scene.tracers) diamond(c, pose.place(tracer.at), 4.6, theme.ink);
  for (const at of scene.centres) centreOfMass(c, pose.place(at));
  for (const load of scene.loads) drawLoad(c, load, pose);
}

// Only what does not move: shown where a row is not solved.
function drawGround(c, scene, pose) {
  for (const support of scene.supports) {
    fixedPivot(c, pose.node(support.node), support.upward);
    disc(c, pose.node(support.node), 6, theme.paper);
  }
  for (const slider of scene.sliders) if (slider.side) drawGuide(c, slider, pose);
  for (const node of scene.crosses) cross(c, pose.node(node));
}

function drawGhost(c, scene, pose) {
  for (const body of scene.bodies) {
    const outline = body.outline.map(anchor => pose.place(anchor));
    if (body.kind === "plate") area(c, outline, null, theme.soft, 0.8);
    else line(c, outline, 0.8, theme.soft);
  }
  if (scene.gears) drawLightGears(c, scene, pose);
  for (const drive of scene.drives)
    if (drive.kind === "cylinder") line(c, drive.nodes.map(node => pose.node(node)), 0.8, theme.soft);
  for (const slider of scene.sliders) drawBlock(c, slider, pose, null, theme.soft, 0.8);
}

function drawBody(c, body, pose, colour = theme.ink) {
  const outline = body.outline.map(anchor => pose.place(anchor));
  if (body.kind === "plate") area(c, outline, theme.plate, colour, 1.4, 0.75);
  else {
    c.lineCap = "round";
    line(c, outline, body.kind === "beam" ? 3.4 : 2.2, colour);
    c.lineCap = "butt";
  }
}

function sliderDirection(slider, pose) {
  const member = typeof slider.line === "number" ? 0 : slider.line[0];
  return pose.direction(member, ...slider.along);
}

function drawGuide(c, slider, pose) {
  const along = sliderDirection(slider, pose), at = pose.place(slider.line);
  const [first, second] = slider.travel.map(travel => plus(at, along, travel * camera.scale));
  if (slider.side) frameGuide(c, first, second, along, [slider.side[0], -slider.side[1]]);
  else {
    movingGuide(c, first, second, along);
    if (slider.bracket.length) line(c, slider.bracket.map(anchor => pose.place(anchor)), 2.2);
  }
}

function drawBlock(c, slider, pose, face = theme.paper, edge = theme.ink, width = 1.3) {
  const along = sliderDirection(slider, pose);
  const ends = slider.nodes.map(node => pose.node(node)).sort((a, b) => (a[0] - b[0]) * along[0] + (a[1] - b[1]) * along[1]);
  block(c, ends[0], ends[ends.length - 1], along, face, edge, width);
}

function drawElement(c, element, pose) {
  const [first, second] = element.ends.map(anchor => pose.place(anchor)), helical = element.kind === "spring";
  if (element.pivot < 0) (helical ? spring : damper)(c, first, second, element.lane);
  else (helical ? torsionSpring : torsionDamper)(c, pose.node(element.pivot), first, second, element.lane);
}

function drawDrive(c, drive, pose) {
  const at = pose.node(drive.nodes[0]);
  if (drive.kind === "travel") {
    const along = pose.direction(drive.guide, ...drive.direction), aside = left(along);
    travelArrow(c, at, along, drive.aside < 0 ? [-aside[0], -aside[1]] : aside, drive.sense);
  } else if (drive.kind === "turn") turningArrow(c, at, Math.atan2(drive.direction[1], drive.direction[0]), drive.sense);
}

function drawLoad(c, load, pose) {
  const at = pose.place(load.at), size = Math.hypot(...load.force);
  if (load.torque) torqueArrow(c, at, load.torque);
  else if (size) {
    const along = [load.force[0] / size, load.force[1] / size];
    const turned = load.follower && Array.isArray(load.at) ? pose.direction(load.at[0], ...along) : [along[0], -along[1]];
    forceArrow(c, at, turned, size);
  }
}

// Velocity and acceleration vectors at the moving nodes and points, each kind with its own scale.

const KINDS = ["velocity", "acceleration"];

// The magnitude that 95 % of the vectors of a clip do not exceed.
function usual(scene, clip, order) {
  const rates = clip.rates[order], sizes = [];
  for (let k = 0; k < rates.length; k += 2) {
    const size = Math.hypot(rates[k], rates[k + 1]);
    if (size > 0) sizes.push(size);
  }
  sizes.sort((a, b) => a - b);
  return sizes.length ? sizes[Math.floor(0.95 * (sizes.length - 1))] : 0;
}

function movingAnchors(scene) {
  const fixed = new Set(scene.fixed);
  const nodes = scene.nodes.map((_, node) => node).filter(node => !fixed.has(node));
  return [...nodes, ...scene.tracers.map(tracer => tracer.at)];
}

function roundBelow(value) {
  const decade = 10 ** Math.floor(Math.log10(value));
  return decade * [5, 2, 1].find(times => times * decade <= value * (1 + 1e-9));
}

// The arrows of one kind, and the bar that shows their scale in line `place` from the bottom.
function drawVectors(c, scene, clip, row, order, pose, place) {
  const long = clip.usual[order], start = 2 * scene.nodes.length * row;
  if (!(long > 0)) return;
  const scale = (clip.longest * camera.whole) / long; // as long as in pictures where the whole drawing is shown
  const colour = order ? theme.second : theme.first, face = order ? theme.paper : colour, { short, greatest } = clip.arrows;
  const vectors = [];
  for (const anchor of clip.moving) {
    const [vx, vy] = anchorRate(scene, clip.xy, clip.rates[order], start, anchor);
    const length = scale * Math.hypot(vx, vy), at = pose.place(anchor);
    if (!(length > 1)) continue;
    const tip = [at[0] + scale * vx, at[1] - scale * vy];
    vectors.push([at, tip, length < short * camera.pt ? 0 : Math.min(greatest, length / camera.pt)]);
  }
  const value = roundBelow(long), y = camera.height - 14 - 20 * place, end = 14 + scale * value;
  arrows(c, [...vectors, [[14, y], [end, y], greatest]], clip.arrows, clip.arrows.pens[order], colour, face);
  text(c, `${KINDS[order]} ${shown(value)} ${raised(clip.rateUnits[order])}`, end + 8, y);
}

// Colours of the drawing, read from the style sheet, and the pens of curves (output/style.py has the pens of pictures).

const theme = { dark: false };
const CURVE_COLOURS = {
  light: ["#a50f15", "#20508c", "#20713a", "#6a3d9a", "#b35806", "#01665e", "#7a0177", "#4d4d4d"],
  dark: ["#ff8a80", "#82b1ff", "#7fdc9a", "#cfa8ff", "#ffb86b", "#66d9cc", "#f78fe0", "#d0d0d0"],
};
const DASHES = [[], [7, 3], [2, 2.5], [10, 3, 2, 3], [14, 4], [4, 2, 1.5, 2, 1.5, 2]];

function readTheme() {
  const style = getComputedStyle(document.documentElement);
  for (const name of ["paper", "panel", "ink", "soft", "faint", "line", "plate", "cylinder", "accent", "load", "first", "second"])
    theme[name] = style.getPropertyValue("--" + name).trim();
}

function setTheme(dark) {
  theme.dark = dark;
  document.documentElement.dataset.theme = dark ? "dark" : "light";
  document.getElementById("theme").textContent = dark ? "Light" : "Dark";
  readTheme();
}

function curvePen(index) {
  const colours = theme.dark ? CURVE_COLOURS.dark : CURVE_COLOURS.light;
  return { colour: colours[index % colours.length], dash: DASHES[index % DASHES.length], width: index % 2 ? 1.6 : 2.2 };
}

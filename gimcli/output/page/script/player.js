// Playback in real time: each solved row is shown for the time to the next; a gap is shown for a moment.

const PAUSE = 0.6; // s, for a gap and between two branches
const SPEEDS = [0.001, 0.002, 0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.25, 0.5, 1, 2, 5, 10];

class Player {
  constructor(app) {
    this.app = app;
    this.playing = false;
    this.speed = 1;
    this.repeat = "loop";
    this.ahead = 1; // -1 on the return of a motion to and fro
  }

  // Plan the rows to show and when [s].
  plan() {
    const { clip } = this.app;
    this.rows = [];
    this.times = [0];
    for (let row = 0; row < clip.rows; row++) {
      if (!clip.good(row) && row && !clip.good(row - 1)) continue;
      const pauses = !clip.good(row) || !(row + 1 < clip.rows && continues(clip, row + 1));
      const next = row + 1 < clip.rows && clip.good(row) && clip.good(row + 1) ? clip.time[row + 1] - clip.time[row] : 0;
      this.rows.push(row);
      this.times.push(this.times[this.times.length - 1] + (pauses ? (row + 1 < clip.rows ? PAUSE : 0) : next / this.speed));
    }
    this.whole = this.times[this.times.length - 1];
  }

  // Choose a speed at which a clip lasts some seconds.
  adapt() {
    const { clip } = this.app, lasts = clip.rows > 1 ? clip.time[clip.rows - 1] - clip.time[0] : 0;
    this.speed = SPEEDS.slice().reverse().find(speed => lasts / speed >= 2.5) || SPEEDS[0];
    if (lasts >= 2.5 && lasts <= 30) this.speed = 1;
    this.repeat = clip.closed || clip.forward ? "loop" : "swing";
  }

  set(playing) {
    this.playing = playing && this.app.clip && this.app.clip.rows > 1;
    if (this.playing) {
      this.plan();
      this.ahead = 1;
      this.at = this.timeOf(this.app.row);
      if (this.at >= this.whole && this.repeat !== "swing") this.at = 0;
      this.before = null;
      this.app.redraw();
    }
    const button = document.getElementById("play");
    button.textContent = this.playing ? "Pause" : "Play";
    button.setAttribute("aria-pressed", String(Boolean(this.playing)));
  }

  timeOf(row) {
    let k = this.rows.findIndex(one => one >= row);
    if (k < 0) k = this.rows.length - 1;
    return this.times[k];
  }

  // The row to show at a time of the screen [ms].
  tick(now) {
    if (this.before !== null) this.at += (this.ahead * Math.min(now - this.before, 250)) / 1000;
    this.before = now;
    if (this.at > this.whole || this.at < 0) this.turn();
    let low = 0, high = this.rows.length - 1;
    while (low < high) {
      const middle = (low + high + 1) >> 1;
      if (this.times[middle] <= this.at) low = middle;
      else high = middle - 1;
    }
    return this.rows[low];
  }

  turn() {
    if (this.repeat === "once") {
      this.at = this.whole;
      this.set(false);
    } else if (this.repeat === "swing") {
      this.ahead = this.at < 0 ? 1 : -1;
      this.at = Math.min(this.whole, Math.max(0, this.at < 0 ? -this.at : 2 * this.whole - this.at));
    } else this.at = this.whole > 0 ? this.at % this.whole : 0;
  }

  setSpeed(speed) {
    this.speed = Math.min(10, Math.max(0.001, speed));
    if (this.playing) this.set(true);
  }
}

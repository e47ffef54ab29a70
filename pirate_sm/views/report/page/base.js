// What all parts share: the data, the time that is shown, the part of the run that is visible.

const data = JSON.parse(document.getElementById('data').textContent);
const byId = (id) => document.getElementById(id);

const summed = (steps, scale) => {
  const out = new Float64Array(steps.length);
  let sum = 0;
  steps.forEach((step, i) => { sum += step; out[i] = sum / scale; });
  return out;
};
let clocks = data.clocks.map((steps) => summed(steps, 1000));

/** Index of the last entry that is not later; -1 before the first. */
const indexAt = (times, at) => {
  let low = 0, high = times.length;
  while (low < high) {
    const middle = (low + high) >> 1;
    if (times[middle] <= at) low = middle + 1; else high = middle;
  }
  return low - 1;
};

/** What a curve shows at a moment; null where that is unknown. */
const valueAt = (series, at) => {
  const times = clocks[series.clock], values = series.values, i = indexAt(times, at);
  if (i < 0) return null;
  const one = values[i], other = values[i + 1];
  if (series.stepped || one === null || other === null || other === undefined) return one;
  return one + (other - one) * (at - times[i]) / (times[i + 1] - times[i]);
};

/** How long before a moment the curve was last measured, s. */
const ageAt = (series, at) => {
  const i = indexAt(clocks[series.clock], at);
  return i < 0 ? NaN : at - clocks[series.clock][i];
};

/** The span of a lane that holds at a moment; of two that touch, the later one. */
const spanAt = (lane, at) => {
  for (let i = lane.spans.length - 1; i >= 0; i--) {
    const [start, end] = lane.spans[i];
    if (start <= at && (at < end || (at === end && i === lane.spans.length - 1))) return lane.spans[i];
  }
  return null;
};

const laneOf = (name) => data.lanes.find((lane) => lane.name === name);

const timeText = (at) => {
  if (data.duration < 120) return `${at.toFixed(2)} s`;
  const minutes = Math.floor(at / 60);
  return `${minutes}:${(at - 60 * minutes).toFixed(1).padStart(4, '0')}`;
};

/** Steps between the marks of an axis of times that a person counts in, s. */
const STEPS = [0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 30, 60, 120, 300, 600, 1200, 1800, 3600, 7200, 21600];

/** A moment as an axis has it. */
const ticked = (at) => (data.duration < 120 ? `${+at.toFixed(3)}` : timeText(at).replace(/\.0$/, ''));

const colour = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();

const shown = {
  at: data.opens,
  from: 0,
  to: data.duration || 1,
  listeners: { data: [], time: [], range: [], look: [], size: [] },
  on(what, listener) { this.listeners[what].push(listener); },
  tell(what) { this.listeners[what].forEach((listener) => listener()); },
  /** The data have changed: the run has gone on, and what showed all of it still does. */
  grow(wasWhole) {
    clocks = data.clocks.map((steps) => summed(steps, 1000));
    if (wasWhole) this.to = data.duration || 1;
    this.tell('data');
    this.tell('time');
  },
  /** This moment is shown everywhere. */
  goTo(at) {
    const wanted = Math.min(Math.max(at, 0), data.duration);
    if (wanted === this.at) return;
    this.at = wanted;
    this.tell('time');
  },
  /** This part of the run is visible everywhere; a part too small to see anything in is not. */
  zoom(from, to) {
    const low = Math.max(0, Math.min(from, to)), high = Math.min(data.duration, Math.max(from, to));
    if (high - low < 0.02) return;
    this.from = low;
    this.to = high;
    if (this.at < low || this.at > high) this.goTo(low);
    this.tell('range');
  },
  whole() { this.zoom(0, data.duration); },
  /** The visible part is this many times as long, with the moment where it was. */
  stretch(factor) {
    const around = Math.min(this.to, Math.max(this.from, this.at));
    this.zoom(around - (around - this.from) * factor, around + (this.to - around) * factor);
  },
  get isWhole() { return this.from <= 0 && this.to >= data.duration; },
};

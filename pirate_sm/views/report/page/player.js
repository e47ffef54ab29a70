// The slider, and everything else that moves the time.

const player = { playing: false, following: false };

const startPlayer = () => {
  const slider = byId('slider'), play = byId('play'), clock = byId('clock'), speed = byId('speed');
  const whole = byId('whole');
  const calm = matchMedia('(prefers-reduced-motion: reduce)'), APART_MS = 1000;
  let before = 0;

  const phase = () => {
    const lane = laneOf('phase'), span = lane && spanAt(lane, shown.at);
    return span ? span[2] : '';
  };
  const show = () => {
    slider.value = shown.at;
    clock.textContent = timeText(shown.at);
    byId('moment').textContent = ` (${timeText(shown.at)})`;
    slider.setAttribute('aria-valuetext', `${timeText(shown.at)}${phase() ? `, ${phase()}` : ''}`);
  };
  const toggle = (wanted) => {
    player.playing = wanted;
    play.textContent = wanted ? 'Pause' : 'Play';
    play.setAttribute('aria-pressed', String(wanted));
    if (!wanted) return;
    if (shown.at >= data.duration) shown.goTo(0);
    before = performance.now();
    requestAnimationFrame(go);
  };
  const go = (now) => {
    if (!player.playing) return;
    // Where a reader asks for less motion, one picture follows another, and nothing glides.
    if (calm.matches && now - before < APART_MS) { requestAnimationFrame(go); return; }
    const next = shown.at + Math.max(0, now - before) / 1000 * Number(speed.value);
    before = now;
    shown.goTo(next);
    if (next >= data.duration) toggle(false); else requestAnimationFrame(go);
  };

  play.addEventListener('click', () => toggle(!player.playing));
  slider.addEventListener('input', () => shown.goTo(Number(slider.value)));
  whole.addEventListener('click', () => shown.whole());
  document.addEventListener('click', (event) => {
    const button = event.target.closest('[data-at]');
    if (button) shown.goTo(Number(button.dataset.at));
  });
  document.addEventListener('keydown', (event) => {
    const inside = event.target.closest('button, input, select, summary, [tabindex]');
    if (inside || event.ctrlKey || event.metaKey || event.altKey) return;
    const moves = { ArrowLeft: -1, ArrowRight: 1 };
    const stretches = { '+': 0.5, '-': 2 };
    if (event.key === ' ') toggle(!player.playing);
    else if (event.key === '0') shown.whole();
    else if (event.key in stretches) shown.stretch(stretches[event.key]);
    else if (event.key in moves) shown.goTo(shown.at + moves[event.key] * Number(slider.step) * (event.shiftKey ? 10 : 1));
    else return;
    event.preventDefault();
  });
  shown.on('data', () => { slider.max = data.duration; });
  shown.on('time', show);
  shown.on('range', () => { whole.hidden = shown.isWhole; });
  show();
};

/** What each lane says at the moment that is shown. */
const startNow = () => {
  const list = byId('now');
  let rows = [];
  const fill = () => {
    list.replaceChildren();
    rows = data.lanes.filter((lane) => lane.spans.length || lane.name === 'faults').map((lane) => {
      const name = document.createElement('dt'), value = document.createElement('dd');
      name.textContent = lane.name;
      list.append(name, value);
      return { lane, value };
    });
  };
  const show = () => rows.forEach(({ lane, value }) => {
    if (!lane.spans.length) { // faults and what they were about: the last one, with its age
      const mark = lane.marks.filter(([at]) => at <= shown.at).pop();
      value.textContent = mark ? `${SIGNS[mark[2]]} ${mark[1]}, ${timeText(shown.at - mark[0])} ago` : '–';
      value.title = mark ? mark[3] : '';
      value.className = mark ? mark[2] : '';
      return;
    }
    const span = spanAt(lane, shown.at);
    const open = span && span[3] === 'unconfirmed';
    value.textContent = span ? `${open ? '○ ' : ''}${span[2]}` : '–';
    value.title = open ? 'commanded, not yet confirmed by sensors' : '';
    value.className = span ? span[3] : '';
  });
  shown.on('data', fill);
  shown.on('time', show);
  fill();
  show();
};

/** The diagram shows which phase is current, and leads to the first time and the lines of each. */
const startDiagram = () => {
  let nodes = new Map(), moments = new Map(), chosen = null, drawn = null;
  const lane = () => laneOf('phase') || { spans: [], marks: [] };
  const nodeOf = (phase) => {
    for (let name = phase; name; name = name.slice(0, Math.max(0, name.lastIndexOf('/')))) {
      if (nodes.has(name)) return nodes.get(name);
    }
    return null;
  };
  const choose = (node) => {
    chosen = node.dataset.node;
    if (moments.has(node)) shown.goTo(moments.get(node));
    show();
  };
  const fill = () => {
    const first = byId('diagram').firstElementChild;
    if (first !== drawn) {
      drawn = first;
      nodes = new Map([...document.querySelectorAll('#diagram [data-node]')].map((node) => [node.dataset.node, node]));
      nodes.forEach((node, name) => {
        if (!data.lines[name]) return;
        node.setAttribute('tabindex', '0');
        node.setAttribute('role', 'button');
        node.addEventListener('click', () => choose(node));
        node.addEventListener('keydown', (event) => {
          if (event.key !== 'Enter' && event.key !== ' ') return;
          event.preventDefault();
          choose(node);
        });
      });
    }
    moments = new Map();
    lane().spans.forEach(([start, , text]) => {
      const node = nodeOf(text);
      if (node && !moments.has(node)) moments.set(node, start);
    });
    lane().marks.forEach(([at, text]) => { if (nodes.has(text)) moments.set(nodes.get(text), at); });
    nodes.forEach((node, name) => {
      const at = moments.get(node), line = data.lines[name];
      if (line) node.setAttribute('aria-label', `${name}, ${at === undefined ? 'not reached' : `at ${timeText(at)}`}, line ${line[0]}`);
    });
  };
  const show = () => {
    const end = lane().marks.find(([at, text]) => shown.at >= at && nodes.has(text));
    const span = spanAt(lane(), shown.at);
    const current = end ? nodes.get(end[1]) : span && nodeOf(span[2]);
    nodes.forEach((node) => node.classList.toggle('now', node === current));
    tellLines(chosen || (current && current.dataset.node) || '');
  };
  shown.on('data', fill);
  shown.on('time', () => { if (chosen && !(moments.get(nodes.get(chosen)) === shown.at)) chosen = null; show(); });
  fill();
  show();
};

/** Of these items, each with a time, the last one that is not later than what is shown is marked. */
const startList = (selector) => {
  let items = [], times = [], marked = null;
  const fill = () => {
    items = [...document.querySelectorAll(selector)];
    times = items.map((item) => Number(item.querySelector('[data-at]').dataset.at));
  };
  const show = () => {
    const current = items[indexAt(times, shown.at + 0.0005)] || null;
    if (current === marked) return;
    if (marked) marked.removeAttribute('aria-current');
    marked = current;
    if (current) current.setAttribute('aria-current', 'step');
  };
  shown.on('data', fill);
  shown.on('time', show);
  fill();
  show();
};

startPlayer();
startNow();
startList('.story li');
startList('.strip li');
startDiagram();
drawScene();
drawTimeline();
drawPlots();
const drawAnew = () => { shown.tell('look'); shown.tell('size'); };
const drawnOnPaper = (on) => {
  document.documentElement.toggleAttribute('data-printing', on);
  drawAnew();
};
for (const wish of ['(prefers-color-scheme: dark)', '(prefers-contrast: more)']) {
  matchMedia(wish).addEventListener('change', drawAnew);
}
addEventListener('beforeprint', () => drawnOnPaper(true));
addEventListener('afterprint', () => drawnOnPaper(false));
document.documentElement.dataset.ready = 'yes';

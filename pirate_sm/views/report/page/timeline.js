// Phases, state machines, commands, triggers and faults over time.

const SIGNS = {
  trigger: '◆', fault: '▲', error: '▲', warning: '△', skipped: '↷', refused: '⊘', operator: '●',
  end: '■', failed: '✗', done: '✓', open: '…',
};
const MEANING = {
  done: 'done', failed: 'failed', skipped: 'not needed', refused: 'refused', trigger: 'trigger',
  fault: 'fault', warning: 'warning', operator: 'person', end: 'end',
};
const SVG = 'http://www.w3.org/2000/svg';

const element = (name, attributes, text) => {
  const made = document.createElementNS(SVG, name);
  for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
  if (text !== undefined) made.textContent = text;
  return made;
};

/** Where an axis of times has its marks. */
const ticksOf = (from, to, room) => {
  const rough = (to - from) / Math.max(2, room / 90);
  const step = STEPS.find((each) => each >= rough) || STEPS[STEPS.length - 1];
  const first = Math.ceil(from / step - 1e-9);
  return Array.from({ length: Math.max(0, Math.floor(to / step + 1e-9) - first + 1) }, (_, i) => (first + i) * step);
};

const drawTimeline = () => {
  const host = byId('timeline'), ROW = 26, AXIS = 22, LETTER = 7, EDGE = 18;
  const root = element('svg', { role: 'img', 'aria-label': 'Timeline of the run; Step by step says the same in words' });
  host.append(root);
  let width = 0, gutter = 0, cursor = null;

  const isNarrow = () => width < 600;
  const xOf = (at) => gutter + (width - gutter - EDGE) * (at - shown.from) / (shown.to - shown.from);
  const atOf = (x) => shown.from + (x - gutter) / (width - gutter - EDGE) * (shown.to - shown.from);

  /** A style of its own for each different text of a lane of words. */
  const tintOf = (lane) => {
    const names = [...new Set(lane.spans.map((span) => span[2]))];
    return (text) => names.indexOf(text) % 6;
  };

  const fitted = (text, room) => {
    const letters = Math.floor((room - 8) / LETTER);
    if (letters < 2) return '';
    if (text.length <= letters) return text;
    const tail = text.slice(text.lastIndexOf('/') + 1);
    if (tail.length <= letters) return tail;
    return letters < 4 ? '' : `${tail.slice(0, letters - 1)}…`;
  };

  const span = (group, [start, end, text, kind, about], y, tint) => {
    if (end < shown.from || start > shown.to) return;
    const left = Math.max(gutter, xOf(start)), right = Math.min(width - EDGE, xOf(end));
    const wide = Math.max(2, right - left);
    const box = element('g', { class: `span ${kind} tint${tint}` });
    box.append(element('title', {}, `${text}${about ? `, ${about}` : ''}: ${timeText(start)} to ${timeText(end)}`));
    box.append(element('rect', { x: left, y: y + 3, width: wide, height: ROW - 6, rx: 3 }));
    if (kind === 'unconfirmed') {
      box.append(element('rect', { class: 'hatch', x: left, y: y + 3, width: wide, height: ROW - 6, rx: 3 }));
    }
    const sign = kind === 'failed' || kind === 'open' ? `${SIGNS[kind]} ` : '';
    const label = fitted(sign + text, wide) || (sign && wide > 8 ? sign : '');
    if (label) box.append(element('text', { x: left + 4, y: y + ROW / 2 + 4 }, label));
    group.append(box);
  };

  const mark = (group, [at, text, kind, about], y, room) => {
    if (at < shown.from || at > shown.to) return;
    const x = xOf(at), box = element('g', { class: `mark ${kind}` });
    box.append(element('title', {}, `${text}${about ? `: ${about}` : ''} at ${timeText(at)}`));
    box.append(element('text', { class: 'sign', x, y: y + ROW / 2 + 5, 'text-anchor': 'middle' }, SIGNS[kind]));
    const label = fitted(about && kind === 'trigger' ? about : text, room - 10);
    if (label) box.append(element('text', { x: x + 9, y: y + ROW / 2 + 4 }, label));
    group.append(box);
  };

  /** When earlier runs let expect that a span ends. */
  const expected = (group, [from, until, about], y) => {
    if (until < shown.from || from > shown.to) return;
    const left = Math.max(gutter, xOf(from)), right = Math.min(width - EDGE, xOf(until));
    const box = element('g', { class: 'expected' });
    box.append(element('title', {}, `${about}: expected to end ${timeText(from)} to ${timeText(until)}`));
    box.append(element('rect', { x: left, y: y + ROW - 6, width: Math.max(3, right - left), height: 5 }));
    group.append(box);
  };

  const row = (lane, y) => {
    const group = element('g', {}), tint = tintOf(lane), top = isNarrow() ? y + 14 : y;
    group.append(element('line', { class: 'rule', x1: 0, x2: width, y1: y, y2: y }));
    group.append(element('text', {
      class: 'lane', x: isNarrow() ? 2 : gutter - 10, y: isNarrow() ? y + 12 : y + ROW / 2 + 4,
      'text-anchor': isNarrow() ? 'start' : 'end',
    }, lane.name));
    lane.spans.forEach((each) => span(group, each, top, tint(each[2])));
    (lane.expected || []).forEach((each) => expected(group, each, top));
    lane.marks.forEach((each, i) => {
      const next = lane.marks[i + 1];
      const open = lane.spans.every(([start, end]) => end <= each[0] || start > each[0]) && lane.spans.length === 0;
      mark(group, each, top, open ? Math.min(width - EDGE, next ? xOf(next[0]) : Infinity) - xOf(each[0]) : 0);
    });
    root.append(group);
    return top + ROW;
  };

  /** Nothing is known there: the recording was damaged. */
  const gap = ([start, end], y) => {
    if (end < shown.from || start > shown.to) return;
    const left = Math.max(gutter, xOf(start)), right = Math.min(width - EDGE, xOf(end));
    const box = element('g', { class: 'gap' });
    box.append(element('title', {}, `nothing is known: ${timeText(start)} to ${timeText(end)}`));
    box.append(element('rect', { x: left, y: 0, width: Math.max(2, right - left), height: y }));
    root.append(box);
  };

  const axis = (y) => {
    const group = element('g', { class: 'axis' });
    ticksOf(shown.from, shown.to, width - gutter).forEach((at) => {
      const x = xOf(at);
      group.append(element('line', { class: 'tick', x1: x, x2: x, y1: 0, y2: y }));
      group.append(element('text', { x, y: y + 15, 'text-anchor': 'middle' }, ticked(at)));
    });
    root.prepend(group);
  };

  const follow = () => {
    if (!cursor) return;
    const x = xOf(shown.at);
    cursor.setAttribute('x1', x);
    cursor.setAttribute('x2', x);
    cursor.style.display = shown.at < shown.from || shown.at > shown.to ? 'none' : '';
  };

  const draw = () => {
    width = host.clientWidth;
    gutter = isNarrow() ? 4 : Math.min(190, 24 + LETTER * Math.max(0, ...data.lanes.map((lane) => lane.name.length)));
    root.replaceChildren();
    const defs = element('defs', {});
    const pattern = element('pattern', { id: 'hatch', width: 7, height: 7, patternUnits: 'userSpaceOnUse', patternTransform: 'rotate(45)' });
    pattern.append(element('line', { class: 'hatching', x1: 0, y1: 0, x2: 0, y2: 7 }));
    defs.append(pattern);
    let y = 2;
    data.lanes.forEach((lane) => { y = row(lane, y); });
    data.gaps.forEach((each) => gap(each, y));
    axis(y);
    cursor = element('line', { class: 'cursor', y1: 0, y2: y });
    root.prepend(defs);
    root.append(cursor);
    root.setAttribute('width', width);
    root.setAttribute('height', y + AXIS);
    root.setAttribute('viewBox', `0 0 ${width} ${y + AXIS}`);
    follow();
  };

  const pick = (event) => {
    const x = event.clientX - root.getBoundingClientRect().left;
    if (x >= gutter) shown.goTo(Math.min(shown.to, Math.max(shown.from, atOf(x))));
  };
  root.addEventListener('pointerdown', (event) => {
    if (event.button !== 0) return;
    pick(event);
    if (event.pointerType === 'mouse') root.setPointerCapture(event.pointerId);
  });
  root.addEventListener('pointermove', (event) => {
    if (event.pointerType === 'mouse' && event.buttons & 1) pick(event);
  });

  const explain = () => {
    const used = new Set(data.lanes.flatMap((lane) => [
      ...lane.marks.map((each) => each[2]), ...lane.spans.map((each) => each[3])]));
    const key = Object.entries(MEANING).filter(([kind]) => used.has(kind) && kind !== 'done')
      .map(([kind, meaning]) => `${SIGNS[kind]} ${meaning}`);
    if (used.has('unconfirmed')) key.push('▨ commanded, not yet confirmed by sensors');
    if (data.lanes.some((lane) => lane.expected)) key.push('▬ when the phase was expected to end, by earlier runs');
    if (data.gaps.length) key.push('▒ nothing is known');
    byId('key').textContent = key.join('   ');
  };

  explain();
  shown.on('data', () => { explain(); draw(); });
  new ResizeObserver(draw).observe(host);
  shown.on('range', draw);
  shown.on('size', draw);
  shown.on('time', follow);
};

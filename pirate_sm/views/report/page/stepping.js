// Steps through a run: the lines of the mission's file, when each began, and where the run pauses.

const steps = {
  /** The newest breakpoints of a run that is under way; else those of the moment. */
  get set() {
    const all = data.stepping.breakpoints, times = all.map(([at]) => at);
    const found = all[data.running ? all.length - 1 : indexAt(times, shown.at)];
    return found ? found[1] : [];
  },
  /** When the first of these moments comes after the one that is shown; undefined: none does. */
  next: (moments) => moments.find((at) => at > shown.at + 0.0005),
  before: (moments) => moments.filter((at) => at < shown.at - 0.0005).pop(),
};

/** The lines of a phase, each leading to when it begins next, with its breakpoint. */
const startLines = () => {
  const figure = byId('lines'), bar = byId('steps'), code = figure.querySelector('pre'), caption = figure.querySelector('figcaption span');
  const WAYS = { ',': 'back', '.': 'next', '<': 'phase-back', '>': 'phase-next' };
  let drawn = null, rows = [];

  const button = (kind, about, press) => {
    const made = document.createElement('button');
    made.type = 'button';
    made.className = kind;
    made.setAttribute('aria-label', about);
    made.title = about;
    if (press) made.dataset.press = press;
    return made;
  };
  const row = (text, number) => {
    const line = document.createElement('span'), can = data.stepping.lines.includes(number), where = `${data.source}:${number}`;
    line.className = 'line';
    line.dataset.line = number;
    const mark = can ? button('mark', `Pause before line ${number}`, `break ${where}`) : document.createElement('span');
    const words = document.createElement(can ? 'button' : 'span');
    mark.classList.add('mark');
    mark.dataset.number = number;
    words.classList.add('text');
    words.textContent = text || ' ';
    line.append(mark, words);
    if (can) line.append(button('here', `Run to line ${number}`, `until ${where}`));
    return { line, mark, words, number, can };
  };
  const moments = (number) => data.stepping.begun.filter(([, line]) => line === number).map(([at]) => at);
  const goes = (made, at) => {
    made.disabled = at === undefined;
    if (at === undefined) delete made.dataset.at; else made.dataset.at = at;
  };

  /** Of the lines, which is under way, where each leads and which has a breakpoint. */
  const show = () => {
    const begun = data.stepping.begun, set = steps.set;
    const own = begun.filter(([, line]) => line), current = own[indexAt(own.map(([at]) => at), shown.at + 0.0005)];
    rows.forEach(({ line, mark, words, number, can }) => {
      line.classList.toggle('now', Boolean(current) && current[1] === number);
      if (!can) return;
      const times = moments(number);
      const at = steps.next(times) ?? times[0];
      goes(words, at);
      words.title = at === undefined ? 'not begun' : `begins at ${timeText(at)}`;
      mark.disabled = !document.documentElement.hasAttribute('data-acts');
      mark.setAttribute('aria-pressed', String(set.includes(number)));
    });
    const lane = laneOf('phase'), phases = lane ? lane.spans.map(([start]) => start) : [], each = begun.map(([at]) => at);
    const to = { back: steps.before(each), next: steps.next(each), 'phase-back': steps.before(phases), 'phase-next': steps.next(phases) };
    bar.querySelectorAll('button').forEach((one) => goes(one, to[one.dataset.step]));
    document.querySelectorAll('#diagram [data-node]').forEach((node) => {
      const found = data.lines[node.dataset.node];
      node.classList.toggle('pauses', Boolean(found) && found[1].split('\n').some((_, i) => set.includes(found[0] + i)));
    });
  };
  const tell = (name) => {
    const found = data.lines[name];
    figure.hidden = !found;
    if (found && drawn !== found) {
      caption.textContent = `${name}: ${data.source}, line ${found[0]}`;
      rows = found[1].split('\n').map((text, i) => row(text, found[0] + i));
      code.replaceChildren(...rows.map(({ line }) => line));
      show();
    }
    drawn = found;
  };
  document.addEventListener('keydown', (event) => {
    if (event.target.closest('input, select') || event.ctrlKey || event.metaKey || event.altKey || !(event.key in WAYS)) return;
    bar.querySelector(`[data-step="${WAYS[event.key]}"]`).click();
  });
  shown.on('data', show);
  shown.on('time', show);
  show();
  return tell;
};

const tellLines = startLines();

// The page of a run in progress: what has changed comes from the server that it was opened from.

/** Changes from the server: a value at a path, or how much of a list stays and what follows. */
const apply = (root, changes) => changes.forEach(([path, value, tail]) => {
  const last = path[path.length - 1], holder = path.slice(0, -1).reduce((each, key) => each[key], root);
  if (tail === undefined) holder[last] = value;
  else holder[last].splice(value, Infinity, ...tail);
});

const startLive = () => {
  const LONGEST_MS = 1500, SILENT_MS = 2000, AGAIN_MS = 1000;
  const play = byId('play'), word = byId('no-word'), now = byId('follow-run');
  const page = { data }, calm = matchMedia('(prefers-reduced-motion: reduce)');
  let version = data.version, following = data.running, glide = null, heard = performance.now(), connected = false;

  const follow = (wanted) => {
    following = player.following = wanted && data.running;
    now.hidden = !data.running;
    now.setAttribute('aria-pressed', String(following));
  };

  const show = (name, html) => {
    const part = document.querySelector(`[data-part="${name}"]`);
    if (part) part.innerHTML = html;
  };

  /** The page has parts now that it did not have when it was made. */
  const isAnotherPage = (parts) => ['robot', 'space'].some((name) => name in parts
    && Boolean(parts[name].includes('<canvas')) !== Boolean(document.querySelector(`[data-part="${name}"] canvas`)));

  const take = ({ changes, parts, version: newest }) => {
    const wasWhole = shown.isWhole, wasRunning = data.running, arrived = performance.now();
    if (!changes || isAnotherPage(parts)) { location.reload(); return; }
    version = newest;
    for (const name of Object.keys(parts)) if (name !== 'robot' && name !== 'space') show(name, parts[name]);
    apply(page, changes);
    shown.grow(wasWhole);
    if (!data.running) {
      if (wasRunning && following) shown.goTo(data.opens);
      follow(false);
    } else if (!wasRunning) follow(true);
    if (following) glide = { from: shown.at, to: data.duration, since: arrived, lasts: calm.matches ? 0 : Math.min(LONGEST_MS, arrived - heard) };
    heard = arrived;
    document.documentElement.dataset.until = data.duration;
  };

  /** Between two messages the moment glides on, so that the robot moves as it did. */
  const frame = (at) => {
    if (following && glide && !player.playing) {
      const share = Math.min(1, Math.max(0, (at - glide.since) / (glide.lasts || 1)));
      shown.goTo(glide.from + (glide.to - glide.from) * share);
    }
    const silent = performance.now() - heard;
    word.hidden = !(data.running && (silent > SILENT_MS || !connected));
    if (!word.hidden) word.textContent = connected
      ? `No word from the run for ${Math.floor(silent / 1000)} s: this is how it was then`
      : 'The server of this page does not answer: this is how it was then';
    requestAnimationFrame(frame);
  };

  const connect = () => {
    const socket = new WebSocket(`ws://${location.host}/changes?since=${version}`);
    socket.addEventListener('open', () => { connected = true; });
    socket.addEventListener('message', (event) => take(JSON.parse(event.data)));
    socket.addEventListener('close', () => {
      connected = false;
      if (data.running) setTimeout(connect, AGAIN_MS);
    });
  };

  now.addEventListener('click', () => follow(!following));
  // Whoever moves the time looks at something else than the newest.
  for (const id of ['slider', 'timeline', 'plots']) byId(id).addEventListener('pointerdown', () => follow(false));
  document.addEventListener('click', (event) => { if (event.target.closest('[data-at], [data-node]')) follow(false); });
  document.addEventListener('keydown', (event) => { if (['ArrowLeft', 'ArrowRight', ' '].includes(event.key)) follow(false); });
  play.addEventListener('click', () => follow(false));
  follow(true);
  connect();
  requestAnimationFrame(frame);
};

startLive();

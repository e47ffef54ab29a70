// The robot in its pipe, to scale: in the plane of the pipe, or from above and from the side.

/** Where the wheels are over time, with two coordinates each, in space with three. */
const motion = data.scene && (() => {
  const scene = data.scene, wheels = scene.wheels.length;
  const axes = scene.space ? 3 : 2;
  const tracks = (lists, per) => lists.map((steps) => summed(steps, per));
  let times, paths, normals;
  const fill = () => {
    times = clocks[scene.clock];
    paths = tracks(scene.paths, scene.perMetre);
    normals = scene.space ? tracks(scene.space.normals, scene.space.perUnit) : [];
  };
  fill();
  shown.on('data', fill);
  /** Points at a moment, between two poses on the line that joins them. */
  const pointsAt = (lists, at) => {
    const i = Math.max(0, indexAt(times, at)), j = Math.min(i + 1, times.length - 1);
    const share = j > i ? Math.min(1, Math.max(0, (at - times[i]) / (times[j] - times[i]))) : 0;
    return Array.from({ length: lists.length / axes }, (_, n) => Array.from({ length: axes }, (__, axis) => {
      const path = lists[axes * n + axis];
      return path[i] + (path[j] - path[i]) * share;
    }));
  };
  const partSpan = (name) => {
    const lane = scene.parts.find((part) => part.name === name);
    return lane ? spanAt(lane, shown.at) : null;
  };
  return {
    scene, wheels, axes, partSpan,
    /** Between which two corners the robot has been, seen along one axis. */
    travelled(right, up) {
      const range = (axis) => {
        const own = paths.filter((_, n) => n % axes === axis);
        return [0, 1].map((end) => own.reduce((far, path) => path.reduce(end ? (a, b) => Math.max(a, b) : (a, b) => Math.min(a, b), far), end ? -Infinity : Infinity));
      };
      const [[x0, x1], [y0, y1]] = [range(right), range(up)];
      return [x0, y0, x1, y1];
    },
    placesAt: (at) => pointsAt(paths, at),
    normalsAt: (at) => pointsAt(normals, at),
    /** What holds the link behind this wheel; null where nothing does. */
    heldAt: (link) => (scene.wheels[link].part === scene.wheels[link + 1].part ? partSpan(scene.wheels[link].part) : null),
  };
})();

/** One view of the robot; returns how it is drawn, and what it draws. */
const flatView = (canvas, view) => {
  const { scene, wheels, placesAt } = motion;
  const [right, up] = view.axes, way = scene.space ? scene.space.way : [];
  const context = canvas.getContext('2d');
  let width = 0, height = 0, following = false;
  const flat = (point) => [point[right], point[up]];

  const bounds = (points) => points.reduce(
    ([x0, y0, x1, y1], [x, y]) => [Math.min(x0, x), Math.min(y0, y), Math.max(x1, x), Math.max(y1, y)],
    [Infinity, Infinity, -Infinity, -Infinity]);
  let travelled = motion.travelled(right, up);
  shown.on('data', () => { travelled = motion.travelled(right, up); });
  /** So much of the pipes beyond where the robot has been that a tee is seen to have its arms, m. */
  const ARM = 0.3;
  const pipesBox = view.outlines.length ? bounds(view.outlines.flat()) : null;
  const withArms = (box) => (pipesBox
    ? box.map((edge, i) => (i < 2 ? Math.min(edge, Math.max(pipesBox[i], edge - ARM)) : Math.max(edge, Math.min(pipesBox[i], edge + ARM))))
    : box);
  const first = placesAt(0);
  const length = first.slice(1).reduce(
    (sum, p, i) => sum + Math.hypot(...p.map((value, axis) => value - first[i][axis])), 0);

  /** Pixels per metre and the middle of the picture. */
  const frame = (places) => {
    const margin = 3.2 * scene.radius;
    let box = withArms(travelled);
    if (following) {
      const [x0, y0, x1, y1] = bounds(places), reach = length / 2, high = Math.max(reach / 3, (y1 - y0) / 2);
      box = [(x0 + x1) / 2 - reach, (y0 + y1) / 2 - high, (x0 + x1) / 2 + reach, (y0 + y1) / 2 + high];
    }
    const [x0, y0, x1, y1] = box;
    const scale = Math.min(width / (x1 - x0 + 2 * margin), height / (y1 - y0 + 2 * margin));
    return { scale, x: (x0 + x1) / 2, y: (y0 + y1) / 2 };
  };

  const setDash = (dash) => context.setLineDash(dash);
  const stroke = (points, style, thick, dash = []) => {
    context.beginPath();
    points.forEach(([x, y], i) => (i ? context.lineTo(x, y) : context.moveTo(x, y)));
    context.strokeStyle = style;
    context.lineWidth = thick;
    setDash(dash);
    context.stroke();
    setDash([]);
  };

  /** The nearest point of the way in space: how far away, of which bore, and which way it goes. */
  const beside = (point) => {
    let best = null;
    for (let i = 1; i < way.length; i++) {
      const a = way[i - 1], step = [0, 1, 2].map((k) => way[i][k] - a[k]);
      const whole = step.reduce((sum, v) => sum + v * v, 0);
      if (!whole) continue;
      const along = step.reduce((sum, v, k) => sum + v * (point[k] - a[k]), 0) / whole;
      const share = Math.min(1, Math.max(0, along));
      const away = Math.hypot(...step.map((v, k) => a[k] + share * v - point[k]));
      const bore = a[3] + share * (way[i][3] - a[3]);
      if (!best || away < best.away) best = { away, bore, ahead: step.map((v) => v / Math.sqrt(whole)) };
    }
    return best;
  };

  /** The nearest point of a wall, how far away it is, and which way the wall goes there. */
  const nearest = ([px, py]) => {
    let best = null;
    for (const wall of scene.walls) {
      for (let i = 1; i < wall.length; i++) {
        const [ax, ay] = wall[i - 1], dx = wall[i][0] - ax, dy = wall[i][1] - ay, whole = Math.hypot(dx, dy);
        const share = Math.min(1, Math.max(0, ((px - ax) * dx + (py - ay) * dy) / (whole * whole)));
        const x = ax + share * dx, y = ay + share * dy, away = Math.hypot(px - x, py - y);
        if (!best || away < best.away) best = { x, y, away, dx: dx / whole, dy: dy / whole };
      }
    }
    return best;
  };

  /** Which way is forward for a wheel, in the picture: along the pipe, or along the robot. */
  const forward = (places, number) => {
    const wall = way.length ? null : nearest(places[number]);
    if (wall) return [wall.dx, -wall.dy];
    const near = beside(places[number]);
    if (near) return [near.ahead[right], -near.ahead[up]];
    const ahead = places[Math.max(0, number - 1)], behind = places[Math.min(wheels - 1, number + 1)];
    const span = Math.hypot(ahead[0] - behind[0], ahead[1] - behind[1]) || 1;
    return [(ahead[0] - behind[0]) / span, -(ahead[1] - behind[1]) / span];
  };

  /** The inside of the pipe is the path of the picture. */
  const outline = ([one, other]) => {
    context.beginPath();
    [...one, ...[...other].reverse()].forEach(([x, y], i) => (i ? context.lineTo(x, y) : context.moveTo(x, y)));
    context.closePath();
  };

  /** Pipes in space are areas that overlap; together they have one border. */
  const pipes = (to, scale, points) => {
    const areas = new Path2D();
    for (const outline of view.outlines) {
      outline.map(to).forEach(([x, y], i) => (i ? areas.lineTo(x, y) : areas.moveTo(x, y)));
      areas.closePath();
    }
    context.strokeStyle = colour('--wall');
    context.lineWidth = 2 * Math.max(2, 0.004 * scale);
    context.stroke(areas);
    context.save();
    context.fillStyle = colour('--bore');
    context.fill(areas);
    context.clip(areas);
    shine(points, scale);
    context.restore();
    stroke(way.map((point) => to(flat(point))), colour('--faint'), 1, [8, 6]);
  };

  const pipe = (to, scale, points) => {
    if (view.outlines.length) { pipes(to, scale, points); return; }
    if (!scene.walls.length) { shine(points, scale); return; }
    const [one, other] = scene.walls.map((wall) => wall.map(to));
    context.save();
    outline([one, other]);
    context.fillStyle = colour('--bore');
    context.fill();
    context.clip();
    shine(points, scale);
    context.restore();
    const thick = Math.max(2, 0.004 * scale);
    [one, other].forEach((wall) => stroke(wall, colour('--wall'), thick));
    stroke(one.map(([x, y], i) => [(x + other[i][0]) / 2, (y + other[i][1]) / 2]), colour('--faint'), 1, [8, 6]);
  };

  const along = (places, at) => {
    const place = at * (places.length - 1), i = Math.min(Math.floor(place), places.length - 2);
    const share = place - i, [a, b] = [places[i], places[i + 1]];
    return { point: [a[0] + (b[0] - a[0]) * share, a[1] + (b[1] - a[1]) * share], from: b, to: a };
  };

  const shine = (points, scale) => {
    for (const light of scene.lights) {
      if (!(valueAt(light.level, shown.at) > 0)) continue;
      const { point: [x, y], from, to } = along(points, light.at);
      const back = light.at > 0.5 ? -1 : 1;
      const heading = Math.atan2(back * (to[1] - from[1]), back * (to[0] - from[0]));
      const atEnd = light.at === 0 || light.at === 1, reach = scale * scene.radius * (atEnd ? 5 : 2);
      const glow = context.createRadialGradient(x, y, 0, x, y, reach);
      glow.addColorStop(0, `${colour('--light')}c0`);
      glow.addColorStop(1, `${colour('--light')}00`);
      context.beginPath();
      context.moveTo(x, y);
      context.arc(x, y, reach, heading - (atEnd ? 0.5 : Math.PI), heading + (atEnd ? 0.5 : Math.PI));
      context.fillStyle = glow;
      context.fill();
    }
  };

  const links = (points, scale) => {
    const thick = Math.max(4, 2 * scene.half * scale);
    context.lineCap = 'round';
    for (let i = 1; i < points.length; i++) {
      const pair = [points[i - 1], points[i]];
      const held = motion.heldAt(i - 1);
      stroke(pair, colour('--ink'), thick + 2);
      stroke(pair, colour(held ? '--held' : '--body'), thick);
      if (held) stroke(pair, colour('--paper'), 2, held[3] === 'unconfirmed' ? [2, 6] : []);
    }
    context.lineCap = 'butt';
  };

  const number = (text, [x, y], radius) => {
    if (radius < 7) return;
    context.fillStyle = colour('--ink');
    context.font = `${text > 1 ? '' : 'bold '}${Math.round(radius * 0.95)}px system-ui, sans-serif`;
    context.textAlign = 'center';
    context.textBaseline = 'middle';
    context.fillText(String(text), x, y + 0.5);
  };

  const wheel = (which, [x, y], radius) => {
    const wheelData = scene.wheels[which];
    context.beginPath();
    context.arc(x, y, radius, 0, 2 * Math.PI);
    context.fillStyle = colour('--paper');
    context.fill();
    context.lineWidth = Math.max(1.5, radius / 6);
    context.strokeStyle = colour('--ink');
    context.stroke();
    const turned = valueAt(wheelData.angle, shown.at);
    if (turned !== null) {
      for (const spoke of [0, 2 * Math.PI / 3, 4 * Math.PI / 3]) {
        const angle = spoke - turned;
        stroke([[x + Math.cos(angle) * radius * 0.62, y + Math.sin(angle) * radius * 0.62],
          [x + Math.cos(angle) * radius * 0.95, y + Math.sin(angle) * radius * 0.95]], colour('--ink'), 1.5);
      }
    }
    number(which + 1, [x, y], radius);
  };

  /** A wheel whose axle does not point at the eye: its disc is seen as an ellipse. */
  const discAslant = (which, [x, y], radius, axle, scale) => {
    const across = Math.hypot(axle[right], axle[up]);
    const thin = Math.max(radius * Math.sqrt(Math.max(0, 1 - across * across)), scene.space.width / 2 * scale);
    context.beginPath();
    context.ellipse(x, y, Math.min(thin, radius), radius, Math.atan2(-axle[up], axle[right]), 0, 2 * Math.PI);
    context.fillStyle = colour('--paper');
    context.fill();
    context.lineWidth = Math.max(1.5, radius / 6);
    context.strokeStyle = colour('--ink');
    context.stroke();
    number(which + 1, [x, y], radius);
  };

  /** A chevron ahead of a driven wheel, in the direction in which it shall go. */
  const drive = ([x, y], radius, [hx, hy]) => {
    const tip = [x + hx * radius * 1.75, y + hy * radius * 1.75];
    const wing = (side) => [tip[0] - hx * radius * 0.5 - side * hy * radius * 0.45, tip[1] - hy * radius * 0.5 + side * hx * radius * 0.45];
    stroke([wing(1), tip, wing(-1)], colour('--drive'), Math.max(2, radius / 4));
  };

  /** A bar at each place where a wheel is at a wall; returns the numbers of those wheels. */
  const contacts = (places, to, scale) => {
    if (scene.source !== 'truth') return [];
    const touches = (place) => (way.length
      ? beside(place).away > beside(place).bore / 2 - scene.radius - TOUCHING
      : nearest(place)?.away < scene.radius + TOUCHING);
    const touching = places.flatMap((place, i) => (touches(place) ? [i + 1] : []));
    if (way.length) return touching;
    const half = Math.max(6, scale * scene.radius * 0.8), thick = Math.max(4, 0.007 * scale);
    touching.map((number) => nearest(places[number - 1])).forEach(({ x, y, dx, dy }) => {
      const [cx, cy] = to([x, y]);
      stroke([[cx - dx * half, cy + dy * half], [cx + dx * half, cy - dy * half]], colour('--touch'), thick);
    });
    return touching;
  };

  const ruler = (scale) => {
    const wide = [0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1, 2, 5].find((each) => each * scale > 60) || 10;
    const x = 12, y = height - 12;
    context.globalAlpha = 0.8;
    context.fillStyle = colour('--paper');
    context.fillRect(x - 6, y - 22, wide * scale + 12, 30);
    context.globalAlpha = 1;
    stroke([[x, y - 4], [x, y], [x + wide * scale, y], [x + wide * scale, y - 4]], colour('--soft'), 1.5);
    context.fillStyle = colour('--soft');
    context.font = '12px system-ui, sans-serif';
    context.textAlign = 'left';
    context.textBaseline = 'alphabetic';
    context.fillText(wide >= 1 ? `${wide} m` : `${wide * 100} cm`, x + 4, y - 6);
  };

  /** Draws everything; returns the numbers of the wheels that are at a wall. */
  const draw = () => {
    const ratio = window.devicePixelRatio || 1;
    context.setTransform(ratio, 0, 0, ratio, 0, 0);
    context.clearRect(0, 0, width, height);
    const places = placesAt(shown.at), { x: midX, y: midY, scale } = frame(places.map(flat));
    const to = ([x, y]) => [width / 2 + (x - midX) * scale, height / 2 - (y - midY) * scale];
    const points = places.map(flat).map(to), normals = scene.space && motion.normalsAt(shown.at);
    context.lineJoin = 'round';
    pipe(to, scale, points);
    links(points, scale);
    const touching = contacts(places, to, scale);
    const radius = Math.max(3, scene.radius * scale);
    points.forEach((point, number) => {
      const axle = normals && normals[number < scene.space.rear ? 0 : 1];
      if (axle && Math.hypot(axle[right], axle[up]) > ASLANT) discAslant(number, point, radius, axle, scale);
      else wheel(number, point, radius);
    });
    places.forEach((_, number) => {
      const told = Math.sign(valueAt(scene.wheels[number].drive, shown.at) || 0);
      if (told) drive(points[number], radius, forward(places, number).map((each) => told * each));
    });
    ruler(scale);
    canvas.dataset.places = places.map((place) => place.map((v) => v.toFixed(4)).join(',')).join(' ');
    return touching;
  };

  const resize = () => {
    const ratio = window.devicePixelRatio || 1, box = canvas.getBoundingClientRect();
    width = box.width;
    height = box.height;
    canvas.width = Math.round(width * ratio);
    canvas.height = Math.round(height * ratio);
    return draw();
  };
  return {
    draw, resize,
    follow(wanted) { following = wanted; },
    get small() { return scene.radius * frame(placesAt(0).map(flat)).scale < 5; },
  };
};

/** How near to a wall a wheel counts as touching it, m. */
const TOUCHING = 0.0012;

/** Sine of the angle between axle and line of sight from which on a wheel is no circle. */
const ASLANT = 0.1;

const drawScene = () => {
  if (!motion || !byId('scene')) return;
  const scene = motion.scene, follow = byId('follow'), pose = byId('pose');
  const canvases = ['scene', 'scene-side'].map(byId).filter(Boolean);
  const views = scene.space ? scene.space.views : [{ axes: [0, 1], outlines: [] }];
  const flats = canvases.map((canvas, i) => flatView(canvas, views[i]));

  const sentence = (touching) => {
    const parts = scene.parts.map((part) => {
      const span = spanAt(part, shown.at);
      return `${part.name} ${span ? span[2] : 'free'}`;
    });
    const lit = scene.lights.filter((light) => valueAt(light.level, shown.at) > 0).length;
    const driven = scene.wheels.flatMap((each, i) => (valueAt(each.drive, shown.at) ? [i + 1] : []));
    const words = [...parts, `driven: ${driven.join(', ') || 'none'}`];
    if (scene.source === 'truth') words.push(`at a wall: ${touching.join(', ') || 'none'}`);
    if (scene.lights.length) words.push(lit ? 'light on' : 'light off');
    return words.join(' · ');
  };

  const draw = () => {
    const [touching] = flats.map((flat) => flat.draw());
    pose.textContent = sentence(touching);
  };
  const toggle = (wanted) => {
    flats.forEach((flat) => flat.follow(wanted));
    follow.setAttribute('aria-pressed', String(wanted));
    draw();
  };
  follow.addEventListener('click', () => toggle(follow.getAttribute('aria-pressed') !== 'true'));
  const watch = new ResizeObserver(() => { flats.forEach((flat) => flat.resize()); });
  canvases.forEach((canvas) => watch.observe(canvas));
  shown.on('time', draw);
  shown.on('look', draw);
  shown.on('size', () => { flats.forEach((flat) => flat.resize()); });
  flats.forEach((flat) => flat.resize());
  draw();
  if (flats[0].small) toggle(true);
};

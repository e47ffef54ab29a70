// The network in space, which can be turned; three.js draws it.

/** What the eye looks at, and from where: angles in radians, the distance in metres. */
const orbit = (canvas, home, changed) => {
  const state = { ...home, target: [...home.target] };
  const pointers = new Map();
  const turn = (dx, dy) => {
    state.azimuth -= 0.008 * dx;
    state.elevation = Math.min(1.55, Math.max(-1.55, state.elevation + 0.008 * dy));
  };
  const zoom = (factor) => {
    state.distance = Math.min(4 * home.distance, Math.max(0.15, state.distance * factor));
  };
  /** Move what is looked at across the line of sight. */
  const slide = (dx, dy) => {
    const step = state.distance / canvas.clientHeight * 0.75;
    const [c, s] = [Math.cos(state.azimuth), Math.sin(state.azimuth)], low = Math.sin(state.elevation);
    const up = [-c * low, -s * low, Math.cos(state.elevation)], right = [-s, c, 0];
    state.target = state.target.map((v, k) => v + step * (dy * up[k] - dx * right[k]));
    state.moved = true;
  };
  canvas.addEventListener('pointerdown', (event) => {
    canvas.setPointerCapture(event.pointerId);
    pointers.set(event.pointerId, [event.clientX, event.clientY]);
  });
  const spread = () => {
    const [a, b] = [...pointers.values()];
    return Math.hypot(a[0] - b[0], a[1] - b[1]) || 1;
  };
  canvas.addEventListener('pointermove', (event) => {
    const before = pointers.get(event.pointerId);
    if (!before) return;
    const wide = pointers.size === 2 ? spread() : 0;
    pointers.set(event.pointerId, [event.clientX, event.clientY]);
    const moved = [event.clientX - before[0], event.clientY - before[1]];
    if (wide) { zoom(wide / spread()); slide(moved[0] / 2, moved[1] / 2); }
    else if (event.shiftKey || event.buttons === 2) slide(...moved);
    else turn(...moved);
    changed();
  });
  for (const end of ['pointerup', 'pointercancel']) {
    canvas.addEventListener(end, (event) => pointers.delete(event.pointerId));
  }
  canvas.addEventListener('contextmenu', (event) => event.preventDefault());
  // The page scrolls under the mouse wheel until the picture has been clicked.
  canvas.addEventListener('wheel', (event) => {
    if (document.activeElement !== canvas) return;
    event.preventDefault();
    zoom(Math.exp(0.001 * event.deltaY));
    changed();
  }, { passive: false });
  const keys = {
    ArrowLeft: () => turn(-12, 0), ArrowRight: () => turn(12, 0),
    ArrowUp: () => turn(0, 12), ArrowDown: () => turn(0, -12),
    '+': () => zoom(0.85), '-': () => zoom(1 / 0.85),
  };
  const slides = { ArrowLeft: [24, 0], ArrowRight: [-24, 0], ArrowUp: [0, 24], ArrowDown: [0, -24] };
  canvas.addEventListener('keydown', (event) => {
    if (!(event.key in keys)) return;
    if (event.shiftKey && event.key in slides) slide(...slides[event.key]);
    else keys[event.key]();
    event.preventDefault();
    changed();
  });
  return state;
};

/** A text that is as large on the screen wherever it stands. */
const label = (text, px, bold) => {
  const fine = Math.max(1, Math.round(window.devicePixelRatio || 1));
  const board = document.createElement('canvas'), pen = board.getContext('2d');
  const font = `${bold ? 'bold ' : ''}${fine * px}px system-ui, sans-serif`;
  pen.font = font;
  board.width = Math.ceil(pen.measureText(text).width) + 8 * fine;
  board.height = 2 * Math.round(0.8 * fine * px);
  pen.font = font;
  pen.textBaseline = 'middle';
  pen.lineJoin = 'round';
  pen.lineWidth = 3 * fine;
  pen.strokeStyle = colour('--paper');
  pen.strokeText(text, 4 * fine, board.height / 2);
  pen.fillStyle = colour('--ink');
  pen.fillText(text, 4 * fine, board.height / 2);
  const map = new THREE.CanvasTexture(board);
  map.colorSpace = THREE.SRGBColorSpace;
  map.generateMipmaps = false;
  map.minFilter = THREE.LinearFilter;
  const sprite = new THREE.Sprite(new THREE.SpriteMaterial({ map, depthTest: false, sizeAttenuation: false }));
  sprite.renderOrder = 2;
  sprite.userData = { wide: board.width / fine, high: board.height / fine };
  return sprite;
};

/** The pipes: their walls let the robot be seen. */
const drawnPipes = (space, paint) => {
  const group = new THREE.Group();
  const glass = paint(new THREE.MeshPhongMaterial({ transparent: true, opacity: 0.16, side: THREE.DoubleSide, depthWrite: false, shininess: 60 }), '--wall');
  const edge = paint(new THREE.LineBasicMaterial({ transparent: true, opacity: 0.55 }), '--wall');
  const axis = paint(new THREE.LineDashedMaterial({ dashSize: 0.03, gapSize: 0.02 }), '--faint');
  for (const wall of space.walls) {
    const around = wall.around, places = Float32Array.from(wall.mm, (each) => each / 1000);
    const rings = places.length / 3 / around, corners = [];
    for (let ring = 0; ring < rings - 1; ring++) {
      for (let k = 0; k < around; k++) {
        const a = ring * around + k, b = ring * around + (k + 1) % around;
        corners.push(a, b, a + around, b, b + around, a + around);
      }
    }
    const skin = new THREE.BufferGeometry();
    skin.setAttribute('position', new THREE.BufferAttribute(places, 3));
    skin.setIndex(corners);
    skin.computeVertexNormals();
    group.add(new THREE.Mesh(skin, glass));
    for (const ring of [0, rings - 1]) {
      const line = new THREE.BufferGeometry();
      line.setAttribute('position', new THREE.BufferAttribute(places.slice(3 * ring * around, 3 * (ring + 1) * around), 3));
      group.add(new THREE.LineLoop(line, edge));
    }
  }
  const way = new THREE.Line(new THREE.BufferGeometry().setFromPoints(space.way.map(([x, y, z]) => new THREE.Vector3(x, y, z))), axis);
  way.computeLineDistances();
  group.add(way);
  return group;
};

/** The robot: boxes with a stripe on side A, wheels with a spoke; returns how it is posed. */
const drawnRobot = (group, paint) => {
  const { scene } = motion, { space, half, radius } = scene, thick = 2 * half;
  const body = paint(new THREE.MeshPhongMaterial(), '--body'), held = paint(new THREE.MeshPhongMaterial(), '--held');
  const stripe = paint(new THREE.MeshPhongMaterial(), '--drive'), tyre = paint(new THREE.MeshPhongMaterial(), '--soft');
  const spoke = paint(new THREE.MeshPhongMaterial(), '--paper'), glow = paint(new THREE.MeshBasicMaterial({ transparent: true, opacity: 0.5 }), '--light');
  const block = new THREE.BoxGeometry(1, thick, thick), mark = new THREE.BoxGeometry(0.7, 0.25 * thick, 0.3 * thick);
  const line = new THREE.BoxGeometry(0.8, 0.2 * thick, 1.06 * thick);
  const half_ = () => {
    const piece = new THREE.Group(), box = new THREE.Mesh(block, body), side = new THREE.Mesh(mark, stripe);
    side.position.y = half;
    const grip = new THREE.Mesh(line, spoke);
    piece.add(box, side, grip);
    group.add(piece);
    return { piece, box, grip };
  };
  const links = scene.wheels.slice(1).map((_, i) => (i === space.rear - 1 ? [half_(), half_()] : [half_()]));
  const wheels = scene.wheels.map(() => {
    const wheel = new THREE.Group();
    wheel.add(new THREE.Mesh(new THREE.CylinderGeometry(radius, radius, space.width, 40), tyre));
    wheel.add(new THREE.Mesh(new THREE.BoxGeometry(1.7 * radius, 1.06 * space.width, 0.2 * radius), spoke));
    group.add(wheel);
    return wheel;
  });
  const lights = scene.lights.map((light) => {
    const cone = new THREE.Mesh(new THREE.ConeGeometry(radius, 3 * radius, 24, 1, true), glow);
    group.add(cone);
    return { light, cone };
  });
  const vector = (point) => new THREE.Vector3(...point);
  /** A frame with these two directions, as far as they are square to each other. */
  const basis = (ahead, normal) => {
    const side = normal.clone().cross(ahead).normalize();
    return [ahead, side, ahead.clone().cross(side)];
  };
  const pose = (at) => {
    const places = motion.placesAt(at).map(vector);
    const normals = motion.normalsAt(at).map((each) => vector(each).normalize());
    const matrix = new THREE.Matrix4();
    const turned = (object, x, y, z) => object.quaternion.setFromRotationMatrix(matrix.makeBasis(x, y, z));
    links.forEach((halves, i) => {
      const [front, rear] = [places[i], places[i + 1]], ahead = front.clone().sub(rear).normalize();
      const long = front.distanceTo(rear) / halves.length, isHeld = Boolean(motion.heldAt(i));
      halves.forEach(({ piece, box, grip }, number) => {
        const part = halves.length > 1 ? number : Number(i >= space.rear);
        turned(piece, ...basis(ahead, normals[part]));
        piece.position.copy(front).addScaledVector(ahead, -long * (number + 0.5));
        piece.scale.x = long;
        box.material = isHeld ? held : body;
        grip.visible = isHeld;
      });
    });
    wheels.forEach((wheel, i) => {
      const next = Math.min(i, places.length - 2), ahead = places[next].clone().sub(places[next + 1]).normalize();
      const [x, , normal] = basis(ahead, normals[Number(i >= space.rear)]);
      turned(wheel, x, normal, x.clone().cross(normal));
      wheel.rotateY(valueAt(scene.wheels[i].angle, at) || 0);
      wheel.position.copy(places[i]);
    });
    lights.forEach(({ light, cone }) => {
      const front = light.at < 0.5, [tip, behind] = front ? places : [...places].reverse();
      const ahead = tip.clone().sub(behind).normalize();
      cone.visible = valueAt(light.level, at) > 0;
      cone.quaternion.setFromUnitVectors(new THREE.Vector3(0, -1, 0), ahead);
      cone.position.copy(tip).addScaledVector(ahead, 2.6 * radius);
    });
    return places;
  };
  return pose;
};

/** A level grid below everything shows where down is; returns how far apart its lines are. */
const drawnGround = (box, group, paint) => {
  const size = box.getSize(new THREE.Vector3()), long = Math.max(size.x, size.y) + 0.4;
  const apart = [0.1, 0.2, 0.5, 1, 2, 5, 10].find((each) => long / each <= 24) || 20;
  const cells = Math.ceil(long / apart), grid = new THREE.GridHelper(cells * apart, cells);
  grid.material.dispose();
  grid.geometry.deleteAttribute('color');
  grid.material = paint(new THREE.LineBasicMaterial({ transparent: true, opacity: 0.6 }), '--grid');
  grid.rotation.x = Math.PI / 2;
  const middle = box.getCenter(new THREE.Vector3());
  grid.position.set(middle.x, middle.y, box.min.z - 0.02);
  group.add(grid);
  return apart;
};

const drawSpace = () => {
  const canvas = byId('space'), space = motion && motion.scene.space;
  if (!canvas || !space) return;
  const gl = canvas.getContext('webgl2', { antialias: true, alpha: true });
  if (!gl) {
    ['space', 'space-below'].forEach((id) => { byId(id).hidden = true; });
    byId('space-off').hidden = false;
    return;
  }
  const renderer = new THREE.WebGLRenderer({ canvas, context: gl });
  const painted = [], world = new THREE.Scene(), camera = new THREE.PerspectiveCamera(40, 1, 0.01, 500);
  const paint = (material, name) => { painted.push([material, name]); return material; };
  camera.up.set(0, 0, 1);
  const pipes = drawnPipes(space, paint), box = new THREE.Box3().setFromObject(pipes);
  world.add(pipes, new THREE.AmbientLight(0xffffff, 1.6));
  const lamp = new THREE.DirectionalLight(0xffffff, 2);
  world.add(lamp, lamp.target);
  const apart = drawnGround(box, world, paint), poseAt = drawnRobot(world, paint);
  byId('space-grid').textContent = apart < 1 ? `${apart * 100} cm` : `${apart} m`;
  const ball = box.getBoundingSphere(new THREE.Sphere());
  const length = 6 * motion.scene.radius + motion.placesAt(0).slice(1).reduce((sum, p, i, all) => sum
    + Math.hypot(...p.map((v, k) => v - motion.placesAt(0)[i][k])), 0);
  const follow = byId('space-follow');
  let following = false, labels = [], tags = [];

  const render = () => {
    const places = poseAt(shown.at);
    if (following) eye.target = ['x', 'y', 'z'].map((axis) => places.reduce((sum, p) => sum + p[axis], 0) / places.length);
    const [c, low] = [Math.cos(eye.elevation), Math.sin(eye.elevation)];
    const from = [c * Math.cos(eye.azimuth), c * Math.sin(eye.azimuth), low];
    camera.position.set(...eye.target.map((v, k) => v + eye.distance * from[k]));
    camera.lookAt(...eye.target);
    lamp.position.copy(camera.position).add(new THREE.Vector3(0, 0, eye.distance / 2));
    lamp.target.position.set(...eye.target);
    tags.forEach((tag, i) => tag.position.copy(places[i]));
    renderer.render(world, camera);
    canvas.dataset.places = motion.placesAt(shown.at).map((place) => place.map((v) => v.toFixed(4)).join(',')).join(' ');
    canvas.dataset.eye = [eye.azimuth, eye.elevation, eye.distance].map((v) => v.toFixed(3)).join(' ');
  };
  const home = { target: ball.center.toArray(), azimuth: -2.0, elevation: 0.45, distance: 2.45 * ball.radius };
  const eye = orbit(canvas, home, () => {
    if (eye.moved) { eye.moved = false; toggle(false); }
    render();
  });
  const toggle = (wanted) => {
    following = wanted;
    follow.setAttribute('aria-pressed', String(wanted));
  };
  const resize = () => {
    const { width, height } = canvas.getBoundingClientRect();
    renderer.setPixelRatio(window.devicePixelRatio || 1);
    renderer.setSize(width, height, false);
    camera.aspect = width / height;
    camera.updateProjectionMatrix();
    const unit = 2 * Math.tan(camera.fov * Math.PI / 360) / height;
    for (const each of [...labels, ...tags]) each.scale.set(each.userData.wide * unit, each.userData.high * unit, 1);
    render();
  };
  const look = () => {
    for (const [material, name] of painted) material.color.set(colour(name));
    for (const each of [...labels, ...tags]) { world.remove(each); each.material.map.dispose(); each.material.dispose(); }
    labels = space.names.map(([name, x, y, z]) => {
      const sprite = label(name, 13, false);
      sprite.position.set(x, y, z);
      return sprite;
    });
    tags = motion.scene.wheels.map((_, i) => label(String(i + 1), 12, i === 0));
    world.add(...labels, ...tags);
    resize();
  };
  follow.addEventListener('click', () => {
    toggle(!following);
    if (following) eye.distance = Math.min(home.distance, 1.7 * length);
    render();
  });
  byId('space-whole').addEventListener('click', () => {
    toggle(false);
    Object.assign(eye, home, { target: [...home.target] });
    render();
  });
  new ResizeObserver(resize).observe(canvas);
  shown.on('time', render);
  shown.on('look', look);
  shown.on('size', resize);
  look();
};

drawSpace();

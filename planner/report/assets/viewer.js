"use strict";
// A 3-D view of surfaces, hulls and relation lines: surfaces by WebGL where there is any, else through a depth buffer
// of our own, so the view needs no graphics card; lines and names on a plain 2-D canvas.

const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const sub = (a, b) => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
const add = (a, b, s) => [a[0] + s * b[0], a[1] + s * b[1], a[2] + s * b[2]];
const unit = (a) => { const n = Math.hypot(...a) || 1; return [a[0] / n, a[1] / n, a[2] / n]; };

const ordinal = (n) => n + (n % 100 > 10 && n % 100 < 14 ? "th" : ["th", "st", "nd", "rd"][n % 10] || "th");

const rgb = (colour) => [1, 3, 5].map((i) => parseInt(colour.slice(i, i + 2), 16));

// What base64 holds; `Uint8Array.from` goes through a text several times as slowly as a loop.
function bytesOf(text) {
  const letters = atob(text), bytes = new Uint8Array(letters.length);
  for (let i = 0; i < bytes.length; i++) bytes[i] = letters.charCodeAt(i);
  return bytes.buffer;
}

// Coordinates come as 16-bit steps from the lower corner of the object's box.
function unpack({ points, lower, step }) {
  const steps = new Uint16Array(bytesOf(points)), places = new Float32Array(steps.length);
  for (let i = 0; i < steps.length; i++) places[i] = lower[i % 3] + steps[i] * step;
  return places;
}

class Viewer {
  // scene: what `Drawing.to_json` wrote, with `relations`, `places` (order numbers) and `path` added.
  // onPick(index or -1, pinned) hears what the pointer is over and what was clicked.
  constructor(canvas, scene, onPick) {
    this.canvas = canvas;
    this.scene = scene;
    this.show = { surfaces: true, hulls: false, relations: true, names: true, order: true, path: true, arm: true, arrows: true };
    this.also = []; // corners that are to stay in sight besides
    this.moved = new Map(); // number of an object -> where it is now, if it is not where it was
    this.busy = false; // turned or played: drawn coarser, at once
    this.lit = new Set();
    this.clouds = scene.objects.map(unpack);
    this.normals = scene.objects.map((o) => new Int8Array(bytesOf(o.normals)));
    this.colours = scene.objects.map((o) => rgb(o.paint));
    this.frame(); this.reset();
    this.listen(onPick);
    new ResizeObserver(() => { if (this.size().some((v, i) => v !== [canvas.width, canvas.height][i])) this.redraw(); }).observe(canvas);
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => this.redraw());
  }

  // Axes of the turntable: yaw is counted about `up` from the axis the first view looks along.
  frame() {
    this.up = unit(this.scene.up);
    const look = sub(this.scene.eye, this.scene.centre);
    this.east = unit(add(look, this.up, -dot(look, this.up)));
    this.north = cross(this.up, this.east);
  }

  reset() {
    const look = sub(this.scene.eye, this.scene.centre);
    this.target = this.middle ? this.middle.slice() : this.scene.centre.slice();
    this.yaw = 0;
    this.pitch = Math.asin(dot(unit(look), this.up));
    this.distance = 0; // until the size of the canvas is known
    this.stir(); // a coarse picture first, before WebGL is set up
    this.redraw();
  }

  // Puts the arm and what it carries where they are at a time of a motion.
  pose(motion, time) {
    const { links, moved } = motion.at(time);
    this.arm = motion.parts.map((part, i) => ({ ...part, pose: links[part.at], number: this.scene.objects.length + i }));
    for (const { number, colour } of this.arm) this.colours[number] = colour;
    this.moved = moved;
    this.redraw();
  }

  redraw() {
    if (this.waiting) return;
    this.waiting = true;
    requestAnimationFrame(() => { this.waiting = false; this.draw(); });
  }

  // Camera axes: right, down, forward; and the eye.
  place() {
    const level = add(this.east.map((v) => v * Math.cos(this.yaw)), this.north, Math.sin(this.yaw));
    const back = add(level.map((v) => v * Math.cos(this.pitch)), this.up, Math.sin(this.pitch));
    this.forward = back.map((v) => -v);
    this.focal = 1.5 * Math.min(this.canvas.width, this.canvas.height);
    this.right = unit(cross(this.forward, this.up));
    this.down = cross(this.forward, this.right);
    this.distance ||= this.fit();
    this.eye = add(this.target, back, this.distance);
  }

  // Frames the view on some corners besides those of what can be taken.
  include(corners) {
    this.also = corners;
    const all = [...this.taken().flatMap((object) => object.corners), ...corners];
    this.middle = [0, 1, 2].map((i) => (Math.min(...all.map((p) => p[i])) + Math.max(...all.map((p) => p[i]))) / 2);
    this.reset();
  }

  taken() { return this.scene.objects.filter((o, _, all) => !o.fixed || all.every((other) => other.fixed)); }

  // Nearest the eye may come for every corner of what can be taken to stay in sight.
  fit() {
    const w = 0.42 * this.canvas.width, h = 0.38 * this.canvas.height;
    let distance = this.scene.radius * 1.5;
    for (const corner of [...this.taken().flatMap((object) => object.corners), ...this.also]) {
      const p = sub(corner, this.target);
      const aside = Math.max(Math.abs(dot(p, this.right)) / w, Math.abs(dot(p, this.down)) / h);
      distance = Math.max(distance, aside * this.focal - dot(p, this.forward));
    }
    return distance;
  }

  project(p) {
    const d = sub(p, this.eye), z = dot(d, this.forward);
    if (z < this.distance * 0.02) return null;
    const s = this.focal / z;
    return [this.canvas.width / 2 + s * dot(d, this.right), this.canvas.height / 2 + s * dot(d, this.down), z];
  }

  size() { return [this.canvas.clientWidth, this.canvas.clientHeight].map((v) => Math.round(v * this.scale)); }

  draw() {
    this.scale = this.busy ? Math.min(devicePixelRatio || 1, 1.5) : Math.max(devicePixelRatio || 1, 2); // smooths edges
    const [width, height] = this.size();
    if (!width || !height) return;
    if (this.canvas.width !== width || this.canvas.height !== height) [this.canvas.width, this.canvas.height] = [width, height];
    const style = getComputedStyle(this.canvas);
    this.paper = style.backgroundColor.match(/\d+/g).slice(0, 3).map(Number);
    this.ink = style.color;
    this.place();
    const context = this.canvas.getContext("2d");
    context.clearRect(0, 0, width, height);
    const coarse = this.busy && Light.one?.slow !== false, light = !coarse && this.colours.length < MOST && Light.get();
    if (!light) this.drawPlainly(context, width, height);
    else {
      const begun = performance.now();
      context.drawImage(light.render(this, width, height), 0, 0);
      light.slow = performance.now() - begun > 60; // without a graphics card
    }
    if (this.show.hulls) this.drawHulls(context);
    if (this.show.relations) this.drawRelations(context);
    if (this.show.path && this.scene.path) this.drawPath(context);
    if (this.show.arrows && this.scene.arrows) this.drawArrows(context);
    this.drawLabels(context);
  }

  // Without WebGL: squares and triangles through a depth buffer of our own, without shadows.
  drawPlainly(context, width, height) {
    const image = context.createImageData(width, height), pixels = new Uint32Array(image.data.buffer);
    const depths = new Float32Array(width * height).fill(Infinity), { eye, right, down, forward, focal, scene, paper } = this;
    const lamp = unit(add(add(forward.map((v) => -v), this.up, 0.9), right, -0.5));
    const paint = (number, side, guessed) => {
      const shine = 0.5 + 0.55 * Math.abs(side), faint = this.dimmed(number) ? 0.78 : guessed || scene.objects[number]?.fixed ? 0.6 : 0;
      return this.colours[number].reduce((all, c, i) => all | (Math.min(255, c * shine) * (1 - faint) + paper[i] * faint) << 8 * i, 0xff000000);
    };
    const put = (u0, u1, v0, v1, tint, depth) => {
      for (let v = Math.max(0, Math.ceil(v0)); v <= Math.min(height - 1, v1); v++) {
        for (let u = Math.max(0, Math.ceil(u0)), k = v * width + u; u <= Math.min(width - 1, u1); u++, k++) {
          const far = typeof depth === "number" ? depth : depth(u, v);
          if (far < depths[k]) { depths[k] = far; pixels[k] = tint; }
        }
      }
    };
    if (this.show.surfaces) scene.objects.forEach(({ seen, spacing }, index) => {
      const points = this.clouds[index], normals = this.normals[index], pose = this.moved.get(index) || STILL;
      const own = (axis) => [0, 1, 2].map((j) => dot(axis, [pose[0][j], pose[1][j], pose[2][j]])).concat(dot(axis, sub(pose[3], eye)));
      const [r, d, f, l] = [right, down, forward, lamp].map(own); // turned into the object's frame, so that no point is
      const along = (axis, i) => axis[0] * points[i] + axis[1] * points[i + 1] + axis[2] * points[i + 2] + axis[3];
      const tints = [false, true].map((guessed) => Array.from({ length: 140 }, (_, side) => paint(index, side / 127, guessed)));
      for (let i = 0; i < points.length; i += 3) {
        const far = along(f, i), s = focal / far, half = Math.max(0.8, s * spacing);
        const u = width / 2 + s * along(r, i), v = height / 2 + s * along(d, i);
        const side = Math.abs(l[0] * normals[i] + l[1] * normals[i + 1] + l[2] * normals[i + 2]) | 0;
        if (far > this.distance * 0.02) put(u - half, u + half, v - half, v + half, tints[i < 3 * seen ? 0 : 1][side], far);
      }
    });
    if (this.show.arm) for (const { corners, normals, pose, number } of this.arm || []) {
      for (let i = 0; i < corners.length; i += 9) {
        const [a, b, c] = [0, 3, 6].map((j) => this.project(placed(pose, corners.subarray(i + j, i + j + 3))));
        const area = a && b && c && (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
        if (!area) continue;
        put(Math.min(a[0], b[0], c[0]), Math.max(a[0], b[0], c[0]), Math.min(a[1], b[1], c[1]), Math.max(a[1], b[1], c[1]),
          paint(number, dot(unit(turned(pose, normals.subarray(i, i + 3))), lamp), false), (u, v) => {
            const e = ((b[0] - u) * (c[1] - v) - (b[1] - v) * (c[0] - u)) / area, f = ((c[0] - u) * (a[1] - v) - (c[1] - v) * (a[0] - u)) / area;
            return e < 0 || f < 0 || e + f > 1 ? Infinity : 1 / (e / a[2] + f / b[2] + (1 - e - f) / c[2]);
          });
      }
    }
    context.putImageData(image, 0, 0);
  }

  dimmed(index) { return this.lit.size > 0 && !this.lit.has(index); }

  line(context, a, b) {
    const from = this.project(a), to = this.project(b);
    if (!from || !to) return null;
    context.beginPath();
    context.moveTo(from[0], from[1]);
    context.lineTo(to[0], to[1]);
    context.stroke();
    return [from, to];
  }

  drawHulls(context) {
    this.scene.objects.forEach((object, index) => {
      if (object.fixed && !this.lit.has(index)) return; // the box of a table hides more than it says
      context.strokeStyle = `rgb(${this.colours[index].map((c) => c * 0.55).join(",")})`;
      context.globalAlpha = this.dimmed(index) ? 0.1 : this.lit.size ? 0.9 : 0.6;
      context.lineWidth = this.scale * (this.lit.has(index) ? 1.5 : 1);
      for (const [a, b] of object.edges) this.line(context, this.now(index, object.corners[a]), this.now(index, object.corners[b]));
    });
    context.globalAlpha = 1;
  }

  // Where a point of an object is at the time that is played.
  now(index, p) { return this.moved.has(index) ? placed(this.moved.get(index), p) : p; }

  drawRelations(context) {
    for (const { a, b, colour, dashed, faint } of this.scene.relations) {
      if (this.moved.has(a) || this.moved.has(b)) continue; // what was seen holds no more
      const off = this.lit.size > 0 && !(this.lit.has(a) && this.lit.has(b) && (a === this.focus || b === this.focus));
      context.globalAlpha = off ? 0.15 : faint ? 0.5 : 1;
      context.strokeStyle = context.fillStyle = colour;
      context.lineWidth = this.scale * (faint ? 1.2 : 2.4);
      context.setLineDash(dashed ? [6 * this.scale, 5 * this.scale] : []);
      const ends = this.line(context, this.anchor(a, b), this.anchor(b, a));
      context.setLineDash([]);
      if (ends && !faint) this.arrow(context, ...ends);
    }
    context.globalAlpha = 1;
  }

  // A line to a table ends below or beside the other object, not at the middle of the table.
  anchor(index, other) {
    const object = this.scene.objects[index], centre = object.centre;
    if (!object.fixed || this.scene.objects[other].fixed) return centre;
    const beside = this.scene.objects[other].centre;
    return add(beside, this.up, dot(sub(centre, beside), this.up));
  }

  // With its head after a share of the way.
  arrow(context, from, to, share = 0.62) {
    const dx = to[0] - from[0], dy = to[1] - from[1], n = Math.hypot(dx, dy), size = 9 * this.scale;
    if (n < (share < 1 ? 2 : 1) * size) return;
    const [x, y] = [from[0] + share * dx, from[1] + share * dy], [u, v] = [dx / n * size, dy / n * size];
    context.beginPath();
    context.moveTo(x, y);
    context.lineTo(x - u - v * 0.45, y - v + u * 0.45);
    context.lineTo(x - u + v * 0.45, y - v - u * 0.45);
    context.fill();
  }

  // Forces and margins: each has its head at its end.
  drawArrows(context) {
    context.lineWidth = 2.4 * this.scale;
    for (const { from, to, colour, object } of this.scene.arrows) {
      context.globalAlpha = this.dimmed(object) ? 0.1 : 1;
      context.strokeStyle = context.fillStyle = colour;
      const ends = this.line(context, from, to);
      if (ends) this.arrow(context, ...ends, 1);
    }
    context.globalAlpha = 1;
  }

  drawPath(context) {
    context.strokeStyle = this.ink;
    context.lineWidth = 2 * this.scale;
    context.setLineDash([2 * this.scale, 3 * this.scale]);
    context.beginPath();
    let started = false;
    for (const point of this.scene.path) {
      const p = this.project(point);
      if (!p) continue;
      if (started) context.lineTo(p[0], p[1]); else context.moveTo(p[0], p[1]);
      started = true;
    }
    context.stroke();
    context.setLineDash([]);
  }

  // Near objects are labelled first; a label that would cover another is left out unless it is lit.
  drawLabels(context) {
    const size = 12 * this.scale, taken = [];
    context.font = `600 ${size}px system-ui, sans-serif`;
    context.textBaseline = "middle";
    const labels = this.scene.objects.map((object, index) => ({ object, index, at: this.project(this.now(index, object.top)) }));
    labels.sort((a, b) => this.lit.has(b.index) - this.lit.has(a.index) || (a.at ? a.at[2] : 1e9) - (b.at ? b.at[2] : 1e9));
    for (const { object, index, at } of labels) {
      if (!at || this.dimmed(index) || (object.fixed && !this.lit.has(index))) continue;
      const place = this.show.order && this.scene.places ? this.scene.places[index] : 0, number = place ? ordinal(place) : "";
      const name = object.name.length > 24 ? object.name.slice(0, 23) + "…" : object.name;
      const text = this.show.names ? name : "", pad = 5 * this.scale, h = size + 6 * this.scale;
      const badge = place ? Math.max(h, context.measureText(number).width + 2 * pad) : 3 * this.scale;
      if (!text && !place) continue;
      const w = badge + (text ? context.measureText(text).width + 2 * pad : 0);
      const box = [at[0] - w / 2, at[1] - h, w, h];
      if (taken.some((t) => box[0] < t[0] + t[2] && t[0] < box[0] + w && box[1] < t[1] + t[3] && t[1] < box[1] + h)) continue;
      taken.push(box);
      context.fillStyle = `rgba(${this.paper.join(",")},0.85)`;
      context.fillRect(...box);
      context.fillStyle = object.colour;
      context.fillRect(box[0], box[1], badge, h);
      context.fillStyle = this.ink;
      context.fillText(text, box[0] + badge + pad, at[1] - h / 2 + 0.5);
      if (!place) continue;
      context.fillStyle = object.ink;
      context.fillText(number, box[0] + (badge - context.measureText(number).width) / 2, at[1] - h / 2 + 0.5);
    }
  }

  // Lights objects up; the first is the one the others are lit for.
  light(indices) {
    this.focus = indices.length ? indices[0] : -1;
    this.lit = new Set(indices);
    this.redraw();
  }

  under(event) {
    const box = this.canvas.getBoundingClientRect();
    const x = (event.clientX - box.left) * this.scale, y = (event.clientY - box.top) * this.scale;
    let found = -1, nearest = Infinity;
    if (this.show.surfaces) this.clouds.forEach((points, index) => {
      const wide = Math.max(this.scene.objects[index].spacing, 0.0008) * this.focal;
      for (let i = 0; i < points.length; i += 3) {
        const [u, v, far] = this.project(this.now(index, [points[i], points[i + 1], points[i + 2]])) || [0, 0, Infinity];
        if (far < nearest && Math.hypot(u - x, v - y) < wide / far + this.scale) [found, nearest] = [index, far];
      }
    });
    return found;
  }

  turn(dx, dy) {
    this.yaw -= dx * 0.008;
    this.pitch = Math.max(-1.5, Math.min(1.5, this.pitch + dy * 0.008));
    this.stir();
    this.redraw();
  }

  shift(dx, dy) {
    const step = this.distance / this.focal * this.scale;
    this.target = add(add(this.target, this.right, -dx * step), this.down, -dy * step);
    this.stir();
    this.redraw();
  }

  // Draws coarsely while somebody turns or zooms, and finely a moment later.
  stir() {
    this.busy = true;
    clearTimeout(this.calming);
    this.calming = setTimeout(() => { this.busy = false; this.redraw(); }, 150);
  }

  zoom(factor) {
    this.distance = Math.max(this.scene.radius * 0.2, Math.min(this.scene.radius * 30, this.distance * factor));
    this.stir();
    this.redraw();
  }

  listen(onPick) {
    const canvas = this.canvas, fingers = new Map();
    let moved = 0;
    canvas.addEventListener("pointerdown", (event) => {
      canvas.setPointerCapture(event.pointerId);
      fingers.set(event.pointerId, [event.clientX, event.clientY]);
      moved = 0;
    });
    canvas.addEventListener("pointermove", (event) => {
      const last = fingers.get(event.pointerId);
      if (!last) { onPick(this.under(event), false); return; }
      const [dx, dy] = [event.clientX - last[0], event.clientY - last[1]];
      const apart = () => { const [p, q] = [...fingers.values()]; return Math.hypot(p[0] - q[0], p[1] - q[1]) || 1; };
      const before = fingers.size === 2 ? apart() : 0;
      fingers.set(event.pointerId, [event.clientX, event.clientY]);
      moved += Math.abs(dx) + Math.abs(dy);
      if (fingers.size === 2) this.zoom(before / apart());
      else if (event.shiftKey || event.buttons & 6) this.shift(dx, dy);
      else this.turn(dx, dy);
    });
    const lift = (event) => {
      if (fingers.delete(event.pointerId) && moved < 4 && event.type === "pointerup") onPick(this.under(event), true);
    };
    for (const kind of ["pointerup", "pointercancel"]) canvas.addEventListener(kind, lift);
    canvas.addEventListener("pointerleave", () => onPick(-1, false));
    canvas.addEventListener("contextmenu", (event) => event.preventDefault());
    canvas.addEventListener("wheel", (event) => { event.preventDefault(); this.zoom(Math.exp(event.deltaY * 0.0012)); }, { passive: false });
    canvas.addEventListener("keydown", (event) => {
      const turns = { ArrowLeft: [-12, 0], ArrowRight: [12, 0], ArrowUp: [0, 12], ArrowDown: [0, -12] };
      if (turns[event.key]) this.turn(...turns[event.key]);
      else if (event.key === "+") this.zoom(0.9);
      else if (event.key === "-") this.zoom(1.1);
      else return;
      event.preventDefault();
      event.stopPropagation();
    });
  }
}

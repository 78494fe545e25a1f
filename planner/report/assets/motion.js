"use strict";
// What an arm does, played back in a view: link shapes come once, poses for key frames, and in between they are mixed.

const SHORT = 1e-4; // metres in a step of a length
const shorts = (text) => Float32Array.from(new Int16Array(bytesOf(text)));

// A pose of seven numbers (position in steps, quaternion) between two frames, as [rotation by rows, position in metres].
function mixed(poses, at, next, share) {
  let same = 0;
  for (let i = 3; i < 7; i++) same += poses[at + i] * poses[next + i];
  const p = [], sign = same < 0 ? -1 : 1;
  for (let i = 0; i < 7; i++) p.push(poses[at + i] * (1 - share) + poses[next + i] * share * (i < 3 ? 1 : sign));
  const n = Math.hypot(p[3], p[4], p[5], p[6]), [x, y, z, w] = p.slice(3).map((v) => v / n);
  return [[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
    [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
    [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)], p.slice(0, 3).map((v) => v * SHORT)];
}

// A normal for each corner of each triangle: that of the triangles about the corner which differ little from its own.
function smoothed(vertices, faces) {
  const at = (k) => [vertices[3 * k], vertices[3 * k + 1], vertices[3 * k + 2]], own = [], about = [];
  for (let i = 0; i < faces.length; i += 3) {
    const [a, b, c] = [at(faces[i]), at(faces[i + 1]), at(faces[i + 2])], area = cross(sub(b, a), sub(c, a));
    own.push({ area, normal: unit(area) });
    for (let j = 0; j < 3; j++) (about[faces[i + j]] ||= []).push(i / 3);
  }
  return faces.map((corner, i) => {
    const mine = own[Math.floor(i / 3)].normal, near = about[corner].filter((f) => dot(own[f].normal, mine) > 0.75);
    return unit(near.reduce((sum, f) => add(sum, own[f].area, 1), [0, 0, 0]));
  });
}

class Motion {
  // data: what `motion_json` wrote; arm: what `arm_shape` wrote.
  constructor(data, arm) {
    this.data = data;
    this.count = arm.links.length;
    this.last = data.times[data.times.length - 1];
    this.parts = arm.parts.map(({ at, colour, vertices, faces }) => {
      const places = shorts(vertices).map((v) => v * SHORT), corners = [...shorts(faces)];
      const points = corners.flatMap((k) => [places[3 * k], places[3 * k + 1], places[3 * k + 2]]);
      return { at, colour: rgb(colour), corners: Float32Array.from(points), normals: Float32Array.from(smoothed(places, corners).flat()) };
    });
    this.poses = shorts(data.links);
    if (data.beside) { // another such arm stands still
      this.still = shorts(data.beside);
      this.parts.push(...this.parts.map((part) => ({ ...part, at: part.at + this.count })));
    }
    this.carried = data.carried.map(({ object, poses }) => ({ object, poses: shorts(poses) }));
  }

  // Poses of all links, and of what is or was carried by its number, at a time.
  at(time) {
    const { times, centre } = this.data, count = this.count;
    let k = 0;
    while (k < times.length - 1 && times[k + 1] <= time) k++;
    const next = Math.min(k + 1, times.length - 1), wide = times[next] - times[k];
    const share = wide > 0 ? Math.min(1, (time - times[k]) / wide) : 0;
    const links = Array.from({ length: this.still ? 2 * count : count }, (_, i) => {
      const pose = i < count ? mixed(this.poses, 7 * (k * count + i), 7 * (next * count + i), share) : mixed(this.still, 7 * (i - count), 7 * (i - count), 0);
      pose[3] = add(pose[3], centre, 1);
      return pose;
    });
    const moved = new Map();
    for (const { object, poses } of this.carried) {
      const pose = mixed(poses, 7 * k, 7 * next, share), at = pose[3];
      const still = Math.hypot(...at) < 2e-4 && pose[0][0] + pose[1][1] + pose[2][2] > 3 - 1e-5;
      pose[3] = sub(add(at, centre, 1), [0, 1, 2].map((i) => dot(pose[i], centre)));
      if (!still) moved.set(object, pose);
    }
    return { links, moved };
  }
}

const turned = (pose, n) => [dot(pose[0], n), dot(pose[1], n), dot(pose[2], n)];
const placed = (pose, p) => [0, 1, 2].map((i) => dot(pose[i], p) + pose[3][i]);

// The switches of a time line: play, scrub, and what the arm does then.
class Player {
  constructor(root, viewer, motion) {
    this.viewer = viewer;
    this.motion = motion;
    this.button = root.querySelector("[data-play]");
    this.slider = root.querySelector("input");
    this.output = root.querySelector("output");
    this.bands = [...root.querySelectorAll(".bands span")];
    this.playing = false;
    this.hearers = []; // told which band is played
    this.slider.addEventListener("input", () => { this.stop(); this.seek(Number(this.slider.value)); });
    this.button.addEventListener("click", () => (this.playing ? this.stop() : this.play()));
    this.bands.forEach((band, i) => band.addEventListener("click", () => { this.stop(); this.seek(motion.data.bands[i][1]); }));
    viewer.include(motion.data.times.flatMap((time) => [...motion.at(time).moved].map(([object, pose]) => placed(pose, viewer.scene.objects[object].top))));
    this.seek(0);
  }

  seek(time) {
    this.time = Math.max(0, Math.min(this.motion.last, time));
    this.slider.value = this.time;
    const within = (parts) => Math.max(0, parts.findLastIndex(([, first]) => first <= this.time + 1e-6));
    const { spans, bands } = this.motion.data, now = within(bands), doing = spans[within(spans)][0];
    this.bands.forEach((band, i) => band.classList.toggle("now", i === now));
    this.output.textContent = `${bands[now][0] === doing ? "" : bands[now][0] + ": "}${doing}, ${this.time.toFixed(1)} of ${this.motion.last.toFixed(1)} s`;
    this.slider.setAttribute("aria-valuetext", this.output.textContent);
    this.viewer.pose(this.motion, this.time);
    for (const heard of this.hearers) heard(now);
  }

  play() {
    if (this.time >= this.motion.last - 1e-3) this.seek(0);
    this.playing = this.viewer.busy = true;
    this.button.textContent = "pause";
    let before = performance.now();
    const tick = (now) => {
      if (!this.playing) return;
      this.seek(this.time + (now - before) / 1000);
      before = now;
      if (this.time >= this.motion.last - 1e-3) this.stop(); else requestAnimationFrame(tick);
    };
    requestAnimationFrame(tick);
  }

  stop() {
    this.playing = this.viewer.busy = false;
    this.button.textContent = "play";
    this.viewer.redraw();
  }
}

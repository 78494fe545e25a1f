"use strict";
// The same surfaces by WebGL, lit by a sun that throws shadows: what is seen where goes into textures, from the eye
// and from the sun, and one more pass colours the pixels. One context serves all views of a page.

const FAR = 100, MAP = 1536, MOST = 250; // metres that are seen; pixels across the sun's picture; numbers there are
const matrix = (rows) => [0, 1, 2, 3].flatMap((column) => rows.map((row) => row[column])); // as WebGL has it
const row = (axis, scale, from, more = 0) => [...axis.map((v) => scale * v), more - scale * dot(axis, from)];
const STILL = [[1, 0, 0], [0, 1, 0], [0, 0, 1], [0, 0, 0]];

const SURFACE = [`#version 300 es
  precision highp float;
  uniform mat4 pose, view; uniform vec4 deep; uniform vec3 sun, right, down, forward; uniform float focal, radius, seen;
  in vec3 at, normal; out float far, bright; out vec2 slope; flat out float guessed;
  void main() {
    vec4 p = pose * vec4(at, 1.0); vec3 n = mat3(pose) * normal;
    gl_Position = view * p;
    float wide = max(0.8, focal * radius / gl_Position.w), facing = dot(n, forward), steep = (facing < 0.0 ? -1.0 : 1.0) * max(abs(facing), 0.3);
    gl_PointSize = 2.0 * wide;
    slope = -vec2(dot(n, right), dot(n, down)) / steep * wide * gl_Position.w / focal * length(deep.xyz);
    far = dot(deep, p); bright = abs(dot(n, sun)); guessed = float(gl_VertexID) < seen ? 0.0 : 1.0;
  }`, `#version 300 es
  precision highp float;
  uniform float number, radius; in float far, bright; in vec2 slope; flat in float guessed; out vec4 found;
  void main() {
    vec2 off = radius > 0.0 ? 2.0 * gl_PointCoord - 1.0 : vec2(0.0);
    if (dot(off, off) > 1.0) discard;
    gl_FragDepth = far + dot(slope, off);
    found = vec4((number + 1.0) / 255.0, bright, guessed, 1.0);
  }`];
const PIXELS = [`#version 300 es
  void main() { gl_Position = vec4(gl_VertexID == 1 ? 3.0 : -1.0, gl_VertexID == 2 ? 3.0 : -1.0, 0.0, 1.0); }`, `#version 300 es
  precision highp float;
  uniform sampler2D found, depths, dark, paints; uniform mat4 lamp; uniform vec4 away; uniform vec3 eye, right, down, forward, paper;
  uniform vec2 size, soft; uniform float focal, stripe, strength; out vec4 colour;
  float depth(vec2 off) { return texelFetch(depths, clamp(ivec2(gl_FragCoord.xy + off), ivec2(0), ivec2(size) - 1), 0).r * ${FAR}.0; }
  void main() {
    vec4 here = texelFetch(found, ivec2(gl_FragCoord.xy), 0);
    if (here.a == 0.0) discard;
    vec4 paint = texelFetch(paints, ivec2(int(here.r * 255.0 + 0.5) - 1, 0), 0);
    vec2 off = gl_FragCoord.xy - size / 2.0;
    float far = depth(vec2(0.0)), hidden = 0.0, fold = 0.0, turn = fract(sin(dot(off, vec2(12.9898, 78.233))) * 43758.5) * 6.283;
    vec4 p = vec4(eye + far * (forward + (off.x * right - off.y * down) / focal), 1.0);
    vec2 q = (lamp * p).xy * 0.5 + 0.5;
    for (int k = 0; k < 16; k++) {
      vec2 step = sqrt((float(k) + 0.5) / 16.0) * vec2(cos(turn + 2.39996 * float(k)), sin(turn + 2.39996 * float(k)));
      hidden += texture(dark, q + soft.x * step).r < dot(away, p) - soft.y ? 0.0625 : 0.0;
      fold += clamp(far - depth(step * 8.0) - 0.004, 0.0, 0.03) * 0.0625;
    }
    bool table = paint.a > 0.25 && paint.a < 0.75, dim = paint.a < 0.25, hatched = mod(floor((off.x - off.y) / stripe), 2.0) == 0.0;
    if (any(greaterThan(abs(q - 0.5), vec2(0.48)))) hidden = 0.0;
    vec3 lit = table ? mix(paint.rgb, paper, 0.6) * (1.0 - 0.4 * hidden)
      : min(paint.rgb * max(0.3, 0.62 + 0.48 * here.g - (0.2 + 0.3 * here.g) * hidden - fold * strength), 1.0);
    colour = vec4(mix(lit, paper, dim ? 0.78 : here.b > 0.5 ? (hatched ? 0.72 : 0.3) : 0.0), 1.0);
  }`];

class Light {
  // That of the page, or something false where there is no WebGL.
  static get() {
    try { Light.one ??= new Light(new OffscreenCanvas(1, 1).getContext("webgl2", { failIfMajorPerformanceCaveat: true })); } catch { Light.one = 0; }
    return Light.one && !Light.one.gl.isContextLost() && Light.one;
  }

  constructor(gl) {
    this.gl = gl;
    this.slow = true; // until a picture was drawn
    this.surface = this.program(SURFACE);
    this.pixels = this.program(PIXELS);
    gl.useProgram(this.pixels);
    ["found", "depths", "dark", "paints"].forEach((name, unit) => gl.uniform1i(gl.getUniformLocation(this.pixels, name), unit));
    this.sun = this.target(MAP, MAP);
    this.paints = this.texture(gl.RGBA8, MOST, 1);
    this.kept = new WeakMap(); // what was uploaded before
  }

  program([vertex, fragment]) {
    const { gl } = this, program = gl.createProgram();
    for (const [kind, text] of [[gl.VERTEX_SHADER, vertex], [gl.FRAGMENT_SHADER, fragment]]) {
      const shader = gl.createShader(kind);
      gl.shaderSource(shader, text); gl.compileShader(shader); gl.attachShader(program, shader);
    }
    ["at", "normal"].forEach((name, place) => gl.bindAttribLocation(program, place, name));
    gl.linkProgram(program);
    if (!gl.getProgramParameter(program, gl.LINK_STATUS)) throw new Error(gl.getProgramInfoLog(program));
    return program;
  }

  texture(format, width, height) {
    const { gl } = this, texture = gl.createTexture();
    gl.bindTexture(gl.TEXTURE_2D, texture);
    gl.texStorage2D(gl.TEXTURE_2D, 1, format, width, height);
    for (const side of [gl.TEXTURE_WRAP_S, gl.TEXTURE_WRAP_T]) gl.texParameteri(gl.TEXTURE_2D, side, gl.CLAMP_TO_EDGE);
    for (const size of [gl.TEXTURE_MIN_FILTER, gl.TEXTURE_MAG_FILTER]) gl.texParameteri(gl.TEXTURE_2D, size, gl.NEAREST);
    return texture;
  }

  target(width, height) {
    const { gl } = this, frame = gl.createFramebuffer();
    const found = this.texture(gl.RGBA8, width, height), depths = this.texture(gl.DEPTH_COMPONENT32F, width, height);
    gl.bindFramebuffer(gl.FRAMEBUFFER, frame);
    gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, gl.TEXTURE_2D, found, 0);
    gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.DEPTH_ATTACHMENT, gl.TEXTURE_2D, depths, 0);
    return { frame, found, depths, width, height };
  }

  // Points and normals of a surface, uploaded once.
  take(points, normals) {
    const { gl } = this;
    if (!this.kept.has(points)) {
      this.kept.set(points, gl.createVertexArray());
      gl.bindVertexArray(this.kept.get(points));
      for (const [place, values, kind] of [[0, points, gl.FLOAT], [1, normals, normals instanceof Int8Array ? gl.BYTE : gl.FLOAT]]) {
        gl.bindBuffer(gl.ARRAY_BUFFER, gl.createBuffer()); gl.bufferData(gl.ARRAY_BUFFER, values, gl.STATIC_DRAW);
        gl.enableVertexAttribArray(place); gl.vertexAttribPointer(place, 3, kind, kind === gl.BYTE, 0, 0);
      }
    }
    gl.bindVertexArray(this.kept.get(points));
  }

  set(program, values) {
    const { gl } = this;
    gl.useProgram(program);
    for (const [name, value] of Object.entries(values)) {
      const place = gl.getUniformLocation(program, name), size = value.length || 1;
      if (size === 16) gl.uniformMatrix4fv(place, false, value);
      else gl[`uniform${size}fv`](place, [value].flat());
    }
  }

  // What is seen of a viewer's surfaces by one who looks along an axis, in a target.
  look(viewer, target, seen) {
    const { gl } = this;
    gl.bindFramebuffer(gl.FRAMEBUFFER, target.frame); gl.viewport(0, 0, target.width, target.height);
    gl.enable(gl.DEPTH_TEST); gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    this.set(this.surface, seen);
    const posed = ([x, y, z, at] = STILL) => matrix([[...x, at[0]], [...y, at[1]], [...z, at[2]], [0, 0, 0, 1]]);
    if (viewer.show.surfaces) viewer.scene.objects.forEach((object, number) => {
      this.take(viewer.clouds[number], viewer.normals[number]);
      const radius = Math.max(object.spacing * 1.15, 0.0008);
      this.set(this.surface, { pose: posed(viewer.moved.get(number)), number, radius, seen: object.seen });
      gl.drawArrays(gl.POINTS, 0, viewer.clouds[number].length / 3);
    });
    if (viewer.show.arm) for (const { corners, normals, pose, number } of viewer.arm || []) {
      this.take(corners, normals);
      this.set(this.surface, { pose: posed(pose), number, radius: 0, seen: 1e9 });
      gl.drawArrays(gl.TRIANGLES, 0, corners.length / 3);
    }
  }

  // The picture of what a viewer shows.
  render(viewer, width, height) {
    const { gl } = this, { scene, eye, right, down, forward, focal } = viewer, middle = viewer.middle || scene.centre;
    if (gl.canvas.width !== width || gl.canvas.height !== height || !this.seen) {
      [gl.canvas.width, gl.canvas.height] = [width, height];
      if (this.seen) [this.seen.found, this.seen.depths].forEach((texture) => gl.deleteTexture(texture));
      this.seen = this.target(width, height);
    }
    const sun = unit(add(add(viewer.up, viewer.east, 0.3), viewer.north, -0.5)), ahead = sun.map((v) => -v);
    const across = unit(cross(ahead, viewer.east)), along = cross(ahead, across), reach = 1.5 * scene.radius + 0.15;
    const lamp = matrix([row(across, 1 / reach, middle), row(along, -1 / reach, middle), [0, 0, 0, 0], [0, 0, 0, 1]]);
    const away = row(ahead, 0.25 / reach, middle, 0.5), none = [0, 0, 0, 0];
    this.look(viewer, this.sun, { sun, view: lamp, deep: away, right: across, down: along, forward: ahead, focal: MAP / 2 / reach });
    const view = matrix([row(right, 2 * focal / width, eye), row(down, -2 * focal / height, eye), none, row(forward, 1, eye)]);
    this.look(viewer, this.seen, { sun, view, deep: row(forward, 1 / FAR, eye), right, down, forward, focal });
    const paints = new Uint8Array(4 * MOST);
    viewer.colours.forEach((colour, i) => paints.set([...colour, viewer.dimmed(i) ? 0 : scene.objects[i]?.fixed ? 128 : 255], 4 * i));
    const textures = [this.seen.found, this.seen.depths, this.sun.depths, this.paints];
    textures.forEach((texture, unit) => { gl.activeTexture(gl.TEXTURE0 + unit); gl.bindTexture(gl.TEXTURE_2D, texture); });
    gl.texSubImage2D(gl.TEXTURE_2D, 0, 0, 0, MOST, 1, gl.RGBA, gl.UNSIGNED_BYTE, paints);
    gl.bindFramebuffer(gl.FRAMEBUFFER, null); gl.viewport(0, 0, width, height);
    gl.disable(gl.DEPTH_TEST); gl.clear(gl.COLOR_BUFFER_BIT);
    const paper = viewer.paper.map((v) => v / 255), stripe = 4 * viewer.scale, soft = [0.004 / reach, 0.0015 / reach];
    this.set(this.pixels, { lamp, away, eye, right, down, forward, paper, size: [width, height], soft, focal, stripe, strength: 14 / scene.radius });
    gl.drawArrays(gl.TRIANGLES, 0, 3);
    return gl.canvas;
  }
}

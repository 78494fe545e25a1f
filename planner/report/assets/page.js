"use strict";
// Links every mention of an object on the page: pointing at one lights it up in the 3-D view, the tables
// and the graph, together with what it touches and what depends on it. Clicking keeps it lit.

class Panel {
  // root: the part of the page that shows one scene; scene: its data; arm: shapes of the links that move in it.
  constructor(root, scene, arm) {
    this.root = root;
    this.scene = scene;
    this.pinned = -1;
    const figure = root.querySelector(".viewer");
    this.info = figure.querySelector(".info");
    this.viewer = new Viewer(figure.querySelector("canvas"), scene, (index, click) => this.pick(index, click));
    for (const box of figure.querySelectorAll("[data-show]")) {
      box.addEventListener("change", () => { this.viewer.show[box.dataset.show] = box.checked; this.viewer.redraw(); });
    }
    figure.querySelector("[data-reset]").addEventListener("click", () => this.viewer.reset());
    if (scene.motion) this.player = new Player(figure.querySelector(".player"), this.viewer, new Motion(scene.motion, arm));
    this.mentions = [...root.querySelectorAll("[data-object]")];
    this.pairs = [...root.querySelectorAll("[data-ends]")].map((node) => ({ node, ends: node.dataset.ends.split(" ").map(Number) }));
    for (const node of this.mentions) this.link(node, [Number(node.dataset.object)]);
    for (const { node, ends } of this.pairs) this.link(node, ends);
  }

  link(node, indices) {
    node.addEventListener("pointerenter", () => this.light(indices));
    node.addEventListener("pointerleave", () => this.light(this.pinned < 0 ? [] : [this.pinned]));
    node.addEventListener("click", (event) => {
      if (indices.length === 1) { this.pick(indices[0], true); event.stopPropagation(); }
    });
    node.addEventListener("keydown", (event) => { if (event.key === "Enter") node.dispatchEvent(new MouseEvent("click")); });
  }

  pick(index, click) {
    if (click) this.pinned = index === this.pinned ? -1 : index;
    const shown = index >= 0 ? index : this.pinned;
    this.light(shown < 0 ? [] : [shown]);
  }

  // One object: light it with its neighbours. Two: just the pair.
  light(indices) {
    const named = indices.filter((index) => index >= 0);
    const lit = new Set(named);
    if (named.length === 1) {
      const met = this.scene.relations.map(({ a, b }) => [a, b]);
      const tied = this.scene.dependencies.map(({ first, then }) => [first, then]);
      for (const ends of [...met, ...tied]) if (ends.includes(named[0])) ends.forEach((end) => lit.add(end));
    }
    this.viewer.light([...lit]);
    for (const node of this.mentions) node.classList.toggle("lit", named.includes(Number(node.dataset.object)));
    for (const { node, ends } of this.pairs) {
      node.classList.toggle("lit", named.length === 1 ? ends.includes(named[0]) : named.length > 1 && named.every((n) => ends.includes(n)));
    }
    this.root.classList.toggle("focused", named.length > 0);
    this.tell(named.length === 1 ? named[0] : -1);
  }

  // What there is to say about one object, beside the view.
  tell(index) {
    this.info.hidden = index < 0;
    if (index < 0) return;
    const name = (i) => this.scene.objects[i].name;
    const lines = [];
    const place = this.scene.places && this.scene.places[index];
    if (place) lines.push(`${ordinal(place)} in the order`);
    for (const { a, b, relation, faint, kind } of this.scene.relations) {
      if (a === index) lines.push(`${faint ? kind || relation : relation} ${faint ? "with " : ""}${name(b)}`);
      if (b === index) lines.push(`${faint ? kind || relation : this.scene.converse[relation]} ${faint ? "with " : ""}${name(a)}`);
    }
    for (const { first, then, text } of this.scene.dependencies) {
      if (then === index) lines.push(`after ${name(first)}: ${text}`);
      if (first === index) lines.push(`before ${name(then)}`);
    }
    const title = document.createElement("b");
    title.textContent = name(index);
    this.info.replaceChildren(title, ...lines.slice(0, 14).map((line) => {
      const row = document.createElement("div");
      row.textContent = line;
      return row;
    }));
    if (lines.length > 14) this.info.append(`and ${lines.length - 14} more`);
  }
}

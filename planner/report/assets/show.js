"use strict";
const data = JSON.parse(document.getElementById("data").textContent);
window.panels = [new Panel(document.body, data.views[0], data.arm)];

// The marks of a plan's steps take the time line to their beginning.
const { player } = window.panels[0], marks = [...document.querySelectorAll("[data-time]")];
if (player) {
  const told = (now) => marks.forEach((mark, i) => mark.setAttribute("aria-current", i === now ? "step" : "false"));
  marks.forEach((mark) => mark.addEventListener("click", () => { player.stop(); player.seek(Number(mark.dataset.time)); }));
  player.hearers.push(told);
  told(0);
}

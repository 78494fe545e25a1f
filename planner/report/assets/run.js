"use strict";
// One step of the run at a time: by the timeline, by the buttons, by the keys.

const data = JSON.parse(document.getElementById("data").textContent);
const steps = [...document.querySelectorAll("section.step")];
const marks = [...document.querySelectorAll(".timeline button")];
window.panels = steps.map(() => null);

// Pictures and views of a step are made when it is first shown.
function fill(index) {
  for (const image of steps[index].querySelectorAll("img[data-picture]")) {
    image.src ||= data.pictures[image.dataset.picture];
  }
  const figure = steps[index].querySelector(".viewer");
  if (figure && !window.panels[index]) window.panels[index] = new Panel(steps[index], data.views[figure.dataset.view], data.arm);
}

function show(index) {
  const chosen = Math.max(0, Math.min(steps.length - 1, index));
  if (window.current !== undefined && window.panels[window.current]?.player) window.panels[window.current].player.stop();
  steps.forEach((step, i) => { step.hidden = i !== chosen; });
  marks.forEach((mark, i) => mark.setAttribute("aria-current", i === chosen ? "step" : "false"));
  fill(chosen);
  marks[chosen].scrollIntoView({ block: "nearest", inline: "nearest" });
  window.current = chosen;
}

marks.forEach((mark, i) => mark.addEventListener("click", () => show(i)));
for (const button of document.querySelectorAll("[data-turn]")) {
  button.addEventListener("click", () => show(window.current + Number(button.dataset.turn)));
}
for (const input of document.querySelectorAll(".cut input")) {
  input.addEventListener("input", () => input.closest("figure").style.setProperty("--cut", `${input.value}%`));
}
document.addEventListener("keydown", (event) => {
  if (event.target.closest("canvas, input")) return;
  const turn = { ArrowRight: 1, ArrowLeft: -1, PageDown: 1, PageUp: -1 }[event.key];
  if (turn) { show(window.current + turn); event.preventDefault(); }
  else if (event.key === "Home") show(0);
  else if (event.key === "End") show(steps.length - 1);
});
if (steps.length) show(0);

// On paper there is every step.
window.addEventListener("beforeprint", () => {
  steps.forEach((step, i) => {
    step.hidden = false;
    fill(i);
    if (window.panels[i]) window.panels[i].viewer.draw();
  });
});
window.addEventListener("afterprint", () => show(window.current));

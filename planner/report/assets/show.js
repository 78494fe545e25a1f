"use strict";
const data = JSON.parse(document.getElementById("data").textContent);
window.panels = [new Panel(document.body, data.views[0])];

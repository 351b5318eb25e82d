// Opens the details to which a link leads, and lets charts be read: values at the pointer, a dragged frame zooms, a double click ends that.
(() => {
"use strict";
const opened = () => {
  const target = location.hash.length > 1 && document.getElementById(location.hash.slice(1));
  if (!target) return;
  const details = target.closest("details");
  if (details) details.open = true;
  target.scrollIntoView();
};
addEventListener("hashchange", opened);
opened();
document.querySelectorAll("nav a").forEach((link) => link.addEventListener("click", () => { if (link.hash === location.hash) opened(); }));
document.querySelectorAll(".open-all").forEach((button) => button.addEventListener("click", () => {
  const all = [...document.querySelectorAll("details[id]")], open = all.some((one) => !one.open);
  all.forEach((one) => { one.open = open; });
  button.textContent = open ? "Close all" : "Open all";
}));

const SVG = "http://www.w3.org/2000/svg";
const node = (name, attributes, text) => {
  const made = document.createElementNS(SVG, name);
  for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
  if (text !== undefined) made.textContent = text;
  return made;
};
const shown = (value) => Number(value.toPrecision(4)).toString().replace("-", "\u2212");
const plain = (cell) => cell.replace(/^"|"$/g, "").replaceAll('""', '"');

function chart(svg) {
  const figure = svg.closest("figure"), link = figure.querySelector("a[download]");
  const [left, right, top, bottom] = svg.dataset.plot.split(" ").map(Number);
  const axis = (text, from, to) => {
    const [low, high, log] = text.split(" ").map(Number);
    const scale = log ? Math.log : (v) => v, back = log ? Math.exp : (v) => v;
    return {
      log, from, to, whole: [scale(low), scale(high)], now: [scale(low), scale(high)],
      at(value) { return from + (to - from) * (scale(value) - this.now[0]) / (this.now[1] - this.now[0]); },
      value(at) { return back(this.now[0] + (this.now[1] - this.now[0]) * (at - from) / (to - from)); },
      // Where a place of the whole chart is now.
      moved(at) { const share = (at - from) / (to - from); return this.place(this.whole[0] + share * (this.whole[1] - this.whole[0])); },
      place(scaled) { return from + (to - from) * (scaled - this.now[0]) / (this.now[1] - this.now[0]); },
    };
  };
  const x = axis(svg.dataset.x, left, right), y = axis(svg.dataset.y, bottom, top);
  let points = null;
  const data = () => points || (points = decodeURIComponent(link.href.split(",").slice(1).join(",")).trim().split("\n").slice(1).map((line) => {
    const [, name, px, py] = line.match(/^("(?:[^"]|"")*"),([^,]*),(.*)$/) || [];
    return { name: plain(name || ""), x: Number(px), y: Number(py) };
  }).filter((p) => Number.isFinite(p.x) && Number.isFinite(p.y)));
  const tip = document.createElement("div");
  tip.className = "tip"; tip.hidden = true;
  figure.append(tip);
  const spot = node("circle", { r: 5, class: "spot" });
  const place = (event) => {
    const box = svg.getBoundingClientRect(), [, , wide, tall] = svg.getAttribute("viewBox").split(" ").map(Number);
    return [(event.clientX - box.left) * wide / box.width, (event.clientY - box.top) * tall / box.height, box.width / wide];
  };
  const inside = ([px, py]) => px >= left && px <= right && py >= top && py <= bottom;
  let from = null, frame = null;
  svg.addEventListener("pointermove", (event) => {
    const at = place(event);
    if (from) {
      const [px, py] = [Math.max(left, Math.min(right, at[0])), Math.max(top, Math.min(bottom, at[1]))];
      frame = frame || svg.appendChild(node("rect", { class: "frame" }));
      for (const [key, value] of Object.entries({ x: Math.min(px, from[0]), y: Math.min(py, from[1]), width: Math.abs(px - from[0]), height: Math.abs(py - from[1]) })) frame.setAttribute(key, value);
      return;
    }
    let best = null, near = 30;
    if (inside(at)) for (const p of data()) {
      const [px, py] = [x.at(p.x), y.at(p.y)], far = Math.hypot(px - at[0], py - at[1]);
      if (far < near && inside([px, py])) { near = far; best = [px, py, p]; }
    }
    tip.hidden = !best;
    if (!best) { spot.remove(); return; }
    const [px, py, p] = best, box = figure.getBoundingClientRect(), own = svg.getBoundingClientRect();
    spot.setAttribute("cx", px); spot.setAttribute("cy", py); svg.append(spot);
    tip.textContent = `${p.name ? p.name + ": " : ""}${shown(p.y)} at ${shown(p.x)}`;
    const tx = own.left - box.left + px * at[2];
    tip.style.left = `${Math.max(0, Math.min(tx + 10, box.width - tip.offsetWidth - 4))}px`;
    tip.style.top = `${own.top - box.top + py * at[2] - 34}px`;
  });
  svg.addEventListener("pointerleave", () => { tip.hidden = true; spot.remove(); });
  svg.addEventListener("pointerdown", (event) => {
    const at = place(event);
    if (event.pointerType === "mouse" && event.button === 0 && inside(at)) { from = at; svg.setPointerCapture(event.pointerId); event.preventDefault(); }
  });
  svg.addEventListener("pointerup", (event) => {
    const start = from, at = place(event);
    from = null;
    if (frame) frame.remove();
    frame = null;
    if (!start || Math.abs(at[0] - start[0]) < 10 || Math.abs(at[1] - start[1]) < 10) return;
    for (const [one, a, b] of [[x, start[0], at[0]], [y, start[1], at[1]]]) {
      const [low, high] = [Math.min(one.from, one.to), Math.max(one.from, one.to)];
      const ends = [a, b].map((p) => one.now[0] + (one.now[1] - one.now[0]) * (Math.max(low, Math.min(high, p)) - one.from) / (one.to - one.from));
      one.now = [Math.min(...ends), Math.max(...ends)];
    }
    redraw();
  });
  svg.addEventListener("dblclick", () => { x.now = [...x.whole]; y.now = [...y.whole]; redraw(); });
  const ticks = (one, wanted) => {
    const [low, high] = one.now.map((v) => one.log ? Math.exp(v) : v), rough = (high - low) / wanted, power = 10 ** Math.floor(Math.log10(rough));
    const step = [1, 2, 5, 10].map((k) => k * power).find((s) => s >= rough), out = [];
    for (let k = Math.ceil(low / step); k * step <= high; k++) out.push(k * step);
    return out;
  };
  const memory = new Map();
  function redraw() {
    const plot = svg.querySelector(".plot");
    if (!svg.querySelector("clipPath")) {
      const id = `clip-${Math.random().toString(36).slice(2)}`, clip = node("clipPath", { id });
      clip.append(node("rect", { x: left, y: top, width: right - left, height: bottom - top }));
      svg.prepend(clip); plot.setAttribute("clip-path", `url(#${id})`);
    }
    plot.querySelectorAll("path.line, path.level, .dot").forEach((shape) => {
      const key = shape.classList.contains("dot") ? "transform" : "d";
      if (!memory.has(shape)) memory.set(shape, shape.getAttribute(key));
      const text = memory.get(shape);
      shape.setAttribute(key, shape.classList.contains("level")
        ? text.replace(/M([-\d.]+) ([-\d.]+)/, (_, px, py) => `M${px} ${y.moved(Number(py))}`)
        : text.replace(/([-\d.]+) ([-\d.]+)/g, (_, px, py) => `${x.moved(Number(px)).toFixed(1)} ${y.moved(Number(py)).toFixed(1)}`));
    });
    const grid = svg.querySelector(".ticks");
    grid.replaceChildren();
    for (const value of ticks(x, 6)) {
      const at = x.at(value);
      grid.append(node("path", { class: "grid", d: `M${at} ${bottom}V${top}` }), node("text", { x: at, y: bottom + 16, "text-anchor": "middle" }, shown(value)));
    }
    for (const value of ticks(y, 5)) {
      const at = y.at(value);
      grid.append(node("path", { class: "grid", d: `M${left} ${at}H${right}` }), node("text", { x: left - 6, y: at + 4, "text-anchor": "end" }, shown(value)));
    }
  }
}
document.querySelectorAll("svg.chart[data-plot]").forEach(chart);
})();

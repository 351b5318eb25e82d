// Draws every scene of a page on a canvas: orbit by mouse, touch and keys, frames, enlarged displacements, highlights.
(() => {
"use strict";

// The same colours as the charts of a page have for the same roles.
const ROLE_COLOUR = { model: "--c1", measured: "--measured", "model as given": "--given", identified: "--identified", extended: "--extended" };
// Yaw and pitch. At yaw 0 the camera looks along the axis of travel.
const VIEWS = { "3-D": [0.65, 0.3], Front: [0, 0], Side: [Math.PI / 2, 0], Top: [Math.PI / 2, Math.PI / 2] };
// Room in pixels for labels, the caption above and the axes below: left and right, top, bottom.
const ROOM = [70, 48, 76], PAPER = [60, 24, 26];

// Frames are [x, y, z, w, i, j, k]; matrices are 12 numbers: rotation by rows, then the origin.
function matrix(f) {
  const [x, y, z, w, i, j, k] = f;
  return [1 - 2 * (j * j + k * k), 2 * (i * j - w * k), 2 * (i * k + w * j),
          2 * (i * j + w * k), 1 - 2 * (i * i + k * k), 2 * (j * k - w * i),
          2 * (i * k - w * j), 2 * (j * k + w * i), 1 - 2 * (i * i + j * j), x, y, z];
}
const apply = (m, p) => [m[0] * p[0] + m[1] * p[1] + m[2] * p[2] + m[9],
                         m[3] * p[0] + m[4] * p[1] + m[5] * p[2] + m[10],
                         m[6] * p[0] + m[7] * p[1] + m[8] * p[2] + m[11]];
const compose = (a, b) => {
  const out = [];
  for (let r = 0; r < 3; r++) for (let c = 0; c < 3; c++) {
    out.push(a[3 * r] * b[c] + a[3 * r + 1] * b[3 + c] + a[3 * r + 2] * b[6 + c]);
  }
  return out.concat(apply(a, [b[9], b[10], b[11]]));
};
const blend = (a, b, s) => a.map((value, k) => value + s * (b[k] - value));
const add = (a, b, s) => [a[0] + s * b[0], a[1] + s * b[1], a[2] + s * b[2]];
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const norm = (a) => Math.hypot(a[0], a[1], a[2]);
const unit = (a) => { const n = norm(a) || 1; return [a[0] / n, a[1] / n, a[2] / n]; };
const column = (m, c) => [m[c], m[3 + c], m[6 + c]];
const element = (tag, attributes, ...children) => {
  const node = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes || {})) {
    if (name.startsWith("on")) node.addEventListener(name.slice(2), value);
    else if (value === true) node.setAttribute(name, "");
    else if (value !== false && value != null) node.setAttribute(name, value);
  }
  node.append(...children);
  return node;
};
const DASHES = { solid: [], dotted: [2, 3], dashed: [7, 4] };
const short = (value) => Number(value.toPrecision(4)).toString();

function start(root) {
  const scene = JSON.parse(root.querySelector('script[type="application/json"]').textContent);
  const full = root.classList.contains("full");
  const main = scene.sets.length - 1;
  const measured = scene.sets.indexOf("measured");
  // The last set is the result. Other models are dashed, whatever their role.
  const styles = scene.sets.map((_, s) => (s === main ? "solid" : s === measured ? "dotted" : "dashed"));
  const state = {
    yaw: 0, pitch: 0, zoom: 1, pan: [0, 0], frameOf: null, frame: 0, factor: 1, mode: "design",
    sets: scene.sets.map(() => true), labels: scene.objects.length <= 24, shapes: true, hidden: new Set(),
    playing: false, hover: null, from: null,
  };

  // A turntable: up is always up on the screen.
  const up = unit(scene.up);
  const side = unit(cross(up, scene.along));
  const ahead = cross(side, up);

  const design = scene.parts.map((part) => matrix(part.design));
  const frames = scene.frames;
  const poses = frames.map((frame) => frame.poses.map((set) => set.map((pose) => pose && matrix(pose))));
  // Where something is attached to ground. The far end of a force holds nothing.
  const holds = (object) => object.kind !== "force" && object.kind !== "motion" || object.address.startsWith("SFORCE") && object.form === "translational";
  const held = new Map();
  scene.objects.filter(holds).forEach((object) => [object.i, object.j].forEach((end) => {
    if (!end || !scene.parts[end.part].ground) return;
    const p = apply(design[end.part], end.at);
    held.set(p.map((x) => x.toPrecision(6)).join(), p);
  }));
  // What moves decides the size, with what holds it.
  const cloud = [];
  scene.parts.forEach((part, k) => {
    if (part.ground) return;
    const own = part.points.length ? part.points : [[0, 0, 0]];
    const every = Math.ceil(poses.length / 40) || 1;
    const places = poses.filter((_, n) => n % every === 0).map((frame) => frame[main][k]).filter((pose) => pose);
    (places.length ? places : [design[k]]).forEach((m) => own.forEach((p) => cloud.push(apply(m, p))));
  });
  if (!cloud.length) scene.parts.forEach((part, k) => part.points.forEach((p) => cloud.push(apply(design[k], p))));
  const wheels = (scene.wheels || []).map((wheel) => ({ ...wheel, local: matrix(wheel.at) }));
  const circle = (m, r, h, sides) => Array.from({ length: sides + 1 }, (_, k) => apply(m, [r * Math.cos(2 * Math.PI * k / sides), r * Math.sin(2 * Math.PI * k / sides), h]));
  const rolling = wheels.map((wheel) => compose(design[wheel.part], wheel.local));
  // The road lies under the lowest tyre.
  const road = wheels.length ? Math.min(...rolling.map((m, k) => dot([m[9], m[10], m[11]], up) - wheels[k].radius)) : null;
  wheels.forEach((wheel, k) => circle(rolling[k], wheel.radius, 0, 12).forEach((p) => cloud.push(p)));
  const centre = [0, 1, 2].map((c) => {
    const [low, high] = cloud.reduce(([l, h], p) => [Math.min(l, p[c]), Math.max(h, p[c])], [Infinity, -Infinity]);
    return low <= high ? (low + high) / 2 : 0;
  });
  const radius = Math.max(cloud.reduce((r, p) => Math.max(r, norm(add(p, centre, -1))), 0), 1e-9);
  const seen = cloud.concat([...held.values()].filter((p) => norm(add(p, centre, -1)) < 3 * radius));
  // Middle, width and height of the mechanism as the camera stands, in perspective at unit scale.
  const away = 6 * radius;
  function framed() {
    const view = camera();
    const ends = [0, 1].map((k) => {
      const flat = seen.map((p) => {
        const d = add(p, centre, -1);
        return dot(d, k ? view.above : view.right) * away / Math.max(away - dot(d, view.toward), 0.2 * radius);
      });
      return flat.reduce(([l, h], x) => [Math.min(l, x), Math.max(h, x)], [Infinity, -Infinity]);
    });
    return ends.map(([low, high]) => low <= high ? [(low + high) / 2, Math.max(high - low, 0.2 * radius)] : [0, radius]);
  }
  // A single wheel is seen from outside.
  const outer = wheels.length === 1 ? dot(add([rolling[0][9], rolling[0][10], rolling[0][11]], centre, -1), side) : 0;
  const mirror = outer > 0.02 * radius ? -1 : 1;
  const look = (name) => { [state.yaw, state.pitch] = VIEWS[name]; if (name !== "Top") state.yaw *= mirror; state.zoom = 1; state.pan = [0, 0]; state.frameOf = framed(); };
  const pixels = () => Math.min(Math.max(stage.clientWidth - 2 * room[0], 50) / state.frameOf[0][1],
    Math.max(stage.clientHeight - room[1] - room[2], 50) / state.frameOf[1][1]) * state.zoom;
  const glyph = 0.028 * radius;
  const strongest = Math.max(1e-30, ...frames.flatMap((frame) => (frame.arrows || []).map((arrow) => norm(arrow.force))));

  const named = (address) => scene.objects.find((o) => o.address === address) || scene.parts.find((p) => p.address === address);
  const culprits = new Map();
  scene.highlight.forEach((mark) => { const found = named(mark.address); if (found) culprits.set(found, mark.label); });

  // ---- controls
  const canvas = element("canvas", { tabindex: "0", role: "img", "aria-label": describe() });
  const tip = element("div", { class: "scene-tip", hidden: true });
  const caption = element("output", { class: "scene-now", "aria-live": "polite" });
  const stage = element("div", { class: "scene-stage" }, canvas, tip, caption);
  const bar = element("div", { class: "scene-bar" });
  const button = (label, title, action) => element("button", { type: "button", title, onclick: action }, label);
  const group = (...nodes) => element("span", { class: "scene-group" }, ...nodes);
  const check = (label, value, action, swatch) => {
    const box = element("input", { type: "checkbox", onchange: () => { action(box.checked); draw(); } });
    box.checked = value;
    return element("label", {}, box, ...(swatch ? [swatch] : []), label);
  };
  bar.append(group(...Object.keys(VIEWS).map((name) => button(name, `Look from: ${name}`, () => {
    look(name); draw();
  }))));
  let select = null, slider = null, play = null;
  if (frames.length > 1) {
    select = element("select", { "aria-label": `${scene.per} shown`, onchange: () => show(select.selectedIndex) },
      ...frames.map((frame) => element("option", {}, `${scene.per} ${frame.label}`)));
    slider = element("input", { type: "range", min: 0, max: frames.length - 1, value: 0, class: "scene-steps",
      "aria-label": scene.per, oninput: () => show(Number(slider.value)) });
    play = button("\u25B6 Play", "Play or stop (space bar)", toggle);
    bar.append(group(play, select, slider));
  }
  if (frames.length) {
    const shown = element("output", {}, "\u00D71");
    const range = element("input", { type: "range", min: 0, max: 3, step: 0.01, value: 0, class: "scene-factor",
      "aria-label": "Enlarge displacements", oninput: () => {
        state.factor = 10 ** Number(range.value);
        shown.textContent = "\u00D7" + (state.factor < 10 ? state.factor.toFixed(1).replace(/\.0$/, "") : Math.round(state.factor));
        draw();
      } });
    const what = element("select", { "aria-label": "Displacement that is enlarged", onchange: () => { state.mode = what.value; draw(); } },
      element("option", { value: "design" }, "motion from the design position"),
      ...(measured >= 0 && main !== measured ? [element("option", { value: "measured" }, "difference from the measurement")] : []));
    bar.append(group(element("label", {}, "Enlarge ", ...(what.options.length > 1 ? [what] : ["motion"]), " ", range), shown));
  }
  const swatch = (role, s) => {
    const line = element("span", { class: "scene-swatch" });
    line.style.borderTop = `3px ${styles[s]} var(${ROLE_COLOUR[role]})`;
    return line;
  };
  const boxes = scene.sets.length > 1
    ? scene.sets.map((role, k) => check(role, true, (on) => { state.sets[k] = on; }, swatch(role, k))) : [];
  boxes.push(check("labels", state.labels, (on) => { state.labels = on; }));
  if (scene.parts.some((part) => part.lines.length)) boxes.push(check("graphics", true, (on) => { state.shapes = on; }));
  bar.append(group(...boxes));
  if (culprits.size) bar.append(button("Show findings", "Zoom to the highlighted object", () => { state.zoom = 2.2; aim([...culprits.keys()][0]); draw(); }));
  const moving = scene.parts.filter((part) => !part.ground);
  const list = element("details", { class: "scene-list" }, element("summary", {}, `${moving.length} parts, ${scene.objects.length} joints and forces`),
    element("div", {}, ...moving.map((part) => {
      const label = check(`${part.name} (${part.address})`, true, (on) => { if (on) state.hidden.delete(part); else state.hidden.add(part); });
      pointed(label, part);
      return label;
    }), ...scene.objects.map((object) => {
      const item = element("span", { tabindex: "0" }, `${object.name} (${object.address}, ${object.form})`);
      pointed(item, object);
      return item;
    })));
  const help = element("p", { class: "note scene-help" },
    "Drag to rotate, shift-drag or right-drag to pan, wheel or pinch to zoom. Keys: arrows rotate, shift-arrows pan, + and \u2212 zoom, [ and ] step, space plays, 0 resets.");
  root.append(bar, stage, help, list);
  scene.notes.forEach((note) => root.append(element("p", { class: "note" }, note)));

  function pointed(node, object) {
    const on = () => { state.from = object; draw(); }, off = () => { state.from = null; draw(); };
    node.addEventListener("pointerenter", on); node.addEventListener("pointerleave", off);
    node.addEventListener("focusin", on); node.addEventListener("focusout", off);
  }
  function describe() {
    const frame = frames[state.frame];
    const count = (word, n) => `${n} ${word}${n === 1 ? "" : "s"}`;
    return `${scene.title}: ${count("part", scene.parts.filter((p) => !p.ground).length)}, ${scene.objects.length} joints and forces` +
      (frame ? `; ${scene.per} ${frame.label}` : "");
  }
  function show(k) {
    state.frame = (k + frames.length) % frames.length;
    if (select) { select.selectedIndex = state.frame; slider.value = state.frame; }
    canvas.setAttribute("aria-label", describe());
    draw();
  }
  function toggle() {
    state.playing = !state.playing;
    play.textContent = state.playing ? "\u25A0 Stop" : "\u25B6 Play";
    let last = 0;
    const gap = Math.max(40, Math.min(700, 8000 / frames.length));
    const tick = (now) => {
      if (!state.playing) return;
      if (now - last > gap) { last = now; show(state.frame + 1); }
      requestAnimationFrame(tick);
    };
    if (state.playing) requestAnimationFrame(tick);
  }

  // ---- geometry of the moment
  function placed(set, part) {
    if (scene.parts[part].ground || !frames.length) return design[part];
    const now = poses[state.frame][set][part];
    if (!now) return null;
    if (state.factor === 1) return now;
    // Displacements are multiplied point by point, so that joints stay joined.
    return blend(base(part), now, state.factor);
  }
  function base(part) {
    const frame = poses[state.frame];
    return state.mode === "measured" ? frame[measured][part] || frame[main][part] || design[part] : design[part];
  }
  function camera() {
    const [cy, sy, cp, sp] = [Math.cos(state.yaw), Math.sin(state.yaw), Math.cos(state.pitch), Math.sin(state.pitch)];
    const flat = add(ahead.map((x) => x * cy), side, sy);
    const right = add(ahead.map((x) => x * sy), side, -cy);
    const toward = add(flat.map((x) => -x * cp), up, sp);
    const above = add(up.map((x) => x * cp), flat, sp);
    return { right, above, toward };
  }
  function aim(object) {
    const end = object.i || null;
    const part = end ? end.part : scene.parts.indexOf(object);
    const m = placed(main, part) || design[part];
    const p = end ? apply(m, end.at) : apply(m, middle(scene.parts[part].points));
    const view = camera(), d = add(p, centre, -1);
    state.pan = [view.right, view.above].map((axis, k) => (state.frameOf[k][0] - dot(d, axis)) / radius);
  }
  const middle = (points) => points.length ? points.reduce((s, p) => add(s, p, 1 / points.length), [0, 0, 0]) : [0, 0, 0];

  let hits = [], room = ROOM;
  let colours = {};
  function readColours(print) {
    room = print ? PAPER : ROOM;
    const style = getComputedStyle(root);
    const value = (name) => style.getPropertyValue(name).trim();
    colours = { ink: value("--ink"), soft: value("--soft"), paper: value("--paper"), line: value("--line"), band: value("--band"), bad: value("--bad") };
    for (let k = 1; k <= 8; k++) colours["--c" + k] = value("--c" + k);
    for (const name of ["--measured", "--given", "--identified", "--extended"]) colours[name] = value(name);
    colours["--soft"] = colours.soft;
    if (print) Object.assign(colours, { ink: "#1b1f24", soft: "#57606a", paper: "#fff", line: "#d0d7de" });
  }

  function draw() {
    const width = stage.clientWidth, height = stage.clientHeight;
    if (!width || !height) return;
    const density = Math.max(window.devicePixelRatio || 1, 2);
    if (canvas.width !== Math.round(width * density) || canvas.height !== Math.round(height * density)) {
      canvas.width = Math.round(width * density); canvas.height = Math.round(height * density);
    }
    const g = canvas.getContext("2d");
    g.setTransform(density, 0, 0, density, 0, 0);
    g.clearRect(0, 0, width, height);
    const view = camera(), scale = pixels();
    // The middle of the frame lies in the middle of the room.
    const [ox, oy] = [width / 2 + (state.pan[0] * radius - state.frameOf[0][0]) * scale, (height + room[1] - room[2]) / 2 - (state.pan[1] * radius - state.frameOf[1][0]) * scale];
    const project = (p) => {
      const d = add(p, centre, -1), depth = dot(d, view.toward);
      const s = scale * away / Math.max(away - depth, 0.2 * radius);
      return [ox + s * dot(d, view.right), oy - s * dot(d, view.above), depth, s / scale];
    };
    const items = [];
    const fade = (depth) => Math.max(0.35, Math.min(1, 0.78 + 0.3 * depth / radius));
    const stroke = (a, b, colour, thick, dash, lift) => {
      const [p, q] = [project(a), project(b)], depth = (p[2] + q[2]) / 2;
      items.push([depth + (lift || 0), () => {
        g.globalAlpha = fade(depth); g.strokeStyle = colour; g.lineWidth = thick; g.lineCap = dash && dash.length ? "butt" : "round"; g.setLineDash(dash || []);
        g.beginPath(); g.moveTo(p[0], p[1]); g.lineTo(q[0], q[1]); g.stroke();
      }]);
    };
    const strokes = (line, colour, thick, dash) => {
      const flat = line.map(project), depth = flat.reduce((s, p) => s + p[2] / flat.length, 0);
      items.push([depth, () => {
        g.globalAlpha = fade(depth); g.strokeStyle = colour; g.lineWidth = thick; g.setLineDash(dash || []);
        g.beginPath(); flat.forEach((p, k) => k ? g.lineTo(p[0], p[1]) : g.moveTo(p[0], p[1])); g.stroke();
      }]);
    };
    const face = (corners, colour, strong) => {
      const flat = corners.map(project), depth = flat.reduce((s, p) => s + p[2] / flat.length, 0);
      const normal = unit(cross(add(corners[1], corners[0], -1), add(corners[2], corners[0], -1)));
      const light = 0.55 + 0.45 * Math.abs(dot(normal, unit(add(add(view.toward, view.above, 0.8), view.right, 0.3))));
      items.push([depth - 0.01 * radius, () => {
        g.globalAlpha = strong * light; g.fillStyle = colour;
        g.beginPath(); flat.forEach((p, k) => k ? g.lineTo(p[0], p[1]) : g.moveTo(p[0], p[1])); g.closePath(); g.fill();
      }]);
    };
    const ball = (p, r, fill, edge, hit) => {
      const q = project(p);
      items.push([q[2] + 0.02 * radius, () => {
        g.globalAlpha = 1; g.setLineDash([]); g.beginPath(); g.arc(q[0], q[1], r, 0, 7);
        if (fill) { g.fillStyle = fill; g.fill(); }
        if (edge) { g.strokeStyle = edge; g.lineWidth = 1.5; g.stroke(); }
      }]);
      if (hit) hits.push([q[0], q[1], hit]);
    };
    const ring = (m, r, h, colour, thick) => {
      const line = [];
      for (let k = 0; k <= 20; k++) line.push(apply(m, [r * Math.cos(k * Math.PI / 10), r * Math.sin(k * Math.PI / 10), h]));
      strokes(line, colour, thick);
    };
    const arrow = (from, to, colour, thick) => {
      const [p, q] = [project(from), project(to)], length = Math.hypot(q[0] - p[0], q[1] - p[1]);
      items.push([q[2] + 0.05 * radius, () => {
        g.globalAlpha = 1; g.strokeStyle = g.fillStyle = colour; g.lineWidth = thick; g.setLineDash([]);
        const [ux, uy] = length > 1e-6 ? [(q[0] - p[0]) / length, (q[1] - p[1]) / length] : [0, 0], head = Math.min(11, length);
        g.beginPath(); g.moveTo(p[0], p[1]); g.lineTo(q[0] - ux * head * 0.8, q[1] - uy * head * 0.8); g.stroke();
        g.beginPath(); g.moveTo(q[0], q[1]); g.lineTo(q[0] - ux * head - uy * head * 0.4, q[1] - uy * head + ux * head * 0.4);
        g.lineTo(q[0] - ux * head + uy * head * 0.4, q[1] - uy * head - ux * head * 0.4); g.closePath(); g.fill();
      }]);
    };
    const texts = [];
    const label = (p, text, colour, bold, hard) => { const q = project(p); texts.push([q[0], q[1], text, colour, bold, hard]); };
    hits = [];

    // ---- road and wheels
    if (road !== null && view.toward && state.pitch >= -0.05) {
      const flat = seen.map((p) => [dot(p, ahead), dot(p, side)]), edge = 0.12 * radius;
      const [a0, a1, b0, b1] = [0, 1].flatMap((c) => [Math.min(...flat.map((p) => p[c])) - edge, Math.max(...flat.map((p) => p[c])) + edge]);
      const at = (a, b) => add(add(add([0, 0, 0], ahead, a), side, b), up, road);
      const corners = [at(a0, b0), at(a1, b0), at(a1, b1), at(a0, b1)].map(project), step = 10 ** Math.floor(Math.log10(radius)) / (radius / 10 ** Math.floor(Math.log10(radius)) < 3 ? 5 : 2);
      items.push([-1e9 * radius, () => {
        g.globalAlpha = 0.5; g.fillStyle = colours.band; g.strokeStyle = colours.line; g.lineWidth = 1; g.setLineDash([]);
        g.beginPath(); corners.forEach((p, k) => k ? g.lineTo(p[0], p[1]) : g.moveTo(p[0], p[1])); g.closePath(); g.fill(); g.stroke();
        g.lineWidth = 0.6;
        const across = (from, to) => { const [p, q] = [project(from), project(to)]; g.beginPath(); g.moveTo(p[0], p[1]); g.lineTo(q[0], q[1]); g.stroke(); };
        for (let a = Math.ceil(a0 / step) * step; a < a1; a += step) across(at(a, b0), at(a, b1));
        for (let b = Math.ceil(b0 / step) * step; b < b1; b += step) across(at(a0, b), at(a1, b));
      }]);
    }
    wheels.forEach((wheel) => scene.sets.forEach((set, s) => {
      const carrier = state.sets[s] && !state.hidden.has(scene.parts[wheel.part]) && placed(s, wheel.part);
      if (!carrier) return;
      const m = compose(carrier, wheel.local), r = wheel.radius, w = 0.32 * r, sides = 36;
      if (s !== main) { strokes(circle(m, r, 0, sides), colours[ROLE_COLOUR[set]], 1.2, DASHES[styles[s]]); return; }
      // Tread, sidewalls down to the rim, and a disc with five spokes.
      const profile = [[0.62, -w], [0.95, -w], [1, -0.75 * w], [1, 0.75 * w], [0.95, w], [0.62, w]].map(([share, h]) => circle(m, share * r, h, sides));
      for (let ring = 0; ring + 1 < profile.length; ring++) for (let k = 0; k < sides; k++) {
        face([profile[ring][k], profile[ring][k + 1], profile[ring + 1][k + 1], profile[ring + 1][k]], colours.soft, 0.13);
      }
      for (const ring of [0, 1, 4, 5]) strokes(profile[ring], colours.soft, ring === 1 || ring === 4 ? 1.4 : 1);
      strokes(circle(m, 0.16 * r, 0.2 * w, 18), colours.soft, 1.2);
      for (let k = 0; k < 5; k++) {
        const [c, n] = [Math.cos(2 * Math.PI * k / 5), Math.sin(2 * Math.PI * k / 5)];
        stroke(apply(m, [0.16 * r * c, 0.16 * r * n, 0.2 * w]), apply(m, [0.62 * r * c, 0.62 * r * n, 0.6 * w]), colours.soft, 1.6);
      }
    }));

    // ---- parts
    scene.sets.forEach((set, s) => {
      if (!state.sets[s]) return;
      const several = scene.sets.length > 1;
      scene.parts.forEach((part, k) => {
        if (part.ground || state.hidden.has(part)) return;
        const m = placed(s, k);
        if (!m) return;
        const lit = state.from === part || state.hover === part, culprit = culprits.has(part);
        const colour = culprit && s === main ? colours.bad : several ? colours[ROLE_COLOUR[set]] : colours["--c" + (1 + k % 8)];
        const dash = DASHES[styles[s]], points = part.points.map((p) => apply(m, p));
        if (s === main) part.faces.forEach((f) => face(f.map((c) => points[c]), colour, lit ? 0.5 : part.edges.length > 60 ? 0.08 : 0.15));
        const bar = part.edges.length === 1 && s === main;
        const thick = (bar ? 4.5 : s === main ? 1.8 : 1.3) * (lit ? 1.7 : 1);
        part.edges.forEach(([a, b]) => stroke(points[a], points[b], colour, thick, dash));
        if (state.shapes && s === main) part.lines.forEach((line) => strokes(line.map((c) => points[c]), colour, lit ? 1.6 : 0.8));
        if (!part.points.length) {
          for (let c = 0; c < 3; c++) stroke(apply(m, [0, 0, 0]), add(apply(m, [0, 0, 0]), column(m, c), 2 * glyph), colour, 1.5);
        }
        if (s === main) {
          const at = apply(m, middle(part.points)), q = project(at);
          hits.push([q[0], q[1], part]);
          if (state.labels && scene.parts.length <= 16 && part.points.length > 1) label(at, part.name, colour, false);
          if (culprit) label(at, culprits.get(part), colours.bad, true);
        }
      });
    });

    // ---- joints and forces, where the main set is
    scene.objects.forEach((object, n) => {
      if (!state.sets[main] || state.hidden.has(scene.parts[object.i.part])) return;
      const end = (e) => { const m = e && placed(main, e.part); return m && compose(m, matrix(e.at)); };
      const i = end(object.i), j = end(object.j) || i;
      if (!i) return;
      const [p, q] = [[i[9], i[10], i[11]], [j[9], j[10], j[11]]];
      const lit = state.from === object || state.hover === object, culprit = culprits.has(object);
      // Where colours tell whose positions these are, what joins the parts has none.
      const colour = culprit ? colours.bad : lit ? colours["--c2"] : scene.sets.length > 1 ? colours.ink
        : object.kind === "bushing" || object.kind === "field" ? colours["--c3"] : object.kind === "force" || object.kind === "motion" ? colours["--c5"] : colours.ink;
      const thick = lit || culprit ? 2.6 : 1.3, gap = norm(add(p, q, -1)) > 0.004 * radius;
      const z = unit(column(j, 2)), axis = (r) => stroke(add(p, z, -r * glyph), add(p, z, r * glyph), colour, thick);
      if (object.kind === "joint" || object.kind === "primitive") {
        if (gap) stroke(p, q, colours.soft, 1, [3, 3]);
        switch (object.form) {
          case "revolute": ring(j, 0.6 * glyph, 0.5 * glyph, colour, thick); ring(j, 0.6 * glyph, -0.5 * glyph, colour, thick); axis(1.3); break;
          case "cylindrical": case "screw": ring(j, 0.5 * glyph, 0.9 * glyph, colour, thick); ring(j, 0.5 * glyph, -0.9 * glyph, colour, thick); axis(1.9); break;
          case "translational": axis(1.9); ring(j, 0.35 * glyph, glyph, colour, thick); ring(j, 0.35 * glyph, -glyph, colour, thick); break;
          case "planar": case "inplane": {
            const c = [[-1, -1], [1, -1], [1, 1], [-1, 1], [-1, -1]].map(([a, b]) => apply(j, [a * glyph, b * glyph, 0]));
            strokes(c, colour, thick); break;
          }
          case "hooke": case "universal": case "convel": {
            const x = unit(column(i, 2)), y = unit(column(j, 2));
            stroke(add(p, x, -glyph), add(p, x, glyph), colour, thick); stroke(add(p, y, -glyph), add(p, y, glyph), colour, thick); break;
          }
          default: break;
        }
        const solid = object.form === "fixed" || object.form === "spherical" || object.form === "atpoint";
        ball(p, object.form === "fixed" ? 5 : 3.4, solid ? colour : colours.paper, colour, object);
      } else if (object.kind === "bushing") {
        // A sleeve along the z axis of J, with the pin of I in it.
        const [outside, inside] = [1.15 * glyph, 0.5 * glyph], half = 1.1 * glyph, sides = 16;
        const [low, high] = [-half, half].map((h) => circle(j, outside, h, sides));
        for (let k = 0; k < sides; k++) face([low[k], low[k + 1], high[k + 1], high[k]], colour, 0.4);
        for (const h of [-half, half]) { ring(j, outside, h, colour, thick); ring(j, inside, h, colour, thick); }
        stroke(apply(i, [0, 0, -1.6 * half]), apply(i, [0, 0, 1.6 * half]), colour, 2.4);
        stroke(p, q, colour, 2);
        ball(p, 2.6, colour, null, object);
      } else if (object.kind === "spring" && gap) {
        const along = add(q, p, -1), x = unit(cross(along, Math.abs(unit(along)[2]) < 0.9 ? [0, 0, 1] : [1, 0, 0])), y = unit(cross(along, x)), line = [p];
        const coil = Math.min(1.7 * glyph, 0.25 * norm(along));
        for (let k = 0; k <= 96; k++) {
          const turn = k / 96 * 2 * Math.PI * 7, r = coil, at = add(p, along, 0.12 + 0.76 * k / 96);
          line.push(add(add(at, x, r * Math.cos(turn)), y, r * Math.sin(turn)));
        }
        line.push(q);
        strokes(line, colour, thick + 1);
        for (const end of [0.12, 0.88]) {
          const seat = add(p, along, end), flat = [];
          for (let k = 0; k <= 24; k++) flat.push(add(add(seat, x, coil * Math.cos(k * Math.PI / 12)), y, coil * Math.sin(k * Math.PI / 12)));
          strokes(flat, colour, thick);
        }
        ball(add(p, along, 0.5), 0, null, null, object);
      } else if (object.kind === "beam" || object.kind === "field" || object.kind === "spring") {
        stroke(p, q, colour, thick + 1, object.kind === "field" ? [5, 3] : []);
        ball(p, 2.6, colour, null, object);
        if (!gap) ring(j, 0.7 * glyph, 0, colour, thick);
      } else if (object.kind === "force") {
        const acting = frames.length && (frames[state.frame].arrows || []).find((a) => a.object === n);
        if (!acting) {
          if (gap && !object.form.includes("action only") && object.address.startsWith("SFORCE")) stroke(p, q, colour, thick, [6, 3]);
          else arrow(add(p, z, -2.4 * glyph), p, colour, thick);
        }
        ball(p, 2.8, colours.paper, colour, object);
      } else {
        ring(j, 1.1 * glyph, 0, colour, thick);
        hits.push([...project(p).slice(0, 2), object]);
      }
      if (culprit) {
        const at = project(p);
        items.push([radius * 9, () => {
          g.globalAlpha = 1; g.setLineDash([]); g.strokeStyle = colours.bad;
          for (const [r, w] of [[15, 2.5], [20, 1]]) { g.lineWidth = w; g.beginPath(); g.arc(at[0], at[1], r, 0, 7); g.stroke(); }
        }]);
        label(add(p, view.above, 0), culprits.get(object), colours.bad, true, true);
      } else if (lit || (state.labels && object.kind !== "motion")) label(p, object.name, colour, lit, lit);
    });

    // ---- ground where something is attached to it
    if (held.size <= 400) held.forEach((at) => {
      const q = project(at);
      items.push([q[2] - 0.02 * radius, () => {
        g.globalAlpha = 0.75; g.strokeStyle = colours.soft; g.lineWidth = 1.2; g.setLineDash([]);
        g.beginPath(); g.moveTo(q[0], q[1]); g.lineTo(q[0] - 7, q[1] + 10); g.lineTo(q[0] + 7, q[1] + 10); g.closePath();
        for (const x of [-7, -2, 3]) { g.moveTo(q[0] + x + 4, q[1] + 10); g.lineTo(q[0] + x, q[1] + 15); }
        g.stroke();
      }]);
    });
    if (state.shapes) scene.parts.forEach((part, k) => {
      if (part.ground) part.lines.forEach((line) => strokes(line.map((c) => apply(design[k], part.points[c])), colours.soft, 0.7));
    });

    // ---- marks: a dot where a set has them, a cross where they were read
    if (frames.length) scene.marks.forEach((mark, k) => {
      const read = (frames[state.frame].marks || [])[k];
      scene.sets.forEach((set, s) => {
        if (s === measured || !state.sets[s]) return;
        const m = placed(s, mark.part);
        if (m) ball(apply(m, mark.p), s === main ? 2.4 : 1.8, colours[ROLE_COLOUR[set]], null, s === main ? { name: `mark ${mark.label}`, address: scene.parts[mark.part].name } : null);
      });
      if (!read || measured < 0 || !state.sets[measured]) return;
      const still = apply(base(mark.part), mark.p), at = state.factor === 1 ? read : blend(still, read, state.factor);
      const q = project(at);
      items.push([q[2] + 0.06 * radius, () => {
        g.globalAlpha = 1; g.setLineDash([]); g.strokeStyle = colours[ROLE_COLOUR.measured]; g.lineWidth = 1.6;
        g.beginPath(); g.moveTo(q[0] - 4, q[1] - 4); g.lineTo(q[0] + 4, q[1] + 4); g.moveTo(q[0] - 4, q[1] + 4); g.lineTo(q[0] + 4, q[1] - 4); g.stroke();
      }]);
    });

    // ---- loads
    if (frames.length && state.sets[main]) (frames[state.frame].arrows || []).forEach((load) => {
      const object = scene.objects[load.object], m = object && placed(main, object.i.part), size = norm(load.force);
      if (!m || !size) return;
      const tip = apply(m, object.i.at), long = (0.12 + 0.38 * size / strongest) * radius;
      // Pushing loads end at their point, so that the arrow stays outside.
      const from = add(tip, unit(load.force), -long);
      arrow(from, tip, colours["--c6"], 2.6);
      label(from, `${short(size)} ${scene.force}`, colours["--c6"], true);
    });

    items.sort((a, b) => a[0] - b[0]).forEach((item) => item[1]());
    g.globalAlpha = 1; g.setLineDash([]);
    // A label takes the first free place around its point, with a line to it where that is not close by. The rest give way.
    const taken = [], free = (box) => box[0] >= 0 && box[2] <= width && box[1] >= 20 && box[3] <= height - 12 &&
      !taken.some((other) => box[0] < other[2] && other[0] < box[2] && box[1] < other[3] && other[1] < box[3]);
    texts.sort((a, b) => (b[4] ? 1 : 0) - (a[4] ? 1 : 0));
    for (const [px, py, text, colour, bold, hard] of texts) {
      g.font = `${bold ? 600 : 400} 12px system-ui, sans-serif`;
      const wide = g.measureText(text).width;
      let spot = null;
      for (const far of [9, 22, 38]) for (const [dx, dy] of [[1, -0.6], [1, 0.9], [-1, -0.6], [-1, 0.9], [0, -1.2], [0, 1.6]]) {
        if (spot) break;
        const left = px + dx * far - (dx < 0 ? wide : dx ? 0 : wide / 2), base = py + dy * far + 3;
        if (free([left - 2, base - 11, left + wide + 2, base + 4])) spot = [left, base, far];
      }
      if (!spot && !hard) continue;
      const [left, base, far] = spot || [Math.max(2, Math.min(px + 9, width - wide - 4)), py - 8, 0];
      taken.push([left - 2, base - 11, left + wide + 2, base + 4]);
      if (far > 9) {
        g.globalAlpha = 0.6; g.strokeStyle = colour; g.lineWidth = 0.8;
        g.beginPath(); g.moveTo(px, py); g.lineTo(left > px ? left : left + wide < px ? left + wide : px, base - 4); g.stroke();
      }
      g.lineJoin = "round"; g.lineWidth = 3.5; g.strokeStyle = colours.paper; g.globalAlpha = 0.85; g.strokeText(text, left, base);
      g.globalAlpha = 1; g.fillStyle = colour; g.fillText(text, left, base);
    }
    triad(g, view, height);
    const frame = frames[state.frame];
    caption.textContent = frame
      ? `${scene.per} ${frame.label}${frame.note ? ": " + frame.note : ""}${frame.poses[main].some((p, k) => !p && !scene.parts[k].ground && scene.sets[main] !== "measured") ? " (the model has no equilibrium)" : ""}`
      : "design position";
    bench(g, scale, width, height);
  }
  function triad(g, view, height) {
    const [ox, oy] = [44, height - 44];
    ["x", "y", "z"].map((name, k) => {
      const e = [0, 0, 0]; e[k] = 1;
      return [dot(e, view.toward), dot(e, view.right), dot(e, view.above), name, ["--c2", "--c3", "--c1"][k]];
    }).sort((a, b) => a[0] - b[0]).forEach(([, x, y, name, colour]) => {
      g.strokeStyle = g.fillStyle = colours[colour]; g.lineWidth = 2;
      g.beginPath(); g.moveTo(ox, oy); g.lineTo(ox + 26 * x, oy - 26 * y); g.stroke();
      g.font = "600 12px system-ui, sans-serif"; g.fillText(name, ox + 34 * x - 3, oy - 34 * y + 4);
    });
  }
  // A bar of a round length.
  function bench(g, scale, width, height) {
    const ideal = 90 / scale, step = 10 ** Math.floor(Math.log10(ideal)), length = [5, 2, 1].map((k) => k * step).find((x) => x <= ideal);
    const [x, y] = [width - 16 - length * scale, height - 16];
    g.strokeStyle = g.fillStyle = colours.soft; g.lineWidth = 1.5;
    g.beginPath(); g.moveTo(x, y - 4); g.lineTo(x, y); g.lineTo(x + length * scale, y); g.lineTo(x + length * scale, y - 4); g.stroke();
    g.font = "12px system-ui, sans-serif"; g.textAlign = "right"; g.fillText(`${short(length)} ${scene.length}`, width - 16, y - 8); g.textAlign = "left";
  }

  // ---- pointer, wheel and keys
  const pointers = new Map();
  let spread = 0;
  canvas.addEventListener("pointerdown", (event) => {
    canvas.setPointerCapture(event.pointerId);
    pointers.set(event.pointerId, [event.clientX, event.clientY]);
    spread = 0;
  });
  canvas.addEventListener("pointermove", (event) => {
    const old = pointers.get(event.pointerId);
    if (!old) { hover(event); return; }
    const [dx, dy] = [event.clientX - old[0], event.clientY - old[1]], all = [...pointers.values()];
    if (pointers.size === 1 && !event.shiftKey && !(event.buttons & 2)) turn(dx * 0.008, dy * 0.008);
    else move(dx / pointers.size, dy / pointers.size);
    pointers.set(event.pointerId, [event.clientX, event.clientY]);
    if (all.length === 2) {
      const [a, b] = [...pointers.values()], now = Math.hypot(a[0] - b[0], a[1] - b[1]);
      if (spread) zoom(now / spread);
      spread = now;
    }
    draw();
  });
  for (const name of ["pointerup", "pointercancel"]) canvas.addEventListener(name, (event) => { pointers.delete(event.pointerId); spread = 0; });
  canvas.addEventListener("pointerleave", () => { state.hover = null; tip.hidden = true; draw(); });
  canvas.addEventListener("contextmenu", (event) => event.preventDefault());
  canvas.addEventListener("wheel", (event) => {
    // Inside a report the page scrolls until the view has the focus.
    if (!full && document.activeElement !== canvas && !event.ctrlKey) return;
    event.preventDefault();
    zoom(Math.exp(-event.deltaY * 0.0015)); draw();
  }, { passive: false });
  canvas.addEventListener("keydown", (event) => {
    const step = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] }[event.key];
    if (step && event.shiftKey) move(-20 * step[0], -20 * step[1]);
    else if (step) turn(0.1 * step[0], 0.1 * step[1]);
    else if (event.key === "+" || event.key === "=") zoom(1.15);
    else if (event.key === "-") zoom(1 / 1.15);
    else if (event.key === "0") look("3-D");
    else if (event.key === " " && play) toggle();
    else if (event.key === "]" && frames.length) show(state.frame + 1);
    else if (event.key === "[" && frames.length) show(state.frame - 1);
    else return;
    event.preventDefault(); draw();
  });
  const zoom = (by) => { state.zoom = Math.max(0.2, Math.min(60, state.zoom * by)); };
  const turn = (dx, dy) => { state.yaw -= dx; state.pitch = Math.max(-Math.PI / 2, Math.min(Math.PI / 2, state.pitch + dy)); };
  const move = (dx, dy) => {
    const scale = pixels() * radius;
    state.pan = [state.pan[0] + dx / scale, state.pan[1] - dy / scale];
  };
  function hover(event) {
    const box = canvas.getBoundingClientRect(), [x, y] = [event.clientX - box.left, event.clientY - box.top];
    let best = null, near = 16;
    for (const [hx, hy, object] of hits) {
      const far = Math.hypot(hx - x, hy - y);
      if (far < near) { near = far; best = object; }
    }
    if (best) {
      tip.textContent = `${best.name} (${best.address}${best.form ? ", " + best.form : ""})`;
      tip.style.left = `${Math.min(x + 14, box.width - 220)}px`; tip.style.top = `${y + 14}px`;
    }
    tip.hidden = !best;
    if (best !== state.hover) { state.hover = best; draw(); }
  }

  const again = () => { readColours(false); draw(); };
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", again);
  // On paper as wide as a page: labels keep their size.
  addEventListener("beforeprint", () => { stage.classList.add("paper"); readColours(true); draw(); });
  addEventListener("afterprint", () => { stage.classList.remove("paper"); again(); });
  new ResizeObserver(draw).observe(stage);
  readColours(matchMedia("print").matches);
  // The case with the largest loads tells most.
  const weight = (frame) => (frame.arrows || []).reduce((s, a) => s + norm(a.force), 0);
  const first = frames.reduce((best, frame, k) => weight(frame) > weight(frames[best]) ? k : best, 0);
  look("3-D");
  if (frames.length) show(first); else draw();
}

document.querySelectorAll(".scene").forEach(start);
})();

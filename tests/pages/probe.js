document.querySelectorAll("details").forEach((one) => { one.open = true; });
setTimeout(() => {
  // A cheap fingerprint of the picture, and how much of it is not empty.
  const look = (canvas) => {
    const data = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height).data;
    let print = 0, drawn = 0;
    for (let k = 3; k < data.length; k += 4) {
      if (data[k]) { drawn += 1; print = (print * 31 + k + data[k] + data[k - 1]) | 0; }
    }
    return [print, drawn];
  };
  // Left, right, top and bottom of what is drawn above the axes and the scale, as parts of width and height; and where its upper third is.
  const extent = (canvas) => {
    const [wide, tall] = [canvas.width, canvas.height];
    const data = canvas.getContext("2d").getImageData(0, 0, wide, tall).data;
    const rows = Math.floor(tall * (1 - 76 / canvas.clientHeight));
    const box = [1, 0, 1, 0], columns = [];
    for (let y = 0; y < rows; y++) for (let x = 0; x < wide; x++) {
      const isAxes = x < wide * 100 / canvas.clientWidth && y > tall * (1 - 120 / canvas.clientHeight);
      if (isAxes || !data[4 * (y * wide + x) + 3]) continue;
      box[0] = Math.min(box[0], x / wide); box[1] = Math.max(box[1], x / wide);
      box[2] = Math.min(box[2], y / tall); box[3] = Math.max(box[3], y / tall);
      columns.push([x / wide, y / tall]);
    }
    const high = columns.filter(([, y]) => y < box[2] + (box[3] - box[2]) / 3);
    return [...box, high.reduce((sum, [x]) => sum + x / high.length, 0)];
  };
  const used = (canvas, action) => { const before = look(canvas)[0]; action(); return look(canvas)[0] !== before; };
  const scenes = [...document.querySelectorAll(".scene")].map((scene) => {
    const canvas = scene.querySelector("canvas");
    const set = (input, value) => { input.value = value; input.dispatchEvent(new Event("input", { bubbles: true })); };
    const slider = scene.querySelector(".scene-factor"), steps = scene.querySelector(".scene-steps");
    const point = (type, x, y) => canvas.dispatchEvent(new PointerEvent(type, { pointerId: 1, clientX: x, clientY: y, buttons: 1, bubbles: true }));
    canvas.setPointerCapture = () => {};
    return {
      drawn: look(canvas)[1],
      step: steps ? used(canvas, () => set(steps, Math.floor((Number(steps.max) + (Number(steps.value) === 0 ? 2 : 0)) / 2))) : null,
      slider: slider ? used(canvas, () => set(slider, slider.max)) : null,
      key: used(canvas, () => canvas.dispatchEvent(new KeyboardEvent("keydown", { key: "ArrowLeft", bubbles: true }))),
      views: (() => {
        const labels = [...scene.querySelectorAll(".scene-bar label")].find((label) => label.textContent === "labels").querySelector("input");
        if (labels.checked) labels.click();
        return Object.fromEntries(["Front", "Side", "Top"].map((name) => {
          [...scene.querySelectorAll(".scene-bar button")].find((button) => button.textContent === name).click();
          return [name, extent(canvas)];
        }));
      })(),
      drag: used(canvas, () => { point("pointerdown", 100, 100); point("pointermove", 140, 120); point("pointerup", 140, 120); }),
    };
  });
  const pictures = [...document.querySelectorAll("svg.chart, svg.map")].map((svg) => {
    const box = svg.getBoundingClientRect();
    return box.width > 50 && box.height > 50 && svg.querySelector(".line, circle, rect") !== null;
  });
  // What a chart does under the pointer: a value is shown, and a dragged frame changes its ticks.
  const charts = [...document.querySelectorAll("svg.chart[data-plot]")].map((svg) => {
    const at = (type, share, extra) => {
      const box = svg.getBoundingClientRect(), [left, right, top, bottom] = svg.dataset.plot.split(" ").map(Number);
      const [, , wide, tall] = svg.getAttribute("viewBox").split(" ").map(Number);
      svg.dispatchEvent(new PointerEvent(type, { pointerId: 2, pointerType: "mouse", button: 0, bubbles: true,
        clientX: box.left + (left + share * (right - left)) * box.width / wide, clientY: box.top + (top + share * (bottom - top)) * box.height / tall, ...extra }));
    };
    svg.setPointerCapture = () => {};
    const dot = svg.querySelector(".plot circle, .plot .line");
    if (!dot) return { value: true, zoomed: true };
    const box = dot.getBoundingClientRect(), line = dot.classList.contains("line") ? dot.getPointAtLength(0) : null;
    const own = svg.getBoundingClientRect(), scale = own.width / Number(svg.getAttribute("viewBox").split(" ")[2]);
    const [clientX, clientY] = line ? [own.left + line.x * scale, own.top + line.y * scale] : [box.left + box.width / 2, box.top + box.height / 2];
    at("pointermove", 0, { clientX, clientY });
    const tip = svg.closest("figure").querySelector(".tip"), value = !tip.hidden && / at /.test(tip.textContent);
    const ticks = () => svg.querySelector(".ticks").textContent, before = ticks();
    at("pointerdown", 0.2); at("pointermove", 0.7); at("pointerup", 0.7);
    const zoomed = ticks() !== before;
    svg.dispatchEvent(new MouseEvent("dblclick", { bubbles: true }));
    return { value, zoomed };
  });
  const outside = [...document.querySelectorAll("[src], [href]")].map((node) => node.getAttribute("src") || node.getAttribute("href"))
    .filter((address) => !/^(data:|#)/.test(address));
  const seen = { errors: window.seenErrors, window: innerWidth, content: document.documentElement.scrollWidth, pictures, scenes, charts, outside };
  const pre = parent.document.createElement("pre");
  pre.id = "seen";
  pre.textContent = JSON.stringify(seen);
  parent.document.body.append(pre);
}, 400);

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
      drag: used(canvas, () => { point("pointerdown", 100, 100); point("pointermove", 140, 120); point("pointerup", 140, 120); }),
    };
  });
  const pictures = [...document.querySelectorAll("svg.chart, svg.map")].map((svg) => {
    const box = svg.getBoundingClientRect();
    return box.width > 50 && box.height > 50 && svg.querySelector(".line, circle, rect") !== null;
  });
  const outside = [...document.querySelectorAll("[src], [href]")].map((node) => node.getAttribute("src") || node.getAttribute("href"))
    .filter((address) => !/^(data:|#)/.test(address));
  const seen = { errors: window.seenErrors, window: innerWidth, content: document.documentElement.scrollWidth, pictures, scenes, outside };
  const pre = parent.document.createElement("pre");
  pre.id = "seen";
  pre.textContent = JSON.stringify(seen);
  parent.document.body.append(pre);
}, 400);

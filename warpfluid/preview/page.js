"use strict";
(() => {
  const find = (name) => document.getElementById(name);
  const scene = JSON.parse(find("scene").textContent);
  const stage = find("stage"), picture = find("picture"), lines = find("lines");
  const SLOW = 70; // ms a picture, above which a moving picture is drawn coarser
  const count = scene.frames.length, unpack = makeFrames(scene);
  const start = {
    frame: scene.start, angle: scene.angle, elevation: scene.elevation, zoom: 0.92, x: 0, y: 0, ramp: scene.ramp, exposure: scene.exposure,
    mode: "sum", absorption: 5, bodies: true, box: true, theme: matchMedia("(prefers-color-scheme: dark)").matches ? "dark" : "light",
    bare: false,
  };
  const state = { ...start, ...fromAddress() };
  let graphics, playing = false, turning = false, coarse = 1, rested = 0, waiting = false, shown = -1;

  // ---- the address keeps the view, so that it can be passed on

  function fromAddress() {
    const given = {};
    for (const [name, text] of new URLSearchParams(location.hash.slice(1))) {
      if (!(name in start)) continue;
      if (name === "frame") given.frame = Math.max(0, scene.frames.indexOf(Number(text)));
      else if (typeof start[name] === "number" && Number.isFinite(Number(text))) given[name] = Number(text);
      else if (typeof start[name] === "boolean") given[name] = text !== "false";
      else if (typeof start[name] === "string") given[name] = text;
    }
    const known = { ramp: Object.keys(scene.ramps), mode: ["sum", "absorbing", "lit"], theme: ["dark", "light"] };
    for (const [name, words] of Object.entries(known)) if (!words.includes(given[name])) delete given[name];
    return given;
  }

  function toAddress() {
    const text = new URLSearchParams();
    for (const name of Object.keys(start)) {
      if (name === "frame" ? state.frame !== start.frame : state[name] !== start[name])
        text.set(name, name === "frame" ? scene.frames[state.frame] : typeof state[name] === "number" ? +state[name].toFixed(3) : state[name]);
    }
    try { history.replaceState(null, "", "#" + text); } catch { /* some readers of files forbid it */ }
  }

  // ---- drawing

  async function show(index) {
    const levels = await unpack(index, shown);
    await graphics.ready;
    if (state.frame !== index || shown === index) return;
    graphics.load(levels);
    shown = index;
    redraw();
    for (let k = 1; k <= 3; ++k) unpack((index + k) % count, shown).catch(() => {});
  }

  function axes() {
    const t = state.angle * Math.PI / 180, e = state.elevation * Math.PI / 180, [c, s] = [Math.cos(t), Math.sin(t)];
    return {
      right: [c, 0, s], up: [s * Math.sin(e), Math.cos(e), -c * Math.sin(e)],
      forward: [s * Math.cos(e), -Math.sin(e), -c * Math.cos(e)],
    };
  }

  function fit(canvas, factor) {
    const width = Math.max(1, Math.round(stage.clientWidth * factor)), height = Math.max(1, Math.round(stage.clientHeight * factor));
    if (canvas.width !== width || canvas.height !== height) [canvas.width, canvas.height] = [width, height];
    const scale = Math.min(width / scene.box[0], height / scene.box[1]) * state.zoom * farther();
    return { width, height, scale, middle: [width / 2 + state.x * scale, height / 2 + state.y * scale] };
  }

  function farther() { // from above the floor is seen as well
    const e = Math.abs(state.elevation) * Math.PI / 180, [x, y, z] = scene.box;
    return y / Math.max(y, y * Math.cos(e) + RING * Math.hypot(x, z) * Math.sin(e));
  }

  function redraw() {
    if (waiting || shown < 0) return;
    waiting = true;
    requestAnimationFrame(draw);
  }

  function draw() {
    waiting = false;
    const began = performance.now(), view = axes(), moving = playing || turning || stage.classList.contains("turning");
    const at = fit(picture, (window.devicePixelRatio || 1) / (moving ? coarse : 1));
    const sum = state.mode === "sum", depth = sum ? 0 : state.absorption, background = sum ? [0, 0, 0] : backdrop();
    const { exposure, bodies } = state, lit = state.mode === "lit";
    graphics.draw({ frame: shown, at, axes: view, depth, lit, exposure, bodies, background });
    lines.hidden = !state.box || state.bare;
    if (!lines.hidden) drawLines(lines, scene, fit(lines, window.devicePixelRatio || 1), view, sum || state.theme === "dark");
    if (moving) {
      graphics.finish();
      const took = performance.now() - began;
      if (took > SLOW && coarse < 4) coarse *= Math.SQRT2;
      else if (took < SLOW / 4 && coarse > 1) coarse = Math.max(1, coarse / Math.SQRT2);
      clearTimeout(rested);
      rested = setTimeout(redraw, 200);
    }
    if (picture.hidden) {
      picture.hidden = false;
      find("still").hidden = true;
    }
    document.body.dataset.shown = scene.frames[shown];
  }

  const backdrop = () => (state.theme === "dark" ? [0.075, 0.08, 0.09] : [0.8, 0.82, 0.85]);

  // ---- controls

  function change(news) {
    const before = { ...state };
    Object.assign(state, news);
    state.frame = ((Math.round(state.frame) % count) + count) % count;
    state.angle = ((state.angle % 360) + 360) % 360;
    if (state.angle > 180) state.angle -= 360;
    state.elevation = Math.min(Math.max(state.elevation, -89), 89);
    state.zoom = Math.min(Math.max(state.zoom, 0.2), 20);
    state.exposure = Math.min(Math.max(state.exposure, -4), 4);
    state.absorption = Math.min(Math.max(state.absorption, 0.1), 12);
    if (graphics && state.ramp !== before.ramp) graphics.setRamp(state.ramp);
    label();
    if (!graphics) return;
    if (state.frame !== shown) show(state.frame).catch(fail);
    redraw();
    clearTimeout(change.later);
    change.later = setTimeout(toAddress, 300);
  }

  function label() {
    find("slider").value = state.frame;
    find("number").textContent = `frame ${scene.frames[state.frame]}`;
    find("play").innerHTML = playing ? "&#10073;&#10073;" : "&#9654;";
    const stops = Math.abs(state.exposure) < 0.005 ? "0" : (state.exposure > 0 ? "+" : "−") + Math.abs(state.exposure).toFixed(2);
    for (const [name, text] of [["exposure", stops + " stops"], ["absorption", "depth " + state.absorption.toFixed(1)]]) {
      find(name).value = state[name];
      find(name).nextElementSibling.textContent = text;
    }
    find("thick").hidden = state.mode === "sum";
    for (const button of find("ramps").children) button.ariaPressed = String(button.dataset.ramp === state.ramp);
    for (const button of find("modes").children) button.ariaPressed = String(button.dataset.mode === state.mode);
    for (const button of find("views").children)
      button.ariaPressed = String(Math.abs(Number(button.dataset.angle) - state.angle) < 0.01 && Math.abs(state.elevation) < 0.01);
    for (const [name, on] of [["turn", turning], ["box", state.box], ["bodies", state.bodies]]) find(name).ariaPressed = String(on);
    const height = state.elevation ? `, ${Math.abs(state.elevation).toFixed(0)}° ${state.elevation > 0 ? "above" : "below"}` : "";
    find("pose").textContent = `camera at ${state.angle.toFixed(0)}°${height}`;
    document.documentElement.classList.toggle("dark", state.theme === "dark");
    document.body.classList.toggle("bare", state.bare);
  }

  function build() {
    const button = (parent, text, click, chip) => {
      const made = document.createElement("button");
      if (chip) made.append(Object.assign(document.createElement("span"), { className: "chip", style: "background:" + chip }));
      made.append(text);
      made.addEventListener("click", click);
      find(parent).append(made);
      return made;
    };
    for (const [name, stops] of Object.entries(scene.ramps)) {
      const chip = `linear-gradient(90deg,${stops.map(([g, r, y, b]) => `rgb(${r},${y},${b}) ${g / 2.55}%`)})`;
      button("ramps", name, () => change({ ramp: name }), chip).dataset.ramp = name;
    }
    for (const angle of scene.angles)
      button("views", `view ${+angle.toFixed(2)}°`, () => change({ angle, elevation: 0 })).dataset.angle = angle;
    for (const chosen of find("modes").children) chosen.addEventListener("click", () => change({ mode: chosen.dataset.mode }));
    for (const name of ["exposure", "absorption"]) find(name).addEventListener("input", (event) => change({ [name]: Number(event.target.value) }));
    find("slider").max = count - 1;
    find("slider").addEventListener("input", (event) => { playing = false; change({ frame: Number(event.target.value) }); });
    find("time").hidden = count < 2;
    const most = Math.max(...scene.lights, 1e-30), step = 100 / Math.max(count - 1, 1);
    const points = scene.lights.map((light, i) => `${(i * step).toFixed(2)} ${(23 - 20 * light / most).toFixed(2)}`);
    find("lights").setAttribute("d", `M0 24L${points.join("L")}L100 24Z`);
    find("bodies").hidden = !scene.solids.length;
    for (const [name, act] of Object.entries({ play, turn, bodies, box, theme, save })) find(name).addEventListener("click", act);
    addEventListener("keydown", press);
    addEventListener("resize", redraw);
    addEventListener("hashchange", () => change(fromAddress()));
    stage.addEventListener("pointerdown", grab);
    stage.addEventListener("wheel", (event) => { event.preventDefault(); change({ zoom: state.zoom * 1.0015 ** -event.deltaY }); }, { passive: false });
    picture.addEventListener("webglcontextlost", () => fail(new Error("the graphics card gave up: load the page again")));
  }

  const bodies = () => change({ bodies: !state.bodies });
  const box = () => change({ box: !state.box });
  const theme = () => change({ theme: state.theme === "dark" ? "light" : "dark" });
  const next = (list, now) => list[(list.indexOf(now) + 1) % list.length];

  function save() {
    if (shown < 0) return;
    picture.toBlob((blob) => {
      const name = `${document.title}.${String(scene.frames[shown]).padStart(4, "0")}.png`;
      const href = URL.createObjectURL(blob);
      Object.assign(document.createElement("a"), { href, download: name }).click();
      setTimeout(() => URL.revokeObjectURL(href), 60000);
    });
  }

  function play() {
    playing = !playing && count > 1 && graphics;
    label();
    if (playing) animate();
  }

  function turn() {
    turning = !turning && graphics;
    label();
    if (turning && !playing) animate();
  }

  function animate() {
    let last = performance.now(), owed = 0;
    const tick = (now) => {
      if (!playing && !turning) return redraw();
      const passed = Math.min(now - last, 250) / 1000;
      last = now;
      owed = playing ? owed + passed * scene.rate : 0;
      const due = shown === state.frame ? Math.floor(owed) : 0; // waits for a frame that is not unpacked yet
      owed = Math.min(owed - due, 1);
      if (due || turning) change({ frame: state.frame + due, angle: state.angle + (turning ? 24 * passed : 0) });
      requestAnimationFrame(tick);
    };
    requestAnimationFrame(tick);
  }

  const keys = {
    " ": play, ArrowLeft: () => change({ frame: state.frame - 1 }), ArrowRight: () => change({ frame: state.frame + 1 }),
    Home: () => change({ frame: 0 }), End: () => change({ frame: count - 1 }),
    ArrowUp: () => change({ exposure: state.exposure + 0.25 }), ArrowDown: () => change({ exposure: state.exposure - 0.25 }),
    c: () => change({ ramp: next(Object.keys(scene.ramps), state.ramp) }), t: turn, b: bodies, o: box, d: theme, s: save,
    a: () => change({ mode: state.mode === "absorbing" ? "sum" : "absorbing" }),
    l: () => change({ mode: state.mode === "lit" ? "sum" : "lit" }), h: () => change({ bare: !state.bare }),
    "+": () => change({ zoom: state.zoom * 1.15 }), "=": () => change({ zoom: state.zoom * 1.15 }),
    "-": () => change({ zoom: state.zoom / 1.15 }),
    0: () => change({ angle: start.angle, elevation: start.elevation, zoom: start.zoom, x: 0, y: 0, exposure: start.exposure }),
  };

  function press(event) {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    const key = event.key.length === 1 ? event.key.toLowerCase() : event.key, angle = scene.angles[Number(key) - 1];
    if (!(key in keys) && angle === undefined) return;
    event.preventDefault();
    if (key.startsWith("Arrow") || key === "Home" || key === "End") playing = false;
    if (key in keys) keys[key]();
    else change({ angle, elevation: 0 });
  }

  function grab(event) {
    if (event.button > 1) return;
    const from = { ...state }, { clientX, clientY } = event, moves = event.shiftKey || event.button === 1;
    stage.setPointerCapture(event.pointerId);
    stage.classList.add("turning");
    const drag = (now) => {
      const [x, y] = [now.clientX - clientX, now.clientY - clientY];
      const scale = fit(lines, 1).scale;
      if (moves) change({ x: from.x + x / scale, y: from.y - y / scale });
      else change({ angle: from.angle + 0.4 * x, elevation: from.elevation + 0.4 * y });
    };
    const drop = () => {
      stage.classList.remove("turning");
      stage.removeEventListener("pointermove", drag);
      redraw();
    };
    stage.addEventListener("pointermove", drag);
    for (const end of ["pointerup", "pointercancel"]) stage.addEventListener(end, drop, { once: true });
  }

  function fail(error) {
    playing = turning = false;
    find("message").textContent = `No moving picture: ${error.message}. This is a still one.`;
    find("message").hidden = false;
    if (shown < 0) find("still").hidden = false;
  }

  build();
  try {
    graphics = openGraphics(picture, scene);
    graphics.setRamp(state.ramp);
  } catch (error) {
    fail(error);
  }
  change({});
})();

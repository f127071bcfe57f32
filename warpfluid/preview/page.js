"use strict";
(() => {
  const find = (name) => document.getElementById(name);
  const scene = JSON.parse(find("scene").textContent);
  const packed = [...document.querySelectorAll("script.frame")];
  const stage = find("stage"), picture = find("picture"), lines = find("lines");
  const KEPT = 6e8; // bytes of unpacked frames
  const SLOW = 70; // ms a picture, above which a moving picture is drawn coarser
  const RING = 1.04; // radius about the floor, over half its diagonal
  const start = {
    frame: scene.start, angle: scene.angle, elevation: scene.elevation, zoom: 0.92, x: 0, y: 0, ramp: scene.ramp, exposure: scene.exposure,
    mode: "sum", absorption: 5, box: true, theme: matchMedia("(prefers-color-scheme: dark)").matches ? "dark" : "light",
    bare: false,
  };
  const state = { ...start, ...fromAddress() };
  let playing = false, turning = false, coarse = 1, rested = 0, waiting = false, shown = -1;

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
    if (given.ramp && !Object.hasOwn(scene.ramps, given.ramp)) delete given.ramp;
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

  // ---- graphics

  let gl, program, uniforms, texture, rampTexture, castShadows;

  function link(shader) {
    const made = gl.createProgram(), places = {};
    const corners = "#version 300 es\nvoid main() { gl_Position = vec4(gl_VertexID == 1 ? 3.0 : -1.0, gl_VertexID == 2 ? 3.0 : -1.0, 0.0, 1.0); }";
    for (const [kind, text] of [[gl.VERTEX_SHADER, corners], [gl.FRAGMENT_SHADER, shader]]) {
      const part = gl.createShader(kind);
      gl.shaderSource(part, text);
      gl.compileShader(part);
      gl.attachShader(made, part);
    }
    gl.linkProgram(made);
    if (!gl.getProgramParameter(made, gl.LINK_STATUS)) throw new Error("the graphics driver refuses the page's shader");
    for (let i = 0; i < gl.getProgramParameter(made, gl.ACTIVE_UNIFORMS); ++i) {
      const { name } = gl.getActiveUniform(made, i);
      places[name] = gl.getUniformLocation(made, name);
    }
    return { program: made, uniforms: places };
  }

  function openGraphics() {
    gl = picture.getContext("webgl2", { alpha: false, antialias: false, preserveDrawingBuffer: true, powerPreference: "high-performance" });
    if (!gl) throw new Error("this browser draws no 3D pictures (WebGL 2): try another one, or switch graphics acceleration on");
    if (typeof DecompressionStream === "undefined") throw new Error("this browser is too old to unpack the volumes: use one of 2023 or later");
    const most = gl.getParameter(gl.MAX_3D_TEXTURE_SIZE);
    if (Math.max(...scene.cells) > most) throw new Error(`this graphics card takes ${most} voxels a side, the volumes have ${Math.max(...scene.cells)}: write the page with a smaller --html-size`);
    ({ program, uniforms } = link(scene.shader));
    gl.pixelStorei(gl.UNPACK_ALIGNMENT, 1);
    const [nx, ny, nz] = scene.cells;
    texture = gl.createTexture();
    gl.activeTexture(gl.TEXTURE0);
    gl.bindTexture(gl.TEXTURE_3D, texture);
    gl.texStorage3D(gl.TEXTURE_3D, 1, gl.R16F, ny, nz, nx);
    clampTo(gl, gl.TEXTURE_3D, gl.LINEAR);
    rampTexture = gl.createTexture();
    gl.activeTexture(gl.TEXTURE1);
    gl.bindTexture(gl.TEXTURE_2D, rampTexture);
    clampTo(gl, gl.TEXTURE_2D, gl.NEAREST);
    castShadows = makeShadows(gl, scene, link);
    gl.useProgram(program);
    for (const [unit, name] of ["density", "ramp", "shade"].entries()) gl.uniform1i(uniforms[name], unit);
    setRamp();
  }

  function setRamp() { // the table of apply_ramp: every eighth of a grey level
    const stops = scene.ramps[state.ramp], count = 255 * 8 + 1, table = new Uint8Array(4 * count).fill(255);
    for (let i = 0, s = 0; i < count; ++i) {
      const grey = i / 8;
      while (s < stops.length - 2 && grey > stops[s + 1][0]) ++s;
      const [a, b] = [stops[s], stops[s + 1]], way = Math.min(Math.max((grey - a[0]) / (b[0] - a[0]), 0), 1);
      for (let c = 0; c < 3; ++c) table[4 * i + c] = Math.round(a[c + 1] + way * (b[c + 1] - a[c + 1]));
    }
    gl.activeTexture(gl.TEXTURE1);
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA8, count, 1, 0, gl.RGBA, gl.UNSIGNED_BYTE, table);
  }

  // ---- frames: unpacked when they are needed, forgotten when there are too many

  const unpacked = new Map();
  const halves = new Uint16Array(scene.table);

  function unpack(index) {
    if (!unpacked.has(index)) {
      const size = scene.cells[0] * scene.cells[1] * scene.cells[2];
      for (const old of unpacked.keys()) if (unpacked.size * size > KEPT && old !== shown) unpacked.delete(old);
      unpacked.set(index, inflate(packed[index].textContent.trim(), scene.cells[1], size));
    }
    return unpacked.get(index);
  }

  async function inflate(text, run, size) {
    const bytes = Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
    const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"));
    const levels = new Uint8Array(await new Response(stream).arrayBuffer());
    if (levels.length !== size) throw new Error("the page is damaged: write it anew");
    for (let i = 0; i < size; i += run) for (let k = i + 1; k < i + run; ++k) levels[k] += levels[k - 1]; // differences along the height
    return levels;
  }

  async function show(index) {
    const levels = await unpack(index);
    if (state.frame !== index || shown === index) return;
    const values = new Uint16Array(levels.length);
    for (let i = 0; i < levels.length; ++i) values[i] = halves[levels[i]];
    const [nx, ny, nz] = scene.cells;
    gl.activeTexture(gl.TEXTURE0);
    gl.texSubImage3D(gl.TEXTURE_3D, 0, 0, 0, 0, ny, nz, nx, gl.RED, gl.HALF_FLOAT, values);
    shown = index;
    redraw();
    for (let k = 1; k <= 3; ++k) unpack((index + k) % packed.length).catch(() => {});
  }

  // ---- drawing

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
    const began = performance.now(), { right, up, forward } = axes(), moving = playing || turning || stage.classList.contains("turning");
    const at = fit(picture, (window.devicePixelRatio || 1) / (moving ? coarse : 1));
    const sum = state.mode === "sum", lit = state.mode === "lit", depth = sum ? 0 : state.absorption;
    if (lit) castShadows(shown, depth);
    gl.useProgram(program);
    gl.viewport(0, 0, at.width, at.height);
    for (const [name, value] of Object.entries({ right, up, forward, low: scene.low, high: scene.high, cells: scene.cells }))
      gl.uniform3fv(uniforms[name], value);
    gl.uniform2fv(uniforms.middle, at.middle);
    gl.uniform1f(uniforms.scale, at.scale);
    gl.uniform1f(uniforms.peak, scene.peak);
    gl.uniform1f(uniforms.absorption, depth);
    gl.uniform1f(uniforms.gain, 2 ** state.exposure * (depth > 0 && !lit ? depth / (1 - Math.exp(-depth)) : 1)); // 255 stays white
    gl.uniform2fv(uniforms.lamps, lit ? scene.lamps : [0, 0]);
    gl.uniform3fv(uniforms.background, sum ? [0, 0, 0] : backdrop());
    gl.drawArrays(gl.TRIANGLES, 0, 3);
    drawLines({ right, up });
    if (moving) {
      gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, new Uint8Array(4)); // waits until it is drawn
      const took = performance.now() - began;
      if (took > SLOW && coarse < 4) coarse *= Math.SQRT2;
      else if (took < SLOW / 4 && coarse > 1) coarse = Math.max(1, coarse / Math.SQRT2);
      clearTimeout(rested);
      rested = setTimeout(redraw, 200);
    }
    if (picture.hidden) {
      picture.hidden = lines.hidden = false;
      find("still").hidden = true;
    }
    document.body.dataset.shown = scene.frames[shown];
  }

  const backdrop = () => (state.theme === "dark" ? [0.075, 0.08, 0.09] : [0.8, 0.82, 0.85]);

  function drawLines({ right, up }) {
    const at = fit(lines, window.devicePixelRatio || 1), pen = lines.getContext("2d"), unit = window.devicePixelRatio || 1;
    pen.clearRect(0, 0, at.width, at.height);
    if (!state.box || state.bare) return;
    const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    const place = (p) => [at.middle[0] + at.scale * dot(p, right), at.height - at.middle[1] - at.scale * dot(p, up)];
    const path = (points) => { pen.beginPath(); for (const p of points) pen.lineTo(...place(p)); pen.stroke(); };
    const [x, y, z] = scene.box.map((n) => n / 2), bright = state.mode === "sum" || state.theme === "dark";
    pen.lineWidth = unit;
    pen.strokeStyle = pen.fillStyle = bright ? "#8b94a8" : "#5a6172";
    pen.globalAlpha = 0.55;
    for (const h of [-y, y]) path([[-x, h, -z], [x, h, -z], [x, h, z], [-x, h, z], [-x, h, -z]]);
    for (const [a, b] of [[-x, -z], [x, -z], [x, z], [-x, z]]) path([[a, -y, b], [a, y, b]]);
    if (Math.abs(state.elevation) < 3) return;
    const round = (angle, r) => [-r * Math.sin(angle), -y, r * Math.cos(angle)], far = RING * Math.hypot(x, z);
    path(Array.from({ length: 73 }, (_, i) => round(i * Math.PI / 36, far)));
    pen.globalAlpha = 0.9;
    pen.font = `${12 * unit}px system-ui, sans-serif`;
    pen.textAlign = "center";
    for (const angle of scene.angles) {
      const [u, v] = place(round(angle * Math.PI / 180, far));
      pen.beginPath();
      pen.arc(u, v, 3 * unit, 0, 7);
      pen.fill();
      pen.fillText(`${+angle.toFixed(1)}°`, u, v - 8 * unit);
    }
  }

  // ---- controls

  function change(news) {
    const before = { ...state };
    Object.assign(state, news);
    state.frame = ((Math.round(state.frame) % packed.length) + packed.length) % packed.length;
    state.angle = ((state.angle % 360) + 360) % 360;
    if (state.angle > 180) state.angle -= 360;
    state.elevation = Math.min(Math.max(state.elevation, -89), 89);
    state.zoom = Math.min(Math.max(state.zoom, 0.2), 20);
    state.exposure = Math.min(Math.max(state.exposure, -4), 4);
    state.absorption = Math.min(Math.max(state.absorption, 0.1), 12);
    if (gl && state.ramp !== before.ramp) setRamp();
    label();
    if (!gl) return;
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
    for (const [name, on] of [["turn", turning], ["box", state.box]]) find(name).ariaPressed = String(on);
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
    find("slider").max = packed.length - 1;
    find("slider").addEventListener("input", (event) => { playing = false; change({ frame: Number(event.target.value) }); });
    find("time").hidden = packed.length < 2;
    const most = Math.max(...scene.lights, 1e-30), step = 100 / Math.max(packed.length - 1, 1);
    const points = scene.lights.map((light, i) => `${(i * step).toFixed(2)} ${(23 - 20 * light / most).toFixed(2)}`);
    find("lights").setAttribute("d", `M0 24L${points.join("L")}L100 24Z`);
    for (const [name, act] of Object.entries({ play, turn, box, theme, save })) find(name).addEventListener("click", act);
    addEventListener("keydown", press);
    addEventListener("resize", redraw);
    addEventListener("hashchange", () => change(fromAddress()));
    stage.addEventListener("pointerdown", grab);
    stage.addEventListener("wheel", (event) => { event.preventDefault(); change({ zoom: state.zoom * 1.0015 ** -event.deltaY }); }, { passive: false });
    picture.addEventListener("webglcontextlost", () => fail(new Error("the graphics card gave up: load the page again")));
  }

  const box = () => change({ box: !state.box });
  const theme = () => change({ theme: state.theme === "dark" ? "light" : "dark" });
  const next = (list, now) => list[(list.indexOf(now) + 1) % list.length];

  function save() {
    if (shown < 0) return;
    picture.toBlob((blob) => {
      const name = `${document.title}.${String(scene.frames[shown]).padStart(4, "0")}.png`;
      Object.assign(document.createElement("a"), { href: URL.createObjectURL(blob), download: name }).click();
    });
  }

  function play() {
    playing = !playing && packed.length > 1 && gl;
    label();
    if (playing) animate();
  }

  function turn() {
    turning = !turning && gl;
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
    Home: () => change({ frame: 0 }), End: () => change({ frame: packed.length - 1 }),
    ArrowUp: () => change({ exposure: state.exposure + 0.25 }), ArrowDown: () => change({ exposure: state.exposure - 0.25 }),
    c: () => change({ ramp: next(Object.keys(scene.ramps), state.ramp) }), t: turn, b: box, d: theme, s: save,
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
    openGraphics();
  } catch (error) {
    gl = null;
    fail(error);
  }
  change({});
})();

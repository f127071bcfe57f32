"use strict";

// The picture of a frame: the volume's light is added up along parallel rays, up to what stands in it and past its edges.
// Units of textures: 0 density, 1 ramp, 2 and 3 shadows, 4 and 5 what stands there.
function openGraphics(picture, scene) {
  const gl = picture.getContext("webgl2", { alpha: false, antialias: false, preserveDrawingBuffer: true, powerPreference: "high-performance" });
  if (!gl) throw new Error("this browser draws no 3D pictures (WebGL 2): try another one, or switch graphics acceleration on");
  if (typeof DecompressionStream === "undefined") throw new Error("this browser is too old to unpack the volumes: use one of 2023 or later");
  const [nx, ny, nz] = scene.cells, most = gl.getParameter(gl.MAX_3D_TEXTURE_SIZE), halves = new Uint16Array(scene.table);
  if (Math.max(nx, ny, nz) > most) throw new Error(`this graphics card takes ${most} voxels a side, the volumes have ${Math.max(nx, ny, nz)}: write the page with a smaller --html-size`);
  const { program, uniforms } = link(gl, scene.shaders.page);
  gl.pixelStorei(gl.UNPACK_ALIGNMENT, 1);
  bindTexture(gl, 0, gl.TEXTURE_3D, gl.LINEAR);
  gl.texStorage3D(gl.TEXTURE_3D, 1, gl.R16F, ny, nz, nx);
  bindTexture(gl, 1, gl.TEXTURE_2D, gl.NEAREST);
  const castShadows = makeShadows(gl, scene), drawSolids = makeSolids(gl, scene);
  gl.useProgram(program);
  for (const [unit, name] of [[0, "density"], [1, "ramp"], [2, "shade"], [4, "solids"], [5, "depths"]]) gl.uniform1i(uniforms[name], unit);

  function setRamp(name) { // the table of apply_ramp: every eighth of a grey level
    const stops = scene.ramps[name], count = 255 * 8 + 1, table = new Uint8Array(4 * count).fill(255);
    for (let i = 0, s = 0; i < count; ++i) {
      const grey = i / 8;
      while (s < stops.length - 2 && grey > stops[s + 1][0]) ++s;
      const [a, b] = [stops[s], stops[s + 1]], way = Math.min(Math.max((grey - a[0]) / (b[0] - a[0]), 0), 1);
      for (let c = 0; c < 3; ++c) table[4 * i + c] = Math.round(a[c + 1] + way * (b[c + 1] - a[c + 1]));
    }
    gl.activeTexture(gl.TEXTURE1);
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA8, count, 1, 0, gl.RGBA, gl.UNSIGNED_BYTE, table);
  }

  function load(levels) {
    const values = new Uint16Array(levels.length);
    for (let i = 0; i < levels.length; ++i) values[i] = halves[levels[i]];
    gl.activeTexture(gl.TEXTURE0);
    gl.texSubImage3D(gl.TEXTURE_3D, 0, 0, 0, 0, ny, nz, nx, gl.RED, gl.HALF_FLOAT, values);
  }

  // at: width, height, scale and middle; axes: right, up, forward; depth: of a white ray, 0 where light adds up
  function draw({ frame, at, axes, depth, lit, exposure, bodies, background }) {
    if (lit) castShadows(frame, depth);
    const fine = bodies ? drawSolids(frame, at, axes, lit) : 0;
    gl.useProgram(program);
    gl.viewport(0, 0, at.width, at.height);
    for (const [name, value] of Object.entries({ ...axes, low: scene.low, high: scene.high, cells: scene.cells, background }))
      gl.uniform3fv(uniforms[name], value);
    gl.uniform2fv(uniforms.middle, at.middle);
    gl.uniform1f(uniforms.scale, at.scale);
    gl.uniform1f(uniforms.peak, scene.peak);
    gl.uniform1f(uniforms.absorption, depth);
    gl.uniform1f(uniforms.gain, 2 ** exposure * (depth > 0 && !lit ? depth / (1 - Math.exp(-depth)) : 1)); // 255 stays white
    gl.uniform2fv(uniforms.lamps, lit ? scene.lamps : [0, 0]);
    gl.uniform1i(uniforms.fine, fine);
    gl.uniform1f(uniforms.reach, scene.reach);
    gl.drawArrays(gl.TRIANGLES, 0, 3);
  }

  const finish = () => gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, new Uint8Array(4)); // waits until it is drawn
  return { setRamp, load, draw, finish, ready: drawSolids.ready };
}

const WHOLE_PICTURE = "#version 300 es\nvoid main() { gl_Position = vec4(gl_VertexID == 1 ? 3.0 : -1.0, gl_VertexID == 2 ? 3.0 : -1.0, 0.0, 1.0); }";

function link(gl, fragment, vertex = WHOLE_PICTURE) {
  const program = gl.createProgram(), uniforms = {};
  for (const [kind, text] of [[gl.VERTEX_SHADER, vertex], [gl.FRAGMENT_SHADER, fragment]]) {
    const part = gl.createShader(kind);
    gl.shaderSource(part, text);
    gl.compileShader(part);
    gl.attachShader(program, part);
  }
  gl.linkProgram(program);
  if (!gl.getProgramParameter(program, gl.LINK_STATUS)) throw new Error("the graphics driver refuses the page's shader");
  for (let i = 0; i < gl.getProgramParameter(program, gl.ACTIVE_UNIFORMS); ++i) {
    const { name } = gl.getActiveUniform(program, i);
    uniforms[name] = gl.getUniformLocation(program, name);
  }
  return { program, uniforms };
}

function bindTexture(gl, unit, target, filter) { // a new one
  const texture = gl.createTexture();
  gl.activeTexture(gl.TEXTURE0 + unit);
  gl.bindTexture(target, texture);
  for (const side of ["S", "T", "R"]) gl.texParameteri(target, gl["TEXTURE_WRAP_" + side], gl.CLAMP_TO_EDGE);
  for (const size of ["MIN", "MAG"]) gl.texParameteri(target, gl[`TEXTURE_${size}_FILTER`], filter);
  return texture;
}

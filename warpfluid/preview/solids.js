"use strict";

// Bodies and obstacles, in a picture of their own with FINE samples a pixel and axis: colour, cover and depth.
function makeSolids(gl, scene) {
  const FINE = 2, { low, high, lamps, reach } = scene;
  const { program, uniforms } = link(gl, scene.shaders.solids, scene.shaders.places);
  const framebuffer = gl.createFramebuffer(), most = gl.getParameter(gl.MAX_TEXTURE_SIZE);
  let parts = [], size = "";

  async function prepare({ mesh, vertices, color, poses }) {
    const { buffer } = await unzip(mesh), array = gl.createVertexArray(), triangles = (buffer.byteLength - 15 * vertices) / 12;
    gl.bindVertexArray(array);
    gl.bindBuffer(gl.ARRAY_BUFFER, gl.createBuffer());
    gl.bufferData(gl.ARRAY_BUFFER, buffer, gl.STATIC_DRAW);
    gl.enableVertexAttribArray(0);
    gl.vertexAttribPointer(0, 3, gl.FLOAT, false, 0, 0);
    gl.enableVertexAttribArray(1);
    gl.vertexAttribPointer(1, 3, gl.BYTE, true, 0, 12 * (vertices + triangles));
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, gl.createBuffer());
    gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, new Uint32Array(buffer, 12 * vertices, 3 * triangles), gl.STATIC_DRAW);
    gl.bindVertexArray(null);
    return { array, count: 3 * triangles, color, poses };
  }

  function fit(width, height) {
    if (size === `${width} ${height}`) return;
    size = `${width} ${height}`;
    gl.bindFramebuffer(gl.FRAMEBUFFER, framebuffer);
    for (const [unit, format, place] of [[4, gl.RGBA8, gl.COLOR_ATTACHMENT0], [5, gl.DEPTH_COMPONENT24, gl.DEPTH_ATTACHMENT]]) {
      gl.activeTexture(gl.TEXTURE0 + unit);
      gl.deleteTexture(gl.getParameter(gl.TEXTURE_BINDING_2D));
      const texture = bindTexture(gl, unit, gl.TEXTURE_2D, gl.NEAREST);
      gl.texStorage2D(gl.TEXTURE_2D, 1, format, width, height);
      gl.framebufferTexture2D(gl.FRAMEBUFFER, place, gl.TEXTURE_2D, texture, 0);
    }
  }

  // returns the samples a pixel and axis, 0 where nothing stands
  function draw(frame, at, axes, lit) {
    const there = parts.filter((part) => part.poses[frame]), fine = FINE * Math.max(at.width, at.height) > most ? 1 : FINE;
    if (!there.length) return 0;
    fit(fine * at.width, fine * at.height);
    gl.bindFramebuffer(gl.FRAMEBUFFER, framebuffer);
    gl.viewport(0, 0, fine * at.width, fine * at.height);
    gl.clearColor(0, 0, 0, 0);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    gl.enable(gl.DEPTH_TEST);
    gl.useProgram(program);
    const { right, up, forward } = axes, [a, b, c] = scene.headlight;
    const toLight = lit ? scene.light : [0, 1, 2].map((i) => a * right[i] + b * up[i] - c * forward[i]);
    for (const [name, value] of Object.entries({ ...axes, toLight, low, high })) gl.uniform3fv(uniforms[name], value);
    gl.uniform2fv(uniforms.middle, [2 * at.middle[0] / at.width - 1, 2 * at.middle[1] / at.height - 1]);
    gl.uniform2fv(uniforms.scale, [2 * at.scale / at.width, 2 * at.scale / at.height]);
    gl.uniform1f(uniforms.reach, reach);
    gl.uniform2fv(uniforms.lamps, lit ? lamps : scene.headlamps);
    gl.uniform1i(uniforms.shade, 2);
    gl.uniform1i(uniforms.shaded, lit ? 1 : 0);
    for (const { array, count, color, poses } of there) {
      gl.uniform3fv(uniforms.color, color);
      gl.uniformMatrix4x3fv(uniforms.pose, false, poses[frame]);
      gl.bindVertexArray(array);
      gl.drawElements(gl.TRIANGLES, count, gl.UNSIGNED_INT, 0);
    }
    gl.bindVertexArray(null);
    gl.disable(gl.DEPTH_TEST);
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    return fine;
  }

  fit(1, 1);
  gl.bindFramebuffer(gl.FRAMEBUFFER, null);
  return Object.assign(draw, { ready: Promise.all(scene.solids.map(prepare)).then((made) => { parts = made; }) });
}

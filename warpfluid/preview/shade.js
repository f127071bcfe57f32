"use strict";

// Shadows in the volume: a 3D texture, axes (x, z, y), of how much light from above reaches every place. Levels are drawn
// one below the other, each from the one above, and copied into it; in large volumes they are half as fine.
function makeShadows(gl, scene) {
  const finer = Math.max(...scene.cells) > 128 ? 2 : 1, levels = scene.cells.map((n) => Math.ceil(n / finer)), [nx, ny, nz] = levels;
  const size = scene.high.map((end, i) => end - scene.low[i]);
  const length = Math.hypot(...scene.light), toLight = scene.light.map((part) => part / length);
  const { program, uniforms } = link(gl, scene.shaders.shade), framebuffer = gl.createFramebuffer();
  const pair = [0, 1].map(() => {
    const level = bindTexture(gl, 3, gl.TEXTURE_2D, gl.LINEAR);
    gl.texStorage2D(gl.TEXTURE_2D, 1, gl.RG8, nx, nz);
    return level;
  });
  bindTexture(gl, 2, gl.TEXTURE_3D, gl.LINEAR);
  gl.texStorage3D(gl.TEXTURE_3D, 1, gl.RG8, nx, nz, ny);
  let cast = "";

  return (frame, absorption) => {
    if (cast === `${frame} ${absorption}`) return;
    cast = `${frame} ${absorption}`;
    gl.useProgram(program);
    for (const [name, value] of Object.entries({ size, toLight, levels })) gl.uniform3fv(uniforms[name], value);
    gl.uniform1i(uniforms.density, 0);
    gl.uniform1i(uniforms.above, 3);
    gl.uniform1f(uniforms.peak, scene.peak);
    gl.uniform1f(uniforms.extinction, scene.shadow * absorption / 255);
    gl.viewport(0, 0, nx, nz);
    gl.bindFramebuffer(gl.FRAMEBUFFER, framebuffer);
    gl.activeTexture(gl.TEXTURE3);
    for (let level = ny - 1; level >= 0; --level) {
      gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, gl.TEXTURE_2D, pair[level % 2], 0);
      gl.bindTexture(gl.TEXTURE_2D, pair[(level + 1) % 2]);
      gl.uniform1f(uniforms.level, level);
      gl.drawArrays(gl.TRIANGLES, 0, 3);
      gl.activeTexture(gl.TEXTURE2);
      gl.copyTexSubImage3D(gl.TEXTURE_3D, 0, 0, 0, level, 0, 0, nx, nz);
      gl.activeTexture(gl.TEXTURE3);
    }
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
  };
}

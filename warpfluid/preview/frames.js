"use strict";

// Frames are unpacked when they are needed, and forgotten when there are too many.
function makeFrames(scene) {
  const KEPT = 6e8; // bytes
  const packed = [...document.querySelectorAll("script.frame")], unpacked = new Map();
  const run = scene.cells[1], size = scene.cells[0] * run * scene.cells[2];

  async function inflate(text) {
    const levels = await unzip(text);
    if (levels.length !== size) throw new Error("the page is damaged: write it anew");
    for (let i = 0; i < size; i += run) for (let k = i + 1; k < i + run; ++k) levels[k] += levels[k - 1]; // differences along the height
    return levels;
  }

  return (index, shown) => {
    if (!unpacked.has(index)) {
      for (const old of unpacked.keys()) if (unpacked.size * size > KEPT && old !== shown) unpacked.delete(old);
      unpacked.set(index, inflate(packed[index].textContent.trim()));
    }
    return unpacked.get(index);
  };
}

async function unzip(text) {
  const bytes = Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

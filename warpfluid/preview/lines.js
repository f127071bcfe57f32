"use strict";

const RING = 1.04; // radius about the floor, over half its diagonal

// Draws the edges of the box and, unless the camera looks along the floor, the ring on which the views stood.
function drawLines(canvas, scene, at, { right, up, forward }, bright) {
  const pen = canvas.getContext("2d"), unit = window.devicePixelRatio || 1;
  pen.clearRect(0, 0, at.width, at.height);
  const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
  const place = (p) => [at.middle[0] + at.scale * dot(p, right), at.height - at.middle[1] - at.scale * dot(p, up)];
  const path = (points) => { pen.beginPath(); for (const p of points) pen.lineTo(...place(p)); pen.stroke(); };
  const [x, y, z] = scene.box.map((n) => n / 2);
  pen.lineWidth = unit;
  pen.strokeStyle = pen.fillStyle = bright ? "#8b94a8" : "#5a6172";
  pen.globalAlpha = 0.55;
  for (const h of [-y, y]) path([[-x, h, -z], [x, h, -z], [x, h, z], [-x, h, z], [-x, h, -z]]);
  for (const [a, b] of [[-x, -z], [x, -z], [x, z], [-x, z]]) path([[a, -y, b], [a, y, b]]);
  if (Math.abs(forward[1]) < 0.05) return;
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

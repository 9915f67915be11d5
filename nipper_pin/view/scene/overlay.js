"use strict";
// Sends the scene to meshcat's viewer and writes, frame by frame, what the film tells.
const film = JSON.parse(document.getElementById("film").textContent);
let viewer;
try {
  viewer = new MeshCat.Viewer(document.getElementById("pane"));
} catch (error) {
  document.getElementById("title").textContent =
    "This browser gives no WebGL, which the picture needs; try another one.";
  throw error;
}
for (const message of JSON.parse(document.getElementById("scene").textContent)) {
  viewer.handle_command_bytearray(Uint8Array.from(atob(message), (c) => c.charCodeAt(0)));
}
// The camera's own axes have y up: x, z and -y of the machine.
const upright = ([x, y, z]) => [x, z, -y];
viewer.camera.fov = 40;
viewer.camera.position.set(...upright(film.camera.position));
viewer.controls.target.set(...upright(film.camera.target));
viewer.set_dirty();

const byId = (id) => document.getElementById(id);
byId("title").textContent = film.title;
byId("case").textContent = film.case;
byId("note").textContent = film.note;
const cells = film.columns.map((column) => {
  const row = byId("numbers").insertRow();
  row.insertCell().textContent = column.label;
  const value = row.insertCell();
  row.insertCell().textContent = column.unit;
  return value;
});

const animator = viewer.animator;
const scrub = byId("scrub");
scrub.max = film.duration;
scrub.addEventListener("input", () => {
  animator.seek(Number(scrub.value));
  animator.display_progress(Number(scrub.value));
});
byId("play").addEventListener("click", () => (animator.playing ? animator.pause() : animator.play()));

function last(places, time) {
  let low = 0, high = places.length;
  while (low < high) {
    const middle = (low + high) >> 1;
    if (places[middle] <= time) low = middle + 1; else high = middle;
  }
  return low - 1;
}

function drawLine() {
  const canvas = document.querySelector("#line canvas"), pen = canvas.getContext("2d");
  canvas.width = canvas.clientWidth;
  canvas.height = canvas.clientHeight;
  const x = (time) => (time / film.duration) * canvas.width;
  film.phases.forEach((phase, place) => {
    const end = place + 1 < film.phases.length ? film.phases[place + 1].start : film.duration;
    pen.fillStyle = phase.colour;
    pen.fillRect(x(phase.start), 0, x(end) - x(phase.start), canvas.height);
  });
  pen.fillStyle = "#d55e00";
  for (const hit of film.collisions) pen.fillRect(x(hit.at), 0, 1.5, canvas.height / 2);
  pen.fillStyle = "#1c2430";
  pen.fillRect(x(animator.time) - 1, 0, 3, canvas.height);
}

const hits = film.collisions.map((hit) => hit.at);
let written = null;
function write() {
  requestAnimationFrame(write);
  const now = `${animator.time} ${animator.playing} ${window.innerWidth}`;
  if (now === written) return;
  written = now;
  const time = animator.time, frame = Math.max(last(film.playback, time + 1e-6), 0);
  film.columns.forEach((column, place) => {
    const value = column.values[frame];
    cells[place].textContent = value === 0 ? "0" : Math.abs(value) < 1e-3
      ? value.toExponential(2) : String(Number(value.toPrecision(4)));
  });
  const phase = film.phases[film.phase_of_frame[frame]];
  byId("phase").textContent = phase.name;
  byId("phase").style.borderColor = phase.colour;
  const hit = last(hits, time + 1e-6);
  byId("hit").textContent = hit >= 0 ? film.collisions[hit].text : "";
  byId("play").textContent = animator.playing ? "pause" : "play";
  if (document.activeElement !== scrub || animator.playing) scrub.value = time;
  drawLine();
}
write();

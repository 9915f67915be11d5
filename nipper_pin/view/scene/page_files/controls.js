// Texts, names, buttons and keys, and what is written in every frame.
const scrub = byId("scrub");
let cells, names, hitTimes, written = null, asAngle = false;
// The place in the turn by the comber's index, or by the angle that the shaft has turned since index 0.
function placeOf(column) {
  const turned = (values) => values && values.map((value) => value * 360 / film.index_per_turn);
  if (!asAngle) return column;
  return { label: "angle from index 0", unit: "deg", values: turned(column.values), other: turned(column.other) };
}
function placeButton(words) {
  const button = document.createElement("button");
  Object.assign(button, { type: "button", textContent: words, title: "by index or by angle" });
  button.addEventListener("click", () => { asAngle = !asAngle; tell(); write(animator.time); });
  return button;
}
// What is written once for a film.
function tell() {
  document.title = film.title;
  for (const id of ["title", "case", "note"]) byId(id).textContent = film[id];
  byId("numbers").querySelectorAll("tbody").forEach((part) => part.remove());
  cells = film.columns.flatMap((each) => {
    const row = byId("numbers").insertRow(), isPlace = each.label === "index";
    const column = isPlace ? placeOf(each) : each;
    row.insertCell().append(isPlace ? placeButton(column.label) : column.label);
    // Of two machines there are two numbers in a row.
    const values = [column.values, ...(film.compare ? [column.other] : [])];
    const places = values.map((list) => [row.insertCell(), list]);
    row.insertCell().textContent = column.unit;
    return places;
  });
  byId("legend").replaceChildren(...film.legend.map(([name, colour]) => {
    const item = document.createElement("span"), box = document.createElement("i");
    box.style.background = colour;
    item.append(box, name);
    return item;
  }));
  names = film.names.map((name) => {
    const label = document.createElement("span");
    label.textContent = name.text;
    return { label, ...name };
  });
  byId("labels").replaceChildren(...names.map((name) => name.label));
  hitTimes = film.collisions.map((hit) => hit.at);
  scrub.max = axisEnd();
  written = null;
}
tell();
byId("names").checked = byId("pane").clientWidth > 600;
byId("names").addEventListener("change", () => { written = null; });

// Another animation at the same time of the film, playing or not.
function replay(scene) {
  const { time, playing } = animator, { timeScale } = animator.mixer;
  draw(scene);
  animator.mixer.timeScale = timeScale;
  animator.pause();
  go(time);
  if (playing) animator.play();
}
// Rebounds larger, or as they are: the drawing alone changes.
if (film.true_size) {
  const { exaggerate, note, lips, other_lips, true_size } = film;
  const larger = { exaggerate, note, lips, other_lips, scene: messages[messages.length - 1] };
  byId("size").hidden = false;
  byId("size").querySelector("span").textContent = `x ${exaggerate}`;
  byId("larger").addEventListener("change", () => {
    film = { ...film, ...(byId("larger").checked ? larger : true_size) };
    byId("note").textContent = film.note;
    tellLips();
    replay(film.scene);
    written = null;
  });
}

scrub.addEventListener("input", () => go(Number(scrub.value)));
const toggle = () => (animator.playing ? animator.pause() : animator.play());
byId("play").addEventListener("click", toggle);
byId("start").addEventListener("click", () => go(0));
byId("pace").addEventListener("change", () => { animator.mixer.timeScale = Number(byId("pace").value); });
function step(by) {
  animator.pause();
  const at = Math.max(last(film.playback, animator.time + 1e-6), 0) + by;
  go(film.playback[Math.min(Math.max(at, 0), film.playback.length - 1)]);
}
document.addEventListener("keydown", (event) => {
  if (event.target.closest("select, #panel") || event.ctrlKey || event.altKey || event.metaKey) return;
  const keys = {
    " ": toggle, ArrowRight: () => step(event.shiftKey ? 10 : 1), Home: () => go(0),
    ArrowLeft: () => step(event.shiftKey ? -10 : -1), End: () => go(film.duration),
  };
  if (!(event.key in keys)) return;
  event.preventDefault();
  keys[event.key]();
});

function write(time) {
  const frame = Math.max(last(film.playback, time + 1e-6), 0);
  for (const [cell, values] of cells) {
    const value = values ? values[frame] : null;
    cell.textContent = value === null ? "-" : value === 0 ? "0" : Math.abs(value) < 1e-3
      ? value.toExponential(2) : String(Number(value.toPrecision(4)));
  }
  const phase = film.phases[film.phase_of_frame[frame]];
  byId("phase").textContent = phase.name;
  byId("phase").style.borderColor = phase.colour;
  const hit = last(hitTimes, time + 1e-6);
  byId("hit").textContent = hit >= 0 ? film.collisions[hit].text : "";
  byId("play").textContent = animator.playing ? "pause" : "play";
  if (document.activeElement !== scrub || animator.playing) scrub.value = time;
}
function drawNames() {
  byId("labels").hidden = !byId("names").checked;
  if (byId("labels").hidden) return;
  const pane = viewer.renderer.domElement;
  for (const name of names) {
    const node = viewer.scene_tree.find(name.path).object;
    const place = viewer.camera.position.clone().set(...name.place);
    place.applyMatrix4(node.matrixWorld).project(viewer.camera);
    name.label.style.left = `${(0.5 + 0.5 * place.x) * pane.clientWidth}px`;
    name.label.style.top = `${(0.5 - 0.5 * place.y) * pane.clientHeight}px`;
  }
}
function follow() {
  requestAnimationFrame(follow);
  const eye = viewer.camera.position, at = [eye.x, eye.y, eye.z, window.innerWidth, window.innerHeight];
  const now = `${animator.time} ${animator.playing} ${at} ${byId("names").checked}`;
  if (now === written) return;
  written = now;
  write(animator.time);
  drawStrip();
  drawCurves();
  drawNames();
}
follow();
dark.addEventListener("change", () => { shadeScene(); written = null; });
new ResizeObserver(() => { viewer.set_3d_pane_size(); written = null; }).observe(byId("picture"));

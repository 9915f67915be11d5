"use strict";
// Sends the scene to meshcat's viewer and places the cameras.
// What is shown; the live page puts another film in its place.
let film = JSON.parse(document.getElementById("film").textContent);
const byId = (id) => document.getElementById(id);
let viewer;
try {
  viewer = new MeshCat.Viewer(byId("pane"));
} catch (error) {
  byId("title").textContent = "This browser gives no WebGL, which the picture needs; try another one.";
  throw error;
}
const draw = (message) => viewer.handle_command_bytearray(Uint8Array.from(atob(message), (c) => c.charCodeAt(0)));
const messages = JSON.parse(byId("scene").textContent);
messages.forEach(draw);
const animator = viewer.animator;
// meshcat takes the height of the window for that of its pane.
const fit = viewer.set_3d_pane_size.bind(viewer);
viewer.set_3d_pane_size = () => fit(byId("pane").clientWidth, byId("pane").clientHeight);
viewer.set_3d_pane_size();

// Colours of the page's style, light or dark as the browser wants it; the scene has a background of its own.
const style = getComputedStyle(document.documentElement), dark = matchMedia("(prefers-color-scheme: dark)");
const shade = (name) => style.getPropertyValue(`--${name}`);
const light = [[1, 1, 1], [0.80, 0.84, 0.88]], dim = [[0.08, 0.09, 0.12], [0.20, 0.23, 0.28]];
function shadeScene() {
  const value = dark.matches ? dim : light;
  for (const [place, property] of ["top_color", "bottom_color"].entries())
    viewer.handle_command({ type: "set_property", path: "/Background", property, value: value[place] });
}
shadeScene();

// The axes of cameras and of the world have y up: x, z and -y of the machine.
const upright = ([x, y, z]) => [x, z, -y];
viewer.camera.fov = 40;
function look(position, target) {
  viewer.camera.position.set(...upright(position));
  viewer.controls.target.set(...upright(target));
  viewer.set_dirty();
}
function lookFrom(name) {
  const { position, target } = film.cameras[name];
  // A pane that is higher than wide sees less to the sides, so its camera stands further back.
  const back = Math.max(1, 1.25 / (byId("pane").clientWidth / byId("pane").clientHeight));
  look(position.map((value, axis) => target[axis] + back * (value - target[axis])), target);
}
lookFrom("whole");
byId("whole").addEventListener("click", () => lookFrom("whole"));
byId("side").addEventListener("click", () => lookFrom("side"));

function last(places, time) {
  let low = 0, high = places.length;
  while (low < high) {
    const middle = (low + high) >> 1;
    if (places[middle] <= time) low = middle + 1; else high = middle;
  }
  return low - 1;
}
// Between frames values change linearly, as the animation does.
function between(values, time) {
  const first = Math.max(last(film.playback, time), 0), next = Math.min(first + 1, values.length - 1);
  const step = film.playback[next] - film.playback[first];
  const share = step > 0 ? Math.min(Math.max((time - film.playback[first]) / step, 0), 1) : 0;
  return values[first] + share * (values[next] - values[first]);
}
function sized(canvas) {
  const ratio = window.devicePixelRatio || 1;
  const width = Math.round(canvas.clientWidth * ratio), height = Math.round(canvas.clientHeight * ratio);
  if (canvas.width !== width || canvas.height !== height) {
    canvas.width = width;
    canvas.height = height;
  }
  const pen = canvas.getContext("2d");
  pen.setTransform(ratio, 0, 0, ratio, 0, 0);
  return pen;
}

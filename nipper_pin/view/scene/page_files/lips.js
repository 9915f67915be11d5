// The lips close up: the same scene through a second camera, which follows the lower lip.
// From far away with a long lens: what lies behind the cut is to have the same scale.
const FIELD = 0.05, closeUps = [];
const arrowNodes = film.arrows.map((path) => viewer.scene_tree.find(path).object);
// Of two machines each close-up, `lips` or `other_lips` of the film, hides the other one.
function addCloseUp(whose, figure, hidden = []) {
  closeUps.push({ whose, figure, hidden, camera: new viewer.camera.constructor(FIELD), around: (draw) => draw() });
}
function tellLips() {
  for (const { whose, figure } of closeUps) {
    const lips = film[whose], times = film.exaggerate === 1 ? "true size" : `rebounds x ${film.exaggerate}`;
    figure.hidden = !lips;
    if (!lips) continue;
    const name = lips.name ? `${lips.name}: ` : "";
    figure.querySelector("figcaption").textContent =
      `${name}${lips.stop} along its hinge, near half cut away; ${times}`;
  }
}
function drawLips({ whose, figure, camera, hidden, around }) {
  const lips = film[whose], canvas = figure.querySelector("canvas");
  if (!lips) return;
  const distance = lips.height / 2 / Math.tan(FIELD / 2 * Math.PI / 180);
  // What is nearer than the cut is not drawn, nor the arrows of impulses, which are larger than lips.
  Object.assign(camera, { near: distance, far: distance + 10 });
  const pen = sized(canvas), renderer = viewer.renderer, time = animator.time;
  const pane = renderer.domElement, ratio = renderer.getPixelRatio();
  const x = between(lips.x, time), z = between(lips.z, time), angle = between(lips.angle, time);
  const wide = canvas.clientWidth, high = canvas.clientHeight;
  const shrink = Math.min(1, pane.clientWidth / wide, pane.clientHeight / high);
  const w = Math.floor(wide * shrink), h = Math.floor(high * shrink);
  if (w < 1 || h < 1) return;
  camera.aspect = w / h;
  camera.up.set(...upright([Math.cos(angle), 0, Math.sin(angle)]));
  camera.position.set(...upright([x, lips.across - distance, z]));
  camera.lookAt(...upright([x, lips.across, z]));
  camera.updateProjectionMatrix();
  renderer.setScissorTest(true);
  renderer.setScissor(0, 0, w, h);
  renderer.setViewport(0, 0, w, h);
  const shown = [...arrowNodes, ...hidden].filter((item) => item.visible);
  for (const item of shown) item.visible = false;
  around(() => renderer.render(viewer.scene, camera));
  for (const item of shown) item.visible = true;
  pen.clearRect(0, 0, wide, high);
  pen.drawImage(pane, 0, pane.height - h * ratio, w * ratio, h * ratio, 0, 0, wide, high);
  renderer.setScissorTest(false);
  renderer.setViewport(0, 0, pane.clientWidth, pane.clientHeight);
  const long = lips.scale_mm / 1000 / lips.height * high;
  pen.fillStyle = shade("ink");
  pen.fillRect(12, high - 14, long, 3);
  pen.fillRect(12, high - 18, 1, 11);
  pen.fillRect(12 + long, high - 18, 1, 11);
  pen.font = "12px system-ui, sans-serif";
  const rebound = film.exaggerate === 1 ? "" : `; of a rebound ${Number((lips.scale_mm / film.exaggerate).toPrecision(2))} mm`;
  pen.fillText(`${lips.scale_mm} mm${rebound}`, 16, high - 20);
}
addCloseUp("lips", byId("lips"));
tellLips();
const drawWhole = viewer.render.bind(viewer);
viewer.render = () => { closeUps.forEach(drawLips); drawWhole(); };
byId("near").hidden = !film.lips;
byId("near").addEventListener("click", () => {
  const { lips } = film, time = animator.time, target = [between(lips.x, time), lips.across, between(lips.z, time)];
  look([target[0] + 0.01, target[1] - 25 * lips.height, target[2] + 0.02], target);
});

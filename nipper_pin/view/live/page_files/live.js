// The panel: sliders and fields that ask for another setting, and the numbers, curves and film that come back.
// A picture that is being drawn would delay the numbers, so the film stands while something is moved [ms].
const HELD = 800;
let state = film.live.state, busy = false, playOn = false, waits;
const queue = [], controls = {}, { axes } = state;
function element(tag, parent, fields = {}) {
  const made = Object.assign(document.createElement(tag), fields);
  parent.append(made);
  return made;
}
document.body.classList.add("live");
const aside = document.querySelector("aside"), panel = element("section", aside, { id: "panel" });
aside.before(panel);
for (const { key, name, label, low, high, step } of film.live.controls) {
  const row = element("div", panel, { className: "control" });
  element("span", row, { textContent: label });
  const slider = element("input", row, { type: "range", min: low, max: high, step, ariaLabel: name });
  const field = element("input", row, { type: "text", inputMode: "decimal", ariaLabel: label, maxLength: 40 });
  const refused = element("p", row, { className: "refused", role: "alert", hidden: true });
  slider.addEventListener("input", () => ask({ kind: "slid", key, value: Number(slider.value) }));
  field.addEventListener("input", () => ask({ kind: "typed", key, text: field.value }));
  controls[key] = { slider, field, refused };
}
const buttons = element("div", panel, { id: "buttons" });
for (const [button, text] of [["reset", "reset"], ["pin", "pin this curve"], ["fit", "fit axes"]]) {
  const made = element("button", buttons, { id: button, type: "button", textContent: text });
  made.addEventListener("click", () => ask({ kind: "pressed", button }));
}
const plain = element("button", buttons, { id: "plain", type: "button", textContent: "true size" });
plain.addEventListener("click", () => ask({ kind: "slid", key: "larger", value: 1 }));
panel.append(byId("lips"));
const answered = element("section", aside, { id: "answer" });
aside.prepend(answered);
for (const id of ["setting", "against", "message"]) element("p", answered, { id });
byId("message").role = "alert";
for (const id of ["rows", "turn"]) element("table", answered, { id });
const key = element("div", byId("bar"), { id: "curve-legend" });

function hold() {
  playOn ||= animator.playing;
  animator.pause();
  clearTimeout(waits);
  waits = setTimeout(() => {
    if (playOn && state.message === "") animator.play();
  }, HELD);
}
for (const kind of ["pointerdown", "focusin"]) panel.addEventListener(kind, hold);
// One question at a time; of many moves of one slider only the last is asked for.
function ask(question) {
  const newest = queue[queue.length - 1];
  if (newest && newest.kind === question.kind && newest.key === question.key) queue.pop();
  queue.push(question);
  hold();
  askNext();
}
function askNext() {
  if (busy || queue.length === 0 || talk.readyState !== WebSocket.OPEN) return;
  busy = true;
  talk.send(JSON.stringify(queue.shift()));
}
function tellControls() {
  for (const [key, { slider, field, refused }] of Object.entries(controls)) {
    const { value, text, refusal } = state.controls[key], asked = queue.some((item) => item.key === key);
    // What is being moved or written is ahead of its answer.
    if (!asked) slider.value = value;
    if (!asked && field !== document.activeElement) field.value = text;
    field.classList.toggle("bad", refusal !== "");
    refused.hidden = refusal === "";
    refused.textContent = refusal;
  }
  byId("pin").textContent = state.pinned ? "unpin" : "pin this curve";
}
function tellRows(id) {
  byId(id).replaceChildren();
  for (const [key, label, text, difference] of state[id]) {
    const row = byId(id).insertRow(), cells = [label, text, difference].map((words) => {
      const cell = row.insertCell();
      cell.textContent = words;
      return cell;
    });
    cells[1].dataset.key = key;
    cells[2].dataset.difference = key;
  }
}
function tellState() {
  const none = state.message !== "";
  film = { ...film, ...state.axes };
  tellControls();
  for (const id of ["setting", "against"]) byId(id).textContent = state[id];
  byId("message").textContent = none ? `No numbers: ${state.message}` : "";
  ["rows", "turn"].forEach(tellRows);
  key.replaceChildren(...state.legend.map(({ name, colour, style, words }) => {
    const item = document.createElement("span"), line = element("i", item);
    line.style.borderTop = `3px ${style} ${colour}`;
    item.append(words);
    item.dataset.curve = name;
    return item;
  }));
  byId("curves").hidden = key.hidden = none;
  scrub.max = axisEnd();
  // All films begin in the touch configuration.
  if (none) go(0);
  written = null;
  write(animator.time);
  drawCurves();
}
function tellFilm(found, scene) {
  film = { ...found, ...state.axes, cameras: film.cameras, live: film.live };
  tell();
  tellLips();
  replay(scene);
}
const writeMoment = write;
write = (time) => {
  writeMoment(time);
  const none = state.message !== "";
  byId("numbers").hidden = none;
  if (none) byId("phase").textContent = "there is no motion to show: the touch configuration";
};
const talk = new WebSocket(`ws://${location.host}/talk`);
talk.addEventListener("open", askNext);
talk.addEventListener("message", ({ data }) => {
  const found = JSON.parse(data);
  if (found.film) {
    tellFilm(found.film, found.scene);
    return;
  }
  ({ state } = found);
  busy = false;
  tellState();
  askNext();
});
talk.addEventListener("close", () => { byId("message").textContent = "The program that served this page has ended."; });
tellState();

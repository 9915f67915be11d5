// Curves over the film's time with a cursor, and the strip of phases with a scale.
const LEFT = 112, RIGHT = 8;
// The axis of time ends with the film, unless it is to stand still while films of other lengths come.
const axisEnd = () => film.until || film.duration;
const across = (canvas, time) => LEFT + (time / axisEnd()) * (canvas.clientWidth - LEFT - RIGHT);

function go(time) {
  const to = Math.min(Math.max(time, 0), film.duration);
  animator.seek(to);
  animator.display_progress(to);
}
// Between two multiples of ten steps all labels of one spacing stand, the closest that has room.
function labelled(placed) {
  const free = (one, next) => next.x - one.x >= one.half + next.half + 6;
  const chosen = [];
  for (const tick of placed.filter((item) => item.number % 10 === 0))
    if (chosen.length === 0 || free(chosen[chosen.length - 1], tick)) chosen.push(tick);
  const ends = [placed[0], ...chosen, placed[placed.length - 1]];
  for (let i = 0; i + 1 < ends.length; i += 1) {
    const [from, to] = [ends[i].number, ends[i + 1].number];
    for (const step of [1, 2, 5]) {
      const part = placed.filter(({ number }) => number >= from && number <= to && number % step === 0);
      if (part.length < 2 || !part.slice(1).every((tick, place) => free(part[place], tick))) continue;
      chosen.push(...part);
      break;
    }
  }
  return new Set(chosen);
}
function ticks(canvas, pen, top, bottom) {
  pen.font = "11px system-ui, sans-serif";
  pen.textAlign = "center";
  const placed = film.ticks.map((tick) => ({
    ...tick, x: across(canvas, tick.at), half: pen.measureText(tick.text).width / 2,
  }));
  pen.fillStyle = shade("tick");
  for (const tick of placed) pen.fillRect(tick.x, top, 1, 4);
  pen.fillStyle = shade("ink");
  for (const tick of labelled(placed))
    if (tick.x + tick.half <= canvas.clientWidth) pen.fillText(tick.text, tick.x, bottom);
}
function drawStrip() {
  const canvas = document.querySelector("#line canvas"), pen = sized(canvas);
  pen.clearRect(0, 0, canvas.clientWidth, canvas.clientHeight);
  film.phases.forEach((phase, place) => {
    const end = place + 1 < film.phases.length ? film.phases[place + 1].start : film.duration;
    pen.fillStyle = phase.colour;
    pen.fillRect(across(canvas, phase.start), 2, across(canvas, end) - across(canvas, phase.start), 13);
  });
  pen.strokeStyle = shade("tick");
  pen.strokeRect(LEFT, 2, canvas.clientWidth - LEFT - RIGHT, 13);
  ticks(canvas, pen, 15, 28);
  pen.textAlign = "left";
  pen.fillText("time [ms]", 0, 28);
  pen.fillRect(across(canvas, animator.time) - 1, 0, 2, 18);
}
function drawCurves() {
  const canvas = document.querySelector("#curves canvas"), pen = sized(canvas);
  pen.clearRect(0, 0, canvas.clientWidth, canvas.clientHeight);
  const lane = canvas.clientHeight / film.curves.length;
  film.curves.forEach((curve, place) => {
    const top = place * lane + 5, bottom = (place + 1) * lane - 5;
    const [low, high] = curve.decades || [];
    const share = low ? (value) => Math.log(value / low) / Math.log(high / low) : (value) => value / curve.most;
    const y = (value) => bottom - Math.min(share(value), 1) * (bottom - top);
    pen.strokeStyle = shade("lane");
    pen.strokeRect(LEFT, top, canvas.clientWidth - LEFT - RIGHT, bottom - top);
    pen.fillStyle = shade("ink");
    pen.font = "11px system-ui, sans-serif";
    pen.textAlign = "left";
    curve.label.forEach((text, row) => pen.fillText(text, 0, top + 10 + 12 * row, LEFT - 48));
    pen.textAlign = "right";
    pen.fillText(curve.text, LEFT - 3, top + 6);
    pen.fillText(low || "0", LEFT - 3, bottom + 1);
    pen.fillText(curve.right || "", canvas.clientWidth - RIGHT - 4, top + 11);
    // Of two machines there are two lines in one lane.
    for (const line of [curve, ...(curve.more || [])]) {
      pen.strokeStyle = line.colour;
      pen.lineWidth = 1.5;
      const times = line.at || film.playback;
      if (low) {
        pen.fillStyle = line.colour;
        line.values.forEach((value, hit) => pen.fillRect(across(canvas, times[hit]) - 3, y(value) - 3, 6, 6));
        continue;
      }
      pen.setLineDash(line.dash || []);
      pen.beginPath();
      // A value beyond the lane is not drawn: an open jaw would hide its rebounds.
      let drawing = false;
      line.values.forEach((value, frame) => {
        const inside = value !== null && value <= 1.001 * curve.most, x = across(canvas, times[frame]);
        if (inside && drawing) pen.lineTo(x, y(value)); else pen.moveTo(x, y(value));
        drawing = inside;
      });
      pen.stroke();
    }
    pen.lineWidth = 1;
    pen.setLineDash([]);
    for (const hit of film.collisions) {
      if (hit.stop !== curve.stop) continue;
      pen.fillStyle = hit.colour || "#d55e00";
      const x = across(canvas, hit.at);
      pen.beginPath();
      pen.moveTo(x, bottom - 7);
      pen.lineTo(x - 3.5, bottom);
      pen.lineTo(x + 3.5, bottom);
      pen.fill();
    }
  });
  pen.fillStyle = shade("ink");
  pen.fillRect(across(canvas, animator.time) - 1, 0, 2, canvas.clientHeight);
}
// A click near a collision goes to it; elsewhere the cursor follows the pointer.
function timeAt(canvas, x) {
  const wide = canvas.clientWidth - LEFT - RIGHT;
  return Math.min(Math.max((x - LEFT) / wide, 0), 1) * axisEnd();
}
function nearest(canvas, x) {
  let found = null;
  for (const hit of film.collisions) {
    const off = Math.abs(across(canvas, hit.at) - x);
    if (off <= 6 && (found === null || off < Math.abs(across(canvas, found) - x))) found = hit.at;
  }
  return found === null ? timeAt(canvas, x) : found;
}
for (const id of ["curves", "line"]) {
  const holder = byId(id), canvas = holder.querySelector("canvas");
  const place = (event) => event.clientX - canvas.getBoundingClientRect().left;
  let dragged = false;
  holder.addEventListener("pointerdown", (event) => {
    animator.pause();
    dragged = true;
    holder.setPointerCapture(event.pointerId);
    go(nearest(canvas, place(event)));
    event.preventDefault();
    byId("scrub").focus();
  });
  holder.addEventListener("pointermove", (event) => {
    if (dragged) go(timeAt(canvas, place(event)));
  });
  for (const end of ["pointerup", "pointercancel"]) holder.addEventListener(end, () => { dragged = false; });
}

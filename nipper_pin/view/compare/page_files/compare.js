// The second machine: names and boxes of both, its close-up, and the table of differences.
const both = film.compare, rootOf = (side) => viewer.scene_tree.find(both[side].root).object;
document.body.classList.add("compare");
for (const side of ["a", "b"]) {
  const label = document.createElement("label"), box = document.createElement("input");
  const line = document.createElement("i"), item = document.createElement("b");
  box.type = "checkbox";
  box.checked = true;
  box.id = `shown-${side}`;
  box.addEventListener("change", () => { rootOf(side).visible = box.checked; viewer.set_dirty(); });
  line.style.background = both[side].colour;
  item.textContent = side.toUpperCase();
  label.append(box, line, item, ` ${both[side].name}`);
  byId("case").append(label);
}
const finding = document.createElement("p");
finding.id = "finding";
finding.textContent = both.finding;
byId("case").after(finding);
byId("legend").prepend("phases of A:");
const numbersHead = byId("numbers").createTHead().insertRow();
for (const text of ["at this time", "A", "B", ""]) {
  const cell = document.createElement("th");
  cell.textContent = text;
  numbersHead.append(cell);
}
const differences = document.createElement("table"), aside = document.querySelector("aside");
differences.id = "differences";
const head = differences.createTHead().insertRow();
for (const text of ["quantity", "", "A", "B", "difference"]) {
  const cell = document.createElement("th");
  cell.textContent = text;
  head.append(cell);
}
const body = differences.createTBody();
for (const row of both.rows) {
  const line = body.insertRow();
  for (const text of row) line.insertCell().textContent = text;
}
aside.append(differences);
for (const [id, text] of [["changes", both.changes], ["notes", both.notes.join(" ")]]) {
  const part = document.createElement("p");
  part.id = id;
  part.textContent = text;
  aside.append(part);
}
if (film.other_lips) {
  const figure = document.createElement("figure");
  figure.className = "lips";
  figure.append(document.createElement("canvas"), document.createElement("figcaption"));
  const pair = document.createElement("div");
  pair.id = "closeups";
  aside.prepend(pair);
  byId("lips").classList.add("lips");
  pair.append(byId("lips"));
  closeUps[0].hidden = [rootOf("b")];
  pair.append(figure);
  addCloseUp("other_lips", figure, [rootOf("a")]);
  tellLips();
  // Alone it need not be transparent.
  closeUps[closeUps.length - 1].around = (draw) => {
    const clear = [];
    rootOf("b").traverse((node) => { if (node.material && node.material.transparent) clear.push(node.material); });
    for (const material of clear) material.opacity = 1;
    draw();
    for (const material of clear) material.opacity = both.b.opacity;
  };
}

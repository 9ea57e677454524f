// Lines between the parts of a page that are dragged, or moved by arrow keys; the browser keeps the sizes, which the style of
// the page has as variables such as --runtime_control-panel.
const KEPT = "remodel size ";
const STEP = 16; // of an arrow key [px]
const LEAST = 120; // [px]

for (const [key, value] of Object.entries(localStorage)) {
  if (key.startsWith(KEPT)) document.documentElement.style.setProperty(key.slice(KEPT.length), value);
}

function forgetSizes(prefix) {
  for (const key of Object.keys(localStorage)) {
    if (!key.startsWith(KEPT + prefix)) continue;
    localStorage.removeItem(key);
    document.documentElement.style.removeProperty(key.slice(KEPT.length));
  }
}

function isColumn(line) {
  return line.getAttribute("aria-orientation") === "vertical";
}

// The part beside the line whose size it is: that after it in the page.
function sized(line) {
  return line.nextElementSibling;
}

function sizeOf(line) {
  const box = sized(line).getBoundingClientRect();
  return isColumn(line) ? box.width : box.height;
}

function resize(line, size) {
  const whole = line.parentElement.getBoundingClientRect();
  const most = (isColumn(line) ? whole.width : whole.height) - 2 * LEAST;
  const kept = `${Math.round(Math.max(LEAST, Math.min(most, size)))}px`;
  document.documentElement.style.setProperty(line.dataset.size, kept);
  localStorage.setItem(KEPT + line.dataset.size, kept);
  line.setAttribute("aria-valuenow", parseInt(kept));
}

// A part that stands at the left grows as its line goes right; one at the right, or below, as it goes left, or up.
function sign(line) {
  const at = line.getBoundingClientRect(), part = sized(line).getBoundingClientRect();
  return isColumn(line) && part.left + part.width / 2 < at.left ? 1 : -1;
}

addEventListener("pointerdown", (event) => {
  const line = event.target.closest?.(".splitter");
  if (!line) return;
  event.preventDefault();
  line.setPointerCapture(event.pointerId);
  const begin = isColumn(line) ? event.clientX : event.clientY;
  const before = sizeOf(line), way = sign(line);
  const move = (now) => resize(line, before + way * ((isColumn(line) ? now.clientX : now.clientY) - begin));
  line.addEventListener("pointermove", move);
  line.addEventListener("pointerup", () => line.removeEventListener("pointermove", move), { once: true });
});

addEventListener("keydown", (event) => {
  const line = event.target.closest?.(".splitter");
  const steps = { ArrowLeft: -1, ArrowUp: -1, ArrowRight: 1, ArrowDown: 1 };
  if (!line || !(event.key in steps)) return;
  event.preventDefault();
  resize(line, sizeOf(line) + sign(line) * steps[event.key] * STEP);
});

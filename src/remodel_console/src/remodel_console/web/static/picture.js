// A drawing as an SVG picture: what cytoscape has laid out, as shapes, lines and text that other programs can edit.
const CORNER = 8; // radius of states
const ARROW = { length: 9, half: 4 };
const LINE = 15; // height of a line of text

const escape = (text) => text.replace(/[&<>"]/g, (one) => ({ "&": "&amp;", "<": "&lt;", ">": "&gt;", '"': "&quot;" })[one]);
const round = (value) => Math.round(value * 10) / 10;
const DASHES = { dashed: "6 4", dotted: "2 3" };
const styleOf = (element, name) => element.pstyle(name).strValue;
const colourOf = (element, name) => `rgb(${element.pstyle(name).value.slice(0, 3).map(Math.round).join(",")})`;

// Returns the text of an SVG file with all that is shown in a cytoscape instance.
export function svgOf(cy, ground) {
  const shown = cy.elements(":visible");
  const { x1, y1, w, h } = shown.boundingBox();
  const [left, top, width, height] = [x1 - 12, y1 - 12, w + 24, h + 24].map(round);
  const boxes = shown.nodes().filter((node) => node.isParent()).sort((one, other) => one.ancestors().length - other.ancestors().length);
  const parts = [...boxes, ...shown.edges(), ...shown.nodes().filter((node) => !node.isParent())];
  return `<svg xmlns="http://www.w3.org/2000/svg" viewBox="${left} ${top} ${width} ${height}" width="${width}" height="${height}" `
    + `font-family="Helvetica, Arial, sans-serif" font-size="12">\n<rect x="${left}" y="${top}" width="${width}" height="${height}" fill="${ground}"/>\n`
    + `${parts.map((part) => (part.isNode() ? nodeOf(part) : edgeOf(part))).join("\n")}\n</svg>\n`;
}

function nodeOf(node) {
  const box = node.boundingBox({ includeLabels: false, includeOverlays: false, includeEdges: false });
  const border = Number(node.pstyle("border-width").pfValue);
  const [x, y, width, height] = [box.x1 + border / 2, box.y1 + border / 2, box.w - border, box.h - border].map(round);
  const dash = DASHES[styleOf(node, "border-style")];
  const paint = `fill="${colourOf(node, "background-color")}" stroke="${colourOf(node, "border-color")}" stroke-width="${border}"${dash ? ` stroke-dasharray="${dash}"` : ""}`;
  if (styleOf(node, "shape") === "ellipse") return `<ellipse cx="${round(x + width / 2)}" cy="${round(y + height / 2)}" rx="${round(width / 2)}" ry="${round(height / 2)}" ${paint}/>`;
  const corner = node.hasClass("outcome") ? round(height / 2) : CORNER;
  const middle = node.isParent() ? box.y1 - LINE / 2 : box.y1 + box.h / 2;
  return `<rect x="${x}" y="${y}" width="${width}" height="${height}" rx="${corner}" ${paint}/>`
    + textOf(node.data("label"), box.x1 + box.w / 2, middle, colourOf(node, "color"), 12, node.isParent() ? ' font-weight="bold"' : "");
}

function edgeOf(edge) {
  const [start, end] = [edge.sourceEndpoint(), edge.targetEndpoint()];
  if (!start || !end || Number.isNaN(start.x) || Number.isNaN(end.x)) return "";
  const controls = edge.controlPoints() || [];
  const bends = edge.segmentPoints() || [];
  const before = bends.at(-1) || controls.at(-1) || start;
  const far = Math.hypot(end.x - before.x, end.y - before.y) || 1;
  const [dx, dy] = [(end.x - before.x) / far, (end.y - before.y) / far];
  const tail = { x: end.x - dx * ARROW.length, y: end.y - dy * ARROW.length };
  const at = ({ x, y }) => `${round(x)} ${round(y)}`;
  let path = `M${at(start)}`;
  if (controls.length) {
    controls.forEach((control, place) => {
      const next = controls[place + 1];
      path += `Q${at(control)} ${at(next ? { x: (control.x + next.x) / 2, y: (control.y + next.y) / 2 } : tail)}`;
    });
  } else path += [...bends, tail].map((point) => `L${at(point)}`).join("");
  const line = colourOf(edge, "line-color");
  const dash = DASHES[styleOf(edge, "line-style")];
  const head = [end, { x: tail.x - dy * ARROW.half, y: tail.y + dx * ARROW.half }, { x: tail.x + dy * ARROW.half, y: tail.y - dx * ARROW.half }].map(at).join(" ");
  const middle = edge.midpoint();
  return `<path d="${path}" fill="none" stroke="${line}" stroke-width="${edge.pstyle("width").pfValue}" stroke-linejoin="round"${dash ? ` stroke-dasharray="${dash}"` : ""}/>`
    + `<polygon points="${head}" fill="${line}"/>`
    + textOf(edge.data("label"), middle.x, middle.y, line, 11, ` paint-order="stroke" stroke="${colourOf(edge, "text-background-color")}" stroke-width="4"`);
}

function textOf(text, x, y, colour, size, more) {
  const lines = (text || "").split("\n").filter(Boolean);
  const first = y - ((lines.length - 1) * LINE) / 2 + size * 0.36;
  return lines.map((line, place) => `<text x="${round(x)}" y="${round(first + place * LINE)}" font-size="${size}" text-anchor="middle" fill="${colour}"${more}>${escape(line)}</text>`).join("");
}

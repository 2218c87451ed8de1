"use strict";
const map = JSON.parse(document.getElementById("map").textContent);
const part = (id) => document.getElementById(id);
const UNITS = { m: { per_m: 1, name: "m" }, ft: { per_m: 1 / 0.3048, name: "ft" } };
const TILE = 256;

// PMTiles version 3, read in parts: https://github.com/protomaps/PMTiles/blob/main/spec/v3/spec.md
class Archive {
  constructor(read) {
    this.read = read;
    this.directories = new Map();
  }
  async open() {
    const head = await this.read(0, 127);
    if (new TextDecoder().decode(head.subarray(0, 7)) !== "PMTiles") throw new Error("no PMTiles");
    const view = new DataView(head.buffer, head.byteOffset, head.byteLength);
    const number = (at) => Number(view.getBigUint64(at, true));
    [this.root, this.rootLength, this.leaves, this.tiles] = [8, 16, 40, 56].map(number);
    return this;
  }
  directory(at, length) {
    if (!this.directories.has(at)) this.directories.set(at, this.read(at, length).then(unzip).then(entries));
    return this.directories.get(at);
  }
  async tile(zoom, x, y) {
    const id = tileNumber(zoom, x, y);
    let list = await this.directory(this.root, this.rootLength);
    for (let depth = 0; depth < 4; depth++) {
      let low = 0, high = list.length;
      while (low < high) {
        const middle = (low + high) >> 1;
        if (list[middle].id <= id) low = middle + 1;
        else high = middle;
      }
      const found = list[low - 1];
      if (!found) return null;
      if (found.run > 0) return id < found.id + found.run ? this.read(this.tiles + found.at, found.length) : null;
      list = await this.directory(this.leaves + found.at, found.length);
    }
    return null;
  }
}

async function unzip(bytes) {
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

function entries(bytes) {
  let at = 0;
  const next = () => {
    let number = 0, place = 1, byte;
    do {
      byte = bytes[at++];
      number += (byte & 127) * place;
      place *= 128;
    } while (byte > 127);
    return number;
  };
  const list = Array.from({ length: next() }, () => ({}));
  let id = 0, end = 0;
  for (const one of list) one.id = id += next();
  for (const one of list) one.run = next();
  for (const one of list) one.length = next();
  for (const one of list) {
    const more = next();
    one.at = more ? more - 1 : end;
    end = one.at + one.length;
  }
  return list;
}

// Along Hilbert's curve, behind all tiles of coarser zooms.
function tileNumber(zoom, x, y) {
  let number = (4 ** zoom - 1) / 3;
  for (let half = 2 ** (zoom - 1); half >= 1; half /= 2) {
    const right = x & half ? 1 : 0, lower = y & half ? 1 : 0;
    number += half * half * ((3 * right) ^ lower);
    if (!lower) {
      if (right) [x, y] = [half - 1 - x, half - 1 - y];
      [x, y] = [y, x];
    }
    [x, y] = [x & (half - 1), y & (half - 1)];
  }
  return number;
}

// Where the bytes come from: inside the page, beside it on a server, or from files that somebody chose.
function inside(id) {
  const text = part(id)?.textContent;
  if (!text) return null;
  const bytes = Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
  return async (at, length) => bytes.subarray(at, at + length);
}
function beside(name) {
  let whole = null;
  return async (at, length) => {
    if (!whole) {
      const answer = await fetch(name, { headers: { Range: `bytes=${at}-${at + length - 1}` } });
      if (!answer.ok) throw new Error(`${name}: ${answer.status}`);
      const bytes = new Uint8Array(await answer.arrayBuffer());
      if (answer.status === 206) return bytes;
      whole = bytes; // A server that knows no ranges sends all of it once.
    }
    return whole.subarray(at, at + length);
  };
}
const chosen = (file) => async (at, length) => new Uint8Array(await file.slice(at, at + length).arrayBuffer());

// Tiles, drawn when they are there.
const layers = {};
const cache = new Map();
function tile(layer, zoom, x, y) {
  const key = `${layer}/${zoom}/${x}/${y}`;
  let found = cache.get(key);
  if (found) {
    cache.delete(key);
  } else {
    found = { picture: null, depths: null };
    load(layer, zoom, x, y, found).catch(() => {});
  }
  cache.set(key, found);
  if (cache.size > 600) cache.delete(cache.keys().next().value);
  return found;
}
async function load(layer, zoom, x, y, into) {
  const bytes = await layers[layer]?.tile(zoom, x, y);
  if (!bytes) return;
  const as_stored = { premultiplyAlpha: layer === "values" ? "none" : "default", colorSpaceConversion: "none" };
  const picture = await createImageBitmap(new Blob([bytes], { type: "image/png" }), as_stored);
  if (layer === "values") into.depths = depthsOf(picture);
  else into.picture = picture;
  redraw();
}
// Terrarium: red * 256 + green + blue / 256 - 32768 is the elevation, metres.
function depthsOf(picture) {
  const canvas = document.createElement("canvas");
  canvas.width = canvas.height = TILE;
  const context = canvas.getContext("2d", { willReadFrequently: true });
  context.drawImage(picture, 0, 0);
  const rgba = context.getImageData(0, 0, TILE, TILE).data;
  return Float32Array.from({ length: TILE * TILE }, (_, pixel) => {
    const [red, green, blue, opacity] = rgba.subarray(4 * pixel, 4 * pixel + 4);
    return opacity === 255 ? 32768 - red * 256 - green - blue / 256 : NaN;
  });
}

// The view: its middle as a share of the square that Web Mercator makes of the earth, and its zoom.
const canvas = part("view");
const context = canvas.getContext("2d");
const view = { x: 0.5, y: 0.5, zoom: 1 };
let pointer = null, wide = 1, high = 1, dots = 1, asked = false;
const size = () => TILE * 2 ** view.zoom;
const toScreen = (x, y) => [(x - view.x) * size() + wide / 2, (y - view.y) * size() + high / 2];
const toWorld = (x, y) => [view.x + (x - wide / 2) / size(), view.y + (y - high / 2) / size()];
const worldOf = (lon, lat) => [(lon + 180) / 360, 0.5 - Math.asinh(Math.tan((lat * Math.PI) / 180)) / (2 * Math.PI)];
const placeOf = (x, y) => [360 * x - 180, (Math.atan(Math.sinh((0.5 - y) * 2 * Math.PI)) * 180) / Math.PI];
const clamp = (value, least, most) => Math.min(Math.max(value, least), most);

function showAll() {
  const [west, south, east, north] = map.bounds;
  const [[x0, y0], [x1, y1]] = [worldOf(west, north), worldOf(east, south)];
  const free = wide > 700 ? wide - 240 : wide * 0.9; // Beside the legend, where there is room.
  const fit = Math.min(free / (x1 - x0), (high * 0.66) / (y1 - y0)) / TILE;
  Object.assign(view, { x: (x0 + x1) / 2, y: (y0 + y1) / 2, zoom: Math.log2(fit) });
  moved();
}
function zoomBy(steps, at = [wide / 2, high / 2]) {
  const [x, y] = toWorld(...at);
  view.zoom = clamp(view.zoom + steps, map.coarsest - 2, map.finest + 4);
  const [left, top] = toScreen(x, y);
  panBy(at[0] - left, at[1] - top);
}
function panBy(right, down) {
  const [x0, y1] = worldOf(map.bounds[0], map.bounds[1]), [x1, y0] = worldOf(map.bounds[2], map.bounds[3]);
  view.x = clamp(view.x - right / size(), x0, x1);
  view.y = clamp(view.y - down / size(), y0, y1);
  moved();
}
function moved() {
  view.zoom = clamp(view.zoom, map.coarsest - 2, map.finest + 4);
  const [lon, lat] = placeOf(view.x, view.y);
  try {
    history.replaceState(null, "", `#${view.zoom.toFixed(2)}/${lat.toFixed(6)}/${lon.toFixed(6)}`);
  } catch { /* Some browsers refuse it for a page on disk. */ }
  redraw();
}
function redraw() {
  if (!asked) requestAnimationFrame(draw);
  asked = true;
}

function draw() {
  asked = false;
  context.setTransform(dots, 0, 0, dots, 0, 0);
  context.clearRect(0, 0, wide, high);
  const zoom = clamp(Math.round(view.zoom + Math.log2(dots)), map.coarsest, map.finest);
  const across = 2 ** zoom;
  const [first, last] = [toWorld(0, 0), toWorld(wide, high)].map((at) => at.map((share) => clamp(Math.floor(share * across), 0, across - 1)));
  for (let y = first[1]; y <= last[1]; y++)
    for (let x = first[0]; x <= last[0]; x++) {
      tile("values", zoom, x, y);
      drawTile(zoom, x, y);
    }
  if (part("lines").checked) drawIsobaths(zoom);
  if (!pointer) drawCross();
  drawScale();
  read(zoom);
}
// A tile, or as long as it is not there the part of a coarser one.
function drawTile(zoom, x, y) {
  const [[left, top], [right, bottom]] = [[x, y], [x + 1, y + 1]].map(([a, b]) => toScreen(a / 2 ** zoom, b / 2 ** zoom).map(Math.round));
  for (let up = 0; zoom - up >= map.coarsest && up < 6; up++) {
    const { picture } = tile("depth", zoom - up, x >> up, y >> up);
    if (!picture) continue;
    const side = TILE / 2 ** up;
    const from = [x, y].map((number) => (number & (2 ** up - 1)) * side);
    context.drawImage(picture, ...from, side, side, left, top, right - left, bottom - top);
    return;
  }
}
// Depth between the middles of four pixels of a zoom, or of the one pixel at the edge of what is known.
function depthAt(zoom, x, y) {
  const pixel = (column, row) => {
    const found = cache.get(`values/${zoom}/${column >> 8}/${row >> 8}`)?.depths;
    return found ? found[(row & 255) * TILE + (column & 255)] : NaN;
  };
  const [a, b] = [x, y].map((share) => share * TILE * 2 ** zoom - 0.5);
  const [column, row] = [Math.floor(a), Math.floor(b)];
  const [u, v] = [a - column, b - row];
  const upper = pixel(column, row) * (1 - u) + pixel(column + 1, row) * u;
  const lower = pixel(column, row + 1) * (1 - u) + pixel(column + 1, row + 1) * u;
  const between = upper * (1 - v) + lower * v;
  return Number.isNaN(between) ? pixel(Math.round(a), Math.round(b)) : between;
}

// Lines of equal depth by marching squares, on a lattice that stays where it is when the map is moved.
function drawIsobaths(zoom) {
  const step = 5 / size();
  const [west, north] = toWorld(0, 0).map((share) => Math.floor(share / step) - 1);
  const [columns, rows] = [Math.ceil(wide / 5) + 3, Math.ceil(high / 5) + 3];
  const depths = new Float32Array(columns * rows);
  let least = Infinity, most = -Infinity;
  for (let cell = 0; cell < depths.length; cell++) {
    const depth = depthAt(zoom, (west + (cell % columns)) * step, (north + Math.floor(cell / columns)) * step);
    depths[cell] = depth;
    if (depth < least) least = depth;
    if (depth > most) most = depth;
  }
  const { per_m, name } = UNITS[part("unit").value];
  const interval = intervalOf(per_m);
  part("interval").textContent = ` every ${+interval.toPrecision(6)} ${name}`;
  const [lines, labels] = [new Path2D(), []];
  for (let level = Math.ceil((least * per_m) / interval); level <= (most * per_m) / interval; level++)
    cut(depths, columns, rows, (level * interval) / per_m, (a, b, column, row) => {
      const [[x0, y0], [x1, y1]] = [a, b].map(([x, y]) => toScreen((west + x) * step, (north + y) * step));
      lines.moveTo(x0, y0);
      lines.lineTo(x1, y1);
      // A few places of the lattice may have a number, the same ones wherever the map is.
      const share = ((west + column) * 73 + (north + row) * 151) % 97;
      if (share === 0 && Math.hypot(x1 - x0, y1 - y0) > 2) labels.push([(x0 + x1) / 2, (y0 + y1) / 2, Math.atan2(y1 - y0, x1 - x0), level * interval]);
    });
  stroke(lines, "#ffffff66", 3);
  stroke(lines, "#10203fd9", 1.1);
  drawLabels(labels);
}
function stroke(path, colour, width) {
  Object.assign(context, { strokeStyle: colour, lineWidth: width, lineCap: "round" });
  context.stroke(path);
}
function intervalOf(per_m) {
  // A round number in the unit, wider where the map is small.
  const coarser = 2 ** Math.max(0, map.finest - 3 - view.zoom);
  const wanted = map.interval * per_m * Math.min(coarser, 8) * 0.99;
  const decade = 10 ** Math.floor(Math.log10(wanted));
  return [1, 2, 5, 10].map((digit) => digit * decade).find((round) => round >= wanted);
}
function cut(depths, columns, rows, level, take) {
  for (let row = 0; row + 1 < rows; row++)
    for (let column = 0; column + 1 < columns; column++) {
      const at = row * columns + column;
      const corners = [depths[at], depths[at + 1], depths[at + columns + 1], depths[at + columns]];
      const ends = [];
      for (let side = 0; side < 4; side++) {
        const [from, to] = [corners[side], corners[(side + 1) & 3]];
        if (Number.isNaN(from + to)) break;
        if (from < level === to < level) continue;
        const share = (level - from) / (to - from);
        ends.push([[column + share, row], [column + 1, row + share], [column + 1 - share, row + 1], [column, row + 1 - share]][side]);
        if (ends.length % 2 === 0) take(ends[ends.length - 2], ends[ends.length - 1], column, row);
      }
    }
}
function drawLabels(labels) {
  Object.assign(context, { font: "600 11px system-ui, sans-serif", textAlign: "center", textBaseline: "middle", lineJoin: "round" });
  const taken = [];
  for (const [x, y, angle, value] of labels) {
    if (taken.some(([a, b]) => Math.hypot(a - x, b - y) < 90)) continue;
    taken.push([x, y]);
    context.save();
    context.translate(x, y);
    context.rotate(Math.abs(angle) > Math.PI / 2 ? angle + Math.PI : angle);
    Object.assign(context, { strokeStyle: "#ffffffe0", lineWidth: 3.5, fillStyle: "#10203f" });
    const text = String(+value.toPrecision(6));
    context.strokeText(text, 0, 0);
    context.fillText(text, 0, 0);
    context.restore();
  }
}
function drawCross() {
  const [x, y] = [wide / 2, high / 2], cross = new Path2D(`M${x - 9} ${y}H${x + 9}M${x} ${y - 9}V${y + 9}`);
  stroke(cross, "#ffffffcc", 4);
  stroke(cross, "#000000", 1.5);
}
function drawScale() {
  const lat = placeOf(view.x, view.y)[1];
  const metres = (2 * Math.PI * 6378137 * Math.cos((lat * Math.PI) / 180)) / size();
  const most = metres * Math.min(160, wide / 3), decade = 10 ** Math.floor(Math.log10(most));
  const length = [5, 2, 1].map((digit) => digit * decade).find((round) => round <= most) ?? decade;
  const text = length >= 1000 ? `${length / 1000} km` : `${+length.toPrecision(3)} m`;
  part("scale").style.width = `${length / metres}px`;
  part("scale").setAttribute("aria-label", `Scale bar: ${text}`);
  part("length").textContent = text;
}
function read(zoom) {
  const [x, y] = toWorld(...(pointer ?? [wide / 2, high / 2]));
  const depth = depthAt(zoom, x, y), [lon, lat] = placeOf(x, y), { per_m, name } = UNITS[part("unit").value];
  const place = `${Math.abs(lat).toFixed(6)}\u00b0 ${lat < 0 ? "S" : "N"} ${Math.abs(lon).toFixed(6)}\u00b0 ${lon < 0 ? "W" : "E"}`;
  const strong = document.createElement("b");
  strong.textContent = Number.isNaN(depth) ? "no depth" : `${(depth * per_m).toFixed(2)} ${name}`;
  part("reading").replaceChildren(strong, ` ${pointer ? "" : "in the middle "}at ${place}`);
}
function drawLegend() {
  const { per_m, name } = UNITS[part("unit").value], [least, most] = map.range.map((depth) => depth * per_m);
  part("bar").style.background = `linear-gradient(${map.colours.join(",")})`;
  const wanted = (most - least) / 4, decade = 10 ** Math.floor(Math.log10(wanted));
  const step = [5, 2, 1].map((digit) => digit * decade).find((round) => round <= wanted) ?? decade;
  const ticks = [];
  for (let number = Math.ceil(least / step); number * step <= most; number++) {
    const tick = document.createElement("li");
    tick.textContent = `${+(number * step).toPrecision(6)} ${name}`;
    tick.style.top = `${(100 * (number * step - least)) / (most - least)}%`;
    ticks.push(tick);
  }
  part("ticks").replaceChildren(...ticks);
}

// Pointers: one moves the map, two zoom it, none pressed reads the depth.
const pressed = new Map();
const spread = () => {
  const [a, b] = [...pressed.values()];
  return [Math.hypot(a[0] - b[0], a[1] - b[1]), [(a[0] + b[0]) / 2, (a[1] + b[1]) / 2]];
};
canvas.addEventListener("pointerdown", (event) => {
  canvas.setPointerCapture(event.pointerId);
  pressed.set(event.pointerId, [event.clientX, event.clientY]);
  pointer = [event.clientX, event.clientY];
  redraw();
});
canvas.addEventListener("pointermove", (event) => {
  pointer = [event.clientX, event.clientY];
  const before = pressed.get(event.pointerId);
  if (before && pressed.size === 2) {
    const [apart, middle] = spread();
    pressed.set(event.pointerId, pointer);
    const [now, there] = spread();
    panBy(there[0] - middle[0], there[1] - middle[1]);
    zoomBy(Math.log2(Math.max(now, 1) / Math.max(apart, 1)), there);
  } else if (before) {
    pressed.set(event.pointerId, pointer);
    panBy(pointer[0] - before[0], pointer[1] - before[1]);
  }
  redraw();
});
for (const name of ["pointerup", "pointercancel"]) canvas.addEventListener(name, (event) => pressed.delete(event.pointerId));
canvas.addEventListener("wheel", (event) => {
  event.preventDefault();
  const lines = event.deltaMode === 1 ? 33 : 1;
  zoomBy(clamp((-event.deltaY * lines) / 250, -1.5, 1.5), [event.clientX, event.clientY]);
}, { passive: false });
canvas.addEventListener("dblclick", (event) => zoomBy(1, [event.clientX, event.clientY]));
canvas.addEventListener("keydown", (event) => {
  const keys = { ArrowLeft: [80, 0], ArrowRight: [-80, 0], ArrowUp: [0, 80], ArrowDown: [0, -80] };
  const steps = { "+": 0.5, "=": 0.5, "-": -0.5 };
  if (event.ctrlKey || event.metaKey || event.altKey) return;
  if (keys[event.key]) panBy(...keys[event.key]);
  else if (steps[event.key]) zoomBy(steps[event.key]);
  else if (event.key === "0") showAll();
  else return;
  event.preventDefault();
  pointer = null;
  redraw();
});
part("in").addEventListener("click", () => zoomBy(1));
part("out").addEventListener("click", () => zoomBy(-1));
part("all").addEventListener("click", showAll);
part("lines").addEventListener("change", redraw);
part("unit").addEventListener("change", () => {
  drawLegend();
  redraw();
});
function resize() {
  [wide, high, dots] = [innerWidth, innerHeight, devicePixelRatio || 1];
  [canvas.width, canvas.height] = [wide * dots, high * dots].map(Math.round);
  redraw();
}
addEventListener("resize", resize);

async function open(sources) {
  const [depth, values] = await Promise.all(sources.map((read) => new Archive(read).open()));
  Object.assign(layers, { depth, values });
  cache.clear();
  part("files").hidden = true;
  redraw();
}
part("choose").addEventListener("change", (event) => {
  const found = map.files.map((name) => [...event.target.files].find((file) => file.name === name));
  const why = `Choose both files that lie beside this page: ${map.files.join(" and ")}.`;
  if (found.every(Boolean)) open(found.map(chosen)).catch(() => (part("why").textContent = why));
  else part("why").textContent = why;
});
function start() {
  resize();
  drawLegend();
  const [zoom, lat, lon] = location.hash.slice(1).split("/").map(Number);
  showAll();
  if (Number.isFinite(zoom + lat + lon) && lon) {
    [view.x, view.y] = worldOf(lon, lat);
    view.zoom = zoom;
    moved();
  }
  open(map.files.map((name) => inside(name) ?? beside(name))).catch(() => {
    part("why").textContent = `The browser does not let this page read the files beside it. Put the folder on a web server, or choose ${map.files.join(" and ")} here.`;
    part("files").hidden = false;
  });
}
start();

// The network in space: floor, cameras, pairs, walkers. An SVG in CSS pixels, drawn anew when it is turned:
// no WebGL, which not every browser has and which talks to the console, and names are text.

const PAIR_WORDS = {
  confirmed: "confirmed by what moves in both", predicted: "predicted, too little moves in both to confirm it",
  no_baseline: "both stand at one place, as far as is known, so that there is no F",
  contradicts: "contradicts: alone it has another geometry",
};
const SHOWN_NAME = 22;
const [LETTER_WIDTH, NAME_HEIGHT] = [8, 14]; // pixels
const MANY = 20; // pairs, of which those that are confirmed are drawn thin

class Space {
  constructor(data, colours) {
    this.data = data;
    this.colours = colours.slice(0, -1); // the last is white, for pictures
    this.off = new Set();
    // What contradicts is drawn over the others.
    const rank = pair => Object.keys(PAIR_WORDS).indexOf(pair.status);
    this.links = [...data.pairs].sort((p, q) => rank(p) - rank(q));
    const { x, y, step, z } = data.floor;
    const corners = x.flatMap(i => y.map(j => [i * step, j * step, z]));
    // The corners of the floor are beyond all tracks.
    this.orbit = new Orbit([...corners, ...data.cameras.flatMap(one => [one.place, ...one.corners])]);
    this.svg = svg("svg", {
      class: "space-view", role: "application", tabindex: 0,
      "aria-label": `The network in space: ${data.cameras.length} cameras. Arrow keys turn it, plus and minus magnify, 0 resets.`,
    });
    this.listen();
    new ResizeObserver(() => this.later()).observe(this.svg);
  }

  element() {
    const turned = (text, azimuth, elevation) => el("button", { type: "button", onclick: () => {
      this.orbit.reset();
      [this.orbit.azimuth, this.orbit.elevation] = [azimuth, elevation];
      this.later();
    } }, text);
    const magnified = (text, label, factor) =>
      el("button", { type: "button", "aria-label": label, onclick: () => { this.orbit.magnify(factor); this.later(); } }, text);
    const tick = (name, text) => el("label", {}, el("input", { type: "checkbox", name, checked: true, onchange: event => {
      if (event.target.checked) this.off.delete(name);
      else this.off.add(name);
      this.later();
    } }), ` ${text}`);
    const { data } = this;
    return [
      this.svg,
      el("div", { class: "switches" },
        turned("From above", -90, 90), turned("From the side", -90, 0), turned("Aslant", -60, 24),
        magnified("+", "Magnify", 1.25), magnified("−", "Reduce", 0.8),
        tick("lines", "pairs"), tick("errors", "position errors"), data.tracks.length ? tick("tracks", "walkers") : null),
      el("ul", { class: "space-legend" },
        ...Object.keys(PAIR_WORDS).filter(status => data.pairs.some(pair => pair.status === status)).map(status =>
          el("li", {}, svg("svg", { width: 28, height: 8, "aria-hidden": true }, svg("path", { class: `link ${status}`, d: "M0,4h28" })),
            ` Pair ${PAIR_WORDS[status]}`))),
    ];
  }

  listen() {
    let from = null;
    this.svg.addEventListener("pointerdown", event => { from = [event.clientX, event.clientY]; });
    this.svg.addEventListener("pointermove", event => {
      if (!from || !event.buttons) return;
      const by = [event.clientX - from[0], event.clientY - from[1]];
      if (!this.svg.hasPointerCapture(event.pointerId)) {
        if (Math.hypot(...by) < 4) return;
        this.svg.setPointerCapture(event.pointerId);
      }
      this.orbit.turn(-0.4 * by[0], 0.3 * by[1]);
      from = [event.clientX, event.clientY];
      this.later();
    });
    for (const name of ["pointerup", "pointercancel"]) this.svg.addEventListener(name, () => { from = null; });
    // A pinch on a touchpad; a plain wheel scrolls the page.
    this.svg.addEventListener("wheel", event => {
      if (!event.ctrlKey) return;
      event.preventDefault();
      this.orbit.magnify(Math.exp(-0.01 * event.deltaY));
      this.later();
    }, { passive: false });
    this.svg.addEventListener("keydown", event => {
      const far = event.shiftKey ? 15 : 5;
      const step = { ArrowLeft: [far, 0], ArrowRight: [-far, 0], ArrowUp: [0, far], ArrowDown: [0, -far] }[event.key];
      const factor = { "+": 1.25, "=": 1.25, "-": 0.8 }[event.key];
      if (step) this.orbit.turn(...step);
      else if (factor && !event.ctrlKey && !event.metaKey) this.orbit.magnify(factor);
      else if (event.key === "0" && !event.ctrlKey && !event.metaKey) this.orbit.reset();
      else return;
      event.preventDefault();
      this.later();
    });
  }

  // Draw before the next picture of the browser, once.
  later() {
    this.waiting ??= requestAnimationFrame(() => { this.waiting = null; this.draw(); });
  }

  // Only one camera and its pairs, or all.
  pick(name) {
    this.picked = this.data.cameras.some(camera => camera.name === name) ? name : null;
    this.later();
  }

  draw() {
    const [width, height] = [this.svg.clientWidth, this.svg.clientHeight];
    if (!width || !height) return;
    const at = this.orbit.projection(width, height, Math.min(26, width / 25));
    this.svg.setAttribute("viewBox", `0 0 ${width} ${height}`);
    const cameras = this.data.cameras
      .map(camera => ({ ...camera, seen: at(camera.place), ahead: at(camera.corners[0])[0] + at(camera.corners[2])[0] - 2 * at(camera.place)[0] }))
      .sort((p, q) => q.seen[3] - p.seen[3]);
    const shown = (name, make) => (this.off.has(name) ? [] : make());
    this.svg.replaceChildren(
      svg("g", { class: "floor" }, ...this.floor(at)),
      svg("g", { class: "tracks" }, ...shown("tracks", () => this.tracks(at))),
      svg("g", { class: "drops" }, ...cameras.map(camera => this.drop(camera, at))),
      svg("g", { class: this.links.length > MANY ? "links many" : "links" },
        ...shown("lines", () => this.links.map(pair => this.link(pair, at)))),
      ...cameras.map(camera => this.camera(camera, at)),
      svg("g", { class: "names" }, ...this.names(cameras)));
  }

  floor(at) {
    const { x, y, step, z } = this.data.floor;
    const line = (from, to, zero) => svg("path", { class: zero ? "axis" : null, d: way([at(from), at(to)]) });
    const lines = [];
    for (let i = x[0]; i <= x[1]; i++) lines.push(line([i * step, y[0] * step, z], [i * step, y[1] * step, z], i === 0));
    for (let j = y[0]; j <= y[1]; j++) lines.push(line([x[0] * step, j * step, z], [x[1] * step, j * step, z], j === 0));
    const ends = [["x", [x[1] * step, 0, z]], ["y", [0, y[1] * step, z]]].map(([text, place]) => {
      const [right, down] = at(place);
      return svg("text", { x: right + 6, y: down + 4 }, text);
    });
    return [...lines, ...ends];
  }

  tracks(at) {
    return this.data.tracks.map((track, k) =>
      svg("path", { d: way(track.map(at)), stroke: this.colours[k % this.colours.length] }));
  }

  drop(camera, at) {
    const [x, y] = camera.place;
    return svg("path", { class: this.faded(camera.name), d: way([camera.seen, at([x, y, this.data.floor.z])]) });
  }

  link(pair, at) {
    const [a, b] = [this.data.cameras[pair.a], this.data.cameras[pair.b]];
    const d = way([at(a.place), at(b.place)]);
    return svg("g", {
      class: pair.pair === null ? this.faded(a.name, b.name) : `to-pair ${this.faded(a.name, b.name)}`,
      onclick: () => { if (pair.pair !== null) location.hash = `#pair-${pair.pair + 1}`; },
    }, svg("title", {}, `${a.name} and ${b.name}: ${PAIR_WORDS[pair.status] ?? pair.status}`),
    svg("path", { class: "hit", d }), svg("path", { class: `link ${pair.status}`, d }));
  }

  camera(camera, at) {
    const corners = camera.corners.map(at);
    const apex = camera.seen;
    const edges = corners.map(corner => way([apex, corner])).join("");
    const error = camera.error === null || this.off.has("errors") ? null : this.ellipsoid(camera, at);
    return svg("g", { class: `station ${camera.accepted ? "accepted" : "refused"} ${this.faded(camera.name)}` },
      svg("title", {}, camera.name + (camera.accepted ? "" : ": left out")), error,
      svg("path", { class: "sides", d: [0, 1, 2, 3].map(k => `${way([apex, corners[k], corners[(k + 1) % 4]])}Z`).join("") }),
      svg("path", { class: "image", d: `${way(corners)}Z` }),
      svg("path", { class: "edges", d: edges }),
      // The upper side is thick, which tells what is up.
      svg("path", { class: "upper", d: way(corners.slice(0, 2)) }),
      svg("circle", { class: "apex", cx: apex[0], cy: apex[1], r: 3 }));
  }

  // Its outline: half axes u, v, w in the picture make the ellipse of the matrix uuᵀ + vvᵀ + wwᵀ.
  ellipsoid(camera, at) {
    const [x, y] = camera.seen, small = 1e-3;
    const seen = camera.error.map(axis => {
      const by = small * this.data.magnification;
      const [right, down] = at(camera.place.map((place, k) => place + by * axis[k]));
      return [(right - x) / small, (down - y) / small];
    });
    const sum = (i, j) => seen.reduce((all, one) => all + one[i] * one[j], 0);
    const [xx, xy, yy] = [sum(0, 0), sum(0, 1), sum(1, 1)];
    const middle = (xx + yy) / 2, apart = Math.hypot((xx - yy) / 2, xy);
    const half = square => Math.min(4000, Math.sqrt(Math.max(square, 0))).toFixed(2);
    const turn = Math.atan2(2 * xy, xx - yy) * 90 / Math.PI;
    return svg("ellipse", {
      class: "error", rx: half(middle + apart), ry: half(middle - apart),
      transform: `translate(${x.toFixed(2)} ${y.toFixed(2)}) rotate(${turn.toFixed(2)})`,
    });
  }

  // Of those that would lie over one another that of the camera in front, or of the one that is picked.
  names(cameras) {
    const boxes = [];
    const inFront = [...cameras].reverse().sort((p, q) => (q.name === this.picked) - (p.name === this.picked));
    return inFront.map(camera => this.name(camera)).filter(text => {
      const [x, y, wide] = [Number(text.getAttribute("x")), Number(text.getAttribute("y")), LETTER_WIDTH * text.textContent.length];
      const left = text.getAttribute("text-anchor") === "end" ? x - wide : x;
      const free = boxes.every(([l, r, t]) => left > r || left + wide < l || Math.abs(t - y) > NAME_HEIGHT);
      if (free) boxes.push([left, left + wide, y]);
      return free;
    }).reverse();
  }

  name(camera) {
    const short = camera.name.length > SHOWN_NAME ? `${camera.name.slice(0, SHOWN_NAME - 1)}…` : camera.name;
    // Behind the camera, where its frustum is not; before it, where that would leave the picture.
    const [x, y] = camera.seen, room = LETTER_WIDTH * short.length + 8;
    const behind = camera.ahead > 0 ? x > room : x + room > this.svg.clientWidth;
    const side = behind ? "end" : "start";
    return svg("text", { class: this.faded(camera.name), x: x + (side === "end" ? -8 : 8), y: y - 9, "text-anchor": side }, short);
  }

  faded(...names) {
    return this.picked && !names.includes(this.picked) ? "faded" : "";
  }
}

const way = places => places.map(([x, y], k) => `${k ? "L" : "M"}${x.toFixed(1)},${y.toFixed(1)}`).join("");

// Show it, and which row of the table belongs to which camera.
function showSpace(data, colours) {
  const host = document.getElementById("space");
  const space = new Space(data, colours);
  host.replaceChildren(...space.element().filter(Boolean));
  host.hidden = false;
  for (const row of document.querySelectorAll("tr[data-camera]")) {
    row.tabIndex = 0;
    for (const name of ["pointerenter", "focus"]) row.addEventListener(name, () => space.pick(row.dataset.camera));
    for (const name of ["pointerleave", "blur"]) row.addEventListener(name, () => space.pick(null));
  }
}

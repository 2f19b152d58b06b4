// One camera's view: an SVG in the pixels of the image, so what is drawn in it needs no scaling.

class View {
  // `point(xy)` is called with what the user points at.
  constructor(camera, letter, pointable, point) {
    this.camera = camera;
    this.letter = letter;
    this.unit = camera.size[0] / 100;
    const [width, height] = camera.size;
    this.image = svg("image", { x: -0.5, y: -0.5, width, height, preserveAspectRatio: "none" });
    this.layers = Object.fromEntries(
      ["hulls", "lines", "points", "epipole", "pointed", "pointer"].map(name => [name, svg("g", { class: name })]));
    this.svg = svg("svg", {
      viewBox: `-0.5 -0.5 ${width} ${height}`, class: pointable ? "view pointable" : "view", "data-view": letter,
      role: pointable ? "application" : "img", tabindex: pointable ? 0 : null,
      "aria-label": `View of camera ${letter}, ${camera.name}` +
        (pointable ? ". Arrow keys move the pointer, with Shift faster." : ""),
    }, this.image, ...Object.values(this.layers));
    this.caption = el("figcaption");
    this.element = el("figure", {}, el("div", { class: "frame" }, this.svg), this.caption);
    if (pointable) this.listen(point);
  }

  listen(point) {
    const at = event => {
      const place = new DOMPoint(event.clientX, event.clientY).matrixTransform(this.svg.getScreenCTM().inverse());
      return this.inside([place.x, place.y]);
    };
    this.svg.addEventListener("pointermove", event => point(at(event)));
    this.svg.addEventListener("pointerdown", event => point(at(event)));
    this.svg.addEventListener("keydown", event => {
      const step = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] }[event.key];
      if (!step) return;
      event.preventDefault();
      const [x, y] = this.place ?? this.camera.size.map(size => (size - 1) / 2);
      const far = event.shiftKey ? 10 : 1;
      point(this.inside([x + far * step[0], y + far * step[1]]));
    });
  }

  inside(place) {
    return place.map((value, k) => Math.min(Math.max(value, -0.5), this.camera.size[k] - 0.5));
  }

  // A frame, or where there is none its silhouettes over the heat map.
  show(frame, caption) {
    const picture = this.camera.images[frame];
    this.svg.classList.toggle("drawn", !picture);
    this.image.setAttribute("href", picture ?? this.camera.heatPicture);
    this.layers.hulls.replaceChildren(
      ...this.camera.hulls[frame].map(hull => svg("polygon", { points: hull.map(p => p.join(",")).join(" ") })));
    this.caption.replaceChildren(
      el("b", {}, this.letter), ` ${this.camera.name} · `, el("span", {}, caption + (picture ? "" : ", silhouettes")));
  }

  showLines(lines, colours) {
    this.layers.lines.replaceChildren(...lines.flatMap((line, k) => {
      const ends = clipLine(line, this.camera.size);
      return ends ? [...this.stroke(ends, colours[k]), this.label(ends, k + 1, colours[k])] : [];
    }));
  }

  showPoints(points) {
    this.layers.points.replaceChildren(
      ...points.map(([x, y]) => svg("circle", { cx: x, cy: y, r: 0.9 * this.unit })));
  }

  showEpipole(place) {
    this.epipole = place;
    const seen = place && place.every((value, k) => value >= -0.5 && value <= this.camera.size[k] - 0.5);
    this.layers.epipole.replaceChildren(...(seen ? [
      svg("circle", { cx: place[0], cy: place[1], r: 2 * this.unit }),
      svg("circle", { cx: place[0], cy: place[1], r: 0.6 * this.unit }),
      svg("title", {}, "Epipole: where the other camera is seen from here"),
    ] : []));
  }

  // What the user points at here.
  mark(place) {
    this.place = place;
    const [x, y] = place ?? [0, 0], r = 1.4 * this.unit;
    this.layers.pointer.replaceChildren(...(place ? ["casing", "core"].map(part =>
      svg("path", { class: part, d: `M${x - 2 * r},${y}h${4 * r}M${x},${y - 2 * r}v${4 * r}` })) : []));
  }

  // The line of what the user points at in the other view.
  markLine(line) {
    const ends = line && clipLine(line, this.camera.size);
    this.layers.pointed.replaceChildren(...(ends ? this.stroke(ends, "#fff") : []));
    return ends;
  }

  stroke([[x1, y1], [x2, y2]], colour) {
    return ["casing", "core"].map(part =>
      svg("line", { class: part, x1, y1, x2, y2, stroke: part === "core" ? colour : null }));
  }

  // A number on the line, near its end away from the epipole, where lines are apart; or near its left end.
  label(ends, text, colour) {
    const rank = this.epipole ? end => -Math.hypot(end[0] - this.epipole[0], end[1] - this.epipole[1]) : end => end[0];
    const [from, to] = [...ends].sort((p, q) => rank(p) - rank(q));
    const length = Math.hypot(to[0] - from[0], to[1] - from[1]);
    const share = Math.min(0.5, (4 + 5 * (text % 2)) * this.unit / length);
    const [x, y] = from.map((value, k) => value + share * (to[k] - value));
    return svg("g", { transform: `translate(${x} ${y})`, "aria-hidden": "true" },
      svg("circle", { r: 1.9 * this.unit, fill: colour }),
      svg("text", { "font-size": 2.9 * this.unit, dy: "0.36em" }, String(text)));
  }
}

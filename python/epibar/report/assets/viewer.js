// Both views of a pair with what links them, the slider over time, the switches.

const LINE_WORDS = {
  epipolar: ["Epipolar lines of F",
    "Each line is one epipolar plane, seen by both cameras: what moves on line 1 of A is on line 1 of B."],
  inliers: ["Line pairs the search matched",
    "Pairs of random lines with like barcodes that agree with F. They are near epipolar lines, not exactly on them."],
  candidates: ["Best matching line pairs",
    "Pairs of random lines with like barcodes. Nothing confirms that they are epipolar."],
};
const REFUSED_GREY = "#b9bec6";
const lineColours = pair => (pair.accepted ? DATA.colours : DATA.colours.map(() => REFUSED_GREY));

class Viewer {
  constructor(pair, a, b, changed) {
    this.pair = pair;
    this.changed = changed;
    this.set = pair.line_sets.length ? 0 : -1;
    const pointable = pair.F !== null;
    this.views = [
      new View(a, "A", pointable, place => this.point(0, place)),
      new View(b, "B", pointable, place => this.point(1, place)),
    ];
    if (pointable) {
      this.views[0].showEpipole(epipole(pair.F));
      this.views[1].showEpipole(epipole(transposed(pair.F)));
    }
    this.element = el("section", { class: pair.accepted ? "viewer" : "viewer refused", "aria-label": "Views" },
      el("div", { class: "views" }, ...this.views.map(view => view.element)),
      ...this.controls(pointable));
    this.showMoment(this.bestMoment());
    this.showLines();
    const first = pair.moments[this.moment]?.points[0];
    if (pointable) this.point(0, first ? first.slice(0, 2) : a.size.map(size => (size - 1) / 2));
  }

  bestMoment() {
    const counts = this.pair.moments.map(moment => moment.points.length);
    return counts.indexOf(Math.max(...counts));
  }

  controls(pointable) {
    const last = this.pair.moments.length - 1;
    this.readout = el("output", { class: "readout" });
    if (last < 0) return [el("p", { class: "note" }, "The two cameras have no moment in common.")];
    this.time = el("output", { for: "moment" });
    this.slider = el("input", {
      type: "range", id: "moment", min: 0, max: last, step: 1,
      oninput: () => this.showMoment(Number(this.slider.value)),
    });
    const tick = (name, text, checked, change) =>
      el("label", {}, el("input", { type: "checkbox", name, checked, onchange: change }), ` ${text}`);
    const toggle = layer => event =>
      this.views.forEach(view => view.layers[layer].classList.toggle("off", !event.target.checked));
    const sets = el("select", { name: "lines", onchange: () => { this.set = Number(sets.value); this.showLines(); } },
      ...this.pair.line_sets.map((set, k) => el("option", { value: k }, LINE_WORDS[set.kind][0])),
      el("option", { value: -1 }, "no lines"));
    sets.value = String(this.set);
    this.views.forEach(view => view.layers.hulls.classList.add("off"));
    return [
      el("div", { class: "slider" }, el("label", { for: "moment" }, "Moment"), this.slider, this.time),
      el("div", { class: "switches" },
        el("label", {}, "Lines ", sets),
        pointable ? tick("points", "frontier points", true, toggle("points")) : null,
        tick("hulls", "silhouettes", false, toggle("hulls"))),
      pointable
        ? el("p", { class: "hint" }, "Point at anything in one view, by mouse, finger or arrow keys: the white line in the other " +
          "view is where it must be. ", this.readout)
        : el("p", { class: "hint" }, "No matrix was found, so pointing at a view shows nothing in the other."),
    ];
  }

  showMoment(index) {
    const moment = this.pair.moments[index];
    this.moment = index;
    if (!moment) {
      this.views.forEach(view => { view.element.hidden = true; });
      return;
    }
    this.slider.value = index;
    const text = `${number(moment.seconds, 2)} s`;
    this.time.textContent = `${index + 1} of ${this.pair.moments.length} · ${text}`;
    this.slider.setAttribute("aria-valuetext", `${text}, frame ${moment.a} of A, frame ${moment.b} of B`);
    this.views[0].show(moment.a, `frame ${moment.a}`);
    this.views[1].show(moment.b, `frame ${moment.b}`);
    this.views[0].showPoints(moment.points.map(p => p.slice(0, 2)));
    this.views[1].showPoints(moment.points.map(p => p.slice(2, 4)));
  }

  showLines() {
    const set = this.pair.line_sets[this.set];
    this.views[0].showLines(set ? set.lines_a : [], lineColours(this.pair));
    this.views[1].showLines(set ? set.lines_b : [], lineColours(this.pair));
    this.changed(set);
  }

  point(side, place) {
    const [here, there] = [this.views[side], this.views[1 - side]];
    const line = (side === 0 ? lineInB : lineInA)(this.pair.F, place);
    here.mark(place);
    here.markLine(null);
    there.mark(null);
    const seen = there.markLine(line);
    const at = place.map(value => value.toFixed(1)).join(", ");
    this.readout.textContent = `${here.letter} (${at})` + (seen ? "" : `: its line misses the image of ${there.letter}`);
  }
}

// One pair, top to bottom.

const EVIDENCE = {
  z: ["evidence on frames kept aside", "standard deviations above shifted clocks", 1],
  z_tops: ["upper edges alone", "standard deviations", 1],
  z_bottoms: ["lower edges alone", "standard deviations", 1],
  z_whole: ["whole silhouettes, both edges with those of one other", "standard deviations", 1],
  explained: ["outlines explained", "of its tangents", 0],
  explained_by_chance: ["by chance", "of its tangents", 0],
  explained_tops: ["upper edges explained", "of them", 0],
  explained_bottoms: ["lower edges explained", "of them", 0],
  tested_distance: ["from the geometry that was tested", "px over the volume where things moved", 2],
  plane_residual: ["distance from one plane", "widths of a silhouette", 2],
  spread_of_bottoms: ["lower edges lie off any line by", "widths of a silhouette; little means one path", 2],
  tops_off_floor: ["upper edges lie off the plane of the lower ones by", "widths of a silhouette; little means one plane", 2],
  may_turn: ["may turn about a plane by", "px over the images, without losing evidence; much means undetermined", 1],
  holds: ["holds throughout", "least share of the evidence that should be there, before or after some moment; below 0.5 a camera moved", 2],
  halves_apart: ["both halves of the recording", "px apart, where either asks for another geometry", 2],
  repeats: ["resembles a later moment", "correlation of both cameras with others in the places; from 0.4 what moves repeats itself", 2],
  essential_deviation: ["from an essential matrix", "difference of its singular values; above 0.05, of an accepted pair, a camera matrix is off", 3],
};

const COUNTS = {
  frames: "frames in common", informative_a: "informative lines of A, with those drawn later",
  informative_b: "informative lines of B, with those drawn later", on_motion_lines: "line pairs dropped as motion lines",
  mutual_pairs: "mutual best line pairs", candidates: "candidate line pairs", line_inliers: "candidates that agree with F",
};

function showPair(host, index) {
  forgetCharts(host);
  const pair = DATA.pairs[index];
  const [a, b] = [DATA.cameras[pair.a], DATA.cameras[pair.b]];
  const strips = el("section", { class: "card strips" });
  const viewer = new Viewer(pair, a, b, set => showStrips(strips, pair, set));
  host.replaceChildren(
    heading(pair, a, b, index), verdict(pair), viewer.element, strips, details(pair, a, b), ...tables(pair));
  host.hidden = false;
}

function heading(pair, a, b, index) {
  const step = (by, text, label) => {
    const target = index + by;
    return target in DATA.pairs ? el("a", { href: `#pair-${target + 1}`, "aria-label": label }, text) : el("span");
  };
  return el("div", { class: "pair-title" },
    el("h2", { id: "pair-title", tabindex: -1 },
      el("span", { class: "who" }, el("b", {}, "A"), ` ${a.name}`), " ",
      el("span", { class: "who" }, el("b", {}, "B"), ` ${b.name}`)),
    el("nav", { "aria-label": "Other pairs" }, step(-1, "‹ previous", "Previous pair"), step(1, "next ›", "Next pair")));
}

function verdict(pair) {
  const error = pair.expected_error === null ? null
    : el("p", { class: "error" }, el("strong", {}, `${number(pair.expected_error, 2)} px`), " expected error");
  const rate = pair.frames_per_frame === 1 ? "" : `${+pair.frames_per_frame.toFixed(6)} × `;
  const offset = pair.time_offset || rate
    ? el("p", {}, `Frame i of A is frame ${rate}i ${pair.time_offset < 0 ? "−" : "+"} ${number(Math.abs(pair.time_offset), 2)} of B.`)
    : null;
  const next = pair.advice.length
    ? [el("h3", {}, "What to do next"), el("ul", {}, ...pair.advice.map(text => el("li", {}, ...withCode(text))))] : [];
  const title = pair.accepted ? `✓ ${pair.verdict}` : `✕ Refused: ${pair.verdict.toLowerCase()}`;
  return el("section", { class: pair.accepted ? "verdict accepted" : "verdict refused" },
    el("div", {},
      el("p", { class: "word" }, title), el("p", {}, pair.reason), offset, ...next),
    el("div", { class: "matrix-box" }, pair.accepted ? error : null, matrixBox(pair)));
}

// What is between backticks is code.
const withCode = text => text.split("`").map((part, k) => (k % 2 ? el("code", {}, part) : part));

// F is there to be copied; that of a refused pair must be asked for, and says so wherever it is pasted.
function matrixBox(pair) {
  if (pair.F === null) {
    const moved = "The fundamental matrix that was found is of before a camera moved.";
    return el("p", { class: "note" }, pair.kind === "moved" ? moved : "No fundamental matrix was found.");
  }
  const rows = pair.F.map(row => `    [${row.join(", ")}],`).join("\n");
  const warning = pair.accepted ? "" : `# REFUSED (${pair.kind}): not to be used\n`;
  const text = `${warning}F = np.array([\n${rows}\n])  # x_b^T F x_a = 0\n`;
  const button = el("button", { type: "button", class: "copy", onclick: async () => {
    button.textContent = (await copyText(text)) ? "Copied" : "Copying failed: select it by hand";
    setTimeout(() => { button.textContent = "Copy F for NumPy"; }, 2000);
  } }, "Copy F for NumPy");
  const table = el("table", { class: "F", "aria-label": "Fundamental matrix" }, ...pair.F.map(row =>
    el("tr", {}, ...row.map(value => el("td", { title: String(value) }, value.toExponential(4).replace("-", "−").replace("e-", "e−"))))));
  return pair.accepted ? el("div", {}, table, button)
    : el("details", {}, el("summary", {}, "The refused matrix"), table, button);
}

function showStrips(host, pair, set) {
  host.hidden = !set;
  if (!set) return;
  forgetCharts(host);
  const frames = pair.strip_frames.length;
  const some = frames < pair.common_frames ? ` The ${frames} busiest of ${number(pair.common_frames, 0)} frames.` : "";
  const known = set.correlation.filter(value => value !== null).sort((p, q) => p - q);
  const middle = known.length ? ` Correlation of A and B: ${number(known[0], 2)} to ${number(known.at(-1), 2)}.` : "";
  host.replaceChildren(
    el("h3", {}, "Motion barcodes of the lines"),
    el("p", { class: "caption" },
      "Bright where something moves on the line. " + LINE_WORDS[set.kind][1] +
      ` ${pair.accepted ? "In colour" : "Light"}: both cameras at once; grey: one alone.` + middle + some),
    chart(() => barcodeChart(pair, set, lineColours(pair)), "strip-plot"));
}

function details(pair, a, b) {
  const card = (title, caption, ...plots) =>
    el("section", { class: plots.length > 1 ? "card wide" : "card" }, el("h3", {}, title),
      el("p", { class: "caption" }, caption), el("div", { class: "plots" }, ...plots));
  const twin = describe => [[a, 0], [b, 1]].map(([camera, side]) =>
    el("figure", {},
      // Room for the colour bar beside an image of the camera's shape.
      chart(() => describe(camera, side), "image-plot", `aspect-ratio: ${1.22 * camera.size[0]} / ${camera.size[1]}`),
      el("figcaption", {}, el("b", {}, "AB"[side]), ` ${camera.name}`)));
  const cards = [];
  if (pair.shift_curve.shift.length > 1) cards.push(card("Time shift",
    "How well F explains frames kept aside when B's clock is shifted, cyclically. Standing out at 0 and nowhere else shows that both see the same scene at the same time, not how accurate F is.",
    chart(() => shiftChart(pair))));
  if (pair.residuals) cards.push(card("Residuals of the frontier points",
    "Places where an epipolar plane touches an outline, seen by both: how far each lies from its line." +
      (pair.residuals.furthest > pair.residuals.edges.at(-1)
        ? ` The last bar holds all that lie further off, up to ${number(pair.residuals.furthest, 0)} px.` : ""),
    chart(() => residualChart(pair))));
  if (pair.error_maps) cards.push(card("Expected error over the image",
    "How far the line of a point here is expected to be off in the other view. F is known best where things moved. " +
      `Yellow: ${number(errorTop(pair.error_maps), 1)} px and more. Empty: its line misses the other view.` +
      (pair.trusted ? ` Up to ${number(pair.trusted.limit, 1)} px are expected in ${number(100 * pair.trusted.shares[0], 0)} % of A and` +
        ` ${number(100 * pair.trusted.shares[1], 0)} % of B; a white line goes round where it is more.`
        : " Of a refused pair this holds only if the geometry is the right one at all."),
    ...twin((camera, side) => errorChart(camera, pair, side))));
  cards.push(card("Where things moved",
    "In how many frames something moved. Dashed: motion lines, straight paths that much of the traffic follows.",
    ...twin(camera => heatChart(camera))));
  return el("div", { class: "cards" }, ...cards);
}

function tables(pair) {
  const row = cells => el("tr", {}, ...cells.map((cell, k) => el(k ? "td" : "th", k ? {} : { scope: "row" }, cell)));
  const found = [];
  if (pair.rivals.length) {
    const head = el("tr", {}, ...["", "distance", "share of the evidence", "behind by"].map(text => el("th", { scope: "col" }, text)));
    const rows = pair.rivals.map((rival, k) => row([
      `rival ${k + 1}`, rival.distance === null ? "unknown" : `${number(rival.distance, 1)} px`,
      `${number(100 * rival.evidence_share, 0)} %`, `${number(rival.evidence_z, 1)} σ`]));
    const more = pair.all_rivals > rows.length ? ` The first ${rows.length} of ${pair.all_rivals}.` : "";
    found.push(el("section", { class: "card" }, el("h3", {}, "Rivals"),
      el("p", { class: "caption" }, "Other geometries that were met. One with about the same evidence and far away makes a pair ambiguous." + more),
      el("div", { class: "scroll" }, el("table", { class: "numbers" }, el("thead", {}, head), el("tbody", {}, ...rows)))));
  }
  const evidence = Object.entries(EVIDENCE).filter(([key]) => pair.evidence[key] !== undefined && pair.evidence[key] !== null)
    .map(([key, [name, unit, digits]]) => {
      const share = key.startsWith("explained");
      return row([name, number(share ? 100 * pair.evidence[key] : pair.evidence[key], digits) + (share ? " % " : " ") + unit]);
    });
  const counts = Object.entries(pair.counts).map(([key, value]) => row([COUNTS[key] ?? key.replaceAll("_", " "), number(value, 0)]));
  const rest = [row(["method", pair.method]), row(["computed in", `${number(pair.seconds, 1)} s`])];
  found.push(el("section", { class: "card" }, el("h3", {}, "Evidence and counts"),
    el("div", { class: "scroll" }, el("table", { class: "numbers" }, el("tbody", {}, ...evidence, ...counts, ...rest)))));
  return [el("div", { class: "cards" }, ...found)];
}

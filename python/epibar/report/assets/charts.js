// The charts of a pair, each as {data, layout} for plotly.

const ONE_ONLY = "#5b6470";

// Barcodes of line pairs, A over B: coloured where both are crossed by motion, grey where only one is.
function barcodeChart(pair, set, colours) {
  const frames = pair.strip_frames;
  const rows = [], names = [], texts = [];
  set.lines_a.forEach((_, k) => {
    const bits = [set.bits_a[k], set.bits_b[k]].map(text => unpackBits(text, frames.length));
    const places = [3 * k, 3 * k + 1];
    for (const side of [0, 1]) {
      rows[places[side]] = bits[side].map((bit, t) => (bit ? (bits[1 - side][t] ? k + 2 : 1) : 0));
      texts[places[side]] = bits[side].map(bit =>
        `line ${k + 1}, ${"AB"[side]}: ${bit ? "crossed by motion" : "nothing moves on it"}`);
      names[places[side]] = side === 0 ? `<b>${k + 1}</b>  A` : "B";
    }
    rows[3 * k + 2] = frames.map(() => null);
    texts[3 * k + 2] = frames.map(() => "");
  });
  rows.pop();
  texts.pop();
  const shades = ["#14181d", ONE_ONLY, ...colours.slice(0, set.lines_a.length)];
  return {
    data: [{
      type: "heatmap", z: rows, x: frames, text: texts, hoverongaps: false, showscale: false, zmin: -0.5,
      zmax: shades.length - 0.5, hovertemplate: "frame %{x} of A<br>%{text}<extra></extra>",
      colorscale: shades.flatMap((shade, k) => [[k / shades.length, shade], [(k + 1) / shades.length, shade]]),
    }],
    layout: {
      xaxis: { title: "frame of A", showgrid: false, zeroline: false },
      yaxis: {
        autorange: "reversed", tickvals: rows.map((_, k) => k).filter(k => k % 3 < 2), fixedrange: true,
        ticktext: names.filter(Boolean), showgrid: false, zeroline: false,
      },
    },
  };
}

function shiftChart(pair) {
  const { shift, score } = pair.shift_curve;
  const highlight = pair.accepted ? css("--accepted") : css("--refused");
  return {
    data: [{
      type: "bar", x: shift, y: score, width: Math.max(...shift) / 130,
      marker: { color: shift.map(s => (s === 0 ? highlight : css("--muted"))) },
      hovertemplate: "clocks shifted by %{x} frames<br>score %{y:.0f}<extra></extra>",
    }],
    layout: {
      xaxis: { title: "shift of B's clock, frames", rangemode: "tozero" }, yaxis: { title: "score of F" },
    },
  };
}

function residualChart(pair) {
  const { counts, edges, median } = pair.residuals;
  const middles = counts.map((_, k) => (edges[k] + edges[k + 1]) / 2);
  return {
    data: [{
      type: "bar", x: middles, y: counts, marker: { color: css(pair.accepted ? "--accepted" : "--muted") }, width: edges[1] - edges[0],
      hovertemplate: "%{x:.2f} px: %{y} points<extra></extra>",
    }],
    layout: {
      xaxis: { title: "distance from the epipolar line, px", rangemode: "tozero" }, yaxis: { title: "points" },
      shapes: [{ type: "line", x0: median, x1: median, y0: 0, y1: 1, yref: "paper",
        line: { color: css("--text"), width: 1.5, dash: "dot" } }],
      annotations: [{ x: median, y: 1, yref: "paper", text: `median ${median.toFixed(2)} px`, showarrow: false,
        xanchor: "left", yanchor: "top", xshift: 5 }],
    },
  };
}

// A grid evenly over the image of a camera, with lines over it.
function imageChart(camera, grid, { unit, zmax, lines = [], outline = null }) {
  const [width, height] = camera.size;
  const [rows, columns] = [grid.length, grid[0].length];
  const middle = (count, size) => Array.from({ length: count }, (_, k) => ((k + 0.5) * size) / count - 0.5);
  const segments = lines.map(line => clipLine(line, camera.size)).filter(Boolean);
  const [x, y] = [middle(columns, width), middle(rows, height)];
  const outlined = outline === null ? [] : [{
    type: "contour", z: grid, x, y, autocontour: false, contours: { start: outline, end: outline, size: 1, coloring: "none" },
    line: { color: "#fff", width: 2 }, showscale: false, hoverinfo: "skip",
  }];
  return {
    data: [{
      type: "heatmap", z: grid, x, y, zmin: 0, zmax,
      colorscale: SEQUENTIAL, hoverongaps: false,
      colorbar: { thickness: 10, outlinewidth: 0, title: { text: unit, side: "right" }, len: 0.9 },
      hovertemplate: `(%{x:.0f}, %{y:.0f}): %{z:.2f} ${unit}<extra></extra>`,
    }, ...outlined],
    layout: {
      xaxis: { range: [-0.5, width - 0.5], showgrid: false, zeroline: false, constrain: "domain", visible: false },
      yaxis: { range: [height - 0.5, -0.5], showgrid: false, zeroline: false, scaleanchor: "x", constrain: "domain",
        visible: false },
      shapes: segments.map(([[x0, y0], [x1, y1]]) =>
        ({ type: "line", x0, y0, x1, y1, line: { color: "#fff", width: 2, dash: "dash" } })),
    },
  };
}

const heatChart = camera =>
  imageChart(camera, camera.heat, { unit: "% of frames", zmax: Math.max(1e-9, ...camera.heat.flat()), lines: camera.motion_lines });

// Both maps of a pair have one scale; the corners, where nothing moved, do not set it.
function errorTop(maps) {
  const known = maps.flat(2).filter(value => value !== null).sort((p, q) => p - q);
  return known[Math.floor(0.9 * (known.length - 1))] || 1;
}

const errorChart = (camera, pair, side) =>
  imageChart(camera, pair.error_maps[side], { unit: "px", zmax: errorTop(pair.error_maps), outline: pair.trusted ? pair.trusted.limit : null });

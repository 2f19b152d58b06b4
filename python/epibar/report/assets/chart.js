// What all charts share: plotly on first use, colours of the page, drawing when scrolled to.

let plotly = null;

// Run the library on first use: reading it costs a phone more than everything else.
function library() {
  if (!plotly) {
    const source = document.getElementById("plotly-source");
    document.head.append(el("script", {}, source.textContent));
    source.remove();
    plotly = window.Plotly;
  }
  return plotly;
}

const COARSE = matchMedia("(pointer: coarse)").matches;
const CONFIG = { responsive: true, displaylogo: false, displayModeBar: false };
const SEQUENTIAL = "Cividis";

// Charts in the page: [element, function that returns {data, layout}, drawn].
let charts = [];
const watcher = new IntersectionObserver(seen => {
  for (const entry of seen) if (entry.isIntersecting) drawChart(entry.target);
}, { rootMargin: "300px" });

function chart(describe, className = "", style = null) {
  const element = el("div", { class: `plot ${className}`, style });
  charts.push({ element, describe, drawn: false });
  watcher.observe(element);
  return element;
}

function drawChart(element) {
  const found = charts.find(item => item.element === element);
  watcher.unobserve(element);
  if (!found) return;
  found.drawn = true;
  const { data, layout } = found.describe();
  library().react(element, data, themed(layout), CONFIG);
}

const redrawCharts = () => charts.filter(item => item.drawn).forEach(item => drawChart(item.element));

// Let go of the charts in an element.
function forgetCharts(host) {
  for (const item of charts.filter(({ element }) => host.contains(element))) {
    watcher.unobserve(item.element);
    if (item.drawn) library().purge(item.element);
  }
  charts = charts.filter(({ element }) => !host.contains(element));
}

function themed(layout) {
  const axis = { gridcolor: css("--grid"), zerolinecolor: css("--grid"), linecolor: css("--grid"), automargin: true };
  const dress = given => ({ ...axis, ...given, ...(given?.title ? { title: { text: given.title, standoff: 8 } } : {}) });
  return {
    margin: { l: 8, r: 8, t: 8, b: 8 }, paper_bgcolor: "rgba(0,0,0,0)", plot_bgcolor: "rgba(0,0,0,0)",
    font: { family: "system-ui, sans-serif", size: 13, color: css("--text") },
    dragmode: COARSE ? false : "zoom", showlegend: false,
    hoverlabel: { font: { family: "system-ui, sans-serif", size: 13 } },
    ...layout, xaxis: dress(layout.xaxis), yaxis: dress(layout.yaxis),
  };
}

// The page: which pair is shown, light and dark.

const DATA = JSON.parse(document.getElementById("data").textContent);
document.querySelectorAll(".camera image").forEach((image, k) => { DATA.cameras[k].heatPicture = image.getAttribute("href"); });

const host = document.getElementById("pair");
const cells = [...document.querySelectorAll("a.cell")];

function route(focus) {
  const asked = Number(location.hash.match(/^#pair-(\d+)$/)?.[1] ?? 1) - 1;
  const index = asked in DATA.pairs ? asked : 0;
  for (const cell of cells) {
    const shown = cell.getAttribute("href") === `#pair-${index + 1}`;
    if (shown) cell.setAttribute("aria-current", "true");
    else cell.removeAttribute("aria-current");
  }
  showPair(host, index);
  if (focus) {
    document.getElementById("pair-title").focus({ preventScroll: true });
    host.scrollIntoView();
  }
}

const root = document.documentElement;
const button = document.getElementById("theme");
const systemDark = matchMedia("(prefers-color-scheme: dark)");
const isDark = () => (root.dataset.theme ? root.dataset.theme === "dark" : systemDark.matches);

function themeChanged() {
  button.textContent = isDark() ? "☀ Light" : "☾ Dark";
  button.setAttribute("aria-label", `Switch to ${isDark() ? "light" : "dark"} colours`);
  redrawCharts();
}

button.addEventListener("click", () => {
  root.dataset.theme = isDark() ? "light" : "dark";
  themeChanged();
});
systemDark.addEventListener("change", themeChanged);
button.hidden = false;
document.getElementById("no-scripts").remove();

if (DATA.space) showSpace(DATA.space, DATA.colours);
if (DATA.pairs.length) {
  window.addEventListener("hashchange", () => route(true));
  route(location.hash.length > 1);
}
themeChanged();

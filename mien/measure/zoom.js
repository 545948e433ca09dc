for (const svg of document.querySelectorAll("svg[data-x]")) {
  const numbers = (words) => words.split(" ").map(Number);
  const [x0, x1] = numbers(svg.dataset.x), [y0, y1] = numbers(svg.dataset.y), steps = numbers(svg.dataset.steps);
  const [left, right, bottom, top] = numbers(svg.dataset.frame), [lowTold, highTold] = numbers(svg.dataset.told);
  const whole = svg.querySelector(".whole"), figure = svg.parentElement;
  const clamp = (value, low, high) => Math.max(low, Math.min(high, value));
  const set = (node, attributes) => Object.entries(attributes).forEach((one) => node.setAttribute(...one));
  const add = (parent, kind, attributes = {}, words = "") => {
    const made = parent.appendChild(document.createElementNS(parent.namespaceURI, kind));
    set(made, attributes);
    made.textContent = words;
    return made;
  };
  const decoded = (run) => {
    const deltas = numbers(run), points = [];
    for (let i = 0, x = 0, y = 0; i < deltas.length; i += 2)
      points.push([x0 + (x += deltas[i]) / steps[0] * (x1 - x0), y0 + (y += deltas[i + 1]) / steps[1] * (y1 - y0)]);
    return points;
  };
  // In the order of drawing: the first name is the last here.
  const lines = [...whole.querySelectorAll(".line")].map((path) => {
    const title = path.querySelector("title"), runs = path.dataset.runs;
    title.remove();  // What the pointer's readout says.
    return { name: title.textContent, colour: path.getAttribute("stroke"), marked: path.dataset.points === "1",
             runs: runs ? runs.split(";").map(decoded) : [] };
  });
  // As axis_ticks and tick_text of plot.cpp.
  const round = (low, high, count) => {
    const rough = (high - low) / count, power = 10 ** Math.floor(Math.log10(rough)), part = rough / power;
    const step = power * (part < 1.5 ? 1 : part < 3.5 ? 2 : part < 7.5 ? 5 : 10), ticks = [];
    for (let i = Math.ceil(low / step - 1e-9); i * step <= high + 1e-9 * step; ++i) ticks.push(i * step);
    return ticks.length < 2 ? [low, high] : ticks;
  };
  const said = (value, step) => Math.abs(value) < 1e-9 * step ? "0"
    : Math.abs(value) >= 1e6 || step < 1e-4 ? String(Number(value.toPrecision(3)))
    : value.toFixed(Math.max(0, Math.ceil(-Math.log10(step) - 1e-9)));
  const between = (run, low, high) => run.flatMap((q, i) => {  // Cut where it enters and leaves.
    const p = run[i - 1] ?? q, ends = [low, high].filter((x) => p[0] < x && x < q[0]);
    const cuts = ends.map((x) => [x, p[1] + (q[1] - p[1]) * (x - p[0]) / (q[0] - p[0])]);
    return q[0] >= low && q[0] <= high ? [...cuts, q] : cuts;
  });

  let a = x0, b = x1, yRange = y1 - y0, from = null;
  const zoomed = add(svg, "g"), cursor = add(svg, "path", { class: "cursor" });
  const band = add(svg, "rect", { class: "band", y: top, height: bottom - top });
  const hint = add(figure, "p", { class: "hint" }), readout = add(figure, "div", { class: "readout" });
  add(hint, "span", {}, "Drag to zoom, double-click for the whole; or the keys + \u2212 \u2190 \u2192 0");
  const button = add(hint, "button", { type: "button" }, "Whole");
  const hush = () => readout.style.display = cursor.style.display = "none";

  const show = (low, high) => {
    const width = clamp(high - low, (x1 - x0) / 1000, x1 - x0), all = width > (x1 - x0) * (1 - 1e-9);
    a = all ? x0 : clamp((low + high - width) / 2, x0, x1 - width);
    b = all ? x1 : a + width;
    yRange = y1 - y0;
    hush();
    zoomed.replaceChildren();
    whole.style.display = all ? "" : "none";
    button.hidden = all;
    if (all) return;
    const seen = lines.map((line) => line.runs.map((run) => between(run, a, b)).filter((run) => run.length > 0));
    const extreme = (worse, found) => seen.flat(2).reduce((before, [, y]) => worse(before, y), found);
    let yLow = lowTold ? y0 : extreme(Math.min, 0), yHigh = highTold ? y1 : extreme(Math.max, -Infinity);
    if (!(yHigh > yLow)) yHigh = yLow + 1;
    const rows = round(yLow, yHigh, 5), step = rows[1] - rows[0], last = rows[rows.length - 1];
    if (!highTold && last < yHigh) rows.push(yHigh = last + step);
    if (!lowTold && yLow < 0 && rows[0] > yLow) rows.unshift(yLow = rows[0] - step);
    yRange = yHigh - yLow;
    const px = (x) => (left + (x - a) / (b - a) * (right - left)).toFixed(1);
    const py = (y) => clamp(bottom - (y - yLow) / yRange * (bottom - top), top - 2, bottom + 2).toFixed(1);
    for (const y of rows) {
      add(zoomed, "line", { class: "grid", x1: left, x2: right, y1: py(y), y2: py(y) });
      add(zoomed, "text", { x: left - 8, y: Number(py(y)) + 4, "text-anchor": "end" }, said(y, step));
    }
    const columns = round(a, b, 8);
    for (const x of columns)
      add(zoomed, "text", { x: px(x), y: bottom + 18, "text-anchor": "middle" }, said(x, columns[1] - columns[0]));
    lines.forEach((line, i) => {
      const path = (run) => "M" + run.map(([x, y]) => px(x) + " " + py(y)).join("L") + (run[1] ? "" : "h0.1");
      add(zoomed, "path", { class: "line", stroke: line.colour, d: seen[i].map(path).join("") });
      for (const [x, y] of line.marked ? line.runs.flat() : [])
        if (x >= a && x <= b) add(zoomed, "circle", { cx: px(x), cy: py(y), r: 3, fill: line.colour });
    });
  };

  const place = (event) => {  // In the drawing, and along the axis.
    const box = svg.getBoundingClientRect(), far = (event.clientX - box.left) / box.width;
    const at = clamp(far * svg.viewBox.baseVal.width, left, right);
    return [at, a + (at - left) / (right - left) * (b - a)];
  };
  const tell = (event) => {
    const [at, x] = place(event), near = 5 / (right - left) * (b - a), around = figure.getBoundingClientRect();
    set(cursor, { d: `M${at} ${top}V${bottom}` });
    readout.replaceChildren();
    add(readout, "b", {}, said(x, (b - a) / 1000) + "  " + svg.querySelector(".along").textContent);
    for (const line of [...lines].reverse()) {
      let p = null;
      for (const run of line.runs)
        if (run[0][0] - near <= x && run[run.length - 1][0] + near >= x)
          for (const q of run) if (!p || Math.abs(q[0] - x) < Math.abs(p[0] - x)) p = q;
      const row = add(readout, "span");
      add(row, "i").style.background = line.colour;
      row.append(line.name + "  " + (p ? said(p[1], yRange / 1000) : "\u2013"));
    }
    readout.style.display = cursor.style.display = "";
    readout.style.top = svg.getBoundingClientRect().top - around.top + 4 + "px";
    readout.style.left = event.clientX - around.left + "px";
    readout.classList.toggle("before", at > (left + right) / 2);
  };
  const mark = (p, q) => set(band, { x: Math.min(p, q), width: Math.abs(q - p) });
  const back = () => show(x0, x1), on = (kind, then, options) => svg.addEventListener(kind, then, options);
  on("pointerdown", (event) => {
    if (event.button !== 0) return;
    from = place(event);
    svg.setPointerCapture(event.pointerId);
  });
  on("pointermove", (event) => {
    tell(event);
    if (from) mark(from[0], place(event)[0]);
  });
  on("pointerup", (event) => {
    const [low, high] = [from ?? place(event), place(event)].sort((p, q) => p[0] - q[0]);
    if (high[0] - low[0] > 4) show(low[1], high[1]);
  });
  on("lostpointercapture", () => { from = null; mark(0, 0); });
  on("pointerleave", hush);
  on("dblclick", back);
  button.addEventListener("click", back);
  // By a factor about x. The wheel only with Ctrl, as touchpads send a pinch too: else the page scrolls.
  const scale = (factor, x) => show(x - (x - a) * factor, x + (b - x) * factor);
  on("wheel", (event) => {
    if (!event.ctrlKey) return;
    event.preventDefault();
    scale(Math.exp(clamp(event.deltaY, -50, 50) / 100), place(event)[1]);
  }, { passive: false });
  const nearer = (factor) => () => scale(factor, (a + b) / 2);
  const along = (part) => () => show(a + part * (b - a), b + part * (b - a));
  const keys = { "+": nearer(0.5), "=": nearer(0.5), "-": nearer(2), "0": back, Escape: back,
                 ArrowLeft: along(-0.25), ArrowRight: along(0.25) };
  on("keydown", (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey || !keys[event.key]) return;
    event.preventDefault();
    keys[event.key]();
  });
  svg.tabIndex = 0;
  set(svg, { "aria-keyshortcuts": "+ - ArrowLeft ArrowRight 0 Escape" });
  Object.assign(svg.style, { touchAction: "pan-y pinch-zoom", userSelect: "none", cursor: "crosshair" });
  back();
}

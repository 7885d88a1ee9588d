// What the report can do beyond its text: plots that zoom, pictures over time, where each number comes from.
"use strict";
(() => {
  const all = (selector, root) => [...(root || document).querySelectorAll(selector)];
  const NS = "http://www.w3.org/2000/svg";
  const LEFT = 74, TOP = 16, RIGHT = 704, BOTTOM = 360, WIDTH = 720, HEIGHT = 404;
  const make = (name, attributes, text) => {
    const e = document.createElement(name);
    for (const [key, value] of Object.entries(attributes || {})) e.setAttribute(key, value);
    if (text !== undefined) e.textContent = text;
    return e;
  };
  const draw = (name, attributes, text) => {
    const e = document.createElementNS(NS, name);
    for (const [key, value] of Object.entries(attributes)) e.setAttribute(key, value);
    if (text !== undefined) e.textContent = text;
    return e;
  };

  // --- numbers and ticks ---

  const digits = (x) => {
    if (x === 0) return "0";
    const size = Math.abs(x);
    const text = size >= 1e-4 && size < 1e7 ? String(Number(x.toPrecision(5))) : x.toExponential(3).replace("e+", "e");
    return text.replace(/-/g, "−");
  };
  const ticks = (low, high, log, most) => {
    if (log) {
      const found = [], first = Math.floor(Math.log10(low)), last = Math.ceil(Math.log10(high));
      const stride = Math.max(1, Math.ceil((last - first) / most));
      for (let e = first; e <= last; e += stride)
        for (const m of high / low < 300 ? [1, 2, 5] : [1]) {
          const v = m * 10 ** e;
          if (v >= low * (1 - 1e-9) && v <= high * (1 + 1e-9)) found.push(v);
        }
      return found;
    }
    const rough = (high - low) / most, power = 10 ** Math.floor(Math.log10(rough));
    const step = power * [1, 2, 5, 10].find((k) => k * power >= rough * (1 - 1e-9));
    const found = [];
    for (let k = Math.ceil(low / step - 1e-9); k * step <= high + 1e-9 * step && found.length < 40; k++)
      found.push(Number((k * step).toPrecision(12)));
    return found;
  };

  // --- plots ---

  class Plot {
    constructor(frame) {
      this.data = JSON.parse(frame.querySelector("script").textContent);
      this.log = [this.data.x.log, this.data.y.log];
      this.hidden = new Set();
      // Series without a name go with the one before them.
      let group = -1;
      this.group = this.data.series.map((s, k) => (group = k === 0 || s.label ? group + 1 : group));
      this.frame = frame;
      this.build();
      this.reset();
    }
    build() {
      this.still = this.frame.querySelector("svg");
      this.bar = make("div", { class: "plot-bar" });
      const button = (text, title, act) => {
        const b = make("button", { type: "button", title }, text);
        b.addEventListener("click", act);
        this.bar.append(b);
        return b;
      };
      ["x", "y"].forEach((axis, k) => {
        const b = button("log " + axis, "logarithmic " + axis + " axis", () => {
          this.log[k] = !this.log[k];
          b.setAttribute("aria-pressed", this.log[k]);
          this.reset();
        });
        b.setAttribute("aria-pressed", this.log[k]);
      });
      button("whole", "show all (0)", () => this.reset());
      this.svg = draw("svg", {
        viewBox: `0 0 ${WIDTH} ${HEIGHT}`, width: WIDTH, height: HEIGHT, tabindex: 0, class: "live-plot", role: "img",
        "aria-label": this.data.title + ". Arrow keys move, + and − zoom, 0 shows all, [ and ] step through the points.",
        "font-size": "12.5", "font-family": "system-ui, sans-serif", fill: "none",
      });
      this.tip = make("div", { class: "tip-box", role: "status", "aria-live": "polite" });
      this.legend = make("div", { class: "plot-legend" });
      this.data.series.forEach((s, k) => {
        if (!s.label) return;
        const b = make("button", { type: "button", "aria-pressed": "true", title: "show or hide" });
        const chip = make("span", { class: "chip" });
        chip.style.background = s.colour;
        b.append(chip, document.createTextNode(s.label));
        b.addEventListener("click", () => {
          const g = this.group[k], off = !this.hidden.has(g);
          off ? this.hidden.add(g) : this.hidden.delete(g);
          b.setAttribute("aria-pressed", !off);
          this.paint();
        });
        this.legend.append(b);
      });
      const box = make("div", { class: "plot-box" });
      box.append(this.svg, this.tip);
      this.frame.append(this.bar, box, this.legend);
      this.frame.classList.add("alive");
      this.svg.addEventListener("pointermove", (e) => this.move(e));
      this.svg.addEventListener("pointerleave", () => this.hover(null));
      this.svg.addEventListener("pointerdown", (e) => this.press(e));
      this.svg.addEventListener("pointerup", (e) => this.release(e));
      this.svg.addEventListener("dblclick", () => this.reset());
      this.svg.addEventListener("wheel", (e) => {
        if (!e.ctrlKey && !e.shiftKey && document.activeElement !== this.svg) return;
        e.preventDefault();
        this.zoom(e.deltaY > 0 ? 1.25 : 0.8, this.at(e));
      }, { passive: false });
      this.svg.addEventListener("keydown", (e) => this.key(e));
    }
    shown() {
      return this.data.series.map((s, k) => ({ s, k })).filter(({ k }) => !this.hidden.has(this.group[k]));
    }
    usable(p) {
      return p.every((v, k) => v !== null && Number.isFinite(v) && (!this.log[k] || v > 0));
    }
    reset() {
      const points = this.data.series.flatMap((s) => s.points.filter((p) => this.usable(p)));
      this.range = [0, 1].map((k) => {
        let low = Infinity, high = -Infinity;
        for (const p of points) { low = Math.min(low, p[k]); high = Math.max(high, p[k]); }
        if (!(low <= high)) [low, high] = this.log[k] ? [1, 10] : [0, 1];
        if (this.log[k]) {
          const room = Math.max((high / low) ** 0.04, 1.1);
          return [low / room, high * room];
        }
        if (k === 1 && low > 0 && low < 0.5 * high) low = 0;
        const span = high > low ? high - low : Math.abs(high) || 1, pad = high > low ? 0.04 : 0.5;
        return [low === 0 && k === 1 ? 0 : low - pad * span, high + pad * span];
      });
      this.paint();
    }
    share(v, k) {
      const [low, high] = this.range[k];
      return this.log[k] ? Math.log(v / low) / Math.log(high / low) : (v - low) / (high - low);
    }
    value(share, k) {
      const [low, high] = this.range[k];
      return this.log[k] ? low * (high / low) ** share : low + share * (high - low);
    }
    place(p) {
      return [LEFT + this.share(p[0], 0) * (RIGHT - LEFT), BOTTOM - this.share(p[1], 1) * (BOTTOM - TOP)];
    }
    paint() {
      const svg = this.svg, id = "clip" + Plot.count++;
      svg.replaceChildren();
      const clip = draw("clipPath", { id });
      clip.append(draw("rect", { x: LEFT, y: TOP - 4, width: RIGHT - LEFT, height: BOTTOM - TOP + 4 }));
      svg.append(clip);
      let grid = "";
      const say = (x, y, anchor, text) => svg.append(draw("text", { x, y, "text-anchor": anchor, fill: "currentColor" }, text));
      for (const v of ticks(...this.range[0], this.log[0], 8)) {
        const x = this.place([v, this.range[1][0]])[0];
        grid += `M${x} ${TOP}V${BOTTOM}`;
        say(x, BOTTOM + 18, "middle", digits(v));
      }
      for (const v of ticks(...this.range[1], this.log[1], 6)) {
        const y = this.place([this.range[0][0], v])[1];
        grid += `M${LEFT} ${y}H${RIGHT}`;
        say(LEFT - 7, y + 4.3, "end", digits(v));
      }
      svg.append(draw("path", { d: grid, stroke: "currentColor", "stroke-opacity": 0.13 }));
      svg.append(draw("path", { d: `M${LEFT} ${TOP}V${BOTTOM}H${RIGHT}`, stroke: "currentColor", "stroke-opacity": 0.6 }));
      const name = (a) => (a.unit ? `${a.label} [${a.unit}]` : a.label);
      say((LEFT + RIGHT) / 2, BOTTOM + 38, "middle", name(this.data.x));
      const y = draw("text", {
        transform: `translate(15 ${(TOP + BOTTOM) / 2}) rotate(-90)`, "text-anchor": "middle", fill: "currentColor",
      }, name(this.data.y));
      svg.append(y);
      const body = draw("g", { "clip-path": `url(#${id})` });
      for (const { s } of this.shown()) this.series(body, s);
      svg.append(body);
      this.box = draw("rect", { class: "zoom-box", visibility: "hidden" });
      this.dot = draw("circle", { r: 6, class: "hover-dot", visibility: "hidden" });
      svg.append(this.box, this.dot);
    }
    series(body, s) {
      const line = s.style === "Line" || s.style === "Dashed";
      let path = "", down = false, bars = "", marks = "", rings = "", crosses = "";
      s.points.forEach((p, i) => {
        if (!this.usable(p)) { down = false; return; }
        const [x, y] = this.place(p).map((v) => Math.round(v * 10) / 10);
        if (line) path += `${down ? "L" : "M"}${x} ${y}`;
        down = true;
        const e = s.errors[i];
        if (e) {
          const ends = [p[1] - e, p[1] + e].map((v) => (this.log[1] && v <= 0 ? BOTTOM : this.place([p[0], v])[1]));
          bars += `M${x} ${ends[0]}V${ends[1]}M${x - 3} ${ends[0]}h6M${x - 3} ${ends[1]}h6`;
        }
        if (s.style === "Dots") marks += `M${x - 3.4} ${y}a3.4 3.4 0 1 0 6.8 0a3.4 3.4 0 1 0 -6.8 0z`;
        if (s.style === "Triangles") marks += `M${x} ${y - 4.5}l4 7h-8z`;
        if (s.style === "Circles") rings += `M${x - 3.4} ${y}a3.4 3.4 0 1 0 6.8 0a3.4 3.4 0 1 0 -6.8 0z`;
        if (s.style === "Crosses") crosses += `M${x - 3.5} ${y - 3.5}l7 7m0 -7l-7 7`;
      });
      const add = (d, attributes) => d && body.append(draw("path", { d, ...attributes }));
      add(path, { stroke: s.colour, "stroke-width": 1.8, "stroke-linejoin": "round", "stroke-dasharray": s.style === "Dashed" ? "6 4" : "none" });
      add(bars, { stroke: s.colour, "stroke-width": 1.2 });
      add(marks, { fill: s.colour });
      add(rings, { stroke: s.colour, "stroke-width": 1.5 });
      add(crosses, { stroke: s.colour, "stroke-width": 1.6 });
    }
    at(event) {
      const r = this.svg.getBoundingClientRect();
      return [((event.clientX - r.left) / r.width) * WIDTH, ((event.clientY - r.top) / r.height) * HEIGHT];
    }
    inside(at) {
      return [(at[0] - LEFT) / (RIGHT - LEFT), (BOTTOM - at[1]) / (BOTTOM - TOP)].map((s) => Math.min(1, Math.max(0, s)));
    }
    zoom(factor, at) {
      const about = at ? this.inside(at) : [0.5, 0.5];
      this.frameTo([0, 1].map((k) => [0, 1].map((end) => this.value(about[k] + (end - about[k]) * factor, k))));
    }
    frameTo(range) {
      if (range.some(([a, b], k) => !(b > a) || !Number.isFinite(a) || !Number.isFinite(b) || (this.log[k] && a <= 0))) return;
      if (range.some(([a, b]) => b - a < 1e-12 * Math.max(Math.abs(a), Math.abs(b)))) return;
      this.range = range;
      this.paint();
    }
    press(event) {
      if (event.button !== 0 || event.pointerType === "touch") return;
      this.start = this.at(event);
      this.svg.setPointerCapture(event.pointerId);
    }
    move(event) {
      const at = this.at(event);
      if (this.start) {
        const [a, b] = [this.start, at].map((p) => [Math.min(RIGHT, Math.max(LEFT, p[0])), Math.min(BOTTOM, Math.max(TOP, p[1]))]);
        const set = { x: Math.min(a[0], b[0]), y: Math.min(a[1], b[1]), width: Math.abs(a[0] - b[0]), height: Math.abs(a[1] - b[1]), visibility: "visible" };
        for (const [key, value] of Object.entries(set)) this.box.setAttribute(key, value);
        return;
      }
      this.hover(this.nearest(at));
    }
    release(event) {
      const start = this.start;
      this.start = null;
      this.box.setAttribute("visibility", "hidden");
      if (!start) return;
      const [a, b] = [this.inside(start), this.inside(this.at(event))];
      if (Math.abs(a[0] - b[0]) < 0.01 || Math.abs(a[1] - b[1]) < 0.01) return;
      this.frameTo([0, 1].map((k) => [Math.min(a[k], b[k]), Math.max(a[k], b[k])].map((s) => this.value(s, k))));
    }
    points() {
      const found = [];
      for (const { s, k } of this.shown())
        s.points.forEach((p, i) => {
          if (!this.usable(p)) return;
          const at = this.place(p);
          if (at[0] >= LEFT - 1 && at[0] <= RIGHT + 1 && at[1] >= TOP - 5 && at[1] <= BOTTOM + 1) found.push({ s, k, i, p, at });
        });
      return found;
    }
    nearest(at) {
      let best = null, least = 40 ** 2;
      for (const point of this.points()) {
        const d = (point.at[0] - at[0]) ** 2 + (point.at[1] - at[1]) ** 2;
        if (d < least) [best, least] = [point, d];
      }
      return best;
    }
    hover(point) {
      this.current = point;
      if (!point) {
        this.dot.setAttribute("visibility", "hidden");
        this.tip.textContent = "";
        this.tip.classList.remove("on");
        return;
      }
      this.dot.setAttribute("cx", point.at[0]);
      this.dot.setAttribute("cy", point.at[1]);
      this.dot.setAttribute("stroke", point.s.colour);
      this.dot.setAttribute("visibility", "visible");
      const named = this.data.series.slice(0, point.k + 1).reverse().find((s) => s.label);
      const e = point.s.errors[point.i];
      const unit = (a) => (a.unit ? " " + a.unit : "");
      this.tip.textContent = `${named ? named.label + ": " : ""}${this.data.x.label} ${digits(point.p[0])}${unit(this.data.x)}, ` +
        `${this.data.y.label} ${digits(point.p[1])}${e ? " ± " + digits(e) : ""}${unit(this.data.y)}`;
      this.tip.classList.add("on");
    }
    key(event) {
      const pan = { ArrowLeft: [-0.1, 0], ArrowRight: [0.1, 0], ArrowUp: [0, 0.1], ArrowDown: [0, -0.1] }[event.key];
      if (pan) this.frameTo([0, 1].map((k) => [0, 1].map((end) => this.value(end + pan[k], k))));
      else if (event.key === "+" || event.key === "=") this.zoom(0.8);
      else if (event.key === "-") this.zoom(1.25);
      else if (event.key === "0" || event.key === "Home") this.reset();
      else if (event.key === "[" || event.key === "]") {
        const points = this.points();
        if (!points.length) return;
        const now = this.current ? points.findIndex((p) => p.k === this.current.k && p.i === this.current.i) : -1;
        const next = event.key === "]" ? now + 1 : now < 0 ? points.length - 1 : now - 1 + points.length;
        this.hover(points[next % points.length]);
      } else if (event.key === "Escape") this.hover(null);
      else return;
      event.preventDefault();
    }
  }
  Plot.count = 0;

  // Plots far down the page are built when they come near: a page of many opens at once.
  const frames = all(".plot[data-plot]");
  if ("IntersectionObserver" in window) {
    const watch = new IntersectionObserver((seen) => seen.filter((s) => s.isIntersecting).forEach((s) => {
      watch.unobserve(s.target);
      new Plot(s.target);
    }), { rootMargin: "800px" });
    frames.forEach((f) => watch.observe(f));
  } else frames.forEach((f) => new Plot(f));

  // --- pictures over time ---

  const slider = (gallery) => {
    const figures = all("figure", gallery);
    const groups = new Map();
    for (const f of figures) {
      const g = f.dataset.group;
      groups.set(g, [...(groups.get(g) || []), f]);
    }
    const most = Math.max(...[...groups.values()].map((g) => g.length));
    if (most < 2) return;
    const bar = make("div", { class: "plot-bar" });
    const one = make("button", { type: "button", "aria-pressed": "false" }, "one by one");
    const range = make("input", { type: "range", min: 0, max: most - 1, value: 0, step: 1, "aria-label": "which picture" });
    const word = make("span", { class: "quiet" });
    const show = () => {
      const on = one.getAttribute("aria-pressed") === "true";
      range.hidden = word.hidden = !on;
      for (const group of groups.values())
        group.forEach((f, k) => (f.hidden = on && k !== Math.min(range.valueAsNumber, group.length - 1)));
      const first = [...groups.values()][0];
      const caption = first[Math.min(range.valueAsNumber, first.length - 1)].querySelector("figcaption");
      word.textContent = `${range.valueAsNumber + 1} of ${most}: ${caption.querySelector(".which").textContent.trim()}`;
    };
    one.addEventListener("click", () => {
      one.setAttribute("aria-pressed", one.getAttribute("aria-pressed") !== "true");
      show();
    });
    range.addEventListener("input", show);
    bar.append(one, range, word);
    gallery.before(bar);
    show();
  };
  all(".pictures").forEach(slider);

  // Pictures of two steps beside each other, as of the paper's choices and the best known.
  const steps = all("section[data-step]").filter((s) => s.querySelector("figure img"));
  if (steps.length > 1) {
    const box = make("section", { id: "beside" });
    box.append(make("h2", {}, "Side by side"));
    const bar = make("div", { class: "plot-bar" }), panes = make("div", { class: "pictures few" });
    const range = make("input", { type: "range", min: 0, max: 0, value: 0, step: 1, "aria-label": "which picture of both" });
    const choose = [0, 1].map((k) => {
      const s = make("select", { "aria-label": k ? "right" : "left" });
      steps.forEach((step, i) => s.append(make("option", { value: i }, step.querySelector("h2").textContent)));
      s.value = Math.min(k, steps.length - 1);
      s.addEventListener("change", () => show());
      bar.append(s);
      return s;
    });
    const show = () => {
      const found = choose.map((s) => all(".pictures figure", steps[s.value]));
      range.max = Math.max(...found.map((f) => f.length)) - 1;
      panes.replaceChildren(...found.map((f) => {
        const copy = f[Math.min(range.valueAsNumber, f.length - 1)].cloneNode(true);
        copy.hidden = false;
        return copy;
      }));
    };
    range.addEventListener("input", show);
    bar.append(range);
    box.append(bar, panes);
    document.querySelector("header").after(box);
    show();
  }

  // --- where a number comes from ---

  const study = JSON.parse(document.getElementById("study").textContent);
  const dialog = make("dialog", { "aria-label": "Where it comes from" });
  document.body.append(dialog);
  const provenance = (cell) => {
    const step = study.steps[cell.closest("[data-step]").dataset.step];
    const row = cell.closest("[data-point]");
    const point = step.points[row ? row.dataset.point : 0];
    const table = cell.closest("table");
    const list = make("dl");
    const add = (name, value) => value && list.append(make("dt", {}, name), make("dd", {}, value));
    if (cell.tagName === "TD") {
      const head = table.tHead && table.tHead.rows[0].cells[cell.cellIndex];
      const first = cell.parentElement.cells[0].textContent.trim();
      const label = row && row.tagName === "TR" && head ? head.firstChild.textContent : [first, head && head.firstChild.textContent].filter(Boolean).join(", ");
      add("number", label + ": " + (cell.dataset.full || cell.textContent.trim()));
    }
    add("step", step.name + (point && point.label ? " · " + point.label : ""));
    add("stage", step.stage + ": " + step.summary);
    if (point) {
      add("came", point.state + (point.time ? ", computed in " + point.time : ""));
      add("key", point.key);
    }
    add("made of", step.needs.join(", "));
    add("parameters", (point && point.swept ? point.swept + "; " : "") + step.params.map((p) => p.join(" = ")).join("; "));
    add("asked by", study.command);
    const close = make("button", { type: "button" }, "close");
    close.addEventListener("click", () => dialog.close());
    dialog.replaceChildren(make("h3", {}, "Where it comes from"), list, close);
    dialog.showModal();
  };
  document.addEventListener("click", (event) => {
    if (event.target === dialog) return dialog.close();
    const cell = event.target.closest("[data-step] td.number, [data-step] .origin");
    if (cell && String(window.getSelection()) === "") provenance(cell);
  });

  // --- light and dark ---

  const theme = make("button", { type: "button", class: "theme" }, "light / dark");
  theme.addEventListener("click", () => {
    const dark = getComputedStyle(document.documentElement).getPropertyValue("--dark").trim() === "1";
    document.documentElement.dataset.theme = dark ? "light" : "dark";
  });
  document.querySelector("header").prepend(theme);
})();

// What animation and curves share: the embedded data; and the page's small conveniences.
"use strict";

const report = (() => {
  const data = JSON.parse(document.getElementById("report-data").textContent);

  const decoded = new Map();
  /** A run's column as numbers; null if the run has none of that name. */
  function column(run, name) {
    if (!(name in run.columns)) return null;
    if (!decoded.has(run)) decoded.set(run, new Map());
    const columns = decoded.get(run);
    if (!columns.has(name)) columns.set(name, unpack(run.columns[name]));
    return columns.get(name);
  }

  /** When the longest run of a test ends, s. */
  function endOf(test) {
    return Math.max(...test.runs.map((run) => column(run, "t").at(-1)));
  }

  /** Calls f once, as soon as the element comes near the visible part of the page. */
  function whenNear(element, f) {
    const observer = new IntersectionObserver(
      (entries) => {
        if (!entries.some((entry) => entry.isIntersecting)) return;
        observer.disconnect();
        f();
      },
      { rootMargin: "300px" },
    );
    observer.observe(element);
  }

  /** A new element with attributes and children; children that are strings become text. */
  function make(tag, attributes = {}, ...children) {
    const element = document.createElement(tag);
    for (const [name, value] of Object.entries(attributes)) element.setAttribute(name, value);
    element.append(...children);
    return element;
  }

  /** A line as the law draws it. */
  function swatch(style) {
    const svg = document.createElementNS("http://www.w3.org/2000/svg", "svg");
    const line = document.createElementNS(svg.namespaceURI, "line");
    const set = (node, values) => {
      for (const [name, value] of Object.entries(values)) node.setAttribute(name, value);
    };
    set(svg, { class: "swatch", viewBox: "0 0 30 8", width: 30, height: 8, "aria-hidden": "true" });
    set(line, {
      x1: 0, y1: 4, x2: 30, y2: 4, stroke: style.color, "stroke-width": 2.5,
      "stroke-dasharray": style.dashes.join(" "),
    });
    svg.append(line);
    return svg;
  }

  return { data, column, endOf, whenNear, make, swatch };
})();

// Navigation: mark the section being read.
{
  const links = [...document.querySelectorAll("nav a")];
  const sections = links.map((link) => document.querySelector(link.getAttribute("href")));
  const mark = () => {
    const reading = window.innerHeight * 0.3;
    let current = 0;
    sections.forEach((section, k) => {
      if (section.getBoundingClientRect().top <= reading) current = k;
    });
    links.forEach((link, k) => {
      const was = link.hasAttribute("aria-current");
      if (k !== current) link.removeAttribute("aria-current");
      else if (!was) {
        link.setAttribute("aria-current", "true");
        const bar = link.parentElement;
        bar.scrollTo({ left: link.offsetLeft - bar.clientWidth / 2 + link.offsetWidth / 2 });
      }
    });
  };
  let waiting = false;
  const later = () => {
    if (waiting) return;
    waiting = true;
    requestAnimationFrame(() => {
      waiting = false;
      mark();
    });
  };
  addEventListener("scroll", later, { passive: true });
  addEventListener("resize", later);
  mark();
}

// Commands: copy to the clipboard.
for (const button of document.querySelectorAll(".copy")) {
  if (!navigator.clipboard) break;
  button.hidden = false;
  button.addEventListener("click", async () => {
    const code = button.parentElement.querySelector("code");
    try {
      await navigator.clipboard.writeText(code.textContent);
      button.textContent = "Copied";
    } catch {
      getSelection().selectAllChildren(code);
      button.textContent = "Selected";
    }
    setTimeout(() => (button.textContent = "Copy"), 1600);
  });
}

// Figures: enlarge.
{
  const box = document.getElementById("lightbox");
  const enlarged = box.querySelector("img");
  const buttons = [...document.querySelectorAll(".enlarge")];
  let shown = 0;
  const show = (k) => {
    shown = (k + buttons.length) % buttons.length;
    const image = buttons[shown].querySelector("img");
    enlarged.src = image.src;
    enlarged.alt = image.alt;
    const caption = buttons[shown].parentElement.querySelector("figcaption");
    box.querySelector("p").textContent = caption.textContent;
    if (!box.open) box.showModal();
  };
  buttons.forEach((button, k) => button.addEventListener("click", () => show(k)));
  for (const button of box.querySelectorAll("[data-step]")) {
    button.addEventListener("click", () => show(shown + Number(button.dataset.step)));
  }
  box.addEventListener("keydown", (event) => {
    if (event.key === "ArrowLeft") show(shown - 1);
    if (event.key === "ArrowRight") show(shown + 1);
  });
  box.addEventListener("click", (event) => {
    if (event.target === box || event.target === enlarged) box.close();
  });
  box.querySelector("[data-close]").addEventListener("click", () => box.close());
}

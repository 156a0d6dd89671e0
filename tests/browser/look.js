// What a reader would see, told to the test: each function returns a list of complaints.
({
  name(element) {
    const heading = element.closest("section, body").querySelector("h2, h1");
    const words = element.textContent.trim().replace(/\s+/g, " ").slice(0, 60);
    return `<${element.tagName.toLowerCase()} class="${element.getAttribute("class") || ""}"> '${words}' (${heading ? heading.textContent : "no heading"})`;
  },

  open(wanted) {
    document.querySelectorAll("details").forEach(details => { details.open = wanted; });
  },

  seen(element) {
    return element.checkVisibility({ visibilityProperty: true, opacityProperty: true });
  },

  // Tables and pictures that are not there or have no size.
  sizes() {
    const found = [];
    const wanted = [...document.querySelectorAll("table, svg, img, canvas")].filter(of => !of.parentElement.closest("svg"));
    for (const element of wanted) {
      const box = element.getBoundingClientRect();
      if (!this.seen(element) || box.width < 1 || box.height < 1) { found.push(`no size: ${this.name(element)}`); }
      if (element.tagName === "IMG" && !(element.complete && element.naturalWidth)) { found.push(`no picture: ${element.src}`); }
    }
    return found;
  },

  // What sticks out of the window sideways. A box that scrolls may hold more than it shows; one that hides it may not.
  overflow() {
    const found = [], root = document.scrollingElement, width = document.documentElement.clientWidth;
    if (root.scrollWidth > innerWidth) { found.push(`the page is ${root.scrollWidth} px wide in a window of ${innerWidth} px`); }
    for (const element of document.body.querySelectorAll("*:not(svg *)")) {
      if (!this.seen(element)) { continue; }
      const style = getComputedStyle(element), box = element.getBoundingClientRect();
      const hides = ["hidden", "clip"].includes(style.overflowX) && !["svg", "INPUT"].includes(element.tagName);
      if (hides && element.scrollWidth > element.clientWidth + 1) { found.push(`cut off: ${this.name(element)}`); }
      if (box.right <= width + 1 && box.left >= -1) { continue; }
      let inside = element.parentElement;
      while (inside && !["auto", "scroll"].includes(getComputedStyle(inside).overflowX)) { inside = inside.parentElement; }
      if (!inside) { found.push(`sticks out: ${this.name(element)}`); }
    }
    // Three columns can be read without scrolling on any screen.
    for (const table of document.querySelectorAll(".scroll > table")) {
      const [row, box] = [table.rows[0], table.parentElement];
      if (this.seen(table) && row.cells.length <= 3 && box.scrollWidth > box.clientWidth + 1) { found.push(`scrolls: ${this.name(table)}`); }
    }
    return found;
  },

  colour(words) {
    const numbers = words.match(/^rgba?\(([^)]*)\)$/);
    if (!numbers) { throw new Error(`a colour that is not understood: ${words}`); }
    const [red, green, blue, alpha = 1] = numbers[1].split(/[\s,/]+/).map(Number);
    return [red, green, blue, alpha];
  },

  over(top, below) {
    return [0, 1, 2].map(at => top[at] * top[3] + below[at] * (1 - top[3])).concat(1);
  },

  // What is painted under an element, from the window's own white up.
  background(element) {
    const below = element.parentElement ? this.background(element.parentElement) : [255, 255, 255, 1];
    return this.over(this.colour(getComputedStyle(element).backgroundColor), below);
  },

  luminance(colour) {
    const [red, green, blue] = colour.slice(0, 3).map(of => of / 255).map(of => of <= 0.04045 ? of / 12.92 : ((of + 0.055) / 1.055) ** 2.4);
    return 0.2126 * red + 0.7152 * green + 0.0722 * blue;
  },

  // Words whose colour is too near to that of what they stand on: WCAG's ratio for ordinary text.
  contrast(least) {
    const found = new Set(), walker = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
    let words = 0;
    while (walker.nextNode()) {
      const element = walker.currentNode.parentElement;
      if (!walker.currentNode.textContent.trim() || element.closest("script, style, title, desc") || !this.seen(element)) { continue; }
      words += 1;
      const style = getComputedStyle(element), below = this.background(element);
      const ink = this.over(this.colour(element.closest("svg") ? style.fill : style.color), below);
      const [dark, light] = [this.luminance(ink), this.luminance(below)].sort((a, b) => a - b);
      const ratio = (light + 0.05) / (dark + 0.05);
      if (ratio < least) { found.add(`contrast ${ratio.toFixed(2)}: ${this.name(element)}`); }
    }
    if (words < 3) { found.add(`only ${words} pieces of text were seen`); }
    return [...found];
  },

  // On paper nothing can be opened, scrolled or typed.
  print() {
    const found = [];
    for (const element of document.querySelectorAll("details td, details th, details p:not(.files), details figure")) {
      if (!element.checkVisibility()) { found.push(`not printed: ${this.name(element)}`); }
    }
    for (const element of document.querySelectorAll("input, button:not(th button)")) {
      if (element.checkVisibility()) { found.push(`of no use on paper: ${this.name(element)}`); }
    }
    for (const table of document.querySelectorAll("table")) {
      if (table.getBoundingClientRect().right > innerWidth + 1) { found.push(`cut off by the paper's edge: ${this.name(table)}`); }
    }
    return found;
  },

  // What makes a page hard to walk through for one who does not see it, or has no mouse.
  structure() {
    const found = [], root = document.documentElement, levels = [...document.querySelectorAll("h1, h2, h3, h4, h5, h6")];
    if (!root.lang) { found.push("no language"); }
    if (!document.title.trim()) { found.push("no title"); }
    for (const [selector, what] of [["h1", "first heading"], ["main", "main part"]]) {
      const count = document.querySelectorAll(selector).length;
      if (count !== 1) { found.push(`${count} times a ${what}`); }
    }
    levels.map(of => Number(of.tagName[1])).forEach((level, at, all) => {
      if (level > (at ? all[at - 1] : 0) + 1) { found.push(`a level of headings is left out: ${this.name(levels[at])}`); }
    });
    const ids = [...document.querySelectorAll("[id]")].map(of => of.id);
    for (const id of ids.filter((id, at) => ids.indexOf(id) !== at)) { found.push(`twice the id ${id}`); }
    for (const of of document.querySelectorAll("th:not([scope])")) { found.push(`a heading of what? ${this.name(of)}`); }
    for (const of of document.querySelectorAll("[tabindex]")) {
      if (of.tabIndex > 0) { found.push(`out of turn: ${this.name(of)}`); }
    }
    for (const of of document.querySelectorAll("th.sorts, [onclick]")) {
      if (!of.querySelector("button") && of.tabIndex < 0) { found.push(`only for a mouse: ${this.name(of)}`); }
    }
    return found;
  },

  // Marks the heading of a table that can be sorted by numbers, and its box for typing; one that has such a box if there is any.
  tableToUse() {
    let best = null;
    for (const table of document.querySelectorAll("table")) {
      const before = table.parentElement.previousElementSibling;
      const input = before && before.querySelector("input[type=search]");
      const rows = [...table.rows].filter(row => row.querySelector("td"));
      for (const heading of table.querySelectorAll("th.n.sorts")) {
        const values = rows.map(row => row.cells[heading.cellIndex].textContent.trim());
        const plain = values.every(value => value !== "" && !Number.isNaN(Number(value)));
        if (plain && new Set(values).size > 2 && (!best || (input && !best.input))) { best = { table, heading, input }; }
      }
    }
    if (!best) { return null; }
    for (const element of [best.table, best.heading, best.input]) {
      if (element) { element.dataset.tested = ""; }
    }
    return { column: best.heading.cellIndex, filter: Boolean(best.input) };
  },

  // Links into the page that lead nowhere, and the addresses of all others.
  links() {
    const all = [...document.querySelectorAll("a[href]")].map(link => link.getAttribute("href"));
    const lost = all.filter(to => to.startsWith("#") && !document.getElementById(to.slice(1)));
    return { lost, others: all.filter(to => !to.startsWith("#")) };
  },

  rowsShown() {
    const rows = [...document.querySelectorAll("table[data-tested] tr")].filter(row => row.querySelector("td") && row.checkVisibility());
    return rows.map(row => [...row.cells].map(cell => cell.textContent.trim()));
  },

  // Where the first element is whose words begin so, from the window's top, px; null if it cannot be seen.
  top(selector, words) {
    window.scrollTo(0, 0);
    for (const element of document.querySelectorAll(selector)) {
      const box = element.getBoundingClientRect();
      const there = box.width > 0 && box.left < innerWidth && this.seen(element);
      if (there && element.textContent.trim().startsWith(words)) { return box.top; }
    }
    return null;
  },
})

"use strict";
// Without this script the page says the same; tables are then as they were written.
(function () {
  var ROWS_TO_FILTER = 12;
  function text(row, column) {
    var cell = row.cells[column];
    return cell ? cell.textContent.trim() : "";
  }
  // Numbers with a sign, decimals and a power of ten before anything else; what has none sorts as words, after the numbers.
  function number(words) {
    var found = words.replace(/[\u2212\u2013]/g, "-").match(/^[^0-9A-Za-z-]*(-?[0-9]+(\.[0-9]+)?(e[-+]?[0-9]+)?)/);
    return found ? parseFloat(found[1]) : null;
  }
  function compare(a, b) {
    var x = number(a), y = number(b);
    if ((x === null) !== (y === null)) { return x === null ? 1 : -1; }
    if (x !== null && x !== y) { return x - y; }
    return a.localeCompare(b);
  }
  function sort(table, heading, rows) {
    var column = heading.cellIndex;
    var down = heading.getAttribute("aria-sort") === "ascending";
    table.querySelectorAll("th").forEach(function (other) { other.removeAttribute("aria-sort"); });
    heading.setAttribute("aria-sort", down ? "descending" : "ascending");
    rows.sort(function (a, b) {
      var order = compare(text(a, column), text(b, column));
      return down ? -order : order;
    });
    rows.forEach(function (row) { row.parentNode.appendChild(row); });
  }
  document.querySelectorAll(".scroll > table").forEach(function (table) {
    var rows = Array.from(table.rows).filter(function (row) { return row.querySelector("td"); });
    var headings = Array.from(table.rows).filter(function (row) { return !row.querySelector("td"); });
    // Rows that span others, and tables with several rows of headings, have an order that means something.
    var plain = headings.length === 1 && !table.querySelector("[rowspan], td[colspan]");
    if (plain && rows.length > 1) {
      Array.from(headings[0].cells).forEach(function (heading) {
        if (!heading.textContent.trim()) { return; }
        var button = document.createElement("button");
        button.type = "button";
        button.title = "sort";
        button.append.apply(button, heading.childNodes);
        heading.appendChild(button);
        heading.classList.add("sorts");
        heading.addEventListener("click", function () { sort(table, heading, rows); });
      });
    }
    if (rows.length >= ROWS_TO_FILTER) {
      var label = document.createElement("label");
      var input = document.createElement("input");
      var count = document.createElement("span");
      label.className = "filter";
      input.type = "search";
      input.placeholder = "show rows with \u2026";
      input.setAttribute("aria-label", "show rows with");
      input.addEventListener("input", function () {
        var wanted = input.value.toLowerCase();
        var shown = rows.filter(function (row) {
          var fits = row.textContent.toLowerCase().indexOf(wanted) >= 0;
          row.classList.toggle("away", !fits);
          return fits;
        });
        count.textContent = wanted ? " " + shown.length + " of " + rows.length : "";
      });
      label.appendChild(input);
      label.appendChild(count);
      table.parentNode.parentNode.insertBefore(label, table.parentNode);
    }
  });
})();

// Elements of the page. Text is set as text, never as markup: names and titles come from files of other people.

function element(space, tag, attributes, children) {
  const node = space ? document.createElementNS(space, tag) : document.createElement(tag);
  for (const [name, value] of Object.entries(attributes || {})) {
    if (value === undefined || value === null || value === false) continue;
    if (name.startsWith("on_")) node.addEventListener(name.slice(3), value);
    else node.setAttribute(name, value === true ? "" : value);
  }
  node.append(...children.flat(Infinity).filter((child) => child !== null && child !== undefined && child !== false));
  return node;
}
const el = (tag, attributes, ...children) => element(null, tag, attributes, children);
const svg = (tag, attributes, ...children) => element("http://www.w3.org/2000/svg", tag, attributes, children);

// A place in a section that is drawn anew whenever one of the named parts of the state changes.
function place(section_id, classes, parts, draw) {
  const node = el("div", { class: classes });
  document.getElementById(section_id).append(node);
  const redraw = () => {
    const content = draw();
    node.replaceChildren(...[content].flat(Infinity).filter((child) => child !== null && child !== undefined && child !== ""));
    node.hidden = node.childNodes.length === 0;
  };
  on_change(parts, redraw);
  redraw();
  return node;
}

// A table; columns are {title, number, cell(row), hint}. Cells give text or elements.
function data_table(columns, rows, options = {}) {
  const heading = (c) => el("th", { scope: "col", class: c.number && "n", title: c.hint }, c.title);
  const cell = (c, row, i) => {
    const content = c.cell(row, i);
    return el(c.head ? "th" : "td", { class: c.number && "n", scope: c.head && "row" }, content ?? "–");
  };
  return el("div", { class: `wrap${options.tall ? " tall" : ""}${options.narrow_heads ? " narrow-heads" : ""}`, tabindex: "0", role: "region",
    "aria-label": options.label || "table" },
    el("table", {}, el("thead", {}, el("tr", {}, columns.map(heading))),
      el("tbody", {}, rows.map((row, i) => el("tr", {}, columns.map((c) => cell(c, row, i)))))));
}

// One of a few: radio buttons that look like one control. options are [value, label] pairs.
let choices = 0;
function choice(label, options, value, on_choose) {
  const name = `choice-${++choices}`;
  return el("fieldset", { class: "choice" }, el("legend", {}, label),
    options.map(([option, text]) => el("label", {},
      el("input", { type: "radio", name, value: option, checked: option === value,
        on_change: () => on_choose(option) }), el("span", {}, text))));
}

function pick(label, options, value, on_choose, attributes = {}) {
  return el("label", { class: "pick" }, el("span", {}, label), " ",
    el("select", { ...attributes, on_change: (event) => on_choose(event.target.value) },
      options.map(([option, text]) => el("option", { value: option, selected: option === value }, text))));
}

const folded = (summary, content, open = false) => el("details", { open }, el("summary", {}, summary), content);

const code = (text) => el("span", { class: "id" }, text);

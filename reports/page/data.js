// The data of the page: unpacked once. Tables keep their fields as text; numbers are made where they are asked for, so
// that an empty field of a failed run stays apart from a zero.

async function unpack(text) {
  if (typeof DecompressionStream === "undefined")
    throw new Error("this browser cannot unpack the tables of the page; it needs to be of 2023 or later");
  const raw = atob(text.trim());
  const bytes = new Uint8Array(raw.length);
  for (let i = 0; i < raw.length; ++i) bytes[i] = raw.charCodeAt(i);
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"));
  return JSON.parse(await new Response(stream).text());
}

// RFC 4180; most tables have no quotes and are split the quick way.
function csv_records(text) {
  if (!text.includes('"')) return text.split("\n").filter((line) => line !== "").map((line) => line.split(","));
  const records = [];
  let record = [], field = "", quoted = false;
  for (let i = 0; i < text.length; ++i) {
    const c = text[i];
    if (quoted) {
      if (c !== '"') field += c;
      else if (text[i + 1] === '"') field += text[++i];
      else quoted = false;
    } else if (c === '"') {
      quoted = true;
    } else if (c === "," || c === "\n") {
      record.push(field);
      field = "";
      if (c === "\n") {
        if (record.length > 1 || record[0] !== "") records.push(record);
        record = [];
      }
    } else if (c !== "\r") {
      field += c;
    }
  }
  if (field !== "" || record.length > 0) records.push([...record, field]);
  return records;
}

class Table {
  constructor(csv) {
    this.csv = csv;
    const [header] = csv_records(csv.slice(0, csv.indexOf("\n") + 1));
    this.column = new Map((header || []).map((name, i) => [name, i]));
    this.groups = new Map();
  }
  // Split when first asked for: the largest tables are needed late.
  get records() {
    this.split ??= csv_records(this.csv).slice(1);
    return this.split;
  }
  get rows() { return this.records.length; }
  has(name) { return this.column.has(name); }
  text(row, name) { return this.records[row][this.column.get(name)] ?? ""; }
  number(row, name) {
    const text = this.text(row, name);
    return text === "" ? NaN : Number(text);
  }
  flag(row, name) { return !["0", "false", "no"].includes(this.text(row, name)); }
  // Rows whose column has this text, in file order.
  where(name, value) {
    if (!this.groups.has(name)) {
      const groups = new Map();
      for (let i = 0; i < this.rows; ++i) {
        const key = this.text(i, name);
        if (!groups.has(key)) groups.set(key, []);
        groups.get(key).push(i);
      }
      this.groups.set(name, groups);
    }
    return this.groups.get(name).get(value) || [];
  }
  // Different texts of a column among rows, in order of appearance.
  values(name, rows = this.records.keys()) {
    const seen = new Set();
    for (const i of rows) seen.add(this.text(i, name));
    return [...seen];
  }
}

const empty_table = new Table("");
let data = null;          // what page_data() of reports/page.cpp wrote
const tables = new Map(); // by file name

function table(name) { return tables.get(name) || empty_table; }

async function read_data() {
  data = await unpack(document.getElementById("data").textContent);
  for (const [name, csv] of Object.entries(data.tables || {})) tables.set(name, new Table(csv));
}

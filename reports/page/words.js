// Numbers and names as a reader wants to see them.

const raised = { "-": "⁻", 0: "⁰", 1: "¹", 2: "²", 3: "³", 4: "⁴", 5: "⁵", 6: "⁶", 7: "⁷", 8: "⁸", 9: "⁹" };
const power_of_ten = (exponent) => "10" + [...String(exponent)].map((c) => raised[c]).join("");

// Three digits, powers of ten raised: 0.02, 3.2·10⁻⁹, 10⁻⁸.
function pretty(value, digits = 3) {
  if (Number.isNaN(value)) return "–";
  if (!Number.isFinite(value)) return value > 0 ? "∞" : "−∞";
  if (value < 0) return "−" + pretty(-value, digits);
  if (value === 0) return "0";
  if (Number.isInteger(value) && value < 1e6) return String(value);
  if (value >= 1e-3 && value < 1e5) return String(Number(value.toPrecision(digits)));
  const [mantissa, exponent] = value.toExponential(digits - 1).split("e");
  const power = power_of_ten(Number(exponent));
  return Number(mantissa) === 1 ? power : `${Number(mantissa)}·${power}`;
}

function pretty_time(seconds) {
  if (!Number.isFinite(seconds)) return "–";
  for (const [size, name] of [[1, "s"], [1e-3, "ms"], [1e-6, "µs"], [1e-9, "ns"]])
    if (seconds >= 0.9995 * size || size === 1e-9) {
      const value = seconds / size;
      return `${value >= 999.5 ? value.toFixed(0) : Number(value.toPrecision(3))}\u00a0${name}`;
    }
  return "–";
}

function pretty_factor(factor) {
  if (!Number.isFinite(factor)) return "–";
  if (factor < 9.95) return String(Number(factor.toPrecision(2)));
  return factor < 9999.5 ? factor.toFixed(0) : pretty(factor);
}

// 1234567 as 1 234 567 with thin spaces.
function pretty_count(value) {
  return Number.isFinite(value) ? String(Math.round(value)).replace(/\B(?=(\d{3})+$)/g, "\u202f") : "–";
}

const counted = (n, noun) => `${n} ${noun}${n === 1 ? "" : "s"}`;

// Not where the solver does not apply, nor where there was no truth to measure it against.
const was_run = (t, i) => !["unsupported", "no_truth"].includes(t.text(i, "outcome"));
const spaced = (name) => name.replaceAll("_", " ");
const sentence_case = (text) => text.charAt(0).toUpperCase() + text.slice(1);

// What a run was told: `64 steps`, `rtol 10⁻⁸`, or nothing to set.
function setting(knob, value) {
  if (!knob || knob === "none" || !Number.isFinite(value)) return "nothing to set";
  return knob === "steps" ? `${pretty_count(value)} steps` : `${knob} ${pretty(value)}`;
}

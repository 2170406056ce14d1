// The style sheet of the page: one column, light and dark, phone and paper, no scripts and no foreign fonts.
#include "reports/page.hpp"

namespace polhode::report {

std::string_view style_sheet() {
  // Figures are drawn on white. In the dark they are inverted and their hues turned back, so that colours
  // keep their meaning and nothing glares.
  return R"css(
:root {
  color-scheme: light dark;
  --paper: #fbfbfa; --card: #ffffff; --ink: #1d2126; --soft: #5b6470; --line: #dfe2e6; --accent: #0b62a4;
  --good: #e3f2ea; --good-ink: #0d5c3a; --fair: #e5eefa; --fair-ink: #174a86; --poor: #fdf0d7; --poor-ink: #7a4b00;
  --bad: #fbe4e2; --bad-ink: #8c1d18; --none: #ecedef; --none-ink: #4a5058;
}
@media (prefers-color-scheme: dark) {
  :root {
    --paper: #14171a; --card: #1b1f23; --ink: #e5e8eb; --soft: #9da7b1; --line: #333a41; --accent: #7cbcf0;
    --good: #16382a; --good-ink: #8fdcb4; --fair: #1a3150; --fair-ink: #a5cbf7; --poor: #43310c; --poor-ink: #f0c878;
    --bad: #4a1d1b; --bad-ink: #f5aaa4; --none: #2a3036; --none-ink: #b3bcc5;
  }
  figure { background: #1b1b1b !important; }
  figure img { filter: invert(0.895) hue-rotate(180deg); }
}
* { box-sizing: border-box; }
html { -webkit-text-size-adjust: 100%; scroll-behavior: smooth; }
body { margin: 0; background: var(--paper); color: var(--ink); line-height: 1.55;
  font: 16px/1.55 system-ui, -apple-system, "Segoe UI", Roboto, "Helvetica Neue", Arial, sans-serif; }
header, main, footer { max-width: 62rem; margin: 0 auto; padding: 0 1.25rem; }
header { padding-top: 3rem; }
h1 { font-size: 2rem; line-height: 1.2; letter-spacing: -0.015em; margin: 0 0 .6rem; text-wrap: balance; }
h2 { font-size: 1.45rem; line-height: 1.25; letter-spacing: -0.01em; margin: 3.2rem 0 .4rem;
  padding-top: 1.2rem; border-top: 1px solid var(--line); }
h3 { font-size: 1.05rem; margin: 2.2rem 0 .5rem; }
p { margin: .5rem 0; max-width: 46rem; }
.lead { font-size: 1.15rem; color: var(--ink); }
.soft, figcaption small, td small, th small { color: var(--soft); }
a { color: var(--accent); text-decoration-thickness: 1px; text-underline-offset: 2px; }
nav { margin: 1.2rem 0 0; display: flex; flex-wrap: wrap; gap: .35rem .9rem; font-size: .95rem; }
code, .id { font: .9em ui-monospace, "SFMono-Regular", Menlo, Consolas, "DejaVu Sans Mono", monospace; }
.id { white-space: nowrap; }
.wrap { overflow-x: auto; margin: .8rem 0 1rem; border: 1px solid var(--line); border-radius: 10px;
  background: var(--card); }
table { border-collapse: collapse; width: 100%; font-size: .92rem; font-variant-numeric: tabular-nums; }
th, td { text-align: left; padding: .5rem .8rem; vertical-align: top; border-top: 1px solid var(--line); }
thead th { border-top: 0; font-weight: 600; color: var(--soft); white-space: nowrap; }
tbody th { font-weight: 600; }
tbody th .id { font-weight: 400; }
td.n, th.n { text-align: right; white-space: nowrap; }
td strong { white-space: nowrap; }
td small, th small { display: block; font-weight: 400; font-size: .85em; }
figure { margin: 1.4rem 0 2.2rem; padding: .9rem; border: 1px solid var(--line); border-radius: 12px;
  background: var(--card); }
figure img { display: block; width: 100%; height: auto; border-radius: 6px; }
figcaption { padding: .8rem .3rem 0; max-width: 48rem; }
figcaption small { display: block; margin-top: .2rem; font-size: .85rem; }
.badge { display: inline-block; padding: .05rem .5rem; border-radius: 99px; font-size: .86em; white-space: nowrap;
  background: var(--none); color: var(--none-ink); }
.good { background: var(--good); color: var(--good-ink); } .fair { background: var(--fair); color: var(--fair-ink); }
.poor { background: var(--poor); color: var(--poor-ink); } .bad { background: var(--bad); color: var(--bad-ink); }
dl.facts { display: flex; flex-wrap: wrap; gap: .3rem 1.8rem; margin: .6rem 0 0; font-size: .92rem; }
dl.facts div { display: flex; gap: .45rem; } dl.facts dt { color: var(--soft); } dl.facts dd { margin: 0; }
details { margin: .7rem 0; } summary { cursor: pointer; font-weight: 600; padding: .2rem 0; }
.note { border-left: 4px solid var(--poor-ink); background: var(--poor); color: var(--poor-ink);
  padding: .6rem .9rem; border-radius: 6px; }
footer { padding-bottom: 4rem; font-size: .92rem; }
footer dl { display: grid; grid-template-columns: max-content 1fr; gap: .15rem 1.2rem; }
footer dt { color: var(--soft); } footer dd { margin: 0; overflow-wrap: anywhere; }
@media (max-width: 40rem) {
  header { padding-top: 1.6rem; } h1 { font-size: 1.55rem; } figure { padding: .4rem; margin-inline: -.6rem; }
  .scroll { overflow-x: auto; } .scroll img { min-width: 40rem; }
  footer dl { grid-template-columns: 1fr; } footer dd { margin-bottom: .4rem; }
}
@media print {
  :root { --paper: #fff; --card: #fff; --ink: #000; --soft: #444; --line: #bbb; --accent: #000;
    --good: #fff; --fair: #fff; --poor: #fff; --bad: #fff; --none: #fff; --good-ink: #000; --fair-ink: #000;
    --poor-ink: #000; --bad-ink: #000; --none-ink: #000; }
  body { font-size: 10pt; } header, main, footer { max-width: none; padding: 0; } nav { display: none; }
  figure { background: #fff !important; } figure img { filter: none; } .wrap { overflow: visible; } table { font-size: 8.5pt; }
  figure { margin: .6rem 0; padding: .4rem; } figure img { max-width: 14.5cm; margin: 0 auto; }
  figure, tr { break-inside: avoid; } h2, h3 { break-after: avoid; } .scroll img { min-width: 0; }
}
)css";
}

}  // namespace polhode::report

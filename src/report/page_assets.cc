#include "report/page_assets.h"

namespace colmap_ext {

const char* const kPageStyle = R"css(
:root { color-scheme: light dark; --page: #f4f6f8; --card: #ffffff; --ink: #1b2530; --soft: #5a6775;
  --line: #dde3e9; --accent: #0b62a4; --covered: #5cbd85; --uncovered: #db422e; --ignored: #85a8e6;
  --s1: #0b62a4; --s2: #b4560b; --s3: #4f7a28; }
@media (prefers-color-scheme: dark) {
  :root { --page: #12171d; --card: #1b222a; --ink: #e7ecf1; --soft: #9aa7b4; --line: #2f3944;
    --accent: #6cb4ee; --s1: #6cb4ee; --s2: #f0a35e; --s3: #9ccc70; } }
* { box-sizing: border-box; }
body { margin: 0; background: var(--page); color: var(--ink);
  font: 15px/1.5 system-ui, -apple-system, "Segoe UI", Roboto, "DejaVu Sans", sans-serif; }
main, header { max-width: 1500px; margin: 0 auto; padding: 0 24px; }
header { padding-top: 32px; padding-bottom: 8px; }
h1 { font-size: 26px; line-height: 1.25; margin: 0 0 4px; overflow-wrap: anywhere; }
h2 { font-size: 18px; margin: 0; }
.soft { color: var(--soft); margin: 0; }
section { background: var(--card); border: 1px solid var(--line); border-radius: 12px;
  padding: 20px; margin: 18px 0; }
section > h2 { margin-bottom: 12px; }
.tiles { display: grid; grid-template-columns: repeat(auto-fit, minmax(150px, 1fr)); gap: 14px;
  margin: 18px 0; }
.tile { background: var(--card); border: 1px solid var(--line); border-radius: 12px;
  padding: 14px 18px; }
.tile b { display: block; font-size: 25px; font-weight: 600; line-height: 1.3;
  font-variant-numeric: tabular-nums; }
.tile span { color: var(--soft); font-size: 13px; }
.charts { display: grid; grid-template-columns: repeat(auto-fit, minmax(min(100%, 320px), 1fr));
  gap: 24px; }
.charts h3 { font-size: 14px; font-weight: 600; margin: 0 0 4px; }
svg.chart { width: 100%; max-width: 560px; height: auto; display: block; }
.chart .grid { stroke: var(--line); }
.chart text { fill: var(--soft); font-size: 12px; }
.chart path { fill: none; stroke-width: 2.5; stroke-linejoin: round; stroke-linecap: round; }
.chart circle { stroke: var(--card); stroke-width: 1.5; }
.series-1 path { stroke: var(--s1); } .series-1 circle, .chart .series-1 text { fill: var(--s1); }
.series-2 path { stroke: var(--s2); stroke-dasharray: 7 5; }
.series-2 circle, .chart .series-2 text { fill: var(--s2); }
.series-3 path { stroke: var(--s3); stroke-dasharray: 2 5; }
.series-3 circle, .chart .series-3 text { fill: var(--s3); }
.scroll { overflow-x: auto; }
table { border-collapse: collapse; width: 100%; font-variant-numeric: tabular-nums; }
th, td { text-align: right; padding: 7px 9px; }
td { white-space: nowrap; }
th { color: var(--soft); font-weight: 500; font-size: 13px; border-bottom: 1px solid var(--line);
  vertical-align: bottom; }
tbody tr + tr td { border-top: 1px solid var(--line); }
td:first-child, th:first-child { text-align: left; }
.head { display: flex; flex-wrap: wrap; gap: 6px 18px; align-items: baseline; margin-bottom: 14px; }
.pictures { display: grid; gap: 16px;
  grid-template-columns: repeat(auto-fit, minmax(min(100%, 380px), 1fr)); }
figure { margin: 0; }
figure button { all: unset; display: block; width: 100%; cursor: zoom-in; border-radius: 8px;
  overflow: hidden; border: 1px solid var(--line); background: #e6eaee; }
figure button:focus-visible { outline: 3px solid var(--accent); outline-offset: 2px; }
figure img { display: block; width: 100%; aspect-ratio: 16 / 10; object-fit: contain; }
figcaption { color: var(--soft); font-size: 13px; padding-top: 5px; }
.legend { display: flex; flex-wrap: wrap; gap: 4px 20px; font-size: 13px; color: var(--soft);
  margin: 12px 0 0; padding: 0; list-style: none; }
.legend i { display: inline-block; width: 12px; height: 12px; border-radius: 3px;
  margin-right: 7px; vertical-align: -1px; }
.legend i.covered { background: var(--covered); } .legend i.uncovered { background: var(--uncovered); }
.legend i.ignored { background: var(--ignored); }
nav { position: sticky; top: 0; z-index: 2; background: var(--page); padding: 10px 0;
  display: flex; flex-wrap: wrap; gap: 6px; align-items: center; }
nav button { font: inherit; font-size: 14px; color: var(--ink); background: var(--card);
  border: 1px solid var(--line); border-radius: 999px; padding: 3px 14px; cursor: pointer; }
nav button[aria-pressed=true] { background: var(--accent); border-color: var(--accent);
  color: var(--card); }
nav button:focus-visible { outline: 3px solid var(--accent); outline-offset: 2px; }
details { margin-top: 14px; } summary { cursor: pointer; }
.names { columns: 4 220px; margin: 8px 0 0; padding-left: 20px; font-size: 13px;
  overflow-wrap: anywhere; }
dialog { border: 0; padding: 0; margin: auto; background: transparent; max-width: 97vw;
  max-height: 97vh; color: #fff; text-align: center; }
dialog::backdrop { background: rgba(8, 12, 16, .92); }
dialog img { display: block; max-width: 97vw; max-height: calc(97vh - 64px); border-radius: 6px; }
dialog p { margin: 8px 0 0; } dialog small { opacity: .75; }
@media (max-width: 600px) { main, header { padding-left: 12px; padding-right: 12px; }
  section { padding: 14px; } h1 { font-size: 21px; } }
@media print { nav, dialog { display: none; } section { break-inside: avoid; } }
)css";

const char* const kPageScript = R"js(
'use strict';
const sections = [...document.querySelectorAll('section[data-iteration]')];
const tabs = [...document.querySelectorAll('nav button')];
function show(name) {
  for (const tab of tabs) tab.setAttribute('aria-pressed', String(tab.dataset.show === name));
  for (const section of sections) section.hidden = name !== 'all' && section.dataset.iteration !== name;
}
for (const tab of tabs) tab.addEventListener('click', () => show(tab.dataset.show));

const dialog = document.querySelector('dialog');
const large = dialog.querySelector('img');
const caption = dialog.querySelector('p');
let current = null;
function open(figure) {
  if (!figure) return;
  current = figure;
  const section = figure.closest('section');
  large.src = figure.querySelector('img').src;
  large.alt = figure.querySelector('img').alt;
  caption.textContent = section.querySelector('h2').textContent + ': ' +
    figure.querySelector('figcaption').textContent;
  if (!dialog.open) dialog.showModal();
}
for (const figure of document.querySelectorAll('figure')) {
  figure.querySelector('button').addEventListener('click', () => open(figure));
}
function step(picture, iteration) {
  const section = current.closest('section');
  if (picture) {
    const figures = [...section.querySelectorAll('figure')];
    return figures[figures.indexOf(current) + picture];
  }
  const other = sections[sections.indexOf(section) + iteration];
  return other && [...other.querySelectorAll('figure')]
    .find(figure => figure.dataset.kind === current.dataset.kind);
}
dialog.addEventListener('keydown', event => {
  const steps = { ArrowRight: [1, 0], ArrowLeft: [-1, 0], ArrowDown: [0, 1], ArrowUp: [0, -1] };
  if (!(event.key in steps)) return;
  event.preventDefault();
  open(step(...steps[event.key]));
});
dialog.addEventListener('click', () => dialog.close());
)js";

}  // namespace colmap_ext

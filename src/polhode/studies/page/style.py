"""How the page of all studies looks."""

STYLE = """
:root { font: 16px/1.5 system-ui, "Segoe UI", Roboto, sans-serif; color: #1b1b1b; }
body { max-width: 80rem; margin: 0 auto; padding: 1rem; background: #fff; }
h1 { font-size: 1.6rem; line-height: 1.2; }
h2 { font-size: 1.3rem; line-height: 1.25; margin-top: 3rem; border-top: 2px solid #0072b2;
     padding-top: .6rem; }
h3 { font-size: 1.05rem; margin: 1.2rem 0 .3rem; }
p, li, figcaption { max-width: 46rem; overflow-wrap: anywhere; }
a { color: #005a9c; }
code { font: .9em ui-monospace, "DejaVu Sans Mono", monospace; background: #f2f2f2;
       padding: 0 .2em; }
.hero { display: flex; flex-wrap: wrap; gap: 1rem 2rem; align-items: center; }
.hero > div { flex: 1 1 22rem; }
.hero p { font-size: 1.1rem; }
.hero svg { flex: 0 1 17rem; width: 17rem; max-width: 100%; height: auto; }
.numbers { display: grid; grid-template-columns: repeat(auto-fit, minmax(15rem, 1fr)); gap: 1rem;
           padding: 0; list-style: none; }
.numbers li { border-left: 3px solid #0072b2; padding-left: .7rem; font-size: .9rem; }
.numbers b { display: block; font-size: 1.5rem; line-height: 1.2; }
nav ol { display: grid; grid-template-columns: repeat(auto-fill, minmax(17rem, 1fr)); gap: 1rem;
         padding: 0; list-style: none; }
nav ol > li { border: 1px solid #ccc; border-radius: .4rem; padding: .7rem; }
nav svg { display: block; width: 100%; height: 8rem; margin-bottom: .4rem; pointer-events: none; }
nav p { margin: .2rem 0; font-size: .85rem; }
nav details { font-size: .85rem; color: #555; }
nav ul { padding-left: 1rem; font-size: .85rem; list-style: none; }
p.data { font-size: .75rem; margin: .2rem 0; }
#made td { white-space: normal; overflow-wrap: anywhere; }
.wide { overflow-x: auto; max-width: 100%; }
.wide { background: linear-gradient(90deg, #fff 30%, #fff0) left / 3rem 100% local no-repeat,
                    linear-gradient(270deg, #fff 30%, #fff0) right / 3rem 100% local no-repeat,
                    linear-gradient(270deg, #0003, #0000) right / .8rem 100% scroll no-repeat; }
details.rows > summary { cursor: pointer; color: #005a9c; font-size: .85rem; margin: .3rem 0; }
table { border-collapse: collapse; font-size: .75rem; font-variant-numeric: tabular-nums;
        margin: .5rem 0; }
th, td { padding: .2rem .45rem; border-bottom: 1px solid #ddd; text-align: left;
         vertical-align: top; white-space: nowrap; }
td.long { white-space: normal; min-width: 18rem; max-width: 30rem; }
th { border-bottom: 2px solid #999; }
th.r, td.r { text-align: right; }
ul.columns { font-size: .75rem; color: #444; margin: .3rem 0 .6rem; padding-left: 1rem; }
dfn { font-style: normal; font-weight: 600; }
p.again { font-size: .75rem; color: #444; margin: 0 0 .6rem; }
tbody tr:nth-child(even) { background: #0000000a; }
figure { margin: 1rem 0; }
figure svg { display: block; width: 100%; height: auto; }
figure g > path { pointer-events: none; }
.marks use:hover { fill: #000 !important; stroke: #000 !important; stroke-width: 3px; }
#gallery figure svg { width: 20rem; max-width: 100%; }
figcaption { font-size: .85rem; color: #444; margin-top: .3rem; }
@media (min-width: 56.25rem) {
  section { display: grid; grid-template-columns: repeat(2, minmax(0, 1fr)); gap: 0 2rem; }
  h2, .whole, .group:has(details[open]), #made > * { grid-column: 1 / -1; }
  #gallery .whole { grid-column: auto; }
  .pair { display: grid; grid-template-columns: minmax(0, 2fr) minmax(0, 3fr); gap: 0 2rem;
          align-items: start; }
}
@media (max-width: 40rem) {
  td:not(.r) { white-space: normal; min-width: 6.5rem; }
  th:first-child, td:first-child { position: sticky; left: 0; background: #fff;
                                   white-space: normal; overflow-wrap: anywhere;
                                   min-width: 7rem; max-width: 8.5rem; }
  #needs th, #needs td { padding: .2rem .25rem; min-width: 0; }
  #needs td:first-child { min-width: 4.5rem; }
  #needs td code { overflow-wrap: anywhere; font-size: .62rem; }
}
@page { size: landscape; margin: 1cm; }
@media print {
  body { max-width: none; padding: 0; }
  .wide { overflow: visible; }
  nav { display: none; }
  figure svg { min-width: 0; max-height: 17cm; }
  table { font-size: .55rem; }
  th, td:not(.r) { white-space: normal; padding: .1rem .25rem; }
  td.long { min-width: 0; overflow-wrap: anywhere; }
  h2 { break-before: page; }
  tr, figure { break-inside: avoid; }
  thead { display: table-header-group; }
}
"""

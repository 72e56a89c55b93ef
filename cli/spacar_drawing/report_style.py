"""Style sheet of the report: one column, readable on screen and paper."""

STYLE = """
body { margin: 0; background: #f3f5f7; color: #1d262e; font: 15px/1.5 "DejaVu Sans", Verdana, sans-serif; }
main { max-width: 880px; margin: 0 auto; padding: 28px 36px 40px; background: #fff; }
h1 { font-size: 26px; font-weight: 600; margin: 0 0 14px; }
h2 { font-size: 18px; font-weight: 600; margin: 34px 0 10px; padding-bottom: 4px; border-bottom: 1px solid #d8dee3; }
table { border-collapse: collapse; font-size: 13px; }
th, td { text-align: left; padding: 3px 18px 3px 0; vertical-align: top; font-weight: 400; }
thead th { color: #5b6770; border-bottom: 1px solid #d8dee3; }
tbody tr + tr { border-top: 1px solid #eef1f3; }
table.facts th { color: #5b6770; white-space: nowrap; }
table.numbers td { font-variant-numeric: tabular-nums; }
table.five td { font-size: 17px; font-variant-numeric: tabular-nums; }
details { margin-top: 18px; border-top: 1px solid #d8dee3; padding-top: 8px; }
summary { font-size: 18px; font-weight: 600; cursor: pointer; }
.scroll { overflow-x: auto; }
figure { margin: 12px 0 20px; }
figure.half { display: inline-block; width: 48%; margin: 8px 1% 12px 0; vertical-align: top; }
iframe.viewer { width: 100%; height: 560px; border: 1px solid #d8dee3; }
img { max-width: 100%; height: auto; display: block; }
figcaption { color: #5b6770; font-size: 12.5px; margin-top: 4px; }
pre { font: 12px/1.4 "DejaVu Sans Mono", Consolas, monospace; }
pre { background: #f7f9fa; border: 1px solid #e3e7ea; padding: 12px; overflow-x: auto; }
.warn { background: #fdf1e3; border-left: 4px solid #c2703d; padding: 8px 12px; }
footer { margin-top: 36px; color: #8a97a3; font-size: 12px; }
@media print { details > * { display: block; } }
@media print { body { background: #fff; } main { padding: 0; } figure, table { break-inside: avoid; } }
"""

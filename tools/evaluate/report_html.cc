#include "tools/evaluate/report_html.h"

#include <algorithm>
#include <cmath>

#include "tools/evaluate/report_numbers.h"
#include "tools/support/html.h"

namespace vantage {

const char* ReportStyle() {
  return R"(
:root { color-scheme: light dark; --ink:#1d2733; --soft:#5c6a7a; --line:#dfe4ea; --page:#f5f7f9;
  --card:#fff; --ours:#0b57a4; --shade:#dcebfa; --good:#1a7f4b; --bad:#b3261e; }
@media screen and (prefers-color-scheme: dark) { :root { --ink:#e3e8ee; --soft:#9eabba; --line:#37414d;
  --page:#14181d; --card:#1d232a; --ours:#7fb7f0; --shade:#20374f; --good:#58c48b; --bad:#f08a80; } }
* { box-sizing: border-box; }
body { margin:0; font:16px/1.5 system-ui,sans-serif; color:var(--ink); background:var(--page); }
main { max-width:1200px; margin:0 auto; padding:24px 20px 60px; }
h1 { font-size:1.7rem; margin:.2em 0; } h2 { font-size:1.25rem; margin:2.2em 0 .3em; }
h3 { font-size:1rem; margin:1.2em 0 .4em; }
p { max-width:95ch; margin:.4em 0 .8em; } .soft { color:var(--soft); }
.card { background:var(--card); border:1px solid var(--line); border-radius:10px; padding:14px;
  overflow-x:auto; margin:0 0 16px; }
figure.card img { width:100%; height:auto; display:block; background:#fff; border-radius:6px;
  padding:4px 0; }
figcaption, .note { color:var(--soft); font-size:.88rem; margin:.6em 0 0; max-width:120ch; }
table { border-collapse:collapse; width:100%; font-variant-numeric:tabular-nums; font-size:.92rem; }
th,td { text-align:right; padding:5px 9px; border-bottom:1px solid var(--line); white-space:nowrap; }
th { color:var(--soft); font-weight:600; font-size:.86rem; white-space:normal; vertical-align:bottom; }
th:first-child,td:first-child { text-align:left; }
tr:last-child td { border-bottom:0; }
.dense th,.dense td { padding:3px 4px; font-size:.78rem; } .ci { color:var(--soft); font-size:.92em; }
.ours { color:var(--ours); font-weight:600; } th.ours { color:var(--ours); }
tr.best td { background:var(--shade); } tr.paper td { color:var(--soft); font-size:.74rem; }
.first { font-weight:700; } .second { font-style:italic; } .far { color:var(--bad); }
.worse { color:var(--bad); } .better { color:var(--good); }
.new { font-size:.72rem; font-weight:400; color:var(--soft); border:1px solid var(--line);
  border-radius:4px; padding:0 3px; margin-left:.4em; white-space:nowrap; }
dl { display:grid; grid-template-columns:max-content 1fr; gap:2px 16px; font-size:.92rem; margin:.6em 0; }
dt { color:var(--soft); } dd { margin:0; overflow-wrap:anywhere; }
code { font-family:ui-monospace,monospace; font-size:.92em; }
nav { font-size:.9rem; margin:.8em 0; } nav a { color:var(--ours); margin-right:1em; white-space:nowrap; }
@media print { body { background:#fff; font-size:12px; } main { max-width:none; padding:0; }
  .card { break-inside:avoid; overflow:visible; } h2,h3,section>p { break-after:avoid; } nav { display:none; }
  .dense th,.dense td { padding:2px 3px; font-size:.62rem; } }
)";
}

std::string Section(const std::string& id,
                    const std::string& title,
                    const std::string& sentence,
                    const std::string& content) {
  return "<section id=\"" + id + "\"><h2>" + EscapeHtml(title) + "</h2>" +
         (sentence.empty() ? "" : "<p>" + EscapeHtml(sentence) + "</p>") + content + "</section>\n";
}

std::string FigureCard(const ReportFigures& figures,
                       const std::string& name,
                       const std::string& alternative,
                       const std::string& note) {
  const auto figure = figures.find(name);
  if (figure == figures.end()) return "";
  return "<figure class=\"card\"><img alt=\"" + EscapeHtml(alternative) + "\" src=\"" +
         DataUri("image/svg+xml", figure->second) + "\"><figcaption>" + EscapeHtml(note) +
         "</figcaption></figure>";
}

std::string TableCard(const std::string& rows, const std::string& note, const char* css_class) {
  return std::string("<div class=\"card\"><table class=\"") + css_class + "\">" + rows +
         "</table><p class=\"note\">" + EscapeHtml(note) + "</p></div>";
}

std::string HtmlCell(const std::string& text, const char* css_class) {
  const std::string open =
      css_class[0] == '\0' ? "<td>" : std::string("<td class=\"") + css_class + "\">";
  return open + EscapeHtml(text) + "</td>";
}

std::string HeadCell(const std::string& text, const char* css_class) {
  const std::string open =
      css_class[0] == '\0' ? "<th>" : std::string("<th class=\"") + css_class + "\">";
  return open + EscapeHtml(text) + "</th>";
}

std::string MethodHtml(const MethodInfo& method) {
  const std::string name = "<span title=\"" + EscapeHtml(method.parameters) + "\"" +
                           (method.is_histogram ? " class=\"ours\"" : "") + ">" +
                           EscapeHtml(MethodName(method)) + "</span>";
  return method.is_past_paper ? name + "<span class=\"new\">new</span>" : name;
}

std::string IntervalText(const Interval& interval, double factor, int decimals, const char* unit) {
  if (!std::isfinite(interval.value)) return "–";
  return NumberText(factor * interval.value, decimals) + unit + " [" +
         NumberText(factor * interval.low, decimals) + ", " +
         NumberText(factor * interval.high, decimals) + "]";
}

std::string IntervalCell(const Interval& interval, double factor, int decimals) {
  if (!std::isfinite(interval.value)) return HtmlCell("–");
  const int digits = std::abs(factor * interval.value) < 10.0 ? decimals : std::min(decimals, 1);
  return "<td>" + NumberText(factor * interval.value, digits) + " <span class=\"ci\">[" +
         NumberText(factor * interval.low, digits) + ", " +
         NumberText(factor * interval.high, digits) + "]</span></td>";
}

}  // namespace vantage

#pragma once

#include <map>
#include <string>
#include <vector>

#include "tools/evaluate/evaluation_results.h"

namespace vantage {

/// SVG by name: "forest", "grid", "sweep", "steps", "boxes", "boxes_plain", "objects", "time".
/// Those without data are not there.
using ReportFigures = std::map<std::string, std::string>;

/// <style> of the page.
const char* ReportStyle();

/// "<h2 id=...>title</h2>", a sentence of what to see, and the content. Title and sentence are
/// escaped here.
std::string Section(const std::string& id,
                    const std::string& title,
                    const std::string& sentence,
                    const std::string& content);

/// A figure in its card, with a note how it is made; nothing where there is no such figure.
std::string FigureCard(const ReportFigures& figures,
                       const std::string& name,
                       const std::string& alternative,
                       const std::string& note);

/// A table in its card with a note; `rows` is HTML from HeadRow() and <tr>s.
std::string TableCard(const std::string& rows, const std::string& note, const char* css_class = "");

/// A cell; the text is escaped.
std::string HtmlCell(const std::string& text, const char* css_class = "");
std::string HeadCell(const std::string& text, const char* css_class = "");

/// The name of a method with a mark where the paper doesn't have it, ours in blue. HTML.
std::string MethodHtml(const MethodInfo& method);

/// "0.12° [0.11, 0.14]", times `factor`.
std::string IntervalText(const Interval& interval, double factor, int decimals, const char* unit);
/// The same as a cell without the unit; values of 10 and more get one decimal at most.
std::string IntervalCell(const Interval& interval, double factor, int decimals);

}  // namespace vantage

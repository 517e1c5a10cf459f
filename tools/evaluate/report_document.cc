#include "tools/evaluate/report_document.h"

#include <utility>

#include "tools/evaluate/figure_boxes.h"
#include "tools/evaluate/figure_forest.h"
#include "tools/evaluate/figure_grid.h"
#include "tools/evaluate/figure_steps.h"
#include "tools/evaluate/report_exhibits.h"
#include "tools/evaluate/report_summary.h"

namespace vantage {
namespace {

constexpr const char* kNavigation =
    "<nav><a href=\"#summary\">Summary</a><a href=\"#grid\">Grid</a><a "
    "href=\"#sweep\">Clustering</a>"
    "<a href=\"#steps\">Three objects</a><a href=\"#objects\">Table 2</a>"
    "<a href=\"#boxes\">Box plots</a><a href=\"#views\">View by view</a>"
    "<a href=\"#sequences\">Sequences</a><a href=\"#time\">Time</a></nav>";

}  // namespace

Result<ReportFigures> DrawFigures(const EvaluationResults& results) {
  ReportFigures figures;
  std::pair<const char*, Result<std::string>> drawn[] = {{"forest", ForestFigure(results)},
                                                         {"grid", GridFigure(results)},
                                                         {"sweep", SweepFigure(results)},
                                                         {"steps", StepFigure(results)},
                                                         {"boxes", BoxFigure(results, true)},
                                                         {"boxes_plain", BoxFigure(results, false)},
                                                         {"objects", ObjectsFigure(results)},
                                                         {"time", TimeFigure(results)}};
  for (auto& [name, figure] : drawn) {
    if (!figure) return figure.error();
    if (!figure->empty()) figures[name] = std::move(*figure);
  }
  return figures;
}

std::string EvaluationPage(const EvaluationResults& results, const ReportFigures& figures) {
  return std::string(
             "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><meta "
             "name=\"viewport\" content=\"width=device-width,initial-scale=1\">"
             "<title>Orientation fusion, evaluated</title><style>") +
         ReportStyle() +
         "</style></head><body><main><h1>Orientation fusion, evaluated</h1>"
         "<p class=\"soft\">Our histogram filters beside the methods that Marton et al. "
         "(Autonomous Robots, 2017) compare, on the same simulated views, and the paper's own "
         "numbers.</p>" +
         kNavigation + SummarySection(results, figures) + RunSection(results) +
         GridSection(results, figures) + SweepSection(results, figures) +
         StepsSection(results, figures) + ObjectsSection(results) + BoxesSection(results, figures) +
         ViewsSection(results, figures) + SequencesSection(results) +
         TimeSection(results, figures) + "</main></body></html>\n";
}

}  // namespace vantage

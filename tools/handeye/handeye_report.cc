#include "tools/handeye/handeye_report.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "common/format.h"
#include "tools/support/csv_field.h"
#include "tools/support/gnuplot.h"
#include "tools/support/html.h"

namespace vantage {
namespace {

constexpr size_t kLongestName = 32;

std::string CutName(const std::string& name) {
  return name.size() <= kLongestName ? name
                                     : Format("%.*s...", int{kLongestName} - 3, name.c_str());
}

const char* NameOfX(HandEyeSetup setup) {
  return setup == HandEyeSetup::kEyeInHand ? "T_hand_camera" : "T_base_camera";
}
const char* NameOfY(HandEyeSetup setup) {
  return setup == HandEyeSetup::kEyeInHand ? "T_base_target" : "T_hand_target";
}

std::string PoseText(const char* name, const Pose& pose, const HandEyeCovariance& covariance) {
  const Eigen::Vector3d t = 1e3 * pose.translation();
  const Eigen::Quaterniond q = Canonical(Eigen::Quaterniond(pose.linear()));
  const Eigen::Vector3d r = LogSo3(q) / kDegree;
  const Eigen::Matrix<double, 6, 1> sigma = covariance.diagonal().cwiseMax(0.0).cwiseSqrt();
  return Format(
      "%s\n"
      "  translation       %10.3f %10.3f %10.3f mm    standard deviations %.3f %.3f %.3f mm\n"
      "  rotation vector   %10.4f %10.4f %10.4f deg   standard deviations %.4f %.4f %.4f deg\n"
      "  quaternion wxyz   %10.7f %10.7f %10.7f %10.7f\n",
      name,
      t.x(),
      t.y(),
      t.z(),
      1e3 * sigma[3],
      1e3 * sigma[4],
      1e3 * sigma[5],
      r.x(),
      r.y(),
      r.z(),
      sigma[0] / kDegree,
      sigma[1] / kDegree,
      sigma[2] / kDegree,
      q.w(),
      q.x(),
      q.y(),
      q.z());
}

std::string ExtraText(const HandEyeResult& result) {
  std::string text;
  if (result.robot_scale) {
    text += Format("robot scale         %.6f, standard deviation %.6f\n",
                   *result.robot_scale,
                   result.robot_scale_sigma);
  }
  if (result.time_offset) {
    text += Format("time offset         %.2f ms, standard deviation %.2f ms\n",
                   1e3 * *result.time_offset,
                   1e3 * result.time_offset_sigma);
  }
  if (result.camera) {
    const CameraModel& camera = *result.camera;
    text += Format("intrinsics          fx %.3f fy %.3f cx %.3f cy %.3f px\n",
                   camera.fx,
                   camera.fy,
                   camera.cx,
                   camera.cy);
  }
  if (result.distortion && !result.distortion->IsNone()) {
    const LensDistortion& k = *result.distortion;
    text += Format("distortion          k1 %.5f k2 %.5f p1 %.5f p2 %.5f k3 %.5f\n",
                   k.k1,
                   k.k2,
                   k.p1,
                   k.p2,
                   k.k3);
  }
  return text;
}

bool HasPixels(const HandEyeResult& result) {
  return std::ranges::any_of(result.views, [](const ViewResidual& v) { return v.pixels > 0.0; });
}

std::string FitText(const HandEyeResult& result) {
  const auto outliers = std::ranges::count_if(result.views, &ViewResidual::is_outlier);
  std::string text = Format(
      "views               %zu, of them %td left out\n"
      "spread of the target %.3f mm, %.4f deg (root mean square)\n"
      "leave-one-out       %.3f mm, %.4f deg\n"
      "noise               %.2f times what was expected; start from %s\n",
      result.views.size(),
      outliers,
      1e3 * result.translation_rms,
      result.rotation_rms / kDegree,
      1e3 * result.left_out_translation_rms,
      result.left_out_rotation_rms / kDegree,
      result.noise_scale,
      result.initial_method.c_str());
  const Eigen::Matrix<double, 6, 1>& s = result.observability.singular_values;
  const Eigen::Vector3d spread = result.observability.rotation_spread / kDegree;
  text += Format(
      "observability       %s; singular values %.3g %.3g %.3g %.3g %.3g %.3g per mm or 0.1 deg\n"
      "                    orientations spread by %.1f, %.1f and %.1f deg about three axes\n",
      result.observability.is_sufficient ? "sufficient" : "NOT sufficient",
      s[0],
      s[1],
      s[2],
      s[3],
      s[4],
      s[5],
      spread.x(),
      spread.y(),
      spread.z());
  std::string names;
  for (const ViewResidual& view : result.views) {
    if (view.is_outlier)
      names += Format("%s%s", names.empty() ? "" : ", ", CutName(view.name).c_str());
  }
  if (!names.empty()) text += Format("outliers            %s\n", names.c_str());
  return text;
}

std::string ViewsText(const HandEyeResult& result) {
  const bool pixels = HasPixels(result);
  std::string text = Format("\n%-32s %11s %12s%s %10s %26s\n",
                            "view",
                            "rotation",
                            "translation",
                            pixels ? "     pixels" : "",
                            "deviation",
                            "left out");
  for (const ViewResidual& view : result.views) {
    text += Format("%-32s %7.4f deg %9.3f mm",
                   CutName(view.name).c_str(),
                   view.rotation / kDegree,
                   1e3 * view.translation);
    if (pixels) text += Format(" %7.3f px", view.pixels);
    text += Format(" %10.2f", view.deviation);
    text += view.is_outlier ? std::string("  outlier")
                            : Format(" %10.4f deg %8.3f mm",
                                     view.left_out_rotation / kDegree,
                                     1e3 * view.left_out_translation);
    text += "\n";
  }
  return text;
}

std::string NextText(const SuggestedPose& next) {
  return Format(
      "\nA view from T_base_hand = %s would bring the standard deviation of X from %.3f to "
      "%.3f mm (rotation at 0.5 m).\n",
      PoseNumbers(next.T_base_hand).c_str(),
      1e3 * next.sigma_now,
      1e3 * next.sigma_after);
}

std::string FigureName(const std::string& name) {
  std::string text;
  for (const char c : CutName(name)) {
    text += static_cast<unsigned char>(c) < 0x20 || c == '"' || c == '\\' || c == '`' ? '_' : c;
  }
  return text;
}

std::string TableHtml(const HandEyeResult& result) {
  const bool pixels = HasPixels(result);
  std::string html = Format(
      "<div class=\"card\"><table><tr><th>view</th><th>rotation</th><th>translation</th>%s"
      "<th>deviation</th><th>left out: rotation</th><th>translation</th></tr>",
      pixels ? "<th>pixels</th>" : "");
  for (const ViewResidual& view : result.views) {
    html += Format("<tr%s><td>%s</td><td>%.4f°</td><td>%.3f mm</td>",
                   view.is_outlier ? " class=\"missed\"" : "",
                   EscapeHtml(view.name).c_str(),
                   view.rotation / kDegree,
                   1e3 * view.translation);
    if (pixels) html += Format("<td>%.3f px</td>", view.pixels);
    html += Format("<td>%.2f</td>", view.deviation);
    html += view.is_outlier ? std::string("<td>outlier</td><td></td></tr>")
                            : Format("<td>%.4f°</td><td>%.3f mm</td></tr>",
                                     view.left_out_rotation / kDegree,
                                     1e3 * view.left_out_translation);
  }
  return html + "</table></div>";
}

constexpr const char* kStyle = R"(
:root { color-scheme: light; --ink:#1d2733; --soft:#5c6a7a; --line:#dfe4ea; --good:#1a7f4b; --bad:#b3261e; }
* { box-sizing: border-box; }
body { margin:0; font:16px/1.55 system-ui,sans-serif; color:var(--ink); background:#f5f7f9; }
main { max-width:1120px; margin:0 auto; padding:24px 18px 60px; }
h1 { font-size:1.7rem; margin:.2em 0; } h2 { font-size:1.2rem; margin:2em 0 .6em; }
.card { background:#fff; border:1px solid var(--line); border-radius:10px; padding:16px; overflow-x:auto; }
table { border-collapse:collapse; width:100%; font-variant-numeric:tabular-nums; }
th,td { text-align:right; padding:6px 10px; border-bottom:1px solid var(--line); white-space:nowrap; }
th:first-child,td:first-child { text-align:left; } th { color:var(--soft); font-weight:600; font-size:.9rem; }
img { max-width:100%; height:auto; display:block; } pre { margin:0; font-size:.85rem; }
.verdict { font-weight:600; } .met { color:var(--good); } .missed { color:var(--bad); }
)";

}  // namespace

std::string PoseNumbers(const Pose& pose) {
  const Eigen::Vector3d t = pose.translation();
  const Eigen::Quaterniond q = Canonical(Eigen::Quaterniond(pose.linear()));
  return Format(
      "%.4f %.4f %.4f  %.5f %.5f %.5f %.5f", t.x(), t.y(), t.z(), q.w(), q.x(), q.y(), q.z());
}

std::string HandEyeText(const HandEyeRun& run) {
  const HandEyeResult& result = run.result;
  std::string text = PoseText(NameOfX(result.setup), result.T_x, result.covariance) +
                     PoseText(NameOfY(result.setup), result.T_y, result.target_covariance) +
                     ExtraText(result) + FitText(result) + ViewsText(result);
  for (const std::string& warning : run.warnings)
    text += Format("\nwarning: %s\n", warning.c_str());
  if (run.next) text += NextText(*run.next);
  for (const std::string& refusal : run.refusals)
    text += Format("\nrefused: %s\n", refusal.c_str());
  return text;
}

std::string ResidualsCsv(const HandEyeResult& result) {
  std::string text =
      "view,rotation_deg,translation_mm,pixels,deviation,outlier,left_out_rotation_deg,"
      "left_out_translation_mm\n";
  for (const ViewResidual& view : result.views) {
    const double nan = std::nan("");
    text += CsvField(view.name);
    for (const double value :
         {view.rotation / kDegree, 1e3 * view.translation, view.pixels, view.deviation}) {
      text += Format(",%s", CsvField(value).c_str());
    }
    text += view.is_outlier ? ",1" : ",0";
    text +=
        Format(",%s", CsvField(view.is_outlier ? nan : view.left_out_rotation / kDegree).c_str());
    text +=
        Format(",%s\n", CsvField(view.is_outlier ? nan : 1e3 * view.left_out_translation).c_str());
  }
  return text;
}

Result<std::string> ResidualFigure(const HandEyeResult& result) {
  constexpr double kLeast = 1e-4;  // deg and mm; what is less is drawn there.
  constexpr size_t kMostNames = 60;
  std::string script =
      "set terminal svg noenhanced size 1000,640 dynamic font 'sans-serif,14' background "
      "'#ffffff'\nset grid ytics lc rgb '#dddddd'\nset border 3 lc rgb '#888888'\n"
      "set tics nomirror textcolor rgb '#555555'\nset logscale y\nset format y '%g'\n"
      "set offsets 0.5, 0.5, 0, 0\nset key outside center top horizontal\n";
  std::string data[3] = {"$kept << END\n", "$left << END\n", "$outliers << END\n"};
  std::string names;
  for (size_t i = 0; i < result.views.size(); ++i) {
    const ViewResidual& view = result.views[i];
    const auto line = [i, least = kLeast](double rotation, double translation) {
      return Format("%zu %g %g\n",
                    i + 1,
                    std::max(least, rotation / kDegree),
                    std::max(least, 1e3 * translation));
    };
    data[view.is_outlier ? 2 : 0] += line(view.rotation, view.translation);
    if (!view.is_outlier) data[1] += line(view.left_out_rotation, view.left_out_translation);
    names +=
        Format("%s\"%s\" %zu", names.empty() ? "" : ", ", FigureName(view.name).c_str(), i + 1);
  }
  bool has[3];
  for (size_t k = 0; k < 3; ++k) {
    has[k] = data[k].find('\n') + 1 < data[k].size();
    script += data[k] + "END\n";
  }
  script += "set multiplot layout 2,1\n";
  if (result.views.size() <= kMostNames) {
    script += Format("set xtics rotate by 40 right font ',10' (%s)\n", names.c_str());
  }
  for (const int column : {2, 3}) {
    script +=
        Format("set ylabel '%s'\nplot ", column == 2 ? "rotation (degrees)" : "translation (mm)");
    std::string plots;
    const auto add = [&](bool there, const std::string& plot) {
      if (!there) return;
      plots += plots.empty() ? "" : ", ";
      plots += plot;
    };
    add(has[0],
        Format("$kept using 1:%d with points pt 7 ps 0.8 lc rgb '#0b57a4' title 'residual'",
               column));
    add(has[1],
        Format("$left using 1:%d with points pt 6 ps 1.1 lc rgb '#0b57a4' title 'left out'",
               column));
    add(has[2],
        Format("$outliers using 1:%d with points pt 2 ps 1.1 lw 2 lc rgb '#d55e00' title 'outlier'",
               column));
    script += plots + "\n";
  }
  return RunGnuplot(script + "unset multiplot\n");
}

std::string HandEyePage(const std::string& title,
                        const HandEyeRun& run,
                        const std::string& figure) {
  const HandEyeResult& result = run.result;
  std::string html = Format(
      "<!doctype html><html lang=\"en\"><head><meta charset=\"utf-8\"><meta name=\"viewport\" "
      "content=\"width=device-width,initial-scale=1\"><title>%s</title><style>%s</style></head>"
      "<body><main><h1>%s</h1>",
      EscapeHtml(title).c_str(),
      kStyle,
      EscapeHtml(title).c_str());
  if (run.refusals.empty()) html += "<p class=\"verdict met\">The views fix the calibration.</p>";
  for (const std::string& refusal : run.refusals) {
    html +=
        Format("<p class=\"verdict missed\">Not to be used: %s.</p>", EscapeHtml(refusal).c_str());
  }
  for (const std::string& warning : run.warnings) {
    html += Format("<p class=\"missed\">%s.</p>", EscapeHtml(warning).c_str());
  }
  const std::string text = PoseText(NameOfX(result.setup), result.T_x, result.covariance) +
                           PoseText(NameOfY(result.setup), result.T_y, result.target_covariance) +
                           ExtraText(result) + FitText(result);
  html += Format("<div class=\"card\"><pre>%s</pre></div>", EscapeHtml(text).c_str());
  if (run.next) html += Format("<p>%s</p>", EscapeHtml(NextText(*run.next)).c_str());
  html += Format(
      "<h2>Residuals</h2><figure class=\"card\" style=\"margin:0\"><img alt=\"residual of each "
      "view\" "
      "src=\"%s\"></figure><p>Dots: against the calibration from all views. Circles: against that "
      "from the other views, the honest measure. Crosses: outliers, which were left out.</p>",
      DataUri("image/svg+xml", figure).c_str());
  return html + TableHtml(result) + "</main></body></html>\n";
}

}  // namespace vantage

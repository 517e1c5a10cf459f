#pragma once

#include <string>
#include <string_view>

#include "tools/evaluate/evaluation_results.h"

namespace vantage {

// What the figures of an evaluation share. One strong blue is ours in every figure; the others are
// told apart with impaired color vision.
inline constexpr const char* kOursColor = "#0b57a4";
inline constexpr const char* kOtherColor = "#666a70";
inline constexpr const char* kDetectionColor = "#d55e00";
inline constexpr const char* kInkColor = "#30363d";

/// Errors that are less are drawn here on a logarithmic axis, deg.
inline constexpr double kSmallestDrawnDeg = 0.001;

/// Terminal (SVG, white), borders and tics; pixels.
std::string FigureHead(int width, int height, int font_size = 14);

/// Any text as a gnuplot string: quoted, control characters and broken UTF-8 replaced, cut after
/// `longest` characters.
std::string FigureText(std::string_view text, size_t longest = 36);

/// The method's name, with a star where the paper doesn't have it.
std::string FigureLabel(const MethodInfo& method, size_t longest = 36);
const char* MethodColor(const MethodInfo& method);

/// A number as gnuplot reads it ("NaN").
std::string DataNumber(double value);
/// max(error, kSmallestDrawnDeg); NaN stays.
double DrawnError(double error_deg);

/// Left, right, bottom and top of a plot as shares of the figure.
struct PanelPlace {
  double left = 0.0;
  double right = 1.0;
  double bottom = 0.0;
  double top = 1.0;
};
std::string PlacePanel(const PanelPlace& place);

/// The rows of a panel with one method a row, the first on top: y range, a light line a row, a band
/// behind the best of ours, the methods' names at the left if `names`. Method i is at y =
/// RowOfMethod(i).
std::string MethodRows(const EvaluationResults& results, bool names);
double RowOfMethod(const EvaluationResults& results, size_t method);

/// A logarithmic axis ('x', 'y') over whole decades round [low, high]; from 100 on it ends at 250.
std::string LogarithmicRange(char axis, double low, double high);

}  // namespace vantage

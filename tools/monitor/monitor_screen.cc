#include "tools/monitor/monitor_screen.h"

#include <algorithm>
#include <iterator>

#include "common/format.h"
#include "tools/monitor/monitor_tables.h"
#include "tools/monitor/shown_text.h"

namespace vantage {
namespace {

using Style = ScreenLine::Style;
using Lines = std::vector<ScreenLine>;

constexpr size_t kMostProblems = 3;  // Shown above the tables.
constexpr size_t kPage = 10;         // Lines.

void Append(const Lines& more, Lines* lines) {
  lines->insert(lines->end(), more.begin(), more.end());
}

// `most` lines of a table, its heading among them, beginning with the row `first` or so far above
// that the last one shows.
Lines Window(const Lines& table, size_t first, size_t most) {
  if (table.size() <= most) return table;
  if (most <= 1) return {};
  const size_t rows = most - 1;
  first = std::min(first, table.size() - 1 - rows);
  Lines window = {table.front()};
  const auto begin = table.begin() + 1 + static_cast<std::ptrdiff_t>(first);
  window.insert(window.end(), begin, begin + static_cast<std::ptrdiff_t>(rows));
  return window;
}

Lines ProblemLines(const std::vector<std::string>& problems, size_t most) {
  Lines lines;
  for (const std::string& problem : problems) {
    if (lines.size() + 1 == most && problems.size() > most) {
      lines.push_back({Format("and %zu more", problems.size() - lines.size()), Style::kWrong});
      return lines;
    }
    lines.push_back({problem, Style::kWrong});
  }
  return lines;
}

Lines Overview(const MonitorModel& model, const ScreenState& state, size_t rows, int64_t now) {
  Lines processes = ProcessTable(model, now);
  const size_t selected = std::min(state.selected + 1, processes.size() - 1);
  if (selected > 0) processes[selected].style = Style::kSelected;
  // A third of the screen is for processes, of the rest what devices leave for channels.
  const size_t most = std::max<size_t>(rows / 3, 3);
  Lines lines = Window(processes, selected < most ? 0 : selected - 1, most);
  Append(Window(CameraTable(model, now), 0, std::max<size_t>(rows / 6, 2)), &lines);
  Lines arms = ArmLines(model, now);
  arms.resize(std::min(arms.size(), std::max<size_t>(rows / 8, 1)));
  Append(arms, &lines);
  const size_t left = rows - std::min(rows, lines.size());
  Append(Window(ChannelTable(model, state.order, now), state.first_line, left), &lines);
  return lines;
}

Lines OneProcess(const MonitorModel& model, const ScreenState& state, size_t rows, int64_t now) {
  const size_t last = model.processes().size() - 1;
  const auto process = std::next(model.processes().begin(),
                                 static_cast<std::ptrdiff_t>(std::min(state.selected, last)));
  return Window(ProcessDetails(model, process->second, now), state.first_line, rows);
}

}  // namespace

void ApplyKeys(std::string_view typed, size_t num_processes, ScreenState* state) {
  const auto take = [&typed](std::string_view key) {
    if (!typed.starts_with(key)) return false;
    typed.remove_prefix(key.size());
    return true;
  };
  while (!typed.empty()) {
    if (take("q") || take("Q")) {
      state->wants_to_quit = true;
    } else if (take("s")) {
      state->order = static_cast<ChannelOrder>((static_cast<int>(state->order) + 1) % 6);
      state->first_line = 0;
    } else if (take("p") || take(" ")) {
      state->is_paused = !state->is_paused;
    } else if (take("\033[A") || take("\033OA") || take("k")) {
      if (state->selected > 0) --state->selected;
    } else if (take("\033[B") || take("\033OB") || take("j")) {
      if (state->selected + 1 < num_processes) ++state->selected;
    } else if (take("\033[5~")) {
      state->first_line -= std::min(state->first_line, kPage);
    } else if (take("\033[6~")) {
      state->first_line = std::min(state->first_line + kPage, MonitorModel::kMaxChannels);
    } else if (take("\r") || take("\n")) {
      state->shows_process = num_processes > 0;
      state->first_line = 0;
    } else if (typed == "\033") {
      typed = {};
      state->shows_process = false;
      state->first_line = 0;
    } else {
      // An escape sequence that means nothing here goes as a whole.
      typed.remove_prefix(typed.front() == '\033' ? typed.size() : 1);
    }
  }
}

std::vector<ScreenLine> DrawScreen(const MonitorModel& model,
                                   const std::vector<std::string>& problems,
                                   const std::string& where,
                                   const ScreenState& state,
                                   ScreenSize size,
                                   int64_t now) {
  Lines lines = {TitleLine(model, where, now)};
  Append(ProblemLines(problems, kMostProblems), &lines);
  if (problems.empty()) lines.push_back({"ok"});
  const size_t used = std::min(size.rows, lines.size() + 1);
  const bool one = state.shows_process && !model.processes().empty();
  Append(one ? OneProcess(model, state, size.rows - used, now)
             : Overview(model, state, size.rows - used, now),
         &lines);
  lines.resize(std::min(lines.size(), size.rows - std::min<size_t>(size.rows, 1)));
  while (lines.size() + 1 < size.rows) lines.push_back({});
  lines.push_back({Format("q quit  s sort: %s  p %s  up/down, Enter process  Esc back  PgUp/PgDn",
                          OrderName(state.order),
                          state.is_paused ? "go on (paused)" : "pause"),
                   Style::kHeading});
  lines.resize(std::min(lines.size(), size.rows));
  for (ScreenLine& line : lines) line.text = Shown(line.text, size.columns);
  return lines;
}

std::vector<ScreenLine> DrawSnapshot(const MonitorModel& model,
                                     const std::vector<std::string>& problems,
                                     const std::string& where,
                                     ChannelOrder order,
                                     int64_t now) {
  Lines lines = {TitleLine(model, where, now)};
  Append(ProblemLines(problems, 100), &lines);
  if (problems.empty()) lines.push_back({"ok"});
  lines.push_back({});
  Append(ProcessTable(model, now), &lines);
  for (const auto& [name, process] : model.processes()) {
    if (IsWatcher(name)) continue;
    lines.push_back({});
    Append(ProcessDetails(model, process, now), &lines);
  }
  lines.push_back({});
  Append(CameraTable(model, now), &lines);
  Append(ArmLines(model, now), &lines);
  lines.push_back({});
  Append(ChannelTable(model, order, now), &lines);
  return lines;
}

}  // namespace vantage

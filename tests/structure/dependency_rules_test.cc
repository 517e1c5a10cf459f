// Which folder may use what. A reader may rely on these rules, so they are checked.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>
#include <regex>
#include <sstream>
#include <string>
#include <vector>

namespace {

namespace fs = std::filesystem;

struct Violation {
  std::string file;
  std::string what;
};

const std::map<std::string, std::vector<std::string>>& AllowedIncludes() {
  static const std::map<std::string, std::vector<std::string>> kAllowed = {
      {"common", {"common"}},
      {"bus", {"bus", "common", "vantage"}},
      {"drivers", {"drivers", "common"}},
      {"perception", {"perception", "common"}},
      {"fusion", {"fusion", "common"}},
      {"planner", {"planner", "fusion", "common"}},
      {"nodes",
       {"nodes", "bus", "common", "drivers", "perception", "fusion", "planner", "vantage"}},
      {"tools",
       {"tools",
        "nodes",
        "bus",
        "common",
        "drivers",
        "perception",
        "fusion",
        "planner",
        "vantage"}},
  };
  return kAllowed;
}

bool IsIn(const std::string& value, const std::vector<std::string>& list) {
  return std::find(list.begin(), list.end(), value) != list.end();
}

std::string WithoutComments(const std::string& text) {
  std::istringstream lines(text);
  std::string code;
  for (std::string line; std::getline(lines, line);) {
    code += line.substr(0, line.find("//")) + "\n";
  }
  return code;
}

/// Checks one file of a folder of the project.
void CheckFile(const std::string& folder,
               const std::string& file,
               const std::string& text,
               std::vector<Violation>* violations) {
  const std::string code = WithoutComments(text);
  static const std::regex kInclude(R"(#\s*include\s*([<"])([^>"]+)[>"])");
  for (std::sregex_iterator it(code.begin(), code.end(), kInclude), end; it != end; ++it) {
    const bool quoted = (*it)[1] == "\"";
    const std::string header = (*it)[2];
    const std::string top = header.substr(0, header.find('/'));
    const bool ours = AllowedIncludes().contains(top) || top == "vantage";
    if ((quoted || ours) && !IsIn(top, AllowedIncludes().at(folder))) {
      violations->push_back({file, folder + " must not include " + header});
    }
    if (top == "lcm" && folder != "bus") {
      violations->push_back({file, "only bus knows LCM, but this includes " + header});
    }
    if (top == "CLI" && folder != "nodes" && folder != "tools") {
      violations->push_back({file, "only nodes and tools read a command line"});
    }
    if (top == "toml++" && folder != "nodes" && folder != "tools" &&
        file.find("perception/model/") == std::string::npos) {
      violations->push_back({file, "only nodes, tools and perception/model read TOML"});
    }
  }
  const auto forbid = [&](const char* pattern, const char* reason) {
    if (std::regex_search(code, std::regex(pattern))) violations->push_back({file, reason});
  };
  forbid(R"(\b(std::random_device|std::mt19937|std::rand\b|srand\s*\())",
         "random numbers come from common/rng.h");
  forbid(R"((Vector|Matrix|Quaternion)\w*::(Random|UnitRandom)\b)",
         "random numbers come from common/rng.h");
  if (IsIn(folder, {"common", "perception", "fusion", "planner"})) {
    forbid(R"(std::(jthread|thread|async)\b)", "libraries own no threads");
    forbid(R"((system_clock|steady_clock|high_resolution_clock|gettimeofday|clock_gettime))",
           "time comes from messages or from a clock that is passed in");
    forbid(R"(\bargv\b)", "libraries read no command line");
  }
}

std::vector<Violation> CheckTree(const fs::path& root) {
  std::vector<Violation> violations;
  for (const auto& [folder, allowed] : AllowedIncludes()) {
    for (const fs::directory_entry& entry : fs::recursive_directory_iterator(root / folder)) {
      const std::string suffix = entry.path().extension().string();
      if (suffix != ".h" && suffix != ".cc") continue;
      std::ifstream stream(entry.path());
      std::ostringstream text;
      text << stream.rdbuf();
      CheckFile(folder, fs::relative(entry.path(), root).string(), text.str(), &violations);
    }
  }
  return violations;
}

std::vector<Violation> Check(const std::string& folder, const std::string& text) {
  std::vector<Violation> violations;
  CheckFile(folder, folder + "/x.cc", text, &violations);
  return violations;
}

TEST(DependencyRules, HoldInTheWholeProject) {
  for (const Violation& violation : CheckTree(VANTAGE_SOURCE_DIR)) {
    ADD_FAILURE() << violation.file << ": " << violation.what;
  }
}

TEST(DependencyRules, CheckerFindsForbiddenIncludes) {
  EXPECT_EQ(Check("common", "#include \"bus/bus.h\"\n").size(), 1U);
  EXPECT_EQ(Check("perception", "#include \"fusion/so3_grid.h\"\n").size(), 1U);
  EXPECT_EQ(Check("fusion", "#include <vantage/images_t.hpp>\n").size(), 1U);
  EXPECT_EQ(Check("fusion", "#include <lcm/lcm-cpp.hpp>\n").size(), 1U);
  EXPECT_EQ(Check("nodes", "#include <lcm/lcm-cpp.hpp>\n").size(), 1U);
  EXPECT_EQ(Check("planner", "#include <CLI/CLI.hpp>\n").size(), 1U);
  EXPECT_EQ(Check("fusion", "#include <toml++/toml.h>\n").size(), 1U);
  EXPECT_EQ(Check("fusion", "#include \"so3_grid.h\"\n").size(), 1U);
}

TEST(DependencyRules, CheckerFindsForbiddenCalls) {
  EXPECT_EQ(Check("fusion", "auto t = std::chrono::steady_clock::now();\n").size(), 1U);
  EXPECT_EQ(Check("perception", "std::thread worker;\n").size(), 1U);
  EXPECT_EQ(Check("tools", "Eigen::Vector3d::Random();\n").size(), 1U);
  EXPECT_EQ(Check("nodes", "std::mt19937 generator;\n").size(), 1U);
}

TEST(DependencyRules, CheckerAllowsWhatIsAllowed) {
  EXPECT_TRUE(Check("planner", "#include \"fusion/so3_grid.h\"\n").empty());
  EXPECT_TRUE(Check("bus", "#include <lcm/lcm-cpp.hpp>\n").empty());
  EXPECT_TRUE(Check("fusion", "// std::thread and #include \"bus/bus.h\" in a comment\n").empty());
}

}  // namespace
